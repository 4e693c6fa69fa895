"""Tables keep every digit, in CSV and in Parquet."""

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_array_equal
from pyarrow import csv, parquet

from tissue_probe.recording.any_file import read_any
from tissue_probe.recording.clocks.stretches import dwell_blocks
from tissue_probe.recording.layout import Layout
from tissue_probe.recording.writing.tables import write_estimates, write_samples
from tissue_probe.signals import (
    TEXT,
    PalpationSite,
    Phase,
    Recording,
    SampleBlock,
    Status,
    TissueEstimates,
)

ENDINGS = [".csv", ".parquet"]
ESTIMATE_COLUMNS = [
    "time",
    "stiffness",
    "damping",
    "stiffness_variance",
    "damping_variance",
    "covariance_trace",
    "innovation",
    "normalized_innovation_squared",
    "status",
    "model",
]
MODELS = st.sampled_from(["kelvin_voigt", "kelvin_voigt+cubic_stiffening 0123456789abcdef"])


def read_back(path):
    read = {".csv": csv.read_csv, ".parquet": parquet.read_table}[path.suffix]
    return read(path)


def written(write, content, origin, ending):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"table{ending}")
        write(path, content, origin)
        return read_back(path)


@st.composite
def tissue_estimates(draw):
    size = draw(st.integers(1, 6))
    return TissueEstimates(
        "ekf",
        np.arange(size) * 500_000 + 1_700_000_000_000_000_000,
        np.arange(size),
        *(draw(arrays(np.float64, size)) for _ in range(10)),
        status=draw(arrays(np.uint8, size, elements=st.sampled_from(Status))),
        model=np.array(draw(st.lists(MODELS, min_size=size, max_size=size)), TEXT),
    )


@pytest.mark.parametrize("ending", ENDINGS)
@given(estimates=tissue_estimates())
@settings(max_examples=40, deadline=None)
def test_estimates_are_read_back_exactly(ending, estimates):
    table = written(write_estimates, estimates, 1_700_000_000_000_000_000, ending)
    assert table.column_names == ESTIMATE_COLUMNS
    assert_array_equal(table["time"], np.arange(len(estimates)) * 500_000 / 1e9)
    for name in ESTIMATE_COLUMNS[1:-2]:
        values = table[name].to_numpy().astype(np.float64)  # whole numbers in CSV look like int
        assert_array_equal(values, getattr(estimates, name))
    names = ["converging", "converged", "no_contact", "model_rejected", "disturbed"]
    assert table["status"].to_pylist() == [names[status] for status in estimates.status]
    assert table["model"].to_pylist() == estimates.model.tolist()


@pytest.mark.parametrize("ending", ENDINGS)
@given(columns=arrays(np.float64, (3, 8)))
@settings(max_examples=40, deadline=None)
def test_samples_are_read_back_exactly(ending, columns):
    blocks = (
        SampleBlock(10**9, 0, 0.5, *columns[:, :3]),
        SampleBlock(10**10, 7, 0.5, *columns[:, 3:]),
    )
    table = written(write_samples, Recording(blocks), 10**9, ending)
    assert table.column_names == ["time", "position", "force", "command", "sequence", "site"]
    assert_array_equal(table["time"], [0.0, 0.5, 1.0, 9.0, 9.5, 10.0, 10.5, 11.0])
    for name, expected in zip(("position", "force", "command"), columns, strict=True):
        assert_array_equal(table[name].to_numpy().astype(np.float64), expected)
    assert table["sequence"].to_pylist() == [0, 1, 2, 7, 8, 9, 10, 11]
    assert table["site"].to_pylist() == 8 * [None]


@pytest.mark.parametrize("ending", ENDINGS)
def test_each_sample_of_a_dwell_has_its_site(ending):
    block = SampleBlock(0, 0, 1.0, *np.zeros((3, 6)))
    sites = (
        PalpationSite(1 * 10**9, 0, (0.0, 0.0, 0.0), Phase.DWELL),
        PalpationSite(3 * 10**9, 0, (0.0, 0.0, 0.0), Phase.LIFTED),
        PalpationSite(4 * 10**9, 12, (0.0, 0.0, 0.0), Phase.DWELL),
    )
    table = written(write_samples, Recording((block,), sites), 0, ending)
    assert table["site"].to_pylist() == [None, 0, 0, None, 12, 12]


@pytest.mark.parametrize("ending", ENDINGS)
@given(gaps=st.lists(st.integers(0, 3), min_size=1, max_size=5), data=st.data())
@settings(max_examples=25, deadline=None)
def test_the_dwells_of_a_scan_come_back_from_its_table(ending, gaps, data):
    sites, stamp = [], 0
    for number, gap in enumerate(gaps):
        sites.append(PalpationSite(stamp + gap, number, (0.0, 0.0, 0.0), Phase.DWELL))
        stamp += gap + data.draw(st.integers(1, 4))
        sites.append(PalpationSite(stamp, number, (0.0, 0.0, 0.0), Phase.LIFTED))
    sites = [replace(site, stamp=site.stamp * 10**9) for site in sites]
    block = SampleBlock(0, 0, 1.0, *np.zeros((3, stamp + 3)))
    recording = Recording((block,), tuple(sites))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"samples{ending}")
        write_samples(path, recording, 0)
        read, _ = read_any(path, Layout())
    dwells = [[(s.site, s.stamp, end) for s, end in each.dwells()] for each in (recording, read)]
    assert dwells[0] == dwells[1]


def test_rows_that_tell_their_site_are_of_it_after_a_silence_too(tmp_path):
    blocks = [SampleBlock(at * 10**9, 100 * at, 0.01, *np.zeros((3, 200))) for at in (0, 60)]
    dwells = [PalpationSite(block.stamp, 3, (0.0, 0.0, 0.0), Phase.DWELL) for block in blocks]
    write_samples(tmp_path / "samples.csv", Recording(tuple(blocks), tuple(dwells)), 0)
    read, _ = read_any(tmp_path / "samples.csv", Layout())
    assert sum(map(len, dwell_blocks(read, 3))) == 400


def test_samples_written_as_csv_are_read_as_a_measurement(tmp_path):
    block = SampleBlock(0, 0, 5e-4, *np.random.default_rng(0).normal(size=(3, 50)))
    write_samples(tmp_path / "samples.csv", Recording((block,)), 0)
    read, _ = read_any(tmp_path / "samples.csv", Layout())
    assert_array_equal(read.position, block.position)
    assert_array_equal(read.force, block.force)


def test_the_header_names_the_columns_without_quotes(tmp_path):
    write_samples(
        tmp_path / "samples.csv", Recording((SampleBlock(0, 0, 1.0, [0.5], [0.5], [np.nan]),)), 0
    )
    assert (tmp_path / "samples.csv").read_text() == (
        "time,position,force,command,sequence,site\n0,0.5,0.5,nan,0,\n"
    )


def test_another_ending_is_refused_and_nothing_written(tmp_path):
    recording = Recording((SampleBlock(0, 0, 1.0, [0.0], [0.0], [0.0]),))
    with pytest.raises(ValueError, match=r"ends in '.xlsx'; tables are .csv or .parquet"):
        write_samples(tmp_path / "samples.xlsx", recording, 0)
    assert list(tmp_path.iterdir()) == []
