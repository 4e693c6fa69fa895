"""Tables that were made of two topics, or of a topic's stamps in two columns."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from nptdms import ChannelObject, TdmsWriter

import tissue_probe as tp

RATE = 250.0


def motion(time):
    return 1e-3 * (2.0 + np.sin(2 * np.pi * 2.0 * time) + 0.4 * np.sin(2 * np.pi * 5.3 * time))


def force(time):
    return 320.0 * motion(time) + 6.0 * (motion(time + 1e-6) - motion(time - 1e-6)) / 2e-6


@given(late=st.floats(1e-4, 3e-3), every=st.integers(1, 5))
@settings(max_examples=15, deadline=None)
def test_topics_that_were_merged_by_time_are_brought_together(late, every):
    """A blank stands where the other topic has its row; the position may come more seldom."""
    felt, moved = np.arange(1000) / RATE, np.arange(0, 1000, every) / RATE + late
    time = np.concatenate([felt, moved])
    order = np.argsort(time, kind="stable")
    blank = np.full(felt.size, np.nan), np.full(moved.size, np.nan)
    table = {
        "t": time[order],
        "u": np.concatenate([blank[0], motion(moved)])[order],
        "F": np.concatenate([force(felt), blank[1]])[order],
    }
    read = tp.read(table, force_polarity="compression")
    assert any("rows of their own" in note for note in read.notes)
    known = np.isfinite(read.position) & np.isfinite(read.force)
    assert np.count_nonzero(known) > 950
    np.testing.assert_allclose(read.position[known], motion(read.time[known]), atol=2e-6)
    np.testing.assert_allclose(read.force[known], force(read.time[known]), atol=1e-9)


def test_gaps_in_one_channel_are_gaps():
    time = np.arange(1000) / RATE
    felt = force(time)
    felt[300:320] = np.nan
    read = tp.read({"t": time, "u": motion(time), "F": felt}, force_polarity="compression")
    assert not any("rows of their own" in note for note in read.notes)


@pytest.mark.parametrize(
    ("seconds", "nanos"),
    [("sec", "nanosec"), ("header.stamp.sec", "header.stamp.nanosec"), ("secs", "nsecs")],
)
@pytest.mark.parametrize("begin", [0, 1_760_000_012])
def test_seconds_and_nanoseconds_are_one_time(tmp_path, seconds, nanos, begin):
    time = np.arange(1000) / RATE
    whole = np.round(1e9 * time).astype(np.int64) + begin * 10**9
    rows = zip(whole // 10**9, whole % 10**9, motion(time), force(time), strict=True)
    lines = [f"{seconds},{nanos},u,F", *(f"{s},{n},{u:.9g},{f:.9g}" for s, n, u, f in rows)]
    (tmp_path / "two.csv").write_text("\n".join(lines) + "\n")
    read = tp.read(tmp_path / "two.csv", force_polarity="compression")
    np.testing.assert_allclose(read.time - read.time[0], time, atol=1e-6)  # since 1970 in floats
    assert any(f"time is {seconds} and {nanos} together" in note for note in read.notes)


@given(late=st.floats(-0.05, 0.05), as_offset=st.booleans())
@settings(
    max_examples=10, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_channels_of_a_tdms_file_begin_when_they_say(tmp_path, late, as_offset):
    """By its date, or by an offset to it."""
    time, nanos = np.arange(1000) / RATE, round(1e9 * late)
    begin = np.datetime64("2026-03-02T09:15:20", "ns")
    of_force = {
        "wf_start_time": begin + np.timedelta64(0 if as_offset else nanos, "ns"),
        "wf_start_offset": 1e-9 * nanos if as_offset else 0.0,
    }
    of_position = {"wf_start_time": begin, "wf_start_offset": 0.0}
    increment = {"wf_increment": 1.0 / RATE}
    with TdmsWriter(tmp_path / "late.tdms") as writer:
        writer.write_segment(
            [
                ChannelObject("Run", "u", motion(time), {**increment, **of_position}),
                ChannelObject("Run", "F", force(time + 1e-9 * nanos), {**increment, **of_force}),
            ]
        )
    units = {"position_unit": "m", "force_unit": "N"}
    read = tp.read(tmp_path / "late.tdms", force_polarity="compression", **units)
    known = np.isfinite(read.position) & np.isfinite(read.force)
    assert np.count_nonzero(known) > 980
    # A spline has no slope beyond its ends to lean on.
    moved = read.position[known][30:-30]
    begin = np.flatnonzero(known)[0] if known.size == 1000 else 1000 - known.size
    at = (begin + np.arange(moved.size) + 30) / RATE + 1e-9 * nanos
    np.testing.assert_allclose(moved, motion(at), atol=5e-6)


def test_a_name_that_two_columns_have_is_refused(tmp_path):
    """In a file of LabVIEW each channel may have times of its own, all called X_Value."""
    rows = [f"{n / RATE}\t{motion(n / RATE)}\t{n / RATE + 0.037}\t1.0" for n in range(100)]
    (tmp_path / "x.txt").write_text("\n".join(["X_Value\tu\tX_Value\tF", *rows]) + "\n")
    with pytest.raises(tp.TissueProbeError, match="2 columns called X_Value: which is the time"):
        tp.read(tmp_path / "x.txt", time="X_Value", force_polarity="compression")
