"""A recorded channel that drives the force: read, named with its lag and curve, or refused."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tissue_probe as tp
from tissue_probe.errors import TissueProbeError

NOISE = 4e-3
RIGID = {"rig": "rigid_probe", "constants": {"tip_mass": 0.0}}
NAMES = {"force_polarity": "compression", "input2": "pressure_kPa"}


def waves(times, lines, seed):
    """Sines of amplitude 1 over the line's number."""
    phases = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, len(lines))
    return sum(np.sin(2.0 * np.pi * f * times + p) for f, p in zip(lines, phases, strict=True))


def table(seed, lag=0.0, curve=(0.05,), unit=1.0, mean=12.0, every=1):
    """Record a spring and a damper under a pressure that swings by itself, by another integrator.

    The pressure is 0 at no force; it is written in a unit of so many kilopascals.
    """
    times = np.arange(0.0, 5.0, 2.5e-3)
    position = 4e-4 * waves(times, (1.1, 2.3, 3.7), seed)
    speed = np.gradient(position, times)
    pressure = mean + 3.0 * waves(times, (0.37, 0.9), seed + 50)
    felt = pressure
    if lag:

        def slope(time, w):
            return (np.interp(time, times, pressure) - w) / lag

        told = solve_ivp(
            slope, (0.0, 5.0), [mean], t_eval=times, max_step=2.5e-3, rtol=1e-8, atol=1e-8
        )
        felt = told.y[0]
    pushed = sum(c * felt**n for n, c in enumerate(curve, 1))
    noise = NOISE * np.random.default_rng(seed + 99).standard_normal(times.size)
    force = 400.0 * position + 3.0 * speed + pushed + noise
    coarse = np.interp(times, times[::every], pressure[::every]) / unit
    return {"t": times, "u": position, "F": force, "pressure_kPa": coarse}


@pytest.mark.parametrize(
    ("made", "told"),
    [
        ({"lag": 0.15}, {"input2_gain": 0.05, "input2_lag": 0.15}),
        ({"curve": (0.02, 3e-3)}, {"input2_gain": 0.02, "input2_square": 3e-3}),
        # In pascals: numbers a thousand times as large, and the gain as many times smaller.
        ({"unit": 1e-3}, {"input2_gain": 0.05e-3}),
    ],
)
def test_a_channel_that_drives_the_force_is_named_with_its_values_and_carries_over(made, told):
    first, second = (tp.read(table(seed, **made), **NAMES) for seed in (1, 2))
    found = tp.diagnose(first, validate=second, **RIGID)
    assert (found.verdict, found.effects) == ("missing", ("second_input",))
    values = {each.name: each for each in found.answer.values}
    for name, truth in told.items():
        assert values[name].value == pytest.approx(truth, abs=4.0 * values[name].deviation)
        assert values[name].deviation < 0.08 * truth
    assert found.answer.rmse.heldout.final < 1.1 * NOISE


def test_a_channel_that_drives_nothing_is_not_named_and_without_one_none_is_asked_for():
    plain = table(3, curve=(0.0,))
    for names in (NAMES, {"force_polarity": "compression"}):
        assert tp.diagnose(tp.read(plain, **names), **RIGID).verdict == "adequate"


def test_a_model_that_follows_the_channel_needs_it(tmp_path):
    first = tp.read(table(1), **NAMES)
    model = tp.diagnose(first, **RIGID).model
    model.save(tmp_path / "model.yaml")
    again = tp.compare(tp.read(table(2), **NAMES), model=tmp_path / "model.yaml")
    assert again.rmse < 1.1 * NOISE
    with pytest.raises(TissueProbeError, match="follows a second input, and none is given"):
        tp.compare(tp.read(table(2), force_polarity="compression"), model=model)
    with pytest.raises(TissueProbeError, match="give 400 finite samples"):
        tp.simulate(model, np.zeros(400), sample_rate=400.0)
    simulated = tp.simulate(model, np.zeros(400), sample_rate=400.0, input2=np.full(400, 10.0))
    assert simulated.force == pytest.approx(0.5, abs=0.01)


def test_both_recordings_must_have_the_channel():
    first, second = tp.read(table(1), **NAMES), tp.read(table(2), force_polarity="compression")
    with pytest.raises(TissueProbeError, match="has no second input and another recording has"):
        tp.diagnose(first, validate=second, **RIGID)
    bare = table(2)
    del bare["pressure_kPa"]
    with pytest.raises(TissueProbeError, match="no column pressure_kPa; its columns are"):
        tp.diagnose(first, validate=bare, **RIGID)


def with_a_blank(columns):
    columns["pressure_kPa"][[700, 900]] = np.nan
    return columns


@pytest.mark.parametrize(
    ("spoil", "input2", "sentence"),
    [
        (dict, "pressure", "no column pressure; its columns are t, u, F, pressure_kPa"),
        (with_a_blank, "pressure_kPa", "no number in 2 of 2000 rows, first at 1.75 s"),
        (dict, "F", "`force` and `input2` are both F"),
    ],
)
def test_a_channel_that_is_not_there_or_not_known_is_refused_in_one_sentence(
    spoil, input2, sentence
):
    with pytest.raises(TissueProbeError, match=sentence) as raised:
        tp.read(spoil(table(1)), force="F", force_polarity="compression", input2=input2)
    assert "\n" not in str(raised.value)
