"""One estimator on one stream of samples: gaps, repeats, restarts, and a kernel for the rest.

Contents: the decisions between blocks of samples.
"""

from __future__ import annotations

from bisect import insort
from functools import lru_cache

import numpy as np

from tissue_probe.alignment import Alignment
from tissue_probe.estimation.run import Run
from tissue_probe.estimation.settings import EstimatorSettings
from tissue_probe.estimation.table import ESTIMATORS
from tissue_probe.signals import SampleBlock, TissueEstimates, sample_offsets

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
    """

    def __init__(self, name: str, settings: EstimatorSettings) -> None:
        if name not in ESTIMATORS:
            raise ValueError(f"no estimator {name!r}; there are {', '.join(ESTIMATORS)}")
        self.name = name
        self.settings = settings
        self.gaps = self.lost = self.missing = self.repeats = self.restarts = 0
        self._kernel = ESTIMATORS[name].kernel(settings)
        self._run: Run | None = None
        self._alignment = Alignment(0.0)
        self._sample_period = 0.0
        self._expected = 0
        self._end = 0
        self._restart_stamps: list[int] = []

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
        estimates = np.empty((11, count))
        begin = 0
        aligned = self._alignment.apply(block.position, block.force)
        run = self._run
        assert run is not None, "the first block begins one"
        run.take(*aligned, estimates)
        while self._restart_stamps:
            index = int(np.searchsorted(stamps, self._restart_stamps[0]))
            if index >= count:
                break
            self.missing += run.filter(begin, index)
            self._restart_stamps.pop(0)
            self.restart()
            begin = index
        self.missing += run.filter(begin, count)
        return self._estimates(stamps, block.sequence, estimates)

    @property
    def covariance(self) -> np.ndarray | None:
        """Covariance of a Kalman filter's whole state after the last sample, shape (n, n)."""
        layout = self._kernel.layout
        if layout is None or self._run is None:
            return None
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
        self._run = Run(self._kernel, self.settings, block.sample_period)
        self._alignment = self._aligning()

    def _aligning(self) -> Alignment:
        """Return the alignment of force and position where the model says that one is late."""
        return Alignment(self._kernel.delay / self._sample_period)

    def _estimates(self, stamps: np.ndarray, first: int, rows: np.ndarray) -> TissueEstimates:
        sequence = np.arange(first, first + stamps.size)
        columns = [*rows[:10], rows[10].astype(np.uint8)]
        return TissueEstimates(self.name, stamps, sequence, *columns)
