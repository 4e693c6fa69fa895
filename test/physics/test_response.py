"""Answers of composed models against closed forms, and events against SciPy's."""

import numpy as np
import pytest
from composed import FORMS, PERIOD, force_of, halved, risen, values_of, vibrating
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.response import course, respond
from tissue_probe.physics.tissues import TISSUES

M, K0, B0 = 0.04, 9700.0, 0.8
K, B = 450.0, 5.0


def branch(s, stiffness, rate):
    return stiffness * s / (s + rate)


#: Dynamic stiffness [N/m] of the paper's Table I, at s = i w.
TABLE_I = {
    "kelvin_voigt": lambda s: K + B * s,
    "maxwell": lambda s: K * B * s / (K + B * s),
    "standard_linear_solid": lambda s: K + B * s + branch(s, 300.0, 50.0),
    "generalized_maxwell": lambda s: K + B * s + branch(s, 200.0, 5.0) + branch(s, 200.0, 100.0),
}


def relaxing(times, position, rates, stiffnesses, cubic):
    """Force of branches and a cubic spring beside the tissue, by SciPy's integrator."""
    coil = CubicSpline(times, position)
    speed = coil.derivative()
    own = np.array(stiffnesses)

    def slope(t, z):
        x, v, branches = z[0], z[1], z[2:]
        load = K0 * (coil(t) - x) + B0 * (speed(t) - v)
        return [
            v,
            (load - K * x - B * v - cubic * x**3 - own @ branches) / M,
            *(v - np.array(rates) * branches),
        ]

    start = np.zeros(2 + len(rates))
    solution = solve_ivp(
        slope, (times[0], times[-1]), start, "DOP853", times, rtol=1e-10, atol=1e-14,
        max_step=PERIOD,
    )  # fmt: skip
    return K0 * (position - solution.y[0])


def phasor(signal, times, frequency):
    """Amplitude and phase of a sine in a signal that may have an offset."""
    angle = 2 * np.pi * frequency * times
    waves = np.stack([np.cos(angle), np.sin(angle), np.ones_like(angle)], axis=1)
    cosine, sine, _ = np.linalg.lstsq(waves, signal, rcond=None)[0]
    return cosine - 1j * sine


def transfer(composition, frequency=10.0):
    """Force over position of the coil in steady state [N/m]."""
    times = np.arange(8000) * PERIOD
    position = 1e-3 * np.sin(2 * np.pi * frequency * times)
    force = force_of(composition, values_of(composition), position).output
    last = times > 3.0
    return phasor(force[last], times[last], frequency) / phasor(
        position[last], times[last], frequency
    )


def test_table_i_is_whole():
    assert set(TABLE_I) == set(TISSUES)


@pytest.mark.parametrize("tissue", TABLE_I)
def test_a_tissue_has_the_dynamic_stiffness_of_table_i(tissue):
    s = 2j * np.pi * 10.0
    tip = K0 + B0 * s
    moved = tip / (tip + TABLE_I[tissue](s) + M * s**2)
    assert transfer(Composition(tissue=tissue)) == pytest.approx(K0 * (1 - moved), rel=1e-6)


@pytest.mark.parametrize("tissue", TABLE_I)
def test_a_rigid_probe_feels_tissue_and_tip(tissue):
    s = 2j * np.pi * 10.0
    expected = TABLE_I[tissue](s) + M * s**2
    # The acceleration is that of the interpolated motion, which errs by (w dt)^2 / 12.
    error = M * abs(s) ** 2 * (abs(s) * PERIOD) ** 2 / 12
    assert abs(transfer(Composition("rigid_probe", tissue)) - expected) < 1.1 * error


def test_values_or_states_of_another_model_are_refused():
    composition, position = Composition(effects=(EFFECTS["springpot"],)), np.zeros(9)
    with pytest.raises(ValueError, match="17 states and 8 values"):
        force_of(composition, values_of(composition), position, start=np.zeros(2))
    with pytest.raises(ValueError, match="17 states and 8 values"):
        force_of(composition, values_of(Composition()), position)


def test_the_force_of_a_rigid_probe_is_that_of_the_motion_between_the_samples():
    composition = Composition("rigid_probe")
    angle = 2 * np.pi * 60.0
    phase = angle * np.arange(500) * PERIOD
    position, speed, acceleration = (
        np.sin(phase),
        angle * np.cos(phase),
        -(angle**2) * np.sin(phase),
    )
    expected = M * acceleration + B * speed + K * position
    force = force_of(composition, values_of(composition), position).output
    inside = slice(20, -20)
    np.testing.assert_allclose(force[inside], expected[inside], atol=3e-5 * np.ptp(expected))


def lifted(attached_until, damping, position, times, longest=2e-4):
    """Force of a tip on Kelvin-Voigt tissue that lets go, by SciPy with its own search for events.

    ``attached_until`` says of (x, v) what turns negative as the contact is lost; it is regained at
    the free surface, where the tissue pushes.
    """
    coil = CubicSpline(times, position)
    rate = coil.derivative()

    def moving(attached):
        def slope(t, z):
            load = K0 * (coil(t) - z[0]) + B0 * (rate(t) - z[1])
            return [z[1], (load - attached * (K * z[0] + damping * z[1])) / M]

        return slope

    def turns(attached):
        def event(t, z):
            return attached_until(*z) if attached else max(-z[0], -K * z[0] - damping * z[1])

        event.terminal, event.direction = True, -1
        return event

    t, z, attached, force, events = times[0], np.zeros(2), True, np.zeros(times.size), 0
    while t < times[-1]:
        ahead = times[times >= t]
        solution = solve_ivp(
            moving(attached), (t, times[-1]), z, "DOP853", dense_output=True, rtol=1e-11,
            atol=1e-14, max_step=longest, events=turns(attached),
        )  # fmt: skip
        t, z = solution.t[-1], solution.y[:, -1]
        done = ahead[ahead <= t]
        first = times.size - ahead.size
        force[first : first + done.size] = K0 * (coil(done) - solution.sol(done)[0])
        if solution.status == 1:
            attached, events = not attached, events + 1
    return force, events


@pytest.mark.parametrize("fast", [500.0, 1900.0, 3000.0, 2e4])
def test_what_relaxes_within_a_few_samples_is_integrated_beside_a_nonlinear_spring(fast):
    effects = tuple(EFFECTS[name] for name in ("generalized_maxwell", "cubic_stiffening"))
    composition = Composition(effects=effects)
    times = np.arange(800) * PERIOD
    position = 2e-3 * (1.0 - np.cos(2 * np.pi * 20.0 * times))
    rates, stiffnesses, cubic = (20.0, fast), (150.0, 2e5 / fast), 3e7
    truth = relaxing(times, position, rates, stiffnesses, cubic)
    values = values_of(
        composition,
        relaxation_rate_1=rates[0],
        relaxation_rate_2=rates[1],
        relaxing_stiffness_1=stiffnesses[0],
        relaxing_stiffness_2=stiffnesses[1],
        cubic_stiffness=cubic,
    )
    force = force_of(composition, values, position).output
    rms = np.sqrt(np.mean(truth**2))
    assert np.sqrt(np.mean((force - truth) ** 2)) < 2e-4 * rms


LOSSES = {
    "contact_loss": ({"damping": B}, lambda x, v: x),
    "adhesion": (
        {"damping": 0.5, "pull_off_force": 0.05},
        lambda x, v: K * x + 0.5 * v + 0.05,
    ),
}


@pytest.mark.parametrize("name", LOSSES)
def test_contact_is_lost_and_regained_at_the_right_instants(name):
    values, attached_until = LOSSES[name]
    composition = Composition(effects=(EFFECTS[name],))
    times = np.arange(1600) * PERIOD
    position = 2e-4 + vibrating(times) * 0.8
    position -= 2e-4 * np.exp(-times / 0.02)
    truth, events = lifted(attached_until, values["damping"], position, times)
    values = values_of(composition, **values)
    force = force_of(composition, values, position).output
    assert events >= 10
    rms = np.sqrt(np.mean(truth**2))
    assert np.sqrt(np.mean((force - truth) ** 2)) < 2e-3 * rms
    # In shorter steps the events themselves err by next to nothing.
    coil = halved(halved(course(composition.kernel, position, PERIOD, values)))
    start = np.zeros(len(composition.kernel.states))
    finer = respond(composition.kernel, values, start, coil).output[::4]
    assert np.sqrt(np.mean((finer - truth[: finer.size]) ** 2)) < 1e-5 * rms


def test_a_tip_that_is_pulled_at_hard_enough_for_less_than_a_step_comes_off():
    times, damping = np.arange(700) * PERIOD, 0.5
    position = 3e-4 + vibrating(times)
    position -= 3e-4 * np.exp(-times / 0.02)
    composition = Composition(effects=(EFFECTS["adhesion"],))
    never = values_of(composition, damping=damping, pull_off_force=1e3)
    attached = force_of(composition, never, position).output
    tip, often = CubicSpline(times, position - attached / K0), np.linspace(0, times[-1], 70_000)
    tension = [-K * tip(at) - damping * tip(at, 1) for at in (times, often)]
    pull = np.mean([each.max() for each in tension])
    assert tension[0].max() < pull < tension[1].max()
    truth, events = lifted(
        lambda x, v: K * x + damping * v + pull, damping, position, times, longest=2e-5
    )
    force = force_of(
        composition, values_of(composition, damping=damping, pull_off_force=pull), position
    ).output
    assert events >= 1
    assert np.abs(truth - attached).max() > 0.1
    np.testing.assert_allclose(force, truth, atol=2e-3 * np.abs(truth).max())


def test_a_tip_that_hardly_sticks_moves_as_one_that_never_pulls():
    # Damping tears it off deep in the tissue, where it sticks again as soon as it is pushed back.
    times = np.arange(4000) * PERIOD
    phases = np.random.default_rng(2).uniform(0.0, 2.0 * np.pi, 60)
    angles = 2.0 * np.pi * np.arange(1, 61)[:, None] * times + phases[:, None]
    position = 4e-3 * risen(times, 0.1) + 1e-4 * risen(times, 0.3) * np.sin(angles).sum(axis=0)
    never_pulls = Composition(effects=EFFECTS["contact_loss"].forms)
    sticking = Composition(effects=(EFFECTS["adhesion"],))
    values = {"stiffness": 313.0, "damping": 6.4}
    pushed = force_of(never_pulls, values_of(never_pulls, **values), position).output
    stuck = force_of(sticking, values_of(sticking, pull_off_force=1e-6, **values), position).output
    free = Composition()
    assert np.ptp(force_of(free, values_of(free, **values), position).output - pushed) > 0.05
    np.testing.assert_allclose(stuck, pushed, atol=1e-4)


@pytest.mark.parametrize("share", [0.1, 0.6, 0.9])
def test_an_error_that_is_periodic_in_the_true_position_is_taken_off(share):
    # As steep as ``share`` of what would make two positions read the same.
    period = 2e-5
    sine, cosine = share * period / (2.0 * np.pi) * np.array([0.6, -0.8])
    true = 3e-4 * np.sin(2.0 * np.pi * 3.0 * np.arange(2000) * PERIOD)
    angle = 2.0 * np.pi * true / period
    read = true + sine * np.sin(angle) + cosine * np.cos(angle)
    composition = Composition(effects=(EFFECTS["encoder_interpolation"],))
    values = values_of(
        composition, interpolation_sine=sine, interpolation_cosine=cosine, grating_period=period
    )
    kernel = composition.kernel
    found = course(kernel, read, PERIOD, values).pieces[3]
    off = np.sqrt(np.mean((found - true[:-1]) ** 2))
    assert off < 0.01 * np.sqrt(np.mean((read - true) ** 2))


@pytest.mark.parametrize("effect", ["bouc_wen_hysteresis", "coulomb_friction"])
def test_friction_is_followed_as_closely_however_fast_the_probe_is(effect):
    """It is stiff at speed where it yields, at rest where it is dry; the start tells neither."""
    composition = Composition(effects=(EFFECTS[effect],))
    strength, shape = {
        "bouc_wen_hysteresis": ({"hysteretic_force": 0.07}, {"yield_displacement": 5e-5}),
        "coulomb_friction": ({"coulomb_force": 0.07}, {"transition_velocity": 1e-4}),
    }[effect]
    values = values_of(composition, **strength, **shape)
    times = np.arange(2000) * PERIOD
    chirp = 1e-3 * np.sin(2 * np.pi * (1.0 + 29.5 * times) * times)  # 60 Hz in the end
    fine = CubicSpline(times, chirp)(np.arange(16 * 1999 + 1) * PERIOD / 16)
    force = force_of(composition, values, chirp).output
    finer = force_of(composition, values, fine, PERIOD / 16).output[::16]
    assert np.sqrt(np.mean((force - finer) ** 2)) < 1e-3  # a fifth of the load cell's noise


def test_what_is_late_begins_at_rest_where_a_motion_begins_at_full_speed():
    position = 1e-3 * np.sin(62.8 * np.arange(800) * PERIOD)
    alone = Composition().plus(EFFECTS["channel_delay"])
    switching = alone.plus(EFFECTS["stiffness_step"])
    late = {"channel_delay": 1e-2, "stiffness": 265.0, "damping": 3.8}
    expected = force_of(alone, values_of(alone, **late), position).output
    found = force_of(switching, values_of(switching, step_change=0.0, **late), position).output
    np.testing.assert_allclose(found, expected, atol=0.02 * np.abs(expected).max())


@pytest.mark.parametrize("name", ["backlash", "contact_loss", "coulomb_friction_1"])
@pytest.mark.parametrize("delay", [7e-5, 2.3e-3, -8e-4])
def test_what_switches_answers_to_an_input_that_is_late(name, delay):
    """A force with kinks is no spline through its samples: those lie elsewhere when it is late."""
    alone = Composition().plus(FORMS[name])
    composition = alone.plus(EFFECTS["channel_delay"])
    times = np.arange(1500) * PERIOD
    late = force_of(composition, values_of(composition, channel_delay=delay), vibrating(times))
    expected = force_of(alone, values_of(alone), vibrating(np.maximum(times - delay, 0.0))).output
    inside = times > 0.02
    inside &= times < times[-1] - 2e-3
    off = (late.output - expected)[inside]
    assert np.sqrt(np.mean(off**2)) < 2e-4 * np.ptp(expected)
    step = 1e-6
    above, below = (
        force_of(composition, values_of(composition, channel_delay=d), vibrating(times)).output
        for d in (delay + step, delay - step)
    )
    column = len(composition.kernel.states) + composition.kernel.values.index("channel_delay")
    slope = ((above - below) / (2 * step))[inside]
    found = late.sensitivity[inside, column]
    # Where a switch turns at a sample the quotient of differences tells nothing.
    assert np.median(np.abs(found - slope)) < 1e-3 * np.std(slope)
    assert np.corrcoef(found, slope)[0, 1] > 0.99
