"""The identification by several records, without ROS: experiments, records, when it ends, answers.

The records of the last test are the challenge's, which shares no code with the models under test.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tissue_probe.analysis.monitor_worker import answer_records
from tissue_probe.challenge.record import follow
from tissue_probe.challenge.simulator import make_challenge
from tissue_probe.devices.limits import Limits
from tissue_probe.excitation import parse_excitation
from tissue_probe.monitoring.experiments import (
    CoilResponse,
    find_bounds,
    find_possible_experiments,
    measure_coil_response,
    refuse_beyond,
)
from tissue_probe.monitoring.identification import (
    LiveRecord,
    RecordsVerdict,
    ask_about_records,
    find_end,
)
from tissue_probe.monitoring.record_collector import RecordCollector
from tissue_probe.monitoring.settings import MonitorSettings
from tissue_probe.monitoring.tested_model import load_tested_model
from tissue_probe.settings import SettingsError
from tissue_probe.signals import SampleBlock

PERIOD = 0.0005
SINE = {"kind": "sine", "amplitude": 0.85, "frequency": 10.0}
CHIRP = {"kind": "chirp", "amplitude": 0.4, "start": 1.0, "stop": 60.0, "duration": 4.0}
COIL = CoilResponse(gain=1e-3, position=0.0, volts=0.85, force=1.0, travel=0.85e-3)
POSITIVE = st.floats(1e-3, 10.0)


def block(excitation, first: int, count: int = 10, value: float = 1.0) -> SampleBlock:
    """Samples of a coil that follows an excitation since its activation."""
    time = (first + np.arange(count)) * PERIOD
    command = parse_excitation(dict(excitation))(time)
    stamp = round(1e9 * first * PERIOD)
    return SampleBlock(stamp, first, PERIOD, 1e-3 * command, np.full(count, value), command)


def verdict(name="missing", probability=0.99, excitation=None, experiment="") -> RecordsVerdict:
    return RecordsVerdict(
        name, (("play", probability),), 2.0, 1.0, (), experiment, "", "",
        probability=probability, excitation=excitation or {}, duration=2.0,
    )  # fmt: skip


@settings(deadline=None)
@given(
    command=POSITIVE,
    current=POSITIVE,
    rms=POSITIVE,
    force=st.floats(0.1, 22.0),
    travel=st.floats(1e-4, 6.5e-3),
    per_volt=st.floats(0.0, 2.0),
    amplitude=st.just(0.0) | POSITIVE,  # 0: none stated
    lowest=st.floats(0.0, 10.0),
)
def test_experiments_keep_to_every_limit(
    command, current, rms, force, travel, per_volt, amplitude, lowest
):
    limits = Limits(
        command_limit=command, current_limit=current, rms_current_limit=rms, force_limit=force,
        travel_limit=travel,
    )  # fmt: skip
    bounds = find_bounds(limits, per_volt, amplitude, lowest)
    possible = find_possible_experiments(bounds, COIL)
    volts = possible.amplitude / COIL.gain
    assert 0.0 < volts <= command * (1 + 1e-12)
    assert volts <= (amplitude or np.inf) * (1 + 1e-12)
    assert volts * per_volt <= current * (1 + 1e-12)
    assert COIL.force * volts / COIL.volts < force
    assert COIL.travel * volts / COIL.volts < travel
    for excitation, preload, _ in possible.motions:
        made = parse_excitation({**excitation, "amplitude": volts})
        assert preload == COIL.position
        assert excitation.get("start", excitation.get("frequency")) >= lowest
        played = per_volt * made(np.arange(0.0, 4.0, PERIOD))
        assert np.sqrt(np.mean(played**2)) <= rms * 1.001


def test_limits_that_allow_nothing_are_told():
    with pytest.raises(SettingsError, match="no experiment is within 0 to 5 Hz"):
        find_bounds(Limits(), 0.2, highest=5.0)
    with pytest.raises(SettingsError, match="10 to 10 Hz, 1 to 60 Hz"):
        find_bounds(Limits(), 0.2, lowest=70.0)


def test_an_excitation_of_the_driver_beyond_the_limits_is_refused():
    given_by = {**SINE, "start": 1.0, "stop": 30.0}
    refuse_beyond(given_by, find_bounds(Limits(), 0.2))
    with pytest.raises(SettingsError, match=r"amplitude 0.85, .* beyond the limits of 0.5 V"):
        refuse_beyond(given_by, find_bounds(Limits(), 0.2, amplitude=0.5))


def test_a_motion_that_was_recorded_is_not_suggested_again():
    bounds = find_bounds(Limits(), 0.2)
    first = {kind["kind"] for kind, *_ in find_possible_experiments(bounds, COIL).motions}
    left = find_possible_experiments(bounds, COIL, [SINE, {**CHIRP, "steps": 10}]).motions
    assert first - {kind["kind"] for kind, *_ in left} == {"sine", "chirp"}
    slower = find_possible_experiments(bounds, COIL, [{**SINE, "frequency": 3.0}]).motions
    assert "sine" in {kind["kind"] for kind, *_ in slower}


def test_a_coil_that_is_not_driven_is_told():
    still = np.zeros(100)
    with pytest.raises(SettingsError, match="give the driver an excitation"):
        measure_coil_response(still, still, still)


def test_a_record_begins_where_the_coil_follows_the_excitation():
    collector = RecordCollector({**CHIRP, "frequency": 10.0}, 0.02, "record_2.mcap")
    assert not collector.takes(block(SINE, 4000))
    unknown = replace(block(CHIRP, 0), command=np.full(10, np.nan))
    assert not collector.takes(unknown)
    for first in range(0, 40, 10):
        assert collector.record() is None
        assert collector.takes(block(CHIRP, first))
    record = collector.record()
    assert record.excitation == CHIRP
    assert record.path == "record_2.mcap"
    np.testing.assert_array_equal(record.command, block(CHIRP, 0, 40).command)


@pytest.mark.parametrize("hole", ["lost samples", "another excitation"])
def test_a_record_has_no_hole(hole):
    collector = RecordCollector(CHIRP, 0.02)
    for first in (0, 10):
        collector.takes(block(CHIRP, first))
    if hole == "another excitation":
        collector.takes(block(SINE, 20))
    for first in range(30, 60, 10):
        collector.takes(block(CHIRP, first))
        assert collector.record() is None
    collector.takes(block(CHIRP, 60))
    np.testing.assert_array_equal(collector.record().command, block(CHIRP, 30, 40).command)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_record_of_values_that_are_not_finite_is_refused(value):
    with pytest.raises(ValueError, match="look at the cables"):
        RecordCollector(SINE, 0.02).takes(block(SINE, 0, value=value))


@pytest.mark.parametrize(
    ("found", "records", "end"),
    [
        (verdict(), 1, "settled: missing, with a probability of 0.990"),
        (verdict("adequate"), 3, "settled: adequate"),
        (verdict("adequate", excitation=CHIRP), 1, ""),
        (verdict("adequate", excitation=CHIRP), 3, "the budget of 3 records is spent"),
        (verdict("ambiguous", 0.6, CHIRP), 2, ""),
        (verdict("ambiguous", 0.6, experiment="tare"), 2, "tells more: ambiguous.*; tare"),
        (verdict("missing", 0.9, CHIRP), 1, ""),
        (verdict("unexplained", 0.99), 1, "no excitation within the limits tells more"),
    ],
)
def test_an_identification_ends_when_it_is_settled_or_nothing_is_left(found, records, end):
    told = find_end(found, 0.95, records, 3)
    assert bool(told) == bool(end)
    assert re.search(end, told)


def record(excitation, seconds: float, seed: int, effects) -> LiveRecord:
    """A record of a specimen, 1 mm for a volt."""
    time = np.arange(round(seconds / PERIOD)) * PERIOD
    rise = np.clip(time / 0.05, 0.0, 1.0)
    command = parse_excitation(dict(excitation))(time)
    moved = 2e-3 + 1e-3 * rise**3 * (10.0 - 15.0 * rise + 6.0 * rise**2) * command
    taken = make_challenge(seed, effects, follow(time, moved, "coil", True), "tolerant").recording
    return LiveRecord(taken.position, taken.force, command, PERIOD, excitation)


@pytest.mark.slow
def test_a_record_that_shows_nothing_asks_for_one_that_would():
    model = load_tested_model(MonitorSettings())
    bounds = find_bounds(Limits(), 0.2)
    found = answer_records(ask_about_records(model, [record(SINE, 2.0, 9200, ())], bounds, 0.95))
    assert found.verdict == "adequate"
    assert found.unseen
    assert found.excitation["kind"] in ("multisine", "chirp")
    assert 0.5 < found.excitation["amplitude"] <= 1.1
    assert not found.is_settled(0.95)
