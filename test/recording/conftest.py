"""A recording of known samples, and bags by other recorders."""

import os
from pathlib import Path

import numpy as np
import pytest

from tissue_probe.signals import SampleBlock

REPOSITORY = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def blocks():
    """Sixty blocks of ten samples at 2 kHz, one after the other."""
    generator = np.random.default_rng(0)
    return [
        SampleBlock(
            stamp=1_700_000_000_000_000_000 + 5_000_000 * number,
            sequence=10 * number,
            sample_period=5e-4,
            position=generator.normal(size=10),
            force=generator.normal(size=10),
            command=generator.normal(size=10),
        )
        for number in range(60)
    ]


@pytest.fixture
def run(tmp_path, messages, record, blocks):
    """A file with these blocks on ``/probe/samples``, logged at their stamps."""
    entries = [
        ("/probe/samples", messages.SAMPLES, block.stamp, messages.samples(block))
        for block in blocks
    ]
    return record(tmp_path / "run.mcap", entries, {"parameters": {"excitation": "sine 10 Hz"}})


@pytest.fixture(scope="session")
def foreign_bags():
    """The folder of bags by other recorders; it is not part of the repository."""
    shared = os.environ.get("TISSUE_PROBE_SHARED_DATA", REPOSITORY.parent / "shared" / "data")
    folder = Path(shared, "rosbags")
    if not folder.is_dir():
        pytest.skip("no foreign bags: set TISSUE_PROBE_SHARED_DATA to the folder of shared data")
    return folder
