"""The simulator's mechanics against closed forms."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from closed_forms import (
    AMPLITUDE,
    ANGULAR,
    hold,
    kelvin_voigt,
    line,
    lost_a_cycle,
    transfer,
    vibrate,
)

from tissue_probe.challenge.change import Situation
from tissue_probe.challenge.mechanical import MECHANICAL, ONLY_BY_NAME
from tissue_probe.challenge.specimen import Specimen

UNDAMPED = Specimen(load_cell_damping=0.0)
# What little the load cell's damper carries is less than 6 mN.
MASSLESS = Specimen(tip_mass=1e-4, stiffness=1000.0, damping=0.5)


def agrees(specimen, tissue, rel):
    """Hold the force's line at 10 Hz against the closed form, in size and phase."""
    u, force = vibrate(specimen)
    expected = transfer(tissue, specimen)
    assert abs(line(force) / line(u) / expected - 1.0) < rel


@pytest.mark.parametrize("stiffness", [150.0, 3000.0])
@pytest.mark.parametrize("damping", [0.5, 15.0])
def test_kelvin_voigt_tissue(stiffness, damping):
    specimen = Specimen(stiffness=stiffness, damping=damping)
    agrees(specimen, kelvin_voigt(specimen), 1e-6)


def test_a_branch_is_a_standard_linear_solid():
    k1, rate = 300.0, 40.0
    specimen = Specimen(branch_stiffness=(k1,), branch_rate=(rate,))
    branch = k1 * 1j * ANGULAR / (1j * ANGULAR + rate)
    agrees(specimen, kelvin_voigt(specimen) + branch, 1e-6)


@pytest.mark.parametrize("law", [{"fung": 600.0}, {"cubic": 1e8}, {"hyperbola_depth": 1e-3}])
def test_a_curved_branch_that_never_yields_is_a_second_spring_of_the_same_law(law):
    spring = Specimen(**law)
    branch = {"branch_stiffness": (450.0,), "branch_rate": (1e-9,), "branch_curved": 1.0}
    twice = {"stiffness": 900.0, "cubic": 2.0 * spring.cubic}
    found, expected = (vibrate(spring._replace(**each))[1] for each in (branch, twice))
    np.testing.assert_allclose(found, expected, atol=1e-5 * np.ptp(expected))


@pytest.mark.parametrize("seed", range(6))
def test_fluid_in_pores_leaves_the_published_part_of_a_force(seed):
    """Held after a quick pressing, against the function of Hu et al. (2010) itself."""
    at = Situation(MASSLESS, AMPLITUDE, 0.0, 2.0, 60.0)
    hidden = ONLY_BY_NAME["poroelastic_relaxation"].make(0.8, at, np.random.default_rng(seed))
    own = hidden.specimen
    stiffness, rates = np.array(own["branch_stiffness"]), np.array(own["branch_rate"])
    last = stiffness[-1] / 0.8e3
    a, b, c = {0.509: (0.491, 0.908, 1.679), 0.507: (0.493, 0.822, 1.348)}.get(
        round(last, 6), (1.304, 1.0, 0.254)
    )
    assert round(last, 6) == round(1.0 - a, 6)
    per_time = rates[-1] / c
    assert 1.0 / 0.6 < per_time < 1.0 / 0.02
    times = np.geomspace(2e-3, 10.0, 200)
    left = np.exp(-np.outer(times, rates)) @ stiffness
    g = a * np.exp(-b * np.sqrt(per_time * times)) + (1.0 - a) * np.exp(-c * per_time * times)
    np.testing.assert_allclose(left, 0.8e3 * g, atol=0.8e3 * 1e-4)


def test_damaged_tissue_that_is_pressed_no_deeper_is_a_weaker_spring():
    damaged = MASSLESS._replace(damage=0.4, damage_depth=1e-3, damage_reached=5e-3)
    left = 1000.0 * (1.0 - 0.4 * (1.0 - np.exp(-5.0)))
    weaker = MASSLESS._replace(stiffness=left)
    np.testing.assert_allclose(vibrate(damaged)[1], vibrate(weaker)[1], atol=1e-9)


def test_damage_that_returns_leaves_a_first_pressing_alone():
    damaged = MASSLESS._replace(damage=0.4, damage_returns=1.0)
    np.testing.assert_allclose(hold(damaged, 2e-3), hold(MASSLESS, 2e-3), rtol=1e-6)
    soft = hold(damaged._replace(damage_reached=4e-3), 2e-3)
    assert np.all(soft < 0.7 * hold(MASSLESS, 2e-3))


def test_tissue_that_was_worked_long_is_a_weaker_spring():
    worked = MASSLESS._replace(worked_off=0.4, working_path=1e-3, worked_before=1.0)
    weaker = MASSLESS._replace(stiffness=600.0)
    np.testing.assert_allclose(vibrate(worked)[1], vibrate(weaker)[1], atol=1e-9)


def test_fresh_tissue_loses_stiffness_by_the_way_that_it_was_pressed():
    force = hold(MASSLESS._replace(worked_off=0.4, working_path=2e-3), 2e-3)[-1]
    depth = 2e-3 - force / MASSLESS.load_cell_stiffness
    left = 1.0 - 0.4 * (1.0 - np.exp(-depth / 2e-3))
    assert force == pytest.approx(1000.0 * left * depth, rel=2e-3)


def test_a_curved_branch_beside_a_straight_spring_is_straight():
    straight = Specimen(branch_stiffness=(300.0,), branch_rate=(40.0,))
    curved = straight._replace(branch_curved=1.0)
    np.testing.assert_allclose(vibrate(curved)[1], vibrate(straight)[1], atol=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_a_springpot_is_a_power_of_the_frequency(seed):
    clean = Specimen()
    at = Situation(clean, AMPLITUDE, 0.0, 2.0, 10.0)
    effect = MECHANICAL["springpot"]
    change = effect.make(1.0, at, np.random.default_rng(seed))
    order = np.random.default_rng(seed).uniform(0.15, 0.6)
    # At strength 1 the springpot is as stiff as the tissue at 10 Hz.
    springpot = clean.stiffness * 1j**order
    agrees(clean._replace(**change.specimen), kelvin_voigt(clean) + springpot, 2e-4)


def test_a_mode_is_a_mass_on_spring_and_damper():
    mass, spring, damper = 0.02, 900.0, 0.7
    specimen = Specimen(mode_mass=mass, mode_stiffness=spring, mode_damping=damper)
    link = spring + 1j * ANGULAR * damper
    inertia = -mass * ANGULAR**2
    agrees(specimen, kelvin_voigt(specimen) + link * inertia / (link + inertia), 1e-6)


def test_coulomb_friction_takes_four_times_force_times_amplitude_a_cycle():
    friction = 0.05
    specimen = UNDAMPED._replace(coulomb=friction, static=friction)
    lost, tip = lost_a_cycle(*vibrate(specimen), specimen)
    expected = 2.0 * friction * np.ptp(tip) + viscous_loss(tip, specimen.damping)
    assert lost == pytest.approx(expected, rel=1e-4)


def viscous_loss(tip, damping):
    """Energy that a damper takes up in a cycle of 0.1 s [J]."""
    return damping * np.mean(np.gradient(tip, 1.0 / 40_000) ** 2) / 10.0


def test_a_tip_that_friction_holds_does_not_move():
    specimen = Specimen(coulomb=0.05, static=0.05)
    u, force = vibrate(specimen, amplitude=1e-6)
    np.testing.assert_allclose(force, specimen.load_cell_stiffness * u, atol=1e-12)


def test_stribeck_friction_without_excess_is_coulombs():
    coulomb = Specimen(coulomb=0.05, static=0.05)
    stribeck = coulomb._replace(static=0.05 * (1.0 + 1e-9), stribeck_velocity=5e-3)
    np.testing.assert_allclose(vibrate(stribeck)[1], vibrate(coulomb)[1], atol=1e-7)


def test_stribeck_friction_holds_with_its_static_force():
    specimen = Specimen(coulomb=0.02, static=0.05, stribeck_velocity=5e-3)
    u, force = vibrate(specimen, amplitude=4e-6)  # 0.039 N: more than Coulomb's
    np.testing.assert_allclose(force, specimen.load_cell_stiffness * u, atol=1e-12)
    _, slides = vibrate(specimen, amplitude=6e-6)
    assert np.abs(slides).max() < 0.055


def test_bouc_wen_is_a_spring_when_small_and_friction_when_large():
    force = 0.05
    small = Specimen(bouc_force=force, bouc_yield=1e-2)
    agrees(small, kelvin_voigt(small) + force / 1e-2, 2e-3)
    large = UNDAMPED._replace(bouc_force=force, bouc_yield=3e-6)
    lost, tip = lost_a_cycle(*vibrate(large), large)
    expected = 2.0 * force * np.ptp(tip) + viscous_loss(tip, large.damping)
    assert lost == pytest.approx(expected, rel=5e-3)


def test_bouc_wen_of_another_shape_slides_with_the_same_force_and_turns_in_other_loops():
    shaped = [
        MASSLESS._replace(bouc_force=0.2, bouc_yield=5e-5, bouc_beta=b, bouc_gamma=1.0 - b)
        for b in (0.5, 1.5)
    ]
    (_, usual), (_, fuller) = map(vibrate, shaped)
    assert fuller.max() == pytest.approx(usual.max(), rel=1e-3)
    assert np.abs(fuller - usual).max() > 0.02


def test_bouc_wen_that_weakens_takes_what_is_left_of_its_strength_by_the_work_done():
    force, weakening = 0.05, 10.0
    large = UNDAMPED._replace(bouc_force=force, bouc_yield=3e-6, bouc_weakening=weakening)
    lost, tip = lost_a_cycle(*vibrate(large), large)
    # de/ds = 1 / (1 + d e) of the way s: 20 cycles have passed, 0.1 s of them at half the size.
    ways = 2.0 * np.ptp(tip) * np.array([19.5, 39.5])
    work = (np.sqrt(1.0 + 2.0 * weakening * ways) - 1.0) / weakening
    expected = force * np.diff(work)[0] / 20.0 + viscous_loss(tip, large.damping)
    assert lost == pytest.approx(expected, rel=0.01)


def test_a_stack_of_sliders_takes_four_times_each_force_times_the_way_beyond_its_reach():
    reaches, forces = np.array([2e-5, 1e-4, 4e-4]), np.array([0.02, 0.03, 0.05])
    stiffness = tuple(forces / reaches)
    specimen = UNDAMPED._replace(slider_stiffness=stiffness, slider_reach=tuple(reaches))
    lost, tip = lost_a_cycle(*vibrate(specimen), specimen)
    beyond = 0.5 * np.ptp(tip) - reaches
    assert beyond.min() > 0.0
    expected = 4.0 * forces @ beyond + viscous_loss(tip, specimen.damping)
    assert lost == pytest.approx(expected, rel=5e-3)


def test_a_stack_that_never_slides_is_a_spring():
    held = Specimen(slider_stiffness=(100.0, 200.0), slider_reach=(5e-3, 1e-2))
    agrees(held, kelvin_voigt(held) + 300.0, 1e-6)


def test_drag_takes_eight_thirds_of_force_times_amplitude_a_cycle():
    drag = 100.0
    specimen = UNDAMPED._replace(drag=drag)
    lost, tip = lost_a_cycle(*vibrate(specimen), specimen)
    amplitude = abs(line(tip))
    expected = 8.0 / 3.0 * drag * ANGULAR**2 * amplitude**3
    expected += pi * specimen.damping * ANGULAR * amplitude**2
    assert lost == pytest.approx(expected, rel=5e-3)


def test_damping_that_grows_with_depth_acts_at_the_mean_depth():
    growth = 2000.0  # N s/m^2
    specimen = UNDAMPED._replace(depth_damping=growth, stiffness=1000.0)
    lost, tip = lost_a_cycle(*vibrate(specimen, preload=2e-3), specimen)
    effective = specimen.damping + growth * tip.mean()
    expected = pi * effective * ANGULAR * abs(line(tip)) ** 2
    assert lost == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize(
    ("numbers", "law"),
    [
        ({}, lambda x: 450.0 * x),
        ({"cubic": 1e8}, lambda x: 450.0 * x + 1e8 * x**3),
        ({"fung": 800.0}, lambda x: 450.0 / 800.0 * np.expm1(800.0 * x)),
        ({"hertz_exponent": 1.5}, lambda x: 450.0 * 1e-3 * (x / 1e-3) ** 1.5),
        ({"hyperbola_depth": 4e-3}, lambda x: 450.0 * x / (1.0 + x / 4e-3)),
        ({"saturation_depth": 1e-3}, lambda x: 450.0 * 1e-3 * np.tanh(x / 1e-3)),
        ({"step": 0.5, "step_time": 0.0}, lambda x: 675.0 * x),
        ({"pull_off": 0.1, "unilateral": 1.0}, lambda x: 450.0 * x),
    ],
)
def test_at_rest_the_load_cell_holds_the_tissue(numbers, law):
    depth = 2e-3
    force = hold(Specimen(**numbers), depth)[-1]
    tip = depth - force / 9700.0
    assert force == pytest.approx(law(tip), rel=1e-6)


def test_at_rest_play_takes_half_the_gap():
    force = hold(Specimen(play=1e-4), 2e-3)
    series = 1.0 / (1.0 / 9700.0 + 1.0 / 450.0)
    np.testing.assert_allclose(force, series * (2e-3 - 1e-4), rtol=1e-6)


def test_no_force_passes_a_gap():
    u, force = vibrate(MASSLESS._replace(play=1e-4))
    assert np.mean(force == 0.0) > 0.02
    assert force.max() == pytest.approx(transfer_size(MASSLESS) * (u.max() - 1e-4), rel=0.03)


def transfer_size(specimen):
    return abs(transfer(kelvin_voigt(specimen), specimen))


def test_tissue_only_pushes():
    _, free = vibrate(MASSLESS._replace(unilateral=1.0))
    _, held = vibrate(MASSLESS)
    assert held.min() < -0.5
    assert free.min() > -6e-3
    assert free.max() == pytest.approx(held.max(), rel=1e-3)


def test_adhesion_pulls_up_to_its_limit():
    _, force = vibrate(MASSLESS._replace(unilateral=1.0, pull_off=0.2))
    assert force.min() == pytest.approx(-0.2, abs=6e-3)
    _, strong = vibrate(MASSLESS._replace(unilateral=1.0, pull_off=2.0))
    np.testing.assert_allclose(strong, vibrate(MASSLESS)[1], atol=1e-9)


@pytest.mark.parametrize("threads", [0.0, 1.0])
def test_a_bond_whose_range_is_short_only_pushes(threads):
    bond = {"pull_off": 0.2, "bond_range": 1e-7, "bond_threads": threads}
    _, force = vibrate(MASSLESS._replace(unilateral=1.0, **bond))
    _, pushed = vibrate(MASSLESS._replace(unilateral=1.0))
    assert np.sqrt(np.mean((force - pushed) ** 2)) < 0.01 * np.std(pushed)


def test_a_bond_of_a_long_range_gives_way_at_its_pull():
    bond = {"pull_off": 0.2, "bond_range": 1.0}
    _, force = vibrate(MASSLESS._replace(unilateral=1.0, **bond))
    assert force.min() == pytest.approx(-0.2, abs=6e-3)
    assert np.mean(force < -0.19) > 0.3


def test_contact_is_not_lost_where_the_tip_is_pressed_in_enough():
    specimen = Specimen(stiffness=1000.0)
    _, force = vibrate(specimen._replace(unilateral=1.0), preload=3e-3)
    np.testing.assert_allclose(force, vibrate(specimen, preload=3e-3)[1], atol=1e-9)


def test_a_surface_that_moves_presses_on_a_probe_at_rest():
    specimen = Specimen(
        damping=0.5, surface_amplitude=1e-4, surface_frequency=0.25, surface_phase=0.5 * pi
    )
    force = hold(specimen, 0.0, duration=4.0)
    expected = 1e-4 / (1.0 / 9700.0 + 1.0 / 450.0)
    surface = np.cos(0.5 * pi * np.arange(force.size) / 40_000)
    np.testing.assert_allclose(force, -expected * surface, atol=2e-2 * expected)


@pytest.mark.parametrize(
    "numbers",
    [
        {"unilateral": 1.0},
        {"unilateral": 1.0, "pull_off": 0.1},
        {"coulomb": 0.1, "static": 0.1},
        {"coulomb": 0.05, "static": 0.1, "stribeck_velocity": 5e-3},
        {"play": 5e-5},
        {"unilateral": 1.0, "coulomb": 0.05, "static": 0.05, "play": 5e-5},
    ],
)
def test_events_are_located_so_that_half_the_step_changes_nothing(numbers):
    specimen = Specimen(**numbers)
    _, force = vibrate(specimen)
    _, finer = vibrate(specimen, rate=80_000)
    assert np.abs(force - finer[::2]).max() < 1e-5  # N; the noise is 5e-3


@pytest.mark.parametrize(
    "numbers",
    [
        {"damping_wave": 0.0, "damping_wave_frequency": 7.0},
        {"corrugation": 0.0, "corrugation_period": 3e-4},
        {"softening": 0.0, "softening_time": 0.2},
        {"mode_mass": 0.0, "mode_stiffness": 100.0},
        {"hertz_depth": 5e-3, "depth_exponent": 1.5, "bouc_yield": 1e-6},
    ],
)
def test_an_effect_of_no_strength_changes_nothing(numbers):
    np.testing.assert_array_equal(vibrate(Specimen(**numbers))[1], vibrate(Specimen())[1])
