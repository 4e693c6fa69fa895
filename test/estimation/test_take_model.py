"""A filter takes another model while it runs: what is known goes along, and no sample is lost."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tissue_probe.estimation import ESTIMATORS, Estimator, EstimatorSettings
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.model_file import save
from tissue_probe.physics.response import course, respond
from tissue_probe.settings import SettingsError
from tissue_probe.signals import SampleBlock, Status, TissueEstimates

# A kernel is compiled for each model.
pytestmark = pytest.mark.timeout(600)

PERIOD, NOISE = 5e-4, 0.005
START = 1_700_000_000_000_000_000
#: Models in files: the tissue without effects and with one, another reading of the position, a late
#: channel, the clock.
MODELS = {
    "plain": (),
    "cubic": ("cubic_stiffening",),
    "play": ("backlash",),
    "late": ("channel_delay",),
    "hum": ("mains_hum",),
    "both": ("cubic_stiffening", "mains_hum"),
}
#: Those that are taken at random.
RANDOM = ["cubic", "play", "late", "hum"]


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> dict[str, str]:
    """A file of each model, with default values; none is Kelvin-Voigt tissue."""
    folder = tmp_path_factory.mktemp("models")
    made = {name: written(folder / f"{name}.yaml", names) for name, names in MODELS.items()}
    return {"none": "", **made}


def composed(names: tuple[str, ...]) -> Composition:
    return Composition(effects=tuple(EFFECTS[name].plain for name in names))


def default_values(composition: Composition) -> dict[str, float]:
    entries = composition.entries(map(str, composition.model.values))
    return {entry.name: entry.default for entry in entries}


def written(path: Path, names: tuple[str, ...]) -> str:
    composition = composed(names)
    save(path, composition, default_values(composition), {})
    return str(path)


def measured(names: tuple[str, ...] = (), samples: int = 4000, seed: int = 1) -> SampleBlock:
    """Samples of a simulated probe, pressed and driven by two sines, begun at rest."""
    composition = composed(names)
    times = np.arange(samples) * PERIOD
    s = np.clip(times / 0.2, 0.0, 1.0)
    sines = 1e-3 * np.sin(44.0 * times) + 4e-4 * np.sin(144.5 * times + 1.0)
    position = s**3 * (10 - 15 * s + 6 * s**2) * (5e-4 + sines)
    kernel, known = composition.kernel, default_values(composition)
    values = np.array([known[name] for name in kernel.values])
    start = np.zeros(len(kernel.states))
    force = respond(kernel, values, start, course(kernel, position, PERIOD, values)).output
    force += NOISE * np.random.default_rng(seed).standard_normal(samples)
    return SampleBlock(START, 0, PERIOD, position, force, np.zeros(samples))


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def own_settings(model: str, tolerant: bool = False) -> EstimatorSettings:
    own = EstimatorSettings(model=model)
    return own.tolerant() if tolerant else own


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ekf", "robust_ekf"])
def test_innovations_fall_to_the_noise_where_the_right_model_is_taken(name, files):
    block = measured(MODELS["cubic"], samples=8000)
    estimator = Estimator(name, EstimatorSettings())
    estimator.take_model(EstimatorSettings(model=files["cubic"]), int(block.stamps[4000]))
    found = estimator.process(block)
    assert estimator.first == (block.stamps[4000], 4000)
    assert estimator.restarts == 0
    assert found.status[3999] == Status.MODEL_REJECTED
    assert rms(found.innovation[2000:4000]) > 1.5 * NOISE
    # A tenth of a second later: what was wrong is forgotten, and nothing jumps.
    assert rms(found.innovation[4200:]) < 1.06 * NOISE
    assert np.abs(found.innovation[4000:]).max() < 2.0 * np.abs(found.innovation[2000:4000]).max()
    assert found.status[-1] == Status.CONVERGED
    assert found.stiffness[-1] == pytest.approx(450.0, rel=0.01)
    assert found.damping[-1] == pytest.approx(5.0, rel=0.02)


@pytest.mark.slow
def test_each_estimate_says_by_which_model_it_was_made(files):
    block = measured()
    estimator = Estimator("ekf", EstimatorSettings())
    estimator.take_model(EstimatorSettings(model=files["cubic"]), int(block.stamps[1000]))
    estimator.take_model(EstimatorSettings(), int(block.stamps[3000]))
    found = estimator.process(block)
    assert set(found.model[:1000]) == set(found.model[3000:]) == {"kelvin_voigt"}
    (name,) = set(found.model[1000:3000])
    assert name.startswith("kelvin_voigt+cubic_stiffening ")
    # Of another content, as of another tissue, it is another model.
    text = Path(files["cubic"]).read_text()
    changed = Path(files["cubic"]).with_name("changed.yaml")
    changed.write_text(text.replace("value: 0.04", "value: 0.041"))
    assert changed.read_text() != text
    again = Estimator("ekf", EstimatorSettings(model=str(changed)))
    assert again.plan.model != name
    assert Estimator("robust_ekf", EstimatorSettings(model=files["cubic"])).plan.model == name


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "before", "after"),
    [("robust_ekf", "none", "cubic"), ("ekf", "hum", "late"), ("ekf", "late", "play")],
)
def test_estimates_do_not_depend_on_how_the_stream_is_cut(name, before, after, files):
    block = measured(MODELS["hum"], samples=2000)
    wholes = []
    for sizes in ((2000,), (10,), (7, 1, 64, 3)):
        estimator = Estimator(name, EstimatorSettings(model=files[before]))
        estimator.take_model(EstimatorSettings(model=files[after]), int(block.stamps[1001]) + 1)
        estimator.restart_at(int(block.stamps[1500]))
        parts, begin = [], 0
        while begin < len(block):
            size = sizes[len(parts) % len(sizes)]
            parts.append(estimator.process(block[begin : begin + size]))
            begin += size
        wholes.append(TissueEstimates.concatenate(parts))
        assert estimator.first == (block.stamps[1001], 1001)
    for whole in wholes[1:]:
        for one, other in zip(whole.arrays(), wholes[0].arrays(), strict=True):
            np.testing.assert_array_equal(one, other)


@pytest.mark.slow
def test_a_model_taken_live_is_taken_at_the_same_sample_off_line(files):
    """Off line the stamp is all that is known of it, of a recording joined to one block."""
    period = 1.0 / 3000.0  # stamps are rounded
    one = measured(samples=2000)
    block = SampleBlock(START, 0, period, one.position, one.force, one.command)
    live = Estimator("ekf", EstimatorSettings())
    parts = []
    for begin in range(0, 2000, 10):
        if begin == 1230:
            live.take_model(EstimatorSettings(model=files["cubic"]))
        parts.append(live.process(block[begin : begin + 10]))
    stamp, sequence = live.first
    assert sequence == 1230
    for off in (-1, 0, 1):
        again = Estimator("ekf", EstimatorSettings())
        again.take_model(EstimatorSettings(model=files["cubic"]), stamp + off)
        whole = again.process(block)
        np.testing.assert_array_equal(
            whole.innovation, TissueEstimates.concatenate(parts).innovation
        )


@pytest.mark.slow
@settings(
    max_examples=30,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(
    before=st.sampled_from(["none", *RANDOM]),
    after=st.sampled_from(["none", *RANDOM]),
    true=st.sampled_from(RANDOM),
    at=st.integers(1, 900),
    seed=st.integers(0, 100),
)
def test_stiffness_and_damping_stay_and_the_covariance_is_definite(
    before, after, true, at, seed, files
):
    """Whichever models: at a sample whose force is missing nothing is learnt, so all must stay."""
    block = measured(MODELS[true], samples=1000, seed=seed)
    force = block.force.copy()
    force[at] = np.nan
    block = SampleBlock(START, 0, PERIOD, block.position, force, block.command)
    estimator = Estimator("ekf", EstimatorSettings(model=files[before]))
    old = estimator.process(block[:at])
    estimator.take_model(EstimatorSettings(model=files[after]))
    new = estimator.process(block[at : at + 1])
    assert new.stiffness[0] == old.stiffness[-1]
    assert new.damping[0] == old.damping[-1]
    covariance = estimator.covariance
    scale = np.sqrt(np.diag(covariance))
    assert np.all(np.isfinite(covariance))
    assert np.linalg.eigvalsh(covariance / np.outer(scale, scale)).min() > 0.0
    if old.status[-1] != Status.MODEL_REJECTED:
        assert new.stiffness_variance[0] == old.stiffness_variance[-1]
        assert new.damping_variance[0] == old.damping_variance[-1]
        both = (old.stiffness_damping_covariance[-1], new.stiffness_damping_covariance[0])
        assert both[0] == both[1]
    rest = estimator.process(block[at + 1 :])
    assert np.all(np.isfinite(rest.stiffness))
    assert np.all(rest.stiffness_variance > 0.0)


@pytest.mark.slow
def test_what_is_known_of_the_rig_is_carried_over_to_another_nominal_value(files, tmp_path):
    """The mass is what it is: told as 1 % more by the file, it is 1 % less in its error."""
    text = Path(files["plain"]).read_text()
    heavier = tmp_path / "heavier.yaml"
    heavier.write_text(text.replace("value: 0.04\n", "value: 0.0404\n"))
    assert heavier.read_text() != text
    block = measured(samples=3000)
    estimator = Estimator("ekf", own_settings(files["plain"], tolerant=True))
    estimator.process(block[:2000])
    stays = Estimator("ekf", own_settings(files["plain"], tolerant=True))
    stays.process(block[:2000])
    estimator.take_model(own_settings(str(heavier), tolerant=True))
    moved, stayed = estimator.process(block[2000:]), stays.process(block[2000:])
    np.testing.assert_allclose(moved.stiffness, stayed.stiffness, rtol=2e-3)
    np.testing.assert_allclose(
        np.sqrt(moved.stiffness_variance), np.sqrt(stayed.stiffness_variance), rtol=0.05
    )
    assert rms(moved.innovation) < 1.05 * NOISE


@pytest.mark.slow
def test_a_hum_keeps_its_phase_where_its_strengths_are_carried_over(files):
    block = measured(MODELS["both"], samples=6000)
    estimator = Estimator("ekf", EstimatorSettings(model=files["hum"]))
    estimator.process(block[:4000])
    estimator.take_model(EstimatorSettings(model=files["both"]))
    after = estimator.process(block[4000:])
    assert rms(after.innovation[400:]) < 1.06 * NOISE


def test_a_model_before_the_first_sample_begins_with_its_priors(files):
    block, cubic = measured(samples=300), EstimatorSettings(model=files["cubic"])
    taken, fresh = Estimator("ekf", EstimatorSettings()), Estimator("ekf", cubic)
    taken.take_model(cubic)
    ours, theirs = taken.process(block), fresh.process(block)
    for one, other in zip(ours.arrays(), theirs.arrays(), strict=True):
        np.testing.assert_array_equal(one, other)


def test_what_cannot_be_taken_is_refused_and_the_filter_goes_on(files, tmp_path):
    block = measured(samples=400)
    estimator = Estimator("ekf", EstimatorSettings())
    estimator.process(block[:200])
    other_rig = tmp_path / "rigid.yaml"
    rigid = Composition("rigid_probe")
    save(other_rig, rigid, default_values(rigid), {})
    for model, said in (
        (str(tmp_path / "nowhere.yaml"), "No such file"),
        (str(other_rig), "rig rigid_probe cannot run live"),
    ):
        with pytest.raises(ValueError, match=said):
            estimator.take_model(EstimatorSettings(model=model))
    with pytest.raises(ValueError, match="only model and effects may change"):
        estimator.take_model(EstimatorSettings(force_noise=0.1))
    with pytest.raises(SettingsError, match="knows Kelvin-Voigt tissue only"):
        Estimator("rls", EstimatorSettings()).take_model(EstimatorSettings(model=files["cubic"]))
    whole = Estimator("ekf", EstimatorSettings()).process(block)
    np.testing.assert_array_equal(estimator.process(block[200:]).stiffness, whole.stiffness[200:])


@pytest.mark.parametrize("name", list(ESTIMATORS))
def test_every_estimator_takes_the_plain_model_again_and_goes_on(name):
    block = measured(samples=600)
    estimator = Estimator(name, EstimatorSettings())
    estimator.process(block[:300])
    estimator.take_model(EstimatorSettings())
    after = estimator.process(block[300:])
    whole = Estimator(name, EstimatorSettings()).process(block)
    np.testing.assert_allclose(after.stiffness, whole.stiffness[300:], rtol=1e-3)
