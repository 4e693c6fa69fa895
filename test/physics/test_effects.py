"""One battery over every effect in every form: what it declares, that it is neutral, its force."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from composed import BASE, FORMS, PERIOD, force_of, halved, pressing, risen, values_of, vibrating

from tissue_probe.physics import effects
from tissue_probe.physics.composition import TISSUE, Composition
from tissue_probe.physics.effects import EFFECTS, Extent
from tissue_probe.physics.effects.springpot import RATES
from tissue_probe.physics.response import course, respond

FILES = {path.stem for path in Path(effects.__file__).parent.glob("*.py")} - {"__init__", "effect"}
FAMILIES = {
    "relaxation", "stiffening", "contact", "friction", "lost motion", "inertia", "scale", "offset",
    "body motion", "mains hum", "second input", "damping", "timing", "encoder", "time-varying",
    "damage",
}  # fmt: skip
EXTENT = Extent(
    duration=2.0, indentation=1e-3, depth=2e-3, speed=0.06, force=0.3, pull=0.2, step=1e-6
)


def test_every_file_is_an_effect_of_its_name():
    assert set(EFFECTS) == FILES


@pytest.mark.parametrize("effect", EFFECTS.values(), ids=EFFECTS)
def test_an_effect_says_what_it_is(effect):
    assert effect.family in FAMILIES
    for text in (effect.physics, effect.assumptions, effect.reference):
        assert text
    assert set(effect.simpler) <= set(EFFECTS) - {effect.name}
    for form in effect.forms:
        assert (form.name, form.family) == (effect.name, effect.family)


@pytest.mark.parametrize("effect", FORMS.values(), ids=FORMS)
def test_parameters_and_starts_lie_within_their_bounds(effect):
    entries = (*effect.parameters, *TISSUE)
    bounds = {entry.name: (entry.lower, entry.upper) for entry in entries}
    for entry in effect.parameters:
        assert entry.lower <= entry.default <= entry.upper
        assert entry.unit
    for entry in effect.parameters[: effect.strengths]:
        assert entry.lower <= effect.neutral <= entry.upper
    for start in effect.starts(EXTENT):
        for name, value in start.items():
            assert bounds[name][0] <= value <= bounds[name][1], name
    if effect.near:
        found = {entry.name: entry.default for entry in entries}
        assert all(set(start) <= set(bounds) for start in effect.near(EXTENT, found))
        # Tissue without damping, and the least that the effect may be, are values like others.
        for start in effect.near(EXTENT, {entry.name: entry.lower for entry in entries}):
            assert np.isfinite(list(start.values())).all()


@pytest.mark.parametrize("name", FORMS)
def test_at_neutral_strength_the_force_is_that_without_the_effect(name):
    """In steps so short that no model errs by more; pressed only, where something switches."""
    effect = FORMS[name]
    times = np.arange(1500) * PERIOD / 10
    position = pressing(times) if effect.switches else vibrating(times)
    composition = Composition(effects=(effect,))
    neutral = {p.name: effect.neutral for p in effect.parameters[: effect.strengths]}
    with_it = force_of(composition, values_of(composition, **neutral), position, PERIOD / 10).output
    without = force_of(BASE, values_of(BASE), position, PERIOD / 10).output
    assert np.abs(without).max() > 0.2
    np.testing.assert_allclose(with_it, without, atol=1e-9)


@pytest.mark.parametrize(
    ("tissue", "effect", "rates"),
    [
        ("kelvin_voigt", "springpot", RATES),
        ("kelvin_voigt", "standard_linear_solid", [50.0]),
        ("maxwell", "contact_loss", [450.0 / 5.0]),
        ("kelvin_voigt", "structural_mode", []),
    ],
)
def test_only_branches_relax_and_each_at_its_rate(tissue, effect, rates):
    composition = Composition(tissue=tissue, effects=(EFFECTS[effect],))
    found = composition.kernel.relaxation_rates(values_of(composition))
    np.testing.assert_allclose(found[found != 0.0], rates)


# On the motion below, pull-off by damping alone would graze its limit, where nothing is smooth.
SHOWN = {"adhesion": {"damping": 0.5, "pull_off_force": 0.05}}
# Nor is it at the largest depth ever: the motion begins a little above.
ABOVE = {"withdrawn_from_largest": 1e-4}


@pytest.mark.parametrize("name", FORMS)
def test_sensitivities_are_the_derivatives_of_the_force(name):
    """By every value and every start, against central differences.

    In quarters of the usual steps where something switches: the instants err with the steps.
    """
    composition = Composition(effects=(FORMS[name],))
    kernel = composition.kernel
    position = 3e-4 + vibrating(np.arange(1200) * PERIOD)
    values = values_of(composition, **SHOWN.get(name, {}))
    start = kernel.begin(values, position[0], 0.13)
    start = start + [ABOVE.get(state, 0.0) for state in kernel.states]
    unknowns = np.concatenate([start, values])
    labels = [*kernel.states, *kernel.values]
    halvings = 2 if FORMS[name].switches else 0

    def answer(unknowns):
        start, values = np.split(unknowns.copy(), [len(kernel.states)])
        coil = course(kernel, position, PERIOD, values)
        for _ in range(halvings):
            coil = halved(coil)
        return respond(kernel, values, start, coil)

    exact = answer(unknowns).sensitivity
    assert np.isfinite(exact).all()
    wrong = {}
    for index, label in enumerate(labels):
        if label == "encoder_step":  # read off the positions, not searched
            continue
        change = np.zeros(unknowns.size)
        change[index] = 1e-5 * abs(unknowns[index]) or 1e-8
        up, down = answer(unknowns + change).output, answer(unknowns - change).output
        difference = (up - down) / (2 * change[index])
        size = max(np.linalg.norm(difference), np.linalg.norm(exact[:, index]))
        error = np.linalg.norm(difference - exact[:, index]) / max(size, 1e-9)
        if not error < 5e-3:
            wrong[label] = float(error)
    assert not wrong


@pytest.mark.parametrize("name", FORMS)
def test_steps_converge(name):
    """The usual steps err by less than a third of the noise; shorter ones by next to nothing."""
    composition = Composition(effects=(FORMS[name],))
    values = values_of(composition, **SHOWN.get(name, {}))
    position = vibrating(np.arange(2000) * PERIOD)
    kernel = composition.kernel
    coil = course(kernel, position, PERIOD, values)
    start = np.zeros(len(kernel.states))
    forces = []
    for stride in (1, 2, 4, 8):
        forces.append(respond(kernel, values, start, coil).output[::stride][: position.size - 1])
        coil = halved(coil)
    rms = np.sqrt(np.mean(forces[-1] ** 2))
    changes = [np.sqrt(np.mean((a - b) ** 2)) for a, b in pairwise(forces)]
    print(name, [f"{change / rms:.1e}" for change in changes])
    # Dry friction turns round within a step or two, and is the worst; most others err 0.1 mN.
    assert changes[0] < (0.005 / 3 if FORMS[name].family == "friction" else 0.0005)
    assert changes[-1] < (1e-4 if FORMS[name].family == "friction" else 1e-5) * rms


@pytest.mark.parametrize(
    "stiffening",
    ["cubic_stiffening", "exponential_stiffening", "hertz_contact", "saturating_spring"],
)
def test_a_quasi_linear_branch_that_hardly_yields_is_a_second_spring_of_the_same_law(stiffening):
    """And its force relaxes in the same proportion at every depth."""
    plain = Composition("rigid_probe").plus(EFFECTS[stiffening].plain)
    relaxing = plain.plus(EFFECTS["quasi_linear_relaxation"].plain)
    twice = {"relaxing_stiffness": 450.0, "damping": 0.0}
    for depth in (3e-4, 2e-3):
        times = np.arange(1000) * PERIOD
        position = depth * risen(times, 0.1)
        spring = force_of(plain, values_of(plain, damping=0.0), position).output
        for rate, share in ((1e-4, 1.0), (2.0, np.exp(-2.0 * 0.3))):
            values = values_of(relaxing, **twice, relaxation_rate=rate)
            branch = force_of(relaxing, values, position).output - spring
            early, late = branch[[399, 999]]
            assert late == pytest.approx(share * early, rel=1e-3)
            if rate < 1.0:
                assert early == pytest.approx(spring[399], rel=1e-3)


@pytest.mark.parametrize("form", range(2))
def test_a_saturating_spring_is_straight_at_first_and_gives_way_with_depth(form):
    composition = Composition(
        "rigid_probe", effects=(EFFECTS["saturating_spring"].every_form[form],)
    )
    values = values_of(composition, stiffness=400.0, damping=0.0, softening_with_depth=500.0)

    def held(depth):
        return force_of(composition, values, np.full(9, depth)).output[0] / (400.0 * depth)

    assert held(1e-7) == pytest.approx(1.0, abs=1e-4)
    assert held(2e-3) == pytest.approx((0.5, np.tanh(1.0))[form])
    assert held(-2e-3) == pytest.approx(held(2e-3))


@pytest.mark.parametrize("form", range(3))
def test_beside_a_straight_spring_quasi_linear_relaxation_is_linear(form):
    linear = (EFFECTS["standard_linear_solid"], *EFFECTS["generalized_maxwell"].every_form)[form]
    position = vibrating(np.arange(1000) * PERIOD)
    forces = [
        force_of(each, values_of(each), position).output
        for each in (
            Composition(effects=(effect,))
            for effect in (linear, EFFECTS["quasi_linear_relaxation"].every_form[form])
        )
    ]
    np.testing.assert_allclose(*forces, atol=1e-12)


def test_a_bouc_wen_loop_of_free_shape_is_the_usual_one_where_beta_is_gamma():
    usual, _, free, _ = EFFECTS["bouc_wen_hysteresis"].every_form
    force, length = 0.05, 2e-4
    shape = dict.fromkeys(("loop_closing", "loop_bending"), 0.5 / length)
    forces = [
        force_of(each, values_of(each, **given), vibrating(np.arange(1000) * PERIOD)).output
        for each, given in (
            (Composition(effects=(usual,)), {"hysteretic_force": force}),
            (Composition(effects=(free,)), {"hysteretic_stiffness": force / length, **shape}),
        )
    ]
    np.testing.assert_allclose(*forces, atol=1e-9)


def test_friction_that_does_not_weaken_is_the_usual_one_and_what_weakens_lasts_less():
    usual, _, _, weakening = EFFECTS["bouc_wen_hysteresis"].every_form
    own = {"hysteretic_force": 0.05, "yield_displacement": 2e-4}
    position = vibrating(np.arange(1000) * PERIOD)

    def force(form, **given):
        composition = Composition(effects=(form,))
        return force_of(composition, values_of(composition, **given), position).output

    without = force(usual, **own | {"hysteretic_force": 0.0})
    lasting, weaker = (force(weakening, **own, weakening_by_work=d) for d in (0.0, 1e3))
    np.testing.assert_allclose(lasting, force(usual, **own), atol=1e-9)
    end = np.abs(lasting - without)[-200:].max()
    assert np.abs(weaker - without)[-200:].max() < 0.8 * end


def test_where_stribeck_friction_turns_sharply_it_is_searched_at_other_speeds_only():
    effect = EFFECTS["stribeck_friction"]
    for turn, same in ((1e-5, False), (1e-4, False), (1e-3, True)):
        found = {"stribeck_velocity": 0.01, "stribeck_transition_velocity": turn}
        speeds = {each["stribeck_velocity"] for each in effect.near(EXTENT, found)}
        assert (0.01 in speeds) is same
        assert min(speeds) < 0.01 < max(speeds)


@pytest.mark.parametrize(
    "stiffening",
    ["cubic_stiffening", "exponential_stiffening", "hertz_contact", "saturating_spring"],
)
@pytest.mark.parametrize("name", ["stiffness_step", "stiffness_ramp"])
def test_a_stiffness_that_changes_does_so_in_all_that_is_elastic(name, stiffening):
    """In the same proportion at every depth; relaxation and damping stay as they are."""
    plain = Composition("rigid_probe").plus(EFFECTS[stiffening].plain)
    changing = plain.plus(EFFECTS[name])
    when = {"step_time": 0.2} if name == "stiffness_step" else {"ramp_duration": 0.2}
    for depth in (3e-4, 2e-3):
        held = np.full(1000, depth)
        before = force_of(plain, values_of(plain), held).output
        after = force_of(changing, values_of(changing, **when), held).output
        known = {entry.name: entry.default for entry in changing.values}
        grown = 1.0 + known[EFFECTS[name].parameters[0].name] / known["stiffness"]
        assert after[-1] == pytest.approx(grown * before[-1], rel=1e-9)
        assert after[0] == pytest.approx(before[0], rel=1e-9)
