"""One estimator on one stream of samples: gaps, repeats, restarts, models, a kernel for the rest.

Contents: the decisions between blocks of samples.
"""

from __future__ import annotations

from bisect import insort
from functools import lru_cache
from typing import Any

import numpy as np

from tissue_probe.alignment import Alignment
from tissue_probe.estimation.kernel import Kernel, Plan
from tissue_probe.estimation.run import Run
from tissue_probe.estimation.settings import OF_MODEL, EstimatorSettings
from tissue_probe.estimation.table import ESTIMATORS
from tissue_probe.estimation.takeover import carry_over
from tissue_probe.signals import TEXT, IntArray, SampleBlock, TissueEstimates, sample_offsets

#: Samples that come again within this time are taken for repeats [ns].
REPEAT_WINDOW = 1_000_000_000

_offsets = lru_cache(maxsize=32)(sample_offsets)


class Estimator:
    """Estimate the tissue's stiffness and damping from samples, one estimate a sample.

    The estimates do not depend on how the stream is cut into blocks, to the last bit.

    Parameters
    ----------
    name : str
        A key of ``ESTIMATORS``.
    settings : EstimatorSettings
        Instrument, noise and prior.

    Raises
    ------
    ValueError
        If there is no estimator of this name.

    Attributes
    ----------
    gaps : int
        How often samples were missing in the sequence. Stiffness, damping and their covariance
        survive a gap; the tip's motion is forgotten, and the input's history begins anew.
    lost : int
        How many samples those gaps held.
    missing : int
        Samples whose position or force was NaN or infinite. Without a force the filter predicts
        on; without a position the tip's motion is forgotten as in a gap.
    repeats : int
        Samples that came again, out of sequence, and were ignored: ``process`` returns no estimate
        for them, and so may return fewer estimates than samples, or none.
    restarts : int
        How often everything learnt was forgotten: by ``restart`` and ``restart_at``, because the
        sequence stepped back to 0 or stamps tell that another run began, or because the sample
        period changed.
    settings : EstimatorSettings
        With the model by which the last sample was estimated, as are the following.
    plan : Plan
        Of the kernel that has this model.
    first : tuple of int, or None
        Stamp [ns since the epoch] and number of the first sample estimated by it.
    """

    def __init__(self, name: str, settings: EstimatorSettings) -> None:
        if name not in ESTIMATORS:
            raise ValueError(f"no estimator {name!r}; there are {', '.join(ESTIMATORS)}")
        self.name = name
        self.settings = settings
        self.gaps = self.lost = self.missing = self.repeats = self.restarts = 0
        self.first: tuple[int, int] | None = None
        self._kernel = ESTIMATORS[name].kernel(settings)
        self._run: Run | None = None
        self._alignment = Alignment(0.0)
        self._sample_period = 0.0
        self._expected = 0
        self._end = 0
        self._restart_stamps: list[int] = []
        self._changes: list[tuple[int, EstimatorSettings, Kernel]] = []

    @property
    def plan(self) -> Plan:
        """Plan of the kernel at work."""
        return self._kernel.plan

    def process(self, block: SampleBlock) -> TissueEstimates:
        """Take in consecutive samples; return the estimate after each that was used."""
        known = self._already_used(block)
        count = len(block.position) - known
        if count == 0:
            return self._estimates(np.empty(0, np.int64), block.sequence, np.empty((11, 0)))
        if known:
            block = block[known:]
        self._expected = block.sequence + count
        self._end = block.end
        stamps = block.stamp + _offsets(count, block.sample_period)
        parts, begin = [], 0
        while self._changes and (index := self._change_index(stamps)) < count:
            if index > begin:
                parts.append(self._filter(block, stamps, begin, index))
            self._take_over(int(stamps[index]), block.sequence + index)
            begin = index
        if self.first is None:
            self.first = int(stamps[0]), block.sequence
        parts.append(self._filter(block, stamps, begin, count))
        return parts[0] if len(parts) == 1 else TissueEstimates.concatenate(parts)

    def _filter(
        self, block: SampleBlock, stamps: IntArray, begin: int, end: int
    ) -> TissueEstimates:
        """Filter the samples of a block from ``begin`` to ``end`` by the kernel at work."""
        stamps, count = stamps[begin:end], end - begin
        estimates = np.empty((11, count))
        aligned = self._alignment.apply(block.position[begin:end], block.force[begin:end])
        run = self._run
        assert run is not None, "the first block begins one"
        run.take(*aligned, estimates)
        done = 0
        while self._restart_stamps:
            index = int(np.searchsorted(stamps, self._restart_stamps[0]))
            if index >= count:
                break
            self.missing += run.filter(done, index)
            self._restart_stamps.pop(0)
            self.restart()
            done = index
        self.missing += run.filter(done, count)
        return self._estimates(stamps, block.sequence + begin, estimates)

    @property
    def covariance(self) -> np.ndarray | None:
        """Covariance of a Kalman filter's whole state after the last sample, shape (n, n)."""
        if not self._kernel.plan.is_kalman or self._run is None:
            return None
        layout = self._kernel.plan.layout
        size = len(layout.states)
        matrix = np.zeros((size, size))
        memory = self._run.memory
        matrix[np.triu_indices(size)] = memory[size : layout.history]
        own = matrix + np.triu(matrix, 1).T
        if not layout.considered:
            return own
        return own + layout.by_constants(memory)

    def restart(self) -> None:
        """Forget everything learnt."""
        self.restarts += 1
        if self._run is not None:
            self._run.start()

    def restart_at(self, stamp: int) -> None:
        """Forget everything learnt at the first sample of this time or later.

        Parameters
        ----------
        stamp : int
            Time [ns since the epoch]. It may lie in the future; if it lies before the samples
            already used, the next sample is meant.
        """
        insort(self._restart_stamps, stamp)

    def take_model(
        self, settings: EstimatorSettings, stamp: int = 0, kernel: Kernel | None = None
    ) -> None:
        """Go on by another model from the first sample of a time on, or a later one.

        What is known of the tissue is carried over (``carry_over``).

        Parameters
        ----------
        settings : EstimatorSettings
            As those so far, but for ``model`` and ``effects``.
        stamp : int
            Time [ns since the epoch], give or take half a sample period, as stamps are rounded. If
            it lies before the samples already used, the next sample is meant.
        kernel : Kernel, optional
            That of these settings; by default it is compiled here, where no process has before.

        Raises
        ------
        SettingsError
            If the model cannot be used.
        ValueError
            If other settings differ.
        """
        of_model = self.settings.model_dump(include=set(OF_MODEL))
        if settings.model_copy(update=of_model) != self.settings:
            raise ValueError(f"only {' and '.join(OF_MODEL)} may change while a filter runs")
        kernel = kernel or ESTIMATORS[self.name].kernel(settings)
        insort(self._changes, (stamp, settings, kernel), key=lambda change: change[0])

    def _change_index(self, stamps: IntArray) -> int:
        """Return at which of these samples the next model is taken over; their count if later."""
        half = round(0.5e9 * self._sample_period)
        return int(np.searchsorted(stamps, self._changes[0][0] - half))

    def _take_over(self, stamp: int, sequence: int) -> None:
        _, self.settings, self._kernel = self._changes.pop(0)
        self.first = stamp, sequence
        before, self._run = self._run, self._new_run()
        assert before is not None, "a model is taken over at a sample"
        if before.kernel.plan.delay != self._kernel.plan.delay:
            self._alignment = self._aligning()
        carry_over(before, self._run)

    def _new_run(self) -> Run:
        return Run(self._kernel, self.settings, self._sample_period)

    def _already_used(self, block: SampleBlock) -> int:
        """Compare a block with the expected next sample; return how many samples came before."""
        if self._run is None or block.sample_period != self._sample_period:
            self._begin(block)
        elif block.sequence > self._expected:
            self.gaps += 1
            self.lost += block.sequence - self._expected
            self._run.reopen()
            self._alignment = self._aligning()
        elif block.sequence < self._expected:
            if self._begins_anew(block):
                self.restart()
                self._alignment = self._aligning()
            else:
                known = min(self._expected - block.sequence, len(block))
                self.repeats += known
                return known
        return 0

    def _begins_anew(self, block: SampleBlock) -> bool:
        """Whether a step back in the sequence is another run, not samples that came twice.

        It is, if the probe was activated anew (stamps go on though numbers do not, even where the
        first blocks were missed), or a recording is replayed from further back.
        """
        came_twice = self._end - REPEAT_WINDOW < block.stamp < self._end
        return block.sequence == 0 or not came_twice

    def _begin(self, block: SampleBlock) -> None:
        """Set the filter up for the block's sample period."""
        if self._run is not None:
            self.restarts += 1
        self._sample_period = block.sample_period
        self._run = self._new_run()
        self._alignment = self._aligning()

    def _aligning(self) -> Alignment:
        """Return the alignment of force and position where the model says that one is late."""
        return Alignment(self._kernel.plan.delay / self._sample_period)

    def _estimates(self, stamps: np.ndarray, first: int, rows: np.ndarray) -> TissueEstimates:
        sequence = np.arange(first, first + stamps.size)
        model = np.full(stamps.size, self._kernel.plan.model, dtype=TEXT)
        columns: list[Any] = [*rows[:10], rows[10].astype(np.uint8), model]
        return TissueEstimates(self.name, stamps, sequence, *columns)
