"""What a rig's tip does and its sensors would read without noise: by SciPy's integrators.

Contents: equations of motion, with instants of contact and of sticking located.

    rigid_probe      x = u(t),                              F = m u'' + f(e, u') + Fc sign u'
    compliant_probe  m x'' = k0 (u - x) + b0 (u' - x') - f, F = k0 (u - x)
    force_driven     m x'' = F(t) - f,                      read is x
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import OptimizeResult

from benchmarks.protocols.course import Course
from benchmarks.protocols.specimen import Specimen

Array = np.ndarray
#: Relative error of a step; absolute errors are this share of the record's own scales.
TOLERANCE = 1e-8
#: So many times the fastest of a motion's own times, a stretch between two jumps of the course is
#: worth a solver that may become a stiff one, whose start takes many steps.
LONG = 20.0
#: How well SciPy finds the time of an event, as a share of it or of 1 s: `brentq` is asked for four
#: times the rounding, and two events are apart by twice that.
FOUND = 8.0 * np.finfo(float).eps
RIGID, COMPLIANT, DRIVEN = "rigid_probe", "compliant_probe", "force_driven"


@dataclass(frozen=True)
class Rig:
    """How the drive couples to the tip.

    Attributes
    ----------
    name : str
        ``rigid_probe``, ``compliant_probe`` or ``force_driven``.
    cell_stiffness, cell_damping : float
        Of the load cell between drive and tip [N/m], [N s/m]; of ``compliant_probe``.
    lag : float
        Time constant of a low-pass in the force channel [s]; 0 for none.
    """

    name: str
    cell_stiffness: float = 0.0
    cell_damping: float = 0.0
    lag: float = 0.0


@dataclass(frozen=True)
class Motion:
    """Position of the tip [m], and what the force channel has [N], at the times asked for."""

    position: Array
    force: Array


@dataclass(frozen=True)
class _Mode:
    """Where the tip is: in touch or not; sliding forwards (1), back (-1), or stuck (0)."""

    touching: bool
    sliding: int


class _Event:
    """What ends a mode: a function of time and states crosses zero in a direction."""

    terminal = True

    def __init__(self, kind: str, function: Callable, direction: float) -> None:
        self.kind, self.direction, self._function = kind, direction, function

    def __call__(self, time: float, state: Array) -> float:
        return self._function(time, state)


def simulate(rig: Rig, specimen: Specimen, course: Course, times: Array, begin: float) -> Motion:
    """Return the motion at ascending times, from rest at ``begin`` [s] or the first of them."""
    return _Simulation(rig, specimen, course).run(np.asarray(times, float), begin)


class _Simulation:
    """The states are [x, v] (unless the rig is rigid), the branches, [the low-pass]."""

    def __init__(self, rig: Rig, specimen: Specimen, course: Course) -> None:
        self.rig, self.specimen, self.course = rig, specimen, course
        self.rigid, self.driven = rig.name == RIGID, rig.name == DRIVEN
        self.own = 0 if self.rigid else 2
        count = len(specimen.branch_rate)
        self.branches = slice(self.own, self.own + count)
        self.gains = np.array(specimen.branch_stiffness)
        self.rates = np.array(specimen.branch_rate)
        self.size = self.own + count + (rig.lag > 0.0)

    def run(self, times: Array, begin: float) -> Motion:
        begin = min(begin, times[0])
        start = self._at_rest(begin)
        if not self.size:
            return self._read(times, np.empty((0, times.size)), None)
        states = np.empty((self.size, times.size))
        now, state, mode, done = begin, start, self._mode(begin, start), 0
        stops = self.course.breaks[(self.course.breaks > begin) & (self.course.breaks < times[-1])]
        slid = np.empty(times.size, int)
        for stop in [*stops, times[-1]]:
            last = np.searchsorted(times, stop, side="right")
            # A tip that yields in the last instant before a jump is followed from the jump on.
            while stop - now > FOUND * max(stop, 1.0):
                events = self._events(mode)
                found = self._advance(now, stop, state, mode, events)
                reached = min(np.searchsorted(times, found.t[-1], side="right"), last)
                if reached > done:
                    states[:, done:reached] = found.sol(times[done:reached])
                    slid[done:reached] = mode.sliding
                    done = reached
                now, state = found.t[-1], found.y[:, -1]
                if found.status == 1:
                    (kind,) = [
                        event.kind
                        for event, at in zip(events, found.t_events, strict=True)
                        if at.size
                    ][:1]
                    mode, state = self._turned(now, state, mode, kind)
            states[:, done:last], slid[done:last] = state[:, np.newaxis], mode.sliding
            done, now = max(done, last), stop
            mode = self._mode(now, state) if self.specimen.friction and not self.rigid else mode
        return self._read(times, states, slid)

    def _advance(
        self, now: float, stop: float, state: Array, mode: _Mode, events: list[_Event]
    ) -> OptimizeResult:
        # A step that ends at a jump of the course belongs to what is before it.
        before = np.nextafter(stop, now)
        # LSODA may end in numbers that are none, or stop short: then a slower one goes on.
        for method in ("LSODA", "Radau") if (stop - now) * self._fastest > LONG else ("DOP853",):
            found = solve_ivp(
                lambda time, y: self._rate(min(time, before), y, mode),
                (now, stop),
                state,
                method=method,
                dense_output=True,
                events=events,
                rtol=TOLERANCE,
                atol=TOLERANCE * self._scale,
                max_step=min(self.course.longest_step, stop - now),
            )
            if found.success and np.isfinite(found.y).all():
                return found
        raise ArithmeticError(f"{method} did not come from {now} s to {stop} s")

    @cached_property
    def _length(self) -> float:
        """How far the tip goes, roughly [m]."""
        probe = np.concatenate([self.course.breaks, np.linspace(0.0, self._end(), 200)])
        largest = float(np.ptp(self.course(probe))) or 1.0
        return largest / self.specimen.stiffness_at_once if self.driven else largest

    @cached_property
    def _scale(self) -> Array:
        """Return how large each state is, roughly: errors are a share of it."""
        stiffness, scale = self.specimen.stiffness_at_once, np.empty(self.size)
        if self.own:
            fastest = max(stiffness, self.rig.cell_stiffness) / self.specimen.mass
            scale[:2] = self._length, self._length * np.sqrt(fastest)
        scale[self.own :] = stiffness * self._length
        return scale

    @cached_property
    def _fastest(self) -> float:
        """The fastest of the motion's own rates, roughly [1/s]."""
        specimen, rates = self.specimen, [*self.rates]
        if self.own:
            stiffness = max(specimen.stiffness_at_once, self.rig.cell_stiffness)
            damping = specimen.damping + self.rig.cell_damping
            rates += [np.sqrt(stiffness / specimen.mass), damping / specimen.mass]
        return float(max([*rates, 1.0 / self.rig.lag if self.rig.lag else 0.0]))

    def _end(self) -> float:
        return getattr(self.course, "end", self.course.breaks[-1] if self.course.breaks.size else 1)

    def _tip(self, time: Array, state: Array) -> tuple[Array, Array]:
        if self.rigid:
            return self.course(time), self.course(time, 1)
        return state[0], state[1]

    def _push(self, time: Array, x: Array, v: Array) -> Array:
        """Return what drives a tip that is free to move [N]."""
        if self.driven:
            return self.course(time)
        return self.rig.cell_stiffness * (self.course(time) - x) + self.rig.cell_damping * (
            self.course(time, 1) - v
        )

    def _net(self, time: float, state: Array, mode: _Mode) -> float:
        """Return the force on a free tip [N], dry friction apart."""
        x, v = state[0], state[1]
        return float(self._push(time, x, v) - self._tissue(x, v, state, mode))

    def _tissue(self, x: Array, v: Array, state: Array, mode: _Mode) -> Array:
        if not mode.touching:
            return 0.0
        depth, branches = x - self.specimen.touch, state[self.branches].sum(axis=0)
        whole = self.specimen.spring(depth) + self.specimen.damping * v + branches
        return max(whole, 0.0) if self.specimen.one_sided else whole

    def _rate(self, time: float, state: Array, mode: _Mode) -> Array:
        rate = np.empty(self.size)
        x, v = self._tip(time, state)
        rate[self.branches] = self.gains * v * mode.touching - self.rates * state[self.branches]
        if self.own:
            held = self.specimen.friction and mode.sliding == 0
            net = self._net(time, state, mode) - self.specimen.friction * mode.sliding
            rate[:2] = (0.0, 0.0) if held else (v, net / self.specimen.mass)
        if self.rig.lag:
            load = self._load(time, x, v, self._tissue(x, v, state, mode))
            rate[-1] = (load - state[-1]) / self.rig.lag
        return rate

    def _load(self, time: Array, x: Array, v: Array, tissue: Array) -> Array:
        """Return what the load cell carries [N]."""
        if self.driven:
            return self.course(time)
        if self.rigid:
            inertia = self.specimen.mass * self.course(time, 2) if self.specimen.mass else 0.0
            return inertia + tissue + self.specimen.friction * np.sign(v)
        return self.rig.cell_stiffness * (self.course(time) - x)

    def _read(self, times: Array, states: Array, slid: Array | None) -> Motion:
        x, v = self._tip(times, states)
        if self.rig.lag:
            return Motion(x, states[-1])
        branches = states[self.branches].sum(axis=0) if self.gains.size else 0.0
        tissue = self.specimen.force(x - self.specimen.touch, v, branches)
        return Motion(x, self._load(times, x, v, tissue))

    def _at_rest(self, begin: float) -> Array:
        """Return the states of a tip that has rested for long, in balance with what drives it."""
        state, here = np.zeros(self.size), float(self.course(np.array(begin)))
        specimen = self.specimen
        if self.rigid:
            tissue = float(specimen.force(here - specimen.touch, 0.0, 0.0))
        else:
            state[0] = self._balance(here)
            tissue = float(specimen.force(state[0] - specimen.touch, 0.0, 0.0))
        if self.rig.lag:
            state[-1] = tissue
        return state

    def _balance(self, here: float) -> float:
        """Return where a free tip rests; of a law that is not linear only without a load."""
        specimen = self.specimen
        if self.driven:
            return specimen.touch + here / specimen.stiffness
        if here <= specimen.touch and specimen.one_sided:
            return here
        cell = self.rig.cell_stiffness
        whole = cell + specimen.stiffness
        return (cell * here + specimen.stiffness * specimen.touch) / whole

    def _mode(self, time: float, state: Array) -> _Mode:
        x, v = self._tip(np.array(time), state)
        touching = not self.specimen.one_sided or bool(x > self.specimen.touch)
        if self.rigid or not self.specimen.friction:
            return _Mode(touching, 0)
        still = abs(v) <= 1e-9 * self._scale[1]
        if not still:
            return _Mode(touching, int(np.sign(v)))
        net = self._net(time, state, _Mode(touching, 0))
        return _Mode(touching, int(np.sign(net)) if abs(net) > self.specimen.friction else 0)

    def _events(self, mode: _Mode) -> list[_Event]:
        found = []
        if self.specimen.one_sided:
            # A tip that rests just where it touches neither leaves nor comes.
            way, least = (-1.0 if mode.touching else 1.0), TOLERANCE * self._length
            found.append(_Event("touch", lambda t, y: self._depth(t, y) - way * least, way))
        if self.specimen.friction and not self.rigid:
            if mode.sliding:
                found.append(_Event("still", lambda t, y: y[1], -float(mode.sliding)))
            else:
                found.append(_Event("yields", lambda t, y: self._excess(t, y, mode), 1.0))
        return found

    def _depth(self, time: float, state: Array) -> float:
        return float(self._tip(np.array(time), state)[0]) - self.specimen.touch

    def _excess(self, time: float, state: Array, mode: _Mode) -> float:
        """Return by how much the force exceeds what friction can hold [N]."""
        return abs(self._net(time, state, mode)) - self.specimen.friction

    def _turned(self, now: float, state: Array, mode: _Mode, kind: str) -> tuple[_Mode, Array]:
        """Return mode and states after an event."""
        if kind == "touch":
            return _Mode(not mode.touching, mode.sliding), state
        if kind == "still":
            state = state.copy()
            state[1] = 0.0
            if self._excess(now, state, mode) <= 0.0:
                return _Mode(mode.touching, 0), state
        return _Mode(mode.touching, int(np.sign(self._net(now, state, mode)))), state
