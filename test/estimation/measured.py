"""Blocks of samples for the tests."""

import numpy as np

from benchmarks.estimators_simulator import Experiment
from tissue_probe.signals import SampleBlock

START = 1_700_000_000_000_000_000


def block_of(experiment: Experiment, first: int = 0) -> SampleBlock:
    """Return an experiment as one block whose sequence begins at ``first``."""
    position, force = experiment.run()
    return SampleBlock(
        stamp=START,
        sequence=first,
        sample_period=experiment.sample_period,
        position=position,
        force=force,
        command=np.full(position.size, np.nan),
    )
