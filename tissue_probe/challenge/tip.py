"""The tip's equation of motion between two events.

Contents: the rates of all states while contact, friction and play keep their mode, and the guards
that say that one has ended.

States: tip position, velocity, Bouc-Wen's z [-], mode's position and velocity, recent strain
amplitude [m], recent speed [m/s], largest depth so far [m], way in and out so far [m], work
of Bouc-Wen's force over that force [m], then
the force of each relaxation branch [N], then the place of each slider [m].
Modes: touching (0, 1), sliding (-1, 0 sticks, 1), engaged (-1, 0 in the gap, 1).
"""

from __future__ import annotations

import math

from numba import njit

from tissue_probe.challenge.specimen import Specimen
from tissue_probe.challenge.tissue import (
    bond,
    elastic,
    share_after_depth,
    share_after_way,
    steepness,
    stiffness,
    surface,
    viscous,
)
from tissue_probe.signals import FloatArray, IntArray

POSITION, VELOCITY, BOUC, MODE, MODE_VELOCITY, STRAIN, AGILITY, LARGEST, WAY, WORK, BRANCHES = (
    range(11)
)
TOUCHING, SLIDING, ENGAGED = range(3)


@njit(cache=True, nogil=True, error_model="numpy")
def tissue_force(p: Specimen, time: float, state: FloatArray) -> float:
    """Force of tissue in contact with the tip [N], whether it could be so or not."""
    d, d_rate = surface(p, time)
    depth, rate = state[POSITION] - d, state[VELOCITY] - d_rate
    force = elastic(p, stiffness(p, time, rate, state[STRAIN]), depth)
    if p.damage != 0.0:
        force *= share_after_depth(p, depth, state[LARGEST])
    if p.worked_off != 0.0:
        force *= share_after_way(p, state[WAY])
    force += viscous(p, time, depth, rate, state[AGILITY])
    for branch in range(p.branches):
        force += state[BRANCHES + branch]
    return force


@njit(cache=True, nogil=True, error_model="numpy")
def cell_force(p: Specimen, engaged: int, u: float, u_rate: float, state: FloatArray) -> float:
    """Force of the load cell on the tip, spring and damper [N].

    With play (Nordin and Gutman, 2002, dead-zone model) none while the coil is in the gap.
    """
    if engaged == 0:
        return 0.0
    stretch = u - state[POSITION] - engaged * p.play
    return float(p.load_cell_stiffness * stretch + p.load_cell_damping * (u_rate - state[VELOCITY]))


@njit(cache=True, nogil=True, error_model="numpy")
def friction(p: Specimen, speed: float) -> float:
    """Coulomb's force, more at low speed (Stribeck; Armstrong-Helouvry et al., 1994, eq. 3) [N]."""
    if p.static == p.coulomb:
        return p.coulomb
    return p.coulomb + (p.static - p.coulomb) * math.exp(-((speed / p.stribeck_velocity) ** 2))


@njit(cache=True, nogil=True, error_model="numpy")
def stack_force(p: Specimen, state: FloatArray) -> float:
    """Force of springs between the tip and sliders that give way, each at its reach [N].

    Prandtl (1928), Ishlinskii (1944): each spring's compression is x less a play of x (Kuhnen,
    2003).
    """
    force, first = 0.0, BRANCHES + p.branches
    for i in range(p.sliders):
        reach = p.slider_reach[i]
        compressed = state[POSITION] - state[first + i]
        force += p.slider_stiffness[i] * min(max(compressed, -reach), reach)
    return force


@njit(cache=True, nogil=True, error_model="numpy")
def drive(
    p: Specimen, time: float, u: float, u_rate: float, state: FloatArray, modes: IntArray
) -> float:
    """Sum of all forces on the tip but dry friction [N]."""
    force = cell_force(p, modes[ENGAGED], u, u_rate, state) - p.bouc_force * state[BOUC]
    force -= stack_force(p, state)
    if modes[TOUCHING]:
        pushed = tissue_force(p, time, state)
        if p.bond_range != 0.0:
            pushed = max(pushed, -bond(p, state[POSITION] - surface(p, time)[0]))
        force -= pushed
    if p.corrugation != 0.0:
        force -= p.corrugation * math.sin(2.0 * math.pi * state[POSITION] / p.corrugation_period)
    if p.mode_mass != 0.0:
        force += p.mode_stiffness * (state[MODE] - state[POSITION])
        force += p.mode_damping * (state[MODE_VELOCITY] - state[VELOCITY])
    return float(force)


@njit(cache=True, nogil=True, error_model="numpy")
def rates(
    p: Specimen,
    time: float,
    u: float,
    u_rate: float,
    state: FloatArray,
    modes: IntArray,
    result: FloatArray,
) -> None:
    """Write the derivatives of all states."""
    v = state[VELOCITY]
    force = drive(p, time, u, u_rate, state, modes)
    if p.static != 0.0 and modes[SLIDING] == 0:
        result[POSITION] = result[VELOCITY] = 0.0
    else:
        result[POSITION] = v
        result[VELOCITY] = (force - modes[SLIDING] * friction(p, abs(v))) / p.tip_mass
    result[BOUC] = result[MODE] = result[MODE_VELOCITY] = result[STRAIN] = result[AGILITY] = 0.0
    result[LARGEST] = result[WAY] = result[WORK] = 0.0
    if p.bouc_force != 0.0:
        # Bouc (1967), Wen (1976) with A = 1, n = 1.
        z = state[BOUC]
        closing = p.bouc_beta * abs(v) * z + p.bouc_gamma * v * abs(z)
        # Strength that falls with the energy taken up (Baber and Wen, 1981): nu = 1 + d e.
        nu = 1.0 + p.bouc_weakening * max(state[WORK], 0.0)
        result[BOUC] = (v - nu * closing) / p.bouc_yield
        result[WORK] = z * v
    if p.mode_mass != 0.0:
        result[MODE] = state[MODE_VELOCITY]
        pull = p.mode_stiffness * (state[POSITION] - state[MODE])
        pull += p.mode_damping * (v - state[MODE_VELOCITY])
        result[MODE_VELOCITY] = pull / p.mode_mass
    d, d_rate = surface(p, time)
    if p.softening != 0.0:
        result[STRAIN] = (abs(state[POSITION] - d) - state[STRAIN]) / p.softening_time
    if p.agile_damping != 0.0:
        result[AGILITY] = (abs(v - d_rate) - state[AGILITY]) / p.agile_time
    if p.worked_off != 0.0:
        result[WAY] = abs(v - d_rate)
    rate = v - d_rate if modes[TOUCHING] else 0.0
    if p.branch_curved != 0.0:
        rate *= steepness(p, state[POSITION] - d)
    for branch in range(p.branches):
        decay = p.branch_rate[branch] * state[BRANCHES + branch]
        result[BRANCHES + branch] = p.branch_stiffness[branch] * rate - decay
    for i in range(p.sliders):
        result[BRANCHES + p.branches + i] = 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def remember(p: Specimen, time: float, state: FloatArray) -> None:
    """Keep the largest depth that the tip has reached, and move the sliders that it has moved."""
    depth = state[POSITION] - surface(p, time)[0]
    state[LARGEST] = max(state[LARGEST], depth, p.damage_reached)
    first = BRANCHES + p.branches
    for i in range(p.sliders):
        at, reach = state[POSITION], p.slider_reach[i]
        state[first + i] = min(max(state[first + i], at - reach), at + reach)


@njit(cache=True, nogil=True, error_model="numpy")
def find_ended_mode(
    p: Specimen, time: float, u: float, u_rate: float, state: FloatArray, modes: IntArray
) -> int:
    """Return the number of a mode that has ended, or -1.

    Contact ends when the tissue would have to pull by more than ``pull_off``, and begins when the
    tip is below the surface and pushed back. A bond with a range gives way first, and is torn by
    the gap: where it is as wide as the range, or a hundredth of the threads is left. Sliding ends
    when the velocity changes its sign, sticking when more than the static friction is needed to
    hold the tip.
    """
    if p.bond_range != 0.0:
        depth = state[POSITION] - surface(p, time)[0]
        widest = p.bond_range * (math.log(100.0) if p.bond_threads != 0.0 else 1.0)
        if depth < -widest if modes[TOUCHING] else depth > 0.0:
            return TOUCHING
    elif p.unilateral != 0.0:
        force = tissue_force(p, time, state)
        if modes[TOUCHING]:
            if force < -p.pull_off:
                return TOUCHING
        elif force > 0.0 and state[POSITION] > surface(p, time)[0]:
            return TOUCHING
    if p.static != 0.0:
        if modes[SLIDING] != 0:
            if modes[SLIDING] * state[VELOCITY] < 0.0:
                return SLIDING
        elif abs(drive(p, time, u, u_rate, state, modes)) > p.static:
            return SLIDING
    if p.play != 0.0:
        stretch = u - state[POSITION]
        if modes[ENGAGED] == 0:
            if abs(stretch) > p.play:
                return ENGAGED
        elif modes[ENGAGED] * stretch < p.play:
            return ENGAGED
    return -1


@njit(cache=True, nogil=True, error_model="numpy")
def switch(
    p: Specimen, time: float, u: float, u_rate: float, state: FloatArray, modes: IntArray, mode: int
) -> None:
    """Put a mode that has ended into its next."""
    if mode == TOUCHING:
        modes[TOUCHING] = 1 - modes[TOUCHING]
    elif mode == SLIDING:
        stuck = modes[SLIDING] == 0
        state[VELOCITY] = 0.0
        force = drive(p, time, u, u_rate, state, modes)
        held = abs(force) <= p.static and not stuck
        modes[SLIDING] = 0 if held else (1 if force > 0.0 else -1)
    elif modes[ENGAGED] != 0:
        modes[ENGAGED] = 0
    else:
        modes[ENGAGED] = 1 if u > state[POSITION] else -1
