"""How much a search has done: counted, and not timed, so that it ends alike on every machine.

Contents: counting, here and in a copy of the process.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar

from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.sharing import Numbers
from tissue_probe.signals import FloatArray


class Effort:
    """The work done for measurements, in responses to one value over all of their samples.

    Most of a search's time goes into these: a model with eight values and four states takes twelve
    to be evaluated once.

    Parameters
    ----------
    measurements : sequence of Measurement
        The observations that models are fitted to.
    """

    def __init__(self, measurements: Sequence[Measurement]) -> None:
        self._samples = sum(measurement.force.size for measurement in measurements)
        self._counted = Numbers(0.0)
        self._within: Effort | None = None

    @property
    def done(self) -> float:
        """How many responses were computed."""
        return float(self._counted.both.sum()) / self._samples

    @contextmanager
    def count_responses(self) -> Iterator[None]:
        """Count the responses of the block, from nothing; an outer block counts them, too."""
        self._counted = Numbers(0.0)
        self._within = _counting.get()
        token = _counting.set(self)
        try:
            yield
        finally:
            _counting.reset(token)

    def _add(self, size: int) -> None:
        self._counted.own += size
        if self._within is not None:
            self._within._add(size)


_counting: ContextVar[Effort | None] = ContextVar("effort", default=None)


def count(sensitivities: Iterable[FloatArray]) -> None:
    """Count responses, each of shape (samples, values), where that is asked for."""
    effort = _counting.get()
    if effort is not None:
        effort._add(sum(sensitivity.size for sensitivity in sensitivities))
