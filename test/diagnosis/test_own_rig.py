"""A rig of a user's own, in one file: diagnosed, saved, compared as those of the package."""

import importlib.util
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tissue_probe as tp
from tissue_probe.errors import ParameterError
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.model_file import ModelFileError
from tissue_probe.physics.response import course, respond

#: The kernels of every effect are compiled where no earlier run has done so.
pytestmark = pytest.mark.timeout(900)

EXAMPLE = Path(__file__).parents[2] / "docs" / "my_rig.py"
#: Platform and tip [kg], spring and its damper [N/m, N s/m], damping of the tissue [N s/m].
HEAVY, LIGHT, SPRING, DAMPER, DAMPING = 0.0503, 0.0199, 3050.0, 0.34, 5.0
TIMES, ENCODER = np.arange(4000) * 5e-4, 2e-7
KELVIN_VOIGT = {"stiffness": 450.0, "damping": DAMPING}
LAWS = {
    None: (lambda x: 450.0 * x, KELVIN_VOIGT),
    "cubic_stiffening": (lambda x: 450.0 * x + 1e8 * x**3, KELVIN_VOIGT | {"cubic_stiffness": 1e8}),
    # A sphere: the stiffness is the secant's at 1 mm.
    "hertz_contact": (
        lambda x: 1.5e4 * max(x, 0.0) ** 1.5,
        {"stiffness": 1.5e4 * 1e-3**0.5, "damping": DAMPING, "contact_exponent": 1.5},
    ),
}


def load(path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.PLATFORM


@pytest.fixture(scope="module")
def platform():
    return load(EXAMPLE)


def push(t):
    """A preload, begun gently, and a sweep from 2 to 60 Hz [N]."""
    begun = np.minimum(t / 0.1, 1.0) ** 4
    return 0.5 * (1.0 - np.exp(-((t / 0.1) ** 4))) + 0.35 * begun * np.sin(
        2 * np.pi * (2.0 * t + 14.5 * t**2)
    )


def recorded(law):
    """A platform pushed by a force, without the package's symbols; an encoder that is noisy."""

    def rate(t, z):
        x, v, p, q = z
        spring = SPRING * (p - x) + DAMPER * (q - v)
        return [v, (spring - law(x) - DAMPING * v) / LIGHT, q, (push(t) - spring) / HEAVY]

    moved = solve_ivp(
        rate, (0.0, TIMES[-1]), np.zeros(4), "DOP853", TIMES,
        rtol=1e-10, atol=1e-14, max_step=5e-4,
    ).y[2]  # fmt: skip
    noisy = moved + ENCODER * np.random.default_rng(0).standard_normal(TIMES.size)
    return tp.read({"t": TIMES, "u": noisy, "F": push(TIMES)}, force_polarity="compression")


@pytest.mark.parametrize(
    "effect", [None, pytest.param("cubic_stiffening", marks=pytest.mark.battery), "hertz_contact"]
)
def test_its_tissue_and_the_hidden_effect_are_found(platform, effect):
    law, values = LAWS[effect]
    found = tp.diagnose(recorded(law), rig=platform, starts="at-rest")
    assert found.verdict == ("missing" if effect else "adequate")
    assert found.effects == ((effect,) if effect else ())
    for name, value in values.items():
        assert found.model.values[name] == pytest.approx(value, rel=5e-3), name
    # Known to 1 or 1.5 % beforehand, and told by the motion.
    for name, value in (
        ("platform_mass", HEAVY),
        ("tip_mass", LIGHT),
        ("spring_stiffness", SPRING),
    ):
        assert found.model.values[name] == pytest.approx(value, rel=5e-3), name


def test_its_model_file_is_read_again_with_the_rig_that_the_user_gives(platform, tmp_path):
    recording, path = recorded(LAWS[None][0]), tmp_path / "model.yaml"
    first = tp.compare(recording, rig=platform, starts="at-rest")
    first.model.save(path)
    with pytest.raises(ModelFileError, match="rig is 'platform': give one of compliant_probe"):
        tp.load_model(path)
    assert tp.load_model(path, rig=platform).values == first.model.values
    again = tp.compare(recording, model=path, rig=platform, starts="at-rest")
    assert again.rmse == pytest.approx(first.rmse, rel=1e-3)
    assert again.rmse == pytest.approx(ENCODER, rel=0.05)


def test_effects_on_what_it_has_not_are_refused(platform):
    told = {name for name, effect in EFFECTS.items() if platform.obstacle(effect)}
    driven_by_position = {"encoder_quantization", "encoder_interpolation"}
    assert told == {"load_cell_stiffness_error", "backlash", "force_lag", *driven_by_position}
    with pytest.raises(ValueError, match="the load cell's spring, and platform has none"):
        platform.compose([EFFECTS["load_cell_stiffness_error"]])


def test_other_equations_under_the_same_name_have_code_of_their_own(platform):
    def heavier(effects, tissue, zero):
        model = platform.equations(effects, tissue, zero)
        return replace(model, motion=model.motion.subs(model.constants[1], 2 * model.constants[1]))

    def moved(rig, **changes):
        kernel = Composition(rig).kernel
        values = {each.name: each.value for each in rig.constants} | KELVIN_VOIGT | changes
        numbers = np.array([values[name] for name in kernel.values])
        return respond(
            kernel, numbers, np.zeros(4), course(kernel, push(TIMES), 5e-4, numbers)
        ).output

    doubled = moved(replace(platform, equations=heavier))
    np.testing.assert_allclose(doubled, moved(platform, platform_mass=0.1), atol=1e-12)
    assert np.abs(doubled - moved(platform)).max() > 1e-5


def test_the_name_of_another_rig_and_a_constant_that_is_not_declared_are_told(platform):
    with pytest.raises(ParameterError, match="`rig` has the name of another rig, rigid_probe"):
        tp.compare(recorded(LAWS[None][0]), rig=replace(platform, name="rigid_probe"))
    with pytest.raises(ValueError, match="platform has no constant tip_mass: declare it"):
        replace(platform, constants=platform.constants[1:]).compose()
