"""A stiffness becomes a modulus by the tip's shape: closed forms, published numbers, errors."""

import json
import math

import pytest

import tissue_probe as tp
from tissue_probe.errors import TissueProbeError
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.fitted_model import FittedModel
from tissue_probe.physics.indenters import Indenter
from tissue_probe.physics.model_file import Data

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


def bar_model(*names, data=None, **values):
    """Return a model on a testing machine, each value known to 1 %."""
    composition = Composition("rigid_probe", effects=tuple(EFFECTS[name] for name in names))
    own = {each.name: each.default for effect in composition.effects for each in effect.parameters}
    found = {"stiffness": 300.0, "damping": 4.0, "contact_position": 1e-3, **own, **values}
    deviations = {"stiffness": 0.01 * found["stiffness"], "damping": 0.01 * found["damping"]}
    return FittedModel(composition, found, deviations, data)


BAR = {"gauge_length": 20e-3, "area": 30e-6}
PER_LENGTH = 20e-3 / 30e-6


def test_a_bar_has_a_modulus_and_a_viscosity_by_its_length_and_area():
    found = tp.modulus(bar_model(), **BAR)
    assert found.value == pytest.approx(300.0 * PER_LENGTH)
    assert found.viscosity == pytest.approx(4.0 * PER_LENGTH)
    assert found.deviation == pytest.approx(0.01 * found.value)
    assert found.viscosity_deviation == pytest.approx(0.01 * found.viscosity)
    assert str(found).startswith("Modulus: 200 +- 3.9 kPa.\nViscosity: 2667 +- 52 Pa s.\n")


def test_errors_of_length_and_area_widen_those_of_a_bar():
    found = tp.modulus(bar_model(), gauge_length=(20e-3, 0.4e-3), area=(30e-6, 0.9e-6))
    assert found.deviation / found.value == pytest.approx(math.hypot(0.01, 0.02, 0.03))
    assert found.viscosity_deviation / found.viscosity == pytest.approx(
        math.hypot(0.01, 0.02, 0.03)
    )


def test_storage_and_loss_of_a_relaxing_bar_are_those_of_its_branch():
    model = bar_model("standard_linear_solid", relaxing_stiffness=150.0, relaxation_rate=12.0)
    found = tp.modulus(model, **BAR, frequency=[0.5, 20.0])
    for at, frequency in zip(found.spectrum, (0.5, 20.0), strict=True):
        s = 2j * math.pi * frequency
        whole = PER_LENGTH * (300.0 + 4.0 * s + 150.0 * s / (s + 12.0))
        assert (at.frequency, at.storage, at.loss) == pytest.approx(
            (frequency, whole.real, whole.imag)
        )
    assert found.value == pytest.approx(300.0 * PER_LENGTH)
    spring = 0.01 * 300.0 * PER_LENGTH
    damper = 0.01 * 4.0 * PER_LENGTH * 2.0 * math.pi * 20.0
    assert found.spectrum[1].storage_deviation == pytest.approx(spring)
    assert found.spectrum[1].loss_deviation == pytest.approx(damper)


def test_a_power_law_stores_as_its_ladder_of_branches_lets_it():
    model = bar_model("springpot", springpot_stiffness=50.0, springpot_exponent=0.4)
    (at,) = tp.modulus(model, **BAR, frequency=3.0).spectrum
    s = 2j * math.pi * 3.0
    law = PER_LENGTH * (300.0 + 4.0 * s + 50.0 * s**0.4)
    assert complex(at.storage, at.loss) == pytest.approx(law, rel=2e-2)


def test_storage_and_loss_under_a_tip_are_as_the_stiffness_is_to_its_modulus():
    model = bar_model("standard_linear_solid", relaxing_stiffness=150.0, relaxation_rate=12.0)
    found = tp.modulus(model, "flat", radius=2e-3, poisson=0.45, frequency=5.0)
    s = 2j * math.pi * 5.0
    whole = (300.0 + 4.0 * s + 150.0 * s / (s + 12.0)) * (1.0 - 0.45**2) / 4e-3
    assert complex(found.spectrum[0].storage, found.spectrum[0].loss) == pytest.approx(whole)
    assert found.viscosity == pytest.approx(4.0 * (1.0 - 0.45**2) / 4e-3)


def test_a_curved_bar_has_the_slope_at_the_stated_extension():
    model = bar_model("exponential_stiffening", exponential_force=0.2, exponential_length=2e-3)
    found = tp.modulus(model, **BAR, depth=3e-3)
    slope = 300.0 + 0.2 / 2e-3 * (math.exp(1.5) - 1.0)
    assert found.value == pytest.approx(slope * PER_LENGTH)
    assert found.deviation == pytest.approx(3.0 * PER_LENGTH)
    with pytest.raises(TissueProbeError, match="`depth`: the spring of the model is curved"):
        tp.modulus(model, **BAR)


def test_strain_and_stress_are_told_from_the_touch_on():
    data = Data(date="2026-01-01", noise=1e-3, rmse_training=1e-3, rmse_heldout=1e-3,
                lowest=1.5e-3, highest=4e-3)  # fmt: skip
    found = tp.modulus(bar_model(data=data), **BAR)
    assert found.strain == pytest.approx((0.025, 0.15))
    assert found.stress == pytest.approx((0.025 * found.value, 0.15 * found.value))
    assert "Strain 2.5 to 15 %, stress 5 to 30 kPa." in str(found)
    assert "small strain about the mean of 8.75 %" in str(found)


@pytest.mark.parametrize(
    ("stated", "sentence"),
    [
        ({}, "`indenter`: give the shape of the tip; or of a bar"),
        ({"gauge_length": 2e-2}, "`area`: a bar has"),
        ({"area": 3e-5}, "`gauge_length`: a bar has"),
        ({**BAR, "radius": 1e-3}, "`radius` is of a tip"),
        ({**BAR, "indenter": "flat"}, "`indenter` is of a tip"),
        ({**BAR, "frequency": 0.0}, "`frequency` is 0.0; give a number above 0"),
        ({"gauge_length": (0.0, 1e-3), "area": 3e-5}, "`gauge_length` is 0.0"),
        ({"gauge_length": "20mm", "area": 3e-5}, "`gauge_length` is '20mm'; give a number"),
    ],
)
def test_a_bar_that_is_stated_wrongly_is_refused_in_one_sentence(stated, sentence):
    with pytest.raises(TissueProbeError, match=sentence) as raised:
        tp.modulus(bar_model(), **stated)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("effect", ["nonlinear_damping", "preconditioning", "stiffness_ramp"])
def test_force_of_speed_history_or_time_has_no_storage_and_loss(effect):
    with pytest.raises(TissueProbeError, match=f"the model has {effect}, by which"):
        tp.modulus(bar_model(effect), **BAR, frequency=1.0)
    assert math.isnan(tp.modulus(bar_model(effect), **BAR).viscosity)


def test_damping_of_the_depth_needs_a_depth():
    model = bar_model("hunt_crossley", depth_damping=2.0)
    with pytest.raises(TissueProbeError, match="`depth`: storage and loss"):
        tp.modulus(model, **BAR, frequency=1.0)
    found = tp.modulus(model, **BAR, depth=3e-3, frequency=1.0)
    assert found.viscosity == pytest.approx((4.0 + 2.0 * 3.0) * PER_LENGTH)


def test_the_answer_for_programs_has_plain_types():
    told = tp.modulus(bar_model(), **BAR, frequency=2.0).to_dict()
    assert json.loads(json.dumps(told, allow_nan=False)) == told
    assert told["strain"] == [None, None]
    assert told["spectrum"][0]["frequency"] == 2.0


def test_a_bar_of_a_model_without_damping_is_refused():
    model = FittedModel(Composition("rigid_probe"), {"stiffness": 300.0}, {})
    with pytest.raises(TissueProbeError, match="`model` has no value of damping: fit it first"):
        tp.modulus(model, **BAR)
