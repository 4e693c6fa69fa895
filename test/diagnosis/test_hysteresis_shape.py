"""Hysteresis whose loops are of another shape than friction's that yields, or many, or weakens."""

import numpy as np
from scipy.integrate import solve_ivp

from tissue_probe.diagnosis.diagnosis import diagnose
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.rigs import RIGID_PROBE

STILL = Instrument(RIGID_PROBE, RIGID_PROBE.known | {"tip_mass": (0.0, 0.0)})
LIBRARY = {
    name: EFFECTS[name]
    for name in (
        *("bouc_wen_hysteresis", "prandtl_ishlinskii", "coulomb_friction", "stribeck_friction"),
        *("standard_linear_solid", "cubic_stiffening", "force_drift"),
    )
}
STIFFNESS, BETA, GAMMA, NOISE = 900.0, 400.0, -500.0, 2e-3
LARGEST_SLIP, STACK = 1.5e-3, 0.02
SLIP, WEAKENING = 3e-4, 20.0
TURNS = 2.0 * np.pi * np.array([0.5, 1.3, 2.9])


def way(times, phases):
    """Three sines [m], and their speed [m/s]."""
    angles = np.multiply.outer(times, TURNS) + phases
    return np.sin(angles) @ [2e-3, 1e-3, 4e-4], np.cos(angles) @ (TURNS * [2e-3, 1e-3, 4e-4])


def recorded(seed):
    """Record a spring, a damper and a loop that hardens, by another integrator."""
    random = np.random.default_rng(seed)
    phases, times = random.uniform(0.0, 2.0 * np.pi, 3), np.arange(0.0, 6.0, 4e-3)

    def slope(time, z):
        speed = way(time, phases)[1]
        return STIFFNESS * speed - BETA * np.abs(speed) * z - GAMMA * speed * np.abs(z)

    z = solve_ivp(slope, (0.0, 6.0), [0.0], t_eval=times, max_step=4e-3, rtol=1e-8, atol=1e-9).y[0]
    position, speed = way(times, phases)
    force = 500.0 * position + 3.0 * speed + z + NOISE * random.standard_normal(times.size)
    return Measurement(position, force, 4e-3)


def test_a_loop_that_hardens_is_named_with_its_shape_and_carries_over():
    found = diagnose(Composition("rigid_probe"), [recorded(1)], STILL, LIBRARY, [recorded(2)])
    assert (found.verdict, found.effects) == ("missing", ("bouc_wen_hysteresis",))
    final = found.ladder.final
    assert found.heldout(final) < 1.15 * NOISE
    values, deviations = final.named(), final.deviations()
    for name, truth in (
        ("hysteretic_stiffness", STIFFNESS), ("loop_closing", BETA), ("loop_bending", GAMMA)
    ):  # fmt: skip
        assert abs(values[name] - truth) < 4.0 * deviations[name]
        assert deviations[name] < 0.02 * abs(truth)


def stacked(seed):
    """Record a spring, a damper and eight springs behind sliders, each kept within its slip."""
    random = np.random.default_rng(seed)
    phases, times = random.uniform(0.0, 2.0 * np.pi, 3), np.arange(0.0, 6.0, 2e-4)
    position, speed = way(times, phases)
    slips = np.geomspace(LARGEST_SLIP / 30.0, LARGEST_SLIP, 8)
    shares = np.sqrt(slips) / np.sqrt(slips).sum()
    bent, stack = np.zeros(8), np.zeros(times.size)
    for sample, step in enumerate(np.diff(position), start=1):
        bent = np.clip(bent + step, -slips, slips)
        stack[sample] = shares @ (bent / slips)
    force = (500.0 * position + 3.0 * speed + STACK * stack)[::20]
    force += NOISE * random.standard_normal(force.size)
    return Measurement(position[::20], force, 4e-3)


def test_a_stack_of_sliders_is_named_with_its_force_and_carries_over():
    found = diagnose(Composition("rigid_probe"), [stacked(1)], STILL, LIBRARY, [stacked(2)])
    assert (found.verdict, found.effects) == ("missing", ("prandtl_ishlinskii",))
    final = found.ladder.final
    assert found.heldout(final) < 1.2 * NOISE
    values = final.named()
    # The elements of the fit slip as smoothly as neighbours do, not as sharply as each.
    assert abs(values["stack_force"] / STACK - 1.0) < 0.1
    assert abs(values["largest_slip"] / LARGEST_SLIP - 1.0) < 0.1
    assert abs(values["slip_slope"] - 0.5) < 0.1


def weakened(seed):
    """Record a spring, a damper and friction that loses its strength by the work done."""
    random = np.random.default_rng(seed)
    phases, times = random.uniform(0.0, 2.0 * np.pi, 3), np.arange(0.0, 6.0, 4e-3)

    def slope(time, state):
        (z, work), speed = state, way(time, phases)[1]
        slides = (1.0 + WEAKENING * work) * 0.5 * (np.abs(speed) * z + speed * np.abs(z))
        return (speed - slides) / SLIP, z * speed

    z = solve_ivp(
        slope, (0.0, 6.0), [0.0, 0.0], t_eval=times, max_step=4e-3, rtol=1e-8, atol=1e-9
    ).y[0]
    position, speed = way(times, phases)
    force = 500.0 * position + 3.0 * speed + STACK * z + NOISE * random.standard_normal(times.size)
    return Measurement(position, force, 4e-3)


def test_friction_that_weakens_with_work_is_named_with_how_fast_it_does():
    found = diagnose(Composition("rigid_probe"), [weakened(1)], STILL, LIBRARY)
    assert (found.verdict, found.effects) == ("missing", ("bouc_wen_hysteresis",))
    values, deviations = found.ladder.final.named(), found.ladder.final.deviations()
    truth = {
        "hysteretic_force": STACK, "yield_displacement": SLIP, "weakening_by_work": WEAKENING
    }  # fmt: skip
    for name, value in truth.items():
        assert abs(values[name] - value) < 4.0 * deviations[name]
        assert deviations[name] < 0.15 * value
