"""On what a missing force depends: the right variables, the curve, and when nothing is claimed."""

import pickle
import re
import sys

import numpy as np
import pytest

from tissue_probe.diagnosis.diagnosis import fit_plainly
from tissue_probe.diagnosis.improvement.ladder import climb_by
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.other_runs import carry_model
from tissue_probe.diagnosis.shape.effect_file import NAME, effect_text
from tissue_probe.diagnosis.shape.shape_report import FoundShape, find_shape
from tissue_probe.errors import MeasurementError
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.library import effects

RATE, NOISE = 1000.0, 5e-3
KNOWN = Instrument("rigid_probe", {"tip_mass": (0.0, 0.0), "contact_position": (0.0, 0.0)})


def moved(seconds=3.0, seed=0):
    """Return time, position and velocity of a tip led by twelve sines at once."""
    random = np.random.default_rng(seed)
    t = np.arange(round(seconds * RATE)) / RATE
    w = 2.0 * np.pi * np.linspace(1.0, 23.0, 12)
    angle = np.multiply.outer(t, w) + random.uniform(0.0, 2.0 * np.pi, w.size)
    return t, 3e-4 * np.sin(angle).sum(axis=1), 3e-4 * (w * np.cos(angle)).sum(axis=1)


def steady(seconds=3.0):
    t = np.arange(round(seconds * RATE)) / RATE
    w = 2.0 * np.pi * 7.0
    return t, 1e-3 * np.sin(w * t + 0.3), 1e-3 * w * np.cos(w * t + 0.3)


def measured(motion, law, seed=1):
    t, x, v = motion
    noise = NOISE * np.random.default_rng(seed).standard_normal(t.size)
    return Measurement(x, 400.0 * x + 4.0 * v + law(x, v) + noise, 1.0 / RATE)


def learnt(motion, law) -> FoundShape:
    base = fit_plainly(Composition("rigid_probe"), [measured(motion, law)], KNOWN)
    return find_shape([base], KNOWN)


def relaxing(x, v):
    """Return the force of a spring of 300 N/m in series with a damper, which yields at 15 /s."""
    z = np.zeros(x.size)
    for n in range(1, x.size):
        z[n] = np.exp(-15.0 / RATE) * z[n - 1] + x[n] - x[n - 1]
    return 300.0 * z


LAWS = {
    ("indentation",): lambda x, v: 1e7 * x**3,
    ("velocity",): lambda x, v: 40.0 * v * np.abs(v),
    ("past",): relaxing,
    ("indentation", "velocity"): lambda x, v: 400.0 * np.maximum(x, 0.0) * v,
}


@pytest.mark.parametrize("variables", LAWS, ids="+".join)
def test_the_variables_of_a_force_are_found(variables):
    found = learnt(moved(), LAWS[variables])
    assert found.variables == variables
    assert found.accepted
    assert found.told
    assert found.share > 0.98
    assert all(found.shares[n].beyond < 0.02 for n in found.shares if n not in variables)


def test_the_band_of_a_curve_holds_the_true_one():
    motion = moved()
    found = learnt(motion, LAWS["indentation",])
    grid, x = found.curve.grid[0], motion[1]
    true = 1e7 * grid**3
    line = np.polyfit(x, 1e7 * x**3, 1)
    off = (found.curve.value - true + np.polyval(line, grid)) / found.curve.sd
    assert np.mean(np.abs(off) < 2.0) > 0.8
    assert np.ptp(found.curve.grid[0]) == pytest.approx(np.ptp(x))


def test_a_formula_is_named_with_its_constants():
    formula = learnt(moved(), LAWS["velocity",]).formula
    assert formula.name == "power, odd"
    assert "abs(velocity / 0.1)**a" in formula.text
    _, power = formula.constants
    assert power.low < 2.0 < power.high
    assert power.value == pytest.approx(2.0, abs=0.1)


def wave(x, v):
    """Return the force of a corrugated surface."""
    return 0.05 * np.sin(x / 2e-4)


def test_no_form_of_the_catalogue_is_a_wave(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyoperon.sklearn", None)
    found = learnt(moved(), wave)
    assert found.variables == ("indentation",)
    assert found.formula is None


def test_a_wave_is_found_by_symbolic_regression(tmp_path):
    found = learnt(moved(), wave)
    assert found.accepted
    written = found.formula.text
    strength, stretch = found.formula.constants
    assert strength.low < strength.value < strength.high
    assert abs(strength.value) == pytest.approx(0.05, rel=0.03)
    (frequency,) = re.findall(r"sin\(([0-9.]+)\*a\*indentation\)", written)
    assert float(frequency) * stretch.value == pytest.approx(5000.0, rel=0.01)
    # Processes hand it to one another.
    assert pickle.loads(pickle.dumps(found.formula)).text == written
    path = tmp_path / "my_effect.py"
    path.write_text(effect_text(found), encoding="utf-8")
    assert [each.name for each in effects([path])[NAME].parameters] == [
        "free_form_strength",
        "free_form_shape",
    ]


def test_a_shape_that_does_not_carry_over_to_a_second_recording_is_not_claimed():
    law, other = LAWS["indentation",], lambda x, v: 2e7 * x**3
    base = fit_plainly(Composition("rigid_probe"), [measured(moved(), law)], KNOWN)
    same, another = (measured(moved(seed=4), each, 2) for each in (law, other))
    assert find_shape([base], KNOWN, [same]).accepted
    refused = find_shape([base], KNOWN, [another])
    assert refused.as_effect.leaves_noise
    assert not refused.as_effect.carries_over
    assert (refused.accepted, refused.curve) == (False, None)


def test_where_nothing_is_missing_nothing_is_claimed():
    found = learnt(moved(), lambda x, v: 0.0 * x)
    assert found.variables == ()
    assert not found.accepted
    assert found.curve is None


def test_one_steady_sine_does_not_tell_what_it_cannot():
    found = learnt(steady(), lambda x, v: 2e8 * x**3)
    assert not found.told
    assert found.curve is None


def test_what_no_function_explains_is_not_claimed():
    random = np.random.default_rng(5)
    found = learnt(moved(), lambda x, v: 0.03 * random.standard_normal(x.size).cumsum() / 20.0)
    assert not (found.accepted and found.variables[:1] != ("clock",))


@pytest.mark.parametrize("variables", [("indentation",), ("velocity",), ("past",)], ids="+".join)
def test_the_file_of_a_shape_is_an_effect_that_carries_over(variables, tmp_path):
    first, law = moved(), LAWS[variables]
    found = learnt(first, law)
    path = tmp_path / "my_effect.py"
    path.write_text(effect_text(found), encoding="utf-8")
    effect = effects([path])[NAME]
    with_it = climb_by(found.fit.composition, found.fit.measurements, KNOWN, [effect]).final
    assert with_it.ratio < 1.05
    t, x, v = moved(seed=3)
    other = measured((t, 0.5 * x, 0.5 * v), law, seed=4)
    on = carry_model(with_it.composition, with_it.named(), [other], KNOWN)
    assert on.rmse < 1.1 * NOISE


def test_no_effect_is_made_of_a_shape_that_is_not_claimed():
    with pytest.raises(MeasurementError, match="no shape of the missing force is claimed"):
        effect_text(learnt(moved(), lambda x, v: 0.0 * x))
