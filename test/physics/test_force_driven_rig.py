"""A force on the tip, its position as the answer: closed forms, and what has no meaning there."""

import numpy as np
import pytest
from composed import FORMS, PERIOD, force_of, halved, values_of

from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.model_file import ModelFileError, load, save
from tissue_probe.physics.response import course, respond
from tissue_probe.physics.rigs import FORCE_DRIVEN
from tissue_probe.quantities import FORCE, POSITION

M, K, B = 0.04, 450.0, 5.0
RELAXED = {
    "kelvin_voigt": lambda s: K + B * s,
    "maxwell": lambda s: K * B * s / (K + B * s),
    "standard_linear_solid": lambda s: K + B * s + 300.0 * s / (s + 50.0),
}
TIMES = np.arange(2000) * PERIOD
#: About a preload, begun gently: the tip is pressed, then shaken.
PUSH = 0.2 + 0.5 * np.minimum(TIMES / 0.1, 1.0) ** 4 * np.sin(62.8 * TIMES) + 0.3 * TIMES


def driven(*names):
    return Composition("force_driven", effects=tuple(FORMS[name] for name in names))


def answer(composition, force, **changes):
    return force_of(composition, values_of(composition, **changes), force)


def test_force_is_the_input_and_position_the_output():
    assert (driven().input, driven().output) == (FORCE, POSITION)
    assert (Composition().input, Composition().output) == (POSITION, FORCE)


@pytest.mark.parametrize("tissue", RELAXED)
def test_the_tip_yields_as_the_tissue_and_its_mass_let_it(tissue):
    composition = Composition("force_driven", tissue)
    times, rate = np.arange(8000) * PERIOD, 2 * np.pi * 10.0
    moved = force_of(composition, values_of(composition), np.sin(rate * times)).output
    last = times > 3.0
    waves = np.stack([np.sin(rate * times), np.cos(rate * times), np.ones_like(times)], axis=1)
    sine, cosine, _ = np.linalg.lstsq(waves[last], moved[last], rcond=None)[0]
    expected = 1.0 / (RELAXED[tissue](1j * rate) + M * (1j * rate) ** 2)
    assert sine + 1j * cosine == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize(
    ("name", "values", "read"),
    [
        ("force_gain", {"gain_error": 0.1}, 1.1 * PUSH),
        ("force_bias", {"force_bias": 0.3}, PUSH + 0.3),
        ("force_drift", {"force_drift": 0.2, "drift_start": -0.1}, PUSH - 0.1 + 0.2 * TIMES),
        (
            "mains_hum",
            {"hum_sine": 0.1, "hum_cosine": 0.2},
            PUSH + 0.1 * np.sin(100 * np.pi * TIMES) + 0.2 * np.cos(100 * np.pi * TIMES),
        ),
    ],
)
def test_what_the_force_channel_adds_is_undone(name, values, read):
    found = answer(driven(name), read, **values).output
    np.testing.assert_allclose(found, answer(driven(), PUSH).output, atol=2e-8)


def test_a_force_that_is_read_late_lets_the_position_seem_early():
    late = np.interp(TIMES - 2e-3, TIMES, PUSH)
    found = answer(driven("channel_delay"), late, channel_delay=2e-3).output
    inside = slice(600, -10)
    expected = answer(driven(), PUSH).output
    assert np.abs(found - expected)[inside].max() < 2e-6 < 0.01 * np.ptp(expected)
    assert np.abs(answer(driven(), late).output - expected)[inside].max() > 1e-4


@pytest.mark.parametrize(
    "name",
    [
        "force_gain",
        "force_drift",
        "channel_delay",
        "contact_loss",
        "coulomb_friction",
        "added_mass",
    ],
)
def test_sensitivities_are_the_derivatives_of_the_position(name):
    composition = driven(name)
    kernel, values = composition.kernel, values_of(composition)
    start = np.zeros(len(kernel.states))
    start[0] = 3e-4
    unknowns = np.concatenate([start, values])
    force = 1.5 * PUSH - 0.3

    def at(unknowns):
        start, values = np.split(unknowns.copy(), [len(kernel.states)])
        coil = halved(halved(course(kernel, force, PERIOD, values)))
        return respond(kernel, values, start, coil)

    exact = at(unknowns).sensitivity
    for index in range(unknowns.size):
        change = np.zeros(unknowns.size)
        change[index] = 1e-5 * abs(unknowns[index]) or 1e-8
        difference = (at(unknowns + change).output - at(unknowns - change).output) / 2
        difference /= change[index]
        size = max(np.linalg.norm(difference), 1e-9)
        assert np.linalg.norm(difference - exact[:, index]) < 0.01 * size, index


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("load_cell_stiffness_error", "the load cell's spring, and force_driven has none"),
        ("backlash", "a position that drives the tip, and in force_driven a force does"),
        ("backlash_1", "the load cell's spring"),
        ("encoder_quantization", "a position that drives the tip"),
        ("encoder_interpolation", "a position that drives the tip"),
        ("force_lag", "force_lag distorts the force in a way that cannot be undone"),
    ],
)
def test_what_has_no_meaning_under_a_known_force_is_refused(name, why):
    assert not FORCE_DRIVEN.admits(FORMS[name])
    with pytest.raises(ValueError, match=why):
        _ = driven(name).model


def test_all_other_effects_have_a_meaning():
    assert sum(FORCE_DRIVEN.admits(effect) for effect in EFFECTS.values()) == len(EFFECTS) - 5


def written(path, **changes):
    composition = driven("cubic_stiffening")
    entries = composition.entries(map(str, composition.model.values))
    save(path, composition, {e.name: e.default for e in entries} | changes, {})
    return composition


def test_a_model_file_keeps_the_rig(tmp_path):
    composition = written(tmp_path / "model.yaml", cubic_stiffness=2e7)
    found = load(tmp_path / "model.yaml")
    assert found.composition.rig is FORCE_DRIVEN
    assert found.composition.names == composition.names
    assert found.values["cubic_stiffness"] == 2e7


def test_a_force_cannot_drive_no_mass(tmp_path):
    written(tmp_path / "model.yaml", tip_mass=0.0)
    with pytest.raises(ModelFileError, match=r"tip_mass\.value is 0: give a number from 1e-06"):
        load(tmp_path / "model.yaml")
