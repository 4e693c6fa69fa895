"""A stiffness becomes a modulus by the tip's shape: closed forms, published numbers, errors."""

import math

import pytest

import tissue_probe as tp
from tissue_probe.errors import TissueProbeError
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.fitted_model import FittedModel
from tissue_probe.physics.indenters import Indenter

MODULUS = 20e3
FLAT = {"indenter": "flat", "radius": 3e-3}


def straight(stiffness):
    return FittedModel(Composition(), {"stiffness": stiffness}, {"stiffness": 0.01 * stiffness})


def having(*names, tissue="kelvin_voigt", stiffness=300.0):
    composition = Composition(tissue=tissue, effects=tuple(EFFECTS[name] for name in names))
    values = {"stiffness": stiffness, "contact_exponent": 1.5}
    return FittedModel(composition, values, {"stiffness": 0.01 * stiffness})


def powered(stiffness, exponent):
    values = {"stiffness": stiffness, "contact_exponent": exponent}
    composition = Composition(effects=(EFFECTS["hertz_contact"],))
    return FittedModel(composition, values, {"stiffness": 0.02 * stiffness})


def test_a_flat_punch_needs_its_radius_only():
    stiffness = 2.0 * 2e-3 * MODULUS / (1.0 - 0.45**2)
    found = tp.modulus(straight(stiffness), "flat", radius=2e-3, poisson=0.45)
    assert found.value == pytest.approx(MODULUS)
    assert found.deviation == pytest.approx(0.01 * MODULUS)


def test_a_sphere_by_its_law_or_by_a_stiffness_at_a_depth():
    radius, plane, depth = 3e-3, MODULUS / 0.75, 7e-4
    at_reference = 4.0 / 3.0 * plane * math.sqrt(radius) * 1e-3**0.5
    found = tp.modulus(powered(at_reference, 1.5), "sphere", radius=radius)
    assert found.value == pytest.approx(MODULUS)
    assert found.deviation == pytest.approx(0.02 * MODULUS)
    slope = 2.0 * plane * math.sqrt(radius * depth)
    assert tp.modulus(straight(slope), "sphere", radius=radius, depth=depth).value == pytest.approx(
        MODULUS
    )


def test_a_cone_by_its_law():
    stiffness = 2.0 / math.pi * MODULUS / 0.75 * math.tan(math.radians(35.0)) * 1e-3
    found = tp.modulus(powered(stiffness, 2.0), "cone", half_angle=35.0)
    assert found.value == pytest.approx(MODULUS)


@pytest.mark.parametrize(("chi", "times"), [(0.1, 1.12691), (0.4, 1.71019), (0.9, 3.68350)])
def test_a_thin_layer_stiffens_as_published(chi, times):
    """For an incompressible bonded layer: Dimitriadis et al. (2002), eq. 12."""
    radius, depth = 3e-3, 5e-4
    layer = math.sqrt(radius * depth) / chi
    thin, thick = Indenter("sphere", radius, layer=layer), Indenter("sphere", radius)
    assert thin.force(depth) / thick.force(depth) == pytest.approx(times, rel=1e-4)
    found = tp.modulus(powered(300.0, 1.5), "sphere", radius=radius, layer=layer, depth=depth)
    whole = tp.modulus(powered(300.0, 1.5), "sphere", radius=radius, depth=depth)
    assert found.value == pytest.approx(whole.value / times, rel=1e-4)


@pytest.mark.parametrize(
    ("model", "stated", "sentence"),
    [
        (straight(300.0), {"indenter": "sphere", "radius": 3e-3}, "`depth`: the stiffness under"),
        (straight(300.0), {"indenter": "sphere"}, "needs `radius`"),
        (straight(300.0), {"indenter": "cone"}, "needs `half_angle`"),
        (straight(300.0), {"indenter": "flat", "radius": 3e-3, "layer": 1e-2}, "leave `layer` out"),
        (straight(300.0), {"indenter": "flat", "radius": 3e-3, "poisson": 0.6}, "`poisson` is 0.6"),
        (
            powered(300.0, 1.5),
            {"indenter": "sphere", "radius": 3e-3, "layer": 1e-2, "poisson": 0.4},
            "known for a `poisson` of 0.5",
        ),
        (powered(300.0, 2.2), {"indenter": "sphere", "radius": 3e-3}, "differs with the depth"),
        (straight(0.0), {"indenter": "flat", "radius": 3e-3}, "no stiffness above 0"),
        (
            straight(300.0),
            {"indenter": "sphere", "radius": 3e-3, "half_angle": 30.0},
            "sphere has no `half_angle`",
        ),
        (
            straight(300.0),
            {"indenter": "cone", "radius": 3e-3, "half_angle": 30.0},
            "cone has no `radius`",
        ),
        (having(tissue="maxwell"), FLAT, "maxwell tissue, which flows"),
        (having("cubic_stiffening"), FLAT, "curved .*: cubic_stiffening;"),
        (having("bilinear_spring"), FLAT, "curved .*: bilinear_spring;"),
        (having("saturating_spring"), FLAT, "curved .*: saturating_spring;"),
        (having("exponential_stiffening"), FLAT, "curved .*: exponential_stiffening;"),
        (having("hertz_contact", "bilinear_spring"), FLAT, "curved .*: bilinear_spring;"),
    ],
)
def test_a_number_that_is_missing_or_wrong_is_refused_in_one_sentence(model, stated, sentence):
    with pytest.raises(TissueProbeError, match=sentence) as raised:
        tp.modulus(model, **stated)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("effect", ["standard_linear_solid", "hunt_crossley", "force_bias"])
def test_an_effect_beside_a_straight_spring_leaves_its_slope(effect):
    whole = tp.modulus(having(effect), **FLAT)
    assert whole.value == pytest.approx(tp.modulus(straight(300.0), **FLAT).value)


def test_without_a_deviation_no_interval_is_told():
    found = tp.modulus(FittedModel(Composition(), {"stiffness": 300.0}, {}), **FLAT)
    assert math.isnan(found.deviation)
    assert "+-" not in str(found)
    assert "no standard deviation of its stiffness" in str(found)


def test_errors_that_are_taken_as_independent_are_said_to_be():
    model = powered(300.0, 1.5)
    known = FittedModel(
        model.composition, model.values, {"stiffness": 6.0, "contact_exponent": 0.1}
    )
    found = tp.modulus(known, "sphere", radius=3e-3, depth=2e-3)
    assert found.deviation / found.value == pytest.approx(math.hypot(0.02, 0.1 * math.log(2.0)))
    assert "taken as independent" in str(found)
    assert "independent" not in str(tp.modulus(known, "sphere", radius=3e-3))
