"""The filters on a model file: innovations fall to the noise, and what cannot run is refused."""

from pathlib import Path

import numpy as np
import pytest

from tissue_probe.estimation import ESTIMATORS, Estimator, EstimatorSettings
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.library import effects
from tissue_probe.physics.model_file import save
from tissue_probe.physics.response import course, respond
from tissue_probe.settings import SettingsError
from tissue_probe.signals import SampleBlock, Status, TissueEstimates

# A kernel is compiled for each model.
pytestmark = pytest.mark.timeout(600)

EXAMPLE = Path(__file__).parents[2] / "docs" / "my_effect.py"
PERIOD, NOISE = 5e-4, 0.005
START = 1_700_000_000_000_000_000


def default_values(composition):
    entries = composition.entries(map(str, composition.model.values))
    return {entry.name: entry.default for entry in entries}


def written(path, composition, **changes):
    """A model file of default values, some of them changed."""
    save(path, composition, default_values(composition) | changes, {})
    return str(path)


def measured(composition, samples=5000, mean=5e-4, seed=1, **changes):
    """Samples of a simulated probe, pressed and driven by two sines, begun at rest."""
    times = np.arange(samples) * PERIOD
    s = np.clip(times / 0.2, 0.0, 1.0)
    sines = 1e-3 * np.sin(44.0 * times) + 4e-4 * np.sin(144.5 * times + 1.0)
    position = s**3 * (10 - 15 * s + 6 * s**2) * (mean + sines)
    kernel = composition.kernel
    known = default_values(composition) | changes
    values = np.array([known[name] for name in kernel.values])
    start = np.zeros(len(kernel.states))
    force = respond(kernel, values, start, course(kernel, position, PERIOD, values)).output
    force += NOISE * np.random.default_rng(seed).standard_normal(samples)
    return SampleBlock(START, 0, PERIOD, position, force, np.zeros(samples))


def rms(values):
    return float(np.sqrt(np.mean(values**2)))


def last_half(estimates):
    return estimates[len(estimates) // 2 :]


#: How an effect comes into a filter is the same for each: of most the ``ekf`` stands for all, whose
#: code is compiled in half the time.
CASES = [
    ("robust_ekf", "cubic_stiffening"),  # nonlinear
    ("robust_ekf", "standard_linear_solid"),  # a state of its own
    pytest.param("ukf", "standard_linear_solid", marks=pytest.mark.battery),
    ("ekf", "force_lag"),  # a state in the output
    ("ekf", "mains_hum"),  # the time in the output, strengths estimated
    pytest.param("robust_ekf", "mains_hum", marks=pytest.mark.battery),
    pytest.param("robust_ekf", "contact_loss", marks=pytest.mark.battery),  # a switch
    pytest.param("ekf", "encoder_interpolation", marks=pytest.mark.battery),  # the position
    ("ekf", "coulomb_friction"),  # the tip sticks
    pytest.param("robust_ekf", "coulomb_friction", marks=pytest.mark.battery),
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "effect"), CASES)
def test_innovations_fall_to_the_noise_on_the_same_data(name, effect, tmp_path):
    form = next((each for each in EFFECTS[effect].every_form if each.moving != 1), EFFECTS[effect])
    composition = Composition(effects=(form,))
    changes = {"interpolation_sine": 3e-6} if effect == "encoder_interpolation" else {}
    block = measured(composition, **changes)
    path = written(tmp_path / "model.yaml", composition, **changes)
    plain = Estimator(name, EstimatorSettings()).process(block)
    improved = Estimator(name, EstimatorSettings(model=path)).process(block)
    assert rms(last_half(plain).innovation) > 1.5 * NOISE
    assert rms(last_half(improved).innovation) < 1.05 * NOISE
    # Wrong derivatives of the output would show in how far the filter believes itself.
    assert np.mean(last_half(improved).normalized_innovation_squared) == pytest.approx(1.0, abs=0.1)
    assert improved.stiffness[-1] == pytest.approx(450.0, rel=0.01)
    assert improved.damping[-1] == pytest.approx(5.0, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(
    "effect",
    ["standard_linear_solid", pytest.param("generalized_maxwell", marks=pytest.mark.battery)],
)
def test_on_tissue_that_relaxes_the_filter_converges_as_surely_as_it_claims(effect, tmp_path):
    """As the node runs it, in blocks of ten; the recordings differ in their noise."""
    composition = Composition(effects=(EFFECTS[effect],))
    path = written(tmp_path / "model.yaml", composition)
    deviations, nis = [], []
    for seed in range(1000, 1010):
        block = measured(composition, samples=6000, seed=seed)
        estimator = Estimator("robust_ekf", EstimatorSettings(model=path))
        parts = [estimator.process(block[i : i + 10]) for i in range(0, len(block), 10)]
        latest = last_half(TissueEstimates.concatenate(parts))
        assert np.all(latest.status == Status.CONVERGED)
        assert latest.stiffness[-1] == pytest.approx(450.0, rel=1e-3)
        assert latest.damping[-1] == pytest.approx(5.0, rel=2e-3)
        deviations.append((latest.stiffness - 450.0) / np.sqrt(latest.stiffness_variance))
        nis.append(latest.normalized_innovation_squared)
    assert np.mean(np.abs(deviations) < 2.0) >= 0.85
    assert 0.93 <= np.mean(np.array(nis) < 3.841) <= 0.97  # chi squared, one degree of freedom
    assert np.mean(nis) == pytest.approx(1.0, abs=0.07)


@pytest.mark.battery
def test_a_surface_that_breathes_is_followed(tmp_path):
    """The time is in the motion; phase and stiffness multiply, so that both take their time."""
    composition = Composition(effects=(EFFECTS["tissue_motion"],))
    block = measured(composition)
    path = written(tmp_path / "model.yaml", composition)
    plain = Estimator("robust_ekf", EstimatorSettings()).process(block)
    improved = Estimator("robust_ekf", EstimatorSettings(model=path)).process(block)
    before, after = rms(last_half(plain).innovation), rms(last_half(improved).innovation)
    assert before > 1.5 * NOISE
    assert after - NOISE < 0.3 * (before - NOISE)
    assert improved.stiffness[-1] == pytest.approx(450.0, rel=0.02)


@pytest.mark.slow
def test_a_model_file_without_effects_is_the_plain_filter(tmp_path):
    block = measured(Composition(), samples=1000)
    path = written(tmp_path / "model.yaml", Composition())
    plain = Estimator("ekf", EstimatorSettings()).process(block)
    same = Estimator("ekf", EstimatorSettings(model=path)).process(block)
    np.testing.assert_allclose(same.stiffness, plain.stiffness, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(same.innovation, plain.innovation, atol=1e-9)


@pytest.mark.slow
def test_the_tool_is_the_files(tmp_path):
    block = measured(Composition(), tip_mass=0.06)
    path = written(tmp_path / "model.yaml", Composition(), tip_mass=0.06)
    estimates = Estimator("ekf", EstimatorSettings(model=path)).process(block)
    assert estimates.stiffness[-1] == pytest.approx(450.0, rel=0.01)
    again = Estimator("ekf", EstimatorSettings(tip_mass=0.06)).process(block)
    np.testing.assert_allclose(again.stiffness, estimates.stiffness, rtol=1e-6, atol=1e-6)


@pytest.mark.slow
def test_a_model_that_knows_the_time_gives_the_same_in_blocks_of_any_size(tmp_path):
    composition = Composition(effects=(EFFECTS["mains_hum"],))
    block = measured(composition, samples=2000)
    settings = EstimatorSettings(model=written(tmp_path / "model.yaml", composition))
    whole = Estimator("ekf", settings).process(block)
    cut = Estimator("ekf", settings)
    pieces = [cut.process(block[i : i + 7]) for i in range(0, 2000, 7)]
    np.testing.assert_array_equal(TissueEstimates.concatenate(pieces).innovation, whole.innovation)


@pytest.mark.slow
def test_a_phase_is_learnt_anew_after_a_gap(tmp_path):
    composition = Composition(effects=(EFFECTS["mains_hum"],))
    block = measured(composition, hum_sine=0.05)
    path = written(tmp_path / "model.yaml", composition, hum_sine=0.05)
    estimator = Estimator("ekf", EstimatorSettings(model=path))
    estimator.process(block[:2000])
    after = estimator.process(block[2007:])
    assert estimator.gaps == 1
    assert rms(after.innovation[1000:]) < 1.05 * NOISE


@pytest.mark.battery
def test_strengths_can_be_estimated_too(tmp_path):
    """The file is of another tissue, three times less curved."""
    composition = Composition(effects=(EFFECTS["cubic_stiffening"],))
    block = measured(composition, cubic_stiffness=6e7)
    path = written(tmp_path / "model.yaml", composition, cubic_stiffness=1.8e8)
    held = Estimator("ekf", EstimatorSettings(model=path)).process(block)
    free = Estimator("ekf", EstimatorSettings(model=path, estimate_effects=True)).process(block)
    assert rms(last_half(held).innovation) > 1.5 * NOISE
    assert rms(last_half(free).innovation) < 1.05 * NOISE
    assert free.stiffness[-1] == pytest.approx(450.0, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("delay", [3e-4, 2.2e-3, -1.3e-3])
def test_a_channel_that_is_late_is_read_as_late(delay, tmp_path):
    composition = Composition(effects=(EFFECTS["channel_delay"],))
    block = measured(composition, channel_delay=delay)
    path = written(tmp_path / "model.yaml", composition, channel_delay=delay)
    plain = Estimator("ekf", EstimatorSettings()).process(block)
    improved = Estimator("ekf", EstimatorSettings(model=path))
    cut = [improved.process(block[i : i + 7]) for i in range(0, len(block), 7)]
    estimates = TissueEstimates.concatenate(cut)
    assert rms(last_half(estimates).innovation) < 1.05 * NOISE
    assert rms(last_half(plain).innovation) > rms(last_half(estimates).innovation)
    assert estimates.stiffness[-1] == pytest.approx(450.0, rel=0.01)
    assert estimates.damping[-1] == pytest.approx(5.0, rel=0.02)
    assert abs(plain.damping[-1] - 5.0) > 5 * abs(estimates.damping[-1] - 5.0)
    whole = Estimator("ekf", EstimatorSettings(model=path)).process(block)
    np.testing.assert_array_equal(whole.innovation, estimates.innovation)


@pytest.mark.slow
@pytest.mark.parametrize("effect", ["stiffness_step", "stiffness_ramp"])
def test_a_stiffness_that_changes_is_followed_whenever_it_does(effect, tmp_path):
    composition = Composition(effects=(EFFECTS[effect],))
    path = written(tmp_path / "model.yaml", composition)
    block = measured(Composition())
    plain = Estimator("ekf", EstimatorSettings()).process(block)
    improved = Estimator("ekf", EstimatorSettings(model=path)).process(block)
    np.testing.assert_allclose(improved.stiffness, plain.stiffness, rtol=1e-6, atol=1e-6)


PLAY = EFFECTS["backlash"].plain


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ["ekf", pytest.param("ukf", marks=pytest.mark.battery)])
def test_play_of_the_drive_is_taken_up_from_sample_to_sample(estimator, tmp_path):
    composition = Composition(effects=(PLAY,))
    block = measured(composition, backlash_width=2e-4)
    path = written(tmp_path / "model.yaml", composition, backlash_width=2e-4)
    plain = Estimator(estimator, EstimatorSettings()).process(block)
    improved = Estimator(estimator, EstimatorSettings(model=path))
    cut = [improved.process(block[i : i + 7]) for i in range(0, len(block), 7)]
    estimates = TissueEstimates.concatenate(cut)
    assert rms(last_half(estimates).innovation) < 1.05 * NOISE
    assert rms(last_half(plain).innovation) > 2.0 * rms(last_half(estimates).innovation)
    assert estimates.stiffness[-1] == pytest.approx(450.0, rel=0.01)
    assert estimates.damping[-1] == pytest.approx(5.0, rel=0.02)
    whole = Estimator(estimator, EstimatorSettings(model=path)).process(block)
    np.testing.assert_array_equal(whole.innovation, estimates.innovation)


TRAILING = """
import sympy as sp
from tissue_probe.physics.effects.effect import POSITION, POSITION_RATE, Effect, Parameter, State

LAG, END = sp.Symbol("cable_lag", real=True), sp.Symbol("cable_end", real=True)
EFFECT = Effect(
    name="cable",
    family="lost motion",
    physics="A cable drags the load cell's end behind the coil",
    parameters=(Parameter(LAG, "s", default=1e-3, lower=0.0, upper=1e-2),),
    coil=(END, (POSITION - END) / LAG),
    states=(State(END, (POSITION - END) / LAG, start=POSITION),),
)
"""


TIMED = """
import sympy as sp
from tissue_probe.physics.effects.effect import INDENTATION, TIME, Effect, Parameter

RATE = sp.Symbol("thawing_rate", real=True)
EFFECT = Effect(
    name="thawing",
    family="time-varying",
    physics="The tissue stiffens less and less as it thaws",
    parameters=(Parameter(RATE, "N/(m^3 s)", default=1e6, lower=-1e9, upper=1e9),),
    force=RATE * TIME * INDENTATION**3,
)
"""


REFUSED = {
    "thawing": (TIMED, "it happens at a time of the recording that it was fitted to"),
    "cable": (TRAILING, "it moves the coil, and does not say how from sample to sample"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_run_live_is_refused_in_one_sentence(name, tmp_path):
    text, why = REFUSED[name]
    file = tmp_path / "own.py"
    file.write_text(text)
    composition, path = Composition(effects=(effects([file])[name],)), tmp_path / "model.yaml"
    save(path, composition, default_values(composition), {}, effect_files=[file])
    with pytest.raises(SettingsError, match=f"{name} cannot run live: {why}") as failure:
        Estimator("robust_ekf", EstimatorSettings(model=str(path), effects=[str(file)]))
    assert str(failure.value).startswith(str(path))
    assert "\n" not in str(failure.value)


def test_an_effect_of_ones_own_runs_live_where_its_file_is_named(tmp_path):
    composition = Composition(effects=(effects([EXAMPLE])["quadratic_drag"],))
    path = tmp_path / "model.yaml"
    save(path, composition, default_values(composition), {}, effect_files=[EXAMPLE])
    with pytest.raises(SettingsError, match=r"quadratic_drag.*name it by `effects`"):
        Estimator("ekf", EstimatorSettings(model=str(path)))
    named = EstimatorSettings(model=str(path), effects=[str(EXAMPLE)])
    estimates = Estimator("ekf", named).process(measured(composition))
    assert rms(last_half(estimates).innovation) < 1.05 * NOISE


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.6, 1.0, 1.6])
@pytest.mark.parametrize(
    "estimator",
    ["ekf", *(pytest.param(name, marks=pytest.mark.battery) for name in ("robust_ekf", "afekf"))],
)
def test_a_fluid_is_followed_from_about_the_values_of_the_file(estimator, share, tmp_path):
    fluid = Composition(tissue="maxwell")
    block = measured(fluid, samples=6000, stiffness=450.0, damping=5.0)
    began = {"stiffness": 450.0 * share, "damping": 5.0 / share}
    path = written(tmp_path / "fluid.yaml", fluid, **began)
    estimates = Estimator(estimator, EstimatorSettings(model=path)).process(block)
    assert rms(last_half(estimates).innovation) < 1.05 * NOISE
    assert estimates.status[-1] == Status.CONVERGED
    assert estimates.stiffness[-1] == pytest.approx(450.0, rel=0.01)
    assert estimates.damping[-1] == pytest.approx(5.0, rel=0.01)


def test_only_the_compliant_probe_runs_live(tmp_path):
    for rig in ("rigid_probe", "force_driven"):
        other = written(tmp_path / "other.yaml", Composition(rig))
        with pytest.raises(SettingsError, match=f"rig {rig} cannot run live"):
            Estimator("ekf", EstimatorSettings(model=other))


@pytest.mark.parametrize("name", ["lock_in", "rls"])
def test_what_is_no_kalman_filter_takes_no_model(name, tmp_path):
    assert name in ESTIMATORS
    path = written(tmp_path / "model.yaml", Composition())
    with pytest.raises(SettingsError, match=f"{name} knows Kelvin-Voigt tissue only"):
        Estimator(name, EstimatorSettings(model=path))
