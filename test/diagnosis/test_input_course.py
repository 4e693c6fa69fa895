"""How a force goes on between its samples is told by the best model, and may be jumps."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import lsim

import tissue_probe as tp

PERIOD, MASS, STIFFNESS, DAMPING = 2e-2, 0.3, 40.0, 2.0


def noisy(position, noise):
    return position + noise * np.random.default_rng(1).standard_normal(position.size)


def answered(force, times, jumps):
    """Return the position of a mass on tissue under a force of time, solved from jump to jump."""

    def slope(t, z):
        return [z[1], (force(t) - STIFFNESS * z[0] - DAMPING * z[1]) / MASS]

    state, found, ends = np.zeros(2), np.zeros(times.size), [*jumps, times[-1] + PERIOD]
    for begin, end in zip([0.0, *jumps], ends, strict=True):
        inside = (times >= begin) & (times < end)
        # The solver sees one side of each jump.
        solved = solve_ivp(
            slope, (begin, end - 1e-9), state, dense_output=True, rtol=1e-10, atol=1e-12,
            max_step=PERIOD,
        )  # fmt: skip
        found[inside] = solved.sol(times[inside])[0]
        state = solved.y[:, -1]
    return found


def ramps(t):
    """Return ramps that end at once, as a simulation commands them."""
    t = np.asarray(t)
    return np.select([t < 4.0, t < 6.0, t < 9.0], [0.5 * t, 0.0, 3.0 - 0.2 * t], -1.0)


def ramped():
    times = PERIOD * np.arange(600)
    position = answered(ramps, times, (4.0, 6.0, 9.0))
    return {"t": times, "u": noisy(position, 2e-5), "F": ramps(times)}


def test_a_force_that_jumps_at_a_sample_and_is_smooth_elsewhere_is_told():
    recording = tp.read(ramped(), force_polarity="compression")
    found = tp.compare(recording, rig="force_driven", starts="at-rest")
    assert any("jumps at a sample" in each for each in found.notes)
    values, deviations = found.fit.named(), found.fit.deviations()
    for name, true in (("tip_mass", MASS), ("stiffness", STIFFNESS), ("damping", DAMPING)):
        assert abs(values[name] - true) < 4.0 * deviations[name]
    held = tp.compare(recording, rig="force_driven", starts="at-rest", course="held")
    assert held.fit.ratio > 3.0 * found.fit.ratio


def test_it_may_be_stated_too():
    recording = tp.read(ramped(), force_polarity="compression")
    told, stated = (
        tp.compare(recording, rig="force_driven", starts="at-rest", course=course)
        for course in ("auto", "jumping")
    )
    assert stated.fit.named() == pytest.approx(told.fit.named())


@pytest.mark.battery
def test_half_a_sample_between_straight_lines_and_a_converter_is_no_delay():
    """The course is chosen by a model without relaxation, and chosen wrongly."""
    rate, stiffness = 12.0, 15.0
    times = 3e-3 * np.arange(2100)
    force = np.repeat([0.0, 0.6, -0.4, 1.0, 0.2, -0.7, 0.9], 300)
    tissue = (
        [
            [0.0, 1.0, 0.0],
            [-STIFFNESS / MASS, -DAMPING / MASS, -stiffness / MASS],
            [0.0, 1.0, -rate],
        ],
        [[0.0], [1.0 / MASS], [0.0]],
        [[1.0, 0.0, 0.0]],
        0.0,
    )
    position = noisy(lsim(tissue, force, times, interp=True)[1], 4e-6)
    recording = tp.read({"t": times, "u": position, "F": force}, force_polarity="compression")
    found = tp.diagnose(recording, rig="force_driven", starts="at-rest")
    assert found.effects == ("standard_linear_solid",)
    assert found.verdict == "missing"
    assert found.found.revisions == ("course",)
    assert found.found.ladder.final.named()["relaxation_rate"] == pytest.approx(rate, rel=0.05)


def slid(force, steps, mass, damping, friction):
    """Return the position of a mass that slides with dry friction, in small steps between samples.

    ``force`` is what drives in each of them [N].
    """
    position, velocity, found = 0.0, 0.0, []
    interval = PERIOD / steps
    for index, push in enumerate(force):
        if index % steps == 0:
            found.append(position)
        if velocity == 0.0 and abs(push) <= friction:
            continue
        way = np.sign(velocity) if velocity else np.sign(push)
        slower = velocity + interval * (push - damping * velocity - friction * way) / mass
        after = 0.0 if slower * velocity < 0.0 else slower
        position += interval * (velocity + after) / 2.0
        velocity = after
    return np.array(found)


def test_a_drive_that_sticks_and_is_read_in_steps_rubs():
    """Rounding is the same in all samples of a rest, and no colour of what is left."""
    steps, friction = 400, 0.6
    fine = np.arange(700 * steps) * PERIOD / steps
    force = np.select(
        [fine < 4.0, fine < 6.0, fine < 9.0], [0.7 * fine, 0.0, 3.0 - 0.2 * fine], -1.1
    )
    position = np.round(slid(force, steps, MASS, DAMPING, friction), 4)
    record = {"t": PERIOD * np.arange(700), "u": position, "F": force[::steps]}
    recording = tp.read(record, force_polarity="compression")
    held = {"stiffness": 0.0, "contact_position": 0.0}
    found = tp.diagnose(recording, rig="force_driven", starts="at-rest", constants=held)
    assert (found.verdict, found.effects) == ("missing", ("coulomb_friction",))
    # Which course it is, tells the model that has what is asked for.
    asked = tp.diagnose(
        recording,
        rig="force_driven",
        starts="at-rest",
        constants=held,
        add=["coulomb_friction"],
    )
    assert asked.found.ladder.final.ratio < 1.1
    values = asked.found.ladder.final.named()
    assert values["coulomb_force"] == pytest.approx(friction, rel=0.01)
    assert values["tip_mass"] == pytest.approx(MASS, rel=0.01)
    assert values["damping"] == pytest.approx(DAMPING, rel=0.01)
