"""The test of the current model on a stream: a right model holds, a wrong one is rejected in time.

The streams are the challenge's, which shares no code with the models under test.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tissue_probe.challenge.record import follow
from tissue_probe.challenge.simulator import make_challenge
from tissue_probe.errors import TissueProbeError
from tissue_probe.monitoring.monitor import Monitor
from tissue_probe.monitoring.settings import MonitorSettings
from tissue_probe.monitoring.tested_model import load_tested_model
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.model_file import save
from tissue_probe.settings import SettingsError, build
from tissue_probe.signals import PalpationSite, Phase, SampleBlock

RATE = 2000
#: Samples to a block, as the driver publishes them.
BLOCK = 10


def stream(effects=(), seconds=3.0, seed=9100):
    """Blocks of samples of a sine of 10 Hz on the tolerant rig."""
    time = np.arange(round(seconds * RATE)) / RATE
    rise = np.clip(time / 0.05, 0.0, 1.0)
    rise = rise**3 * (10.0 - 15.0 * rise + 6.0 * rise**2)
    moved = 2e-3 + 1e-3 * rise * np.sin(2.0 * np.pi * 10.0 * time)
    taken = make_challenge(seed, effects, follow(time, moved, "sine", True), "tolerant").recording
    return [
        SampleBlock(
            round(1e9 * first / RATE),
            first,
            1.0 / RATE,
            taken.position[first : first + BLOCK],
            taken.force[first : first + BLOCK],
            np.full(taken.force[first : first + BLOCK].size, np.nan),
        )
        for first in range(0, taken.force.size, BLOCK)
    ]


def windows_of(monitor, blocks):
    return [each for each in map(monitor.take, blocks) if each is not None]


@pytest.fixture(scope="module")
def clean():
    return stream()


@pytest.fixture
def monitor():
    return Monitor(MonitorSettings())


def test_the_right_model_holds_on_a_rig_within_its_tolerances(clean, monitor):
    found = windows_of(monitor, clean)
    assert [round(1e-9 * each.stamp, 3) for each in found] == [0.0, 0.75, 1.5]
    assert not any(each.rejected for each in found)
    assert all(0.8 < each.error_over_noise < 1.25 for each in found)
    assert all(each.noise == pytest.approx(0.005, rel=0.2) for each in found)


@pytest.mark.parametrize("effect", ["cubic_stiffening", "channel_delay"])
def test_a_missing_effect_is_told_within_three_seconds(effect, monitor):
    assert any(each.rejected for each in windows_of(monitor, stream((effect,), seed=9103)))


def written(path, effect):
    """Write a model file of an effect, with default values."""
    composition = Composition(effects=(EFFECTS[effect],))
    save(path, composition, {entry.name: entry.default for entry in composition.values}, {})
    return str(path)


def test_a_model_file_that_has_the_effect_holds(tmp_path):
    path = written(tmp_path / "model.yaml", "cubic_stiffening")
    monitor = Monitor(MonitorSettings(model=path))
    found = windows_of(monitor, stream(("cubic_stiffening",), seed=9103))
    assert len(found) == 3
    assert not any(each.rejected for each in found)


@pytest.mark.parametrize("effect", ["mains_hum", "tissue_motion"])
def test_an_effect_that_follows_the_clock_holds_in_windows_of_any_time(effect, monitor, tmp_path):
    blocks = stream((effect,), seconds=6.0, seed=9103)
    assert any(each.rejected for each in windows_of(monitor, blocks))
    own = Monitor(MonitorSettings(model=written(tmp_path / "model.yaml", effect)))
    found = windows_of(own, blocks)
    assert len(found) == 7
    assert not any(each.rejected for each in found)


@pytest.mark.parametrize("effect", ["stiffness_step", "stiffness_ramp"])
def test_an_effect_of_one_instant_is_refused_with_a_sentence(effect, tmp_path):
    path = written(tmp_path / "model.yaml", effect)
    with pytest.raises(SettingsError, match=f"{effect} begins at an instant of the recording"):
        Monitor(MonitorSettings(model=path))


def test_another_model_is_tested_from_its_taking_on(monitor, tmp_path):
    """Of the samples that are kept, too: nothing is waited for."""
    blocks = stream(("cubic_stiffening",), seconds=6.0, seed=9103)
    before = windows_of(monitor, blocks[:600])
    assert all(each.rejected for each in before)
    settings = MonitorSettings(model=written(tmp_path / "model.yaml", "cubic_stiffening"))
    monitor.take_model(settings, load_tested_model(settings))
    after = windows_of(monitor, blocks[600:])
    assert len(after) == 4
    assert not any(each.rejected for each in after)
    assert monitor.model.composition.names == ("cubic_stiffening",)


def test_an_error_of_the_encoder_that_the_force_does_not_feel_is_told(clean, monitor):
    step = 5e-6
    coarse = [replace(each, position=step * np.rint(each.position / step)) for each in clean]
    assert any(each.rejected for each in windows_of(monitor, coarse))


def test_a_lost_block_begins_the_window_anew(clean, monitor):
    found = windows_of(monitor, [*clean[:100], *clean[101:]])
    assert [each.stamp for each in found] == [clean[101].stamp, clean[101].stamp + 750_000_000]


def test_samples_that_are_not_finite_are_in_no_window_and_told(clean, monitor):
    spoilt = SampleBlock(0, 0, 1.0 / RATE, np.full(BLOCK, np.nan), np.zeros(BLOCK), np.zeros(BLOCK))
    assert monitor.take(spoilt) is None
    assert "look at the cables" in monitor.untested
    assert monitor.last() is None
    assert len(windows_of(monitor, clean)) == 3
    assert not monitor.untested


def test_samples_between_two_sites_are_not_tested(clean, monitor):
    for second, phase in ((0.0, Phase.APPROACH), (1.0, Phase.DWELL)):
        monitor.announce(PalpationSite(round(1e9 * second), 0, (0.0, 0.0, 0.0), phase))
    assert monitor.take(clean[0]) is None
    assert monitor.untested == "the tip is between two sites"
    assert [1e-9 * each.stamp for each in windows_of(monitor, clean[1:])] == [1.0]


def test_the_last_seconds_are_kept_and_no_more(clean):
    monitor = Monitor(MonitorSettings(kept=2.0))
    windows_of(monitor, clean)
    last = monitor.last()
    assert 2.0 <= len(last) / RATE < 2.0 + BLOCK / RATE
    assert last.sequence + len(last) == clean[-1].sequence + BLOCK


def test_too_slow_samples_are_told(monitor):
    slow = SampleBlock(0, 0, 0.1, np.zeros(20), np.zeros(20), np.zeros(20))
    assert monitor.take(slow) is None
    assert "give a longer window" in monitor.untested


def test_a_model_file_that_is_not_there_is_told():
    with pytest.raises((TissueProbeError, OSError), match=r"nowhere\.yaml"):
        Monitor(MonitorSettings(model="nowhere.yaml"))


@pytest.mark.parametrize(
    ("values", "told"),
    [({"step": 2.0}, "a step of at most the window"), ({"kept": 1.0}, "kept at least the window")],
)
def test_settings_that_leave_samples_untested_are_refused(values, told):
    with pytest.raises(SettingsError, match=told):
        build(MonitorSettings, values)


def test_the_chance_of_a_window_is_the_rate_of_false_alarms():
    settings = MonitorSettings(false_alarms=1.0, step=0.9, window=1.5)
    assert settings.chance == pytest.approx(0.9 / 3600.0)
