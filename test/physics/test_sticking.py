"""A tip that dry friction holds: until when, and what follows for all that is estimated."""

import numpy as np
import pytest
from composed import PERIOD, force_of, risen, values_of

from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.effects.effect import TIME

K0, B0 = 9700.0, 0.8
STICKING = {
    "coulomb_friction": {"coulomb_force": 0.1},
    "stribeck_friction": {
        "stribeck_coulomb_force": 0.07,
        "breakaway_excess": 0.03,
        "stribeck_velocity": 3e-3,
    },
}
TIMES = np.arange(2000) * PERIOD


def sticking(name: str) -> Composition:
    (form,) = EFFECTS[name].forms
    return Composition(effects=(form,))


@pytest.mark.parametrize("name", STICKING)
def test_a_tip_is_held_until_the_other_forces_exceed_the_friction(name):
    composition = sticking(name)
    values = values_of(composition, **STICKING[name])
    position = 3e-5 * risen(TIMES, TIMES[-1])
    held = K0 * position + B0 * np.gradient(position, PERIOD) < 0.1
    force = force_of(composition, values, position).output
    assert 500 < held.sum() < 1500
    assert force[held] == pytest.approx(K0 * position[held], abs=1e-12)
    assert np.all(force[~held][10:] < K0 * position[~held][10:] - 1e-4)  # it has given way


@pytest.mark.parametrize("name", STICKING)
def test_a_tip_that_nothing_moves_stays_where_it_was_pushed(name):
    """With the coil at rest again the force is what friction holds, whatever the time."""
    composition = sticking(name)
    position = 1e-3 * (risen(TIMES, 0.3) - 0.05 * risen(TIMES - 0.3, 0.3))
    force = force_of(composition, values_of(composition, **STICKING[name]), position).output
    still = TIMES > 0.65
    assert np.ptp(force[still]) < 1e-9
    tissue = 450.0 * (position[-1] - force[-1] / K0)
    assert 1e-3 < abs(force[-1] - tissue) < 0.1


@pytest.mark.parametrize("speed", [20.0, 200.0])
@pytest.mark.parametrize("name", STICKING)
def test_sensitivities_hold_where_it_sticks_and_where_it_turns_at_once(name, speed):
    composition = sticking(name)
    values = values_of(composition, **STICKING[name])
    position = 1e-3 * risen(TIMES, 0.1) * np.sin(speed * TIMES)
    sensitivity = force_of(composition, values, position).sensitivity
    for entry in composition.effects[0].parameters:
        index = composition.kernel.values.index(entry.name)
        step = np.zeros(values.size)
        step[index] = 1e-4 * values[index]
        ahead, back = (
            force_of(composition, v, position).output for v in (values + step, values - step)
        )
        slope = (ahead - back) / (2.0 * step[index])
        found = sensitivity[:, len(composition.kernel.states) + index]
        # Where an instant differs by a sample between the two, the slope has a tooth.
        assert np.median(np.abs(found - slope)) < 5e-3 * np.std(slope)


def test_creep_becomes_sticking_as_it_gets_slower():
    creeping = Composition(effects=(EFFECTS["coulomb_friction"].plain,))
    position = 1e-3 * risen(TIMES, 0.1) * np.sin(62.8 * TIMES)
    composition = sticking("coulomb_friction")
    held = force_of(composition, values_of(composition, coulomb_force=0.1), position).output
    errors = []
    for velocity in (1e-3, 1e-4, 1e-5):
        values = values_of(creeping, coulomb_force=0.1, transition_velocity=velocity)
        errors.append(np.sqrt(np.mean((force_of(creeping, values, position).output - held) ** 2)))
    assert errors[0] > 3.0 * errors[1] > 9.0 * errors[2]
    assert errors[2] < 5e-4


def test_a_recording_that_begins_in_motion_begins_with_a_tip_that_slides():
    composition = sticking("coulomb_friction")
    values = values_of(composition, coulomb_force=0.1)
    position = 1e-3 * np.sin(62.8 * TIMES)
    long = force_of(composition, values, position)
    for first in (1000, 1025, 1050, 1075):  # forwards, back, and near the turns
        speed = np.gradient(position - long.output / K0, PERIOD)[first]
        start = np.array([position[first] - long.output[first] / K0, speed])
        force = force_of(composition, values, position[first:], start=start).output
        assert np.sqrt(np.mean((force - long.output[first:]) ** 2)) < 2e-3


def test_friction_in_the_guide_knows_nothing_of_a_surface_that_breathes():
    moved = EFFECTS["tissue_motion"]
    own = {TIME, *(entry.symbol for entry in moved.parameters)}
    for form in EFFECTS["coulomb_friction"].every_form:
        acceleration = Composition(effects=(moved, form)).model.motion[1]
        friction = acceleration.expand().coeff(form.parameters[0].symbol)
        assert friction != 0
        assert own.isdisjoint(friction.free_symbols)
        assert not own.isdisjoint(acceleration.free_symbols)


def test_a_tip_that_follows_the_coil_is_dragged_at_once_whichever_way_it_goes():
    (form,) = EFFECTS["coulomb_friction"].forms
    plain, rubbed = (Composition("rigid_probe", effects=e) for e in ((), (form,)))
    position = 1e-3 * np.sin(62.8 * TIMES)
    alone = force_of(plain, values_of(plain), position).output
    force = force_of(rubbed, values_of(rubbed, coulomb_force=0.1), position).output
    speed = np.cos(62.8 * TIMES)
    moving = np.abs(speed) > 0.02
    assert (force - alone)[moving] == pytest.approx(0.1 * np.sign(speed[moving]), abs=1e-9)
