"""Margins of the loop of an admittance against closed forms, and against the loop run in time."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tissue_probe.contact.loop import Admittance


def grows(admittance: Admittance, stiffness: float, damping: float, seconds: float = 30.0) -> bool:
    """Run the loop from a small step on, in steps of Euler's; return whether its swings grow."""
    step = 2e-4
    late = round(admittance.delay / step)
    line = np.zeros(late + 1)
    commanded = speed = 0.0
    at, before = 1e-3, 1e-3
    swings = np.empty(round(seconds / step))
    for number in range(swings.size):
        line[number % line.size] = -(stiffness * at + damping * (at - before) / step)
        force = line[(number + 1) % line.size]
        pull = force - admittance.damping * speed - admittance.spring * at
        speed += step * pull / admittance.mass
        commanded += step * speed
        before = at
        if admittance.lag:
            at += step * (commanded - at) / admittance.lag
        else:
            at = commanded
        swings[number] = at
    third = swings.size // 3
    return bool(np.abs(swings[-third:]).max() > np.abs(swings[third : 2 * third]).max())


@pytest.mark.parametrize("lag", [0.0, 0.02])
def test_at_the_gain_margin_the_loop_begins_to_swing_up(lag):
    admittance = Admittance(mass=1.0, damping=80.0, spring=50.0, delay=0.02, lag=lag)
    gain = admittance.margins(1000.0, 3.0).gain
    assert 1.0 < gain < 10.0
    assert not grows(admittance, 0.93 * gain * 1000.0, 0.93 * gain * 3.0)
    assert grows(admittance, 1.07 * gain * 1000.0, 1.07 * gain * 3.0)


def test_more_delay_than_the_phase_margin_allows_makes_it_swing_up():
    admittance = Admittance(mass=1.0, damping=80.0, spring=50.0, delay=0.01)
    margins = admittance.margins(1000.0, 0.0)
    further = margins.phase / (2.0 * math.pi * margins.crossover)
    least, most = (replace(admittance, delay=0.01 + share * further) for share in (0.93, 1.07))
    assert not grows(least, 1000.0, 0.0)
    assert grows(most, 1000.0, 0.0)


@given(st.floats(0.05, 3.0), st.floats(10.0, 1e3), st.floats(1e-3, 0.05))
@settings(max_examples=20, deadline=None)
def test_a_damper_alone_has_the_margins_of_an_integrator_with_delay(turned, damping, delay):
    # Of k exp(-tau s) / (D s): crossover k / D, phase margin pi/2 - tau k / D, and gain margin
    # pi / 2 over tau k / D. Mass and spring are too small to count.
    rate = turned / delay
    stiffness = rate * damping
    admittance = Admittance(1e-4 * damping * delay, damping, 1e-6 * stiffness, delay)
    margins = admittance.margins(stiffness, 0.0)
    assert margins.gain == pytest.approx(0.5 * math.pi / (rate * delay), rel=1e-3)
    if rate * delay < 0.5 * math.pi:
        assert margins.crossover == pytest.approx(rate / (2.0 * math.pi), rel=1e-3)
        assert margins.phase == pytest.approx(0.5 * math.pi - rate * delay, abs=1e-3)


def test_without_delay_no_tissue_makes_it_unstable():
    margins = Admittance(2.0, 30.0, 100.0, delay=0.0).margins(1e4, 0.0)
    assert margins.gain == math.inf
    assert 0.0 < margins.phase < math.pi


def test_a_position_loop_slower_than_its_own_spring_has_no_margin():
    lazy = Admittance(mass=1.0, damping=1.0, spring=1000.0, delay=0.0, lag=0.5)
    assert not lazy.is_stable_in_air
    assert lazy.margins(100.0, 0.0).gain == 0.0


@pytest.mark.parametrize("late", [1, 2, 5])
def test_the_controllers_own_steps_swing_up_at_the_margin(late):
    # As admittance_controller integrates, 250 times a second: speed, then position by the new
    # speed; the force is that of the position some steps before.
    step, mass, damping, spring, stiffness = 4e-3, 2.0, 80.0, 50.0, 1000.0
    gain = Admittance(mass, damping, spring, late * step).margins(stiffness, 0.0).gain

    def growth(stiffness):
        """Largest eigenvalue of a step of (speed, position, positions before)."""
        steps = np.zeros((late + 2, late + 2))
        steps[0, 0] = 1.0 - step * damping / mass
        steps[0, 1] = -step * spring / mass
        steps[0, late + 1] -= step * stiffness / mass
        steps[1] = step * steps[0]
        steps[1, 1] += 1.0
        steps[np.arange(2, late + 2), np.arange(1, late + 1)] = 1.0
        return np.abs(np.linalg.eigvals(steps)).max()

    assert growth(0.95 * gain * stiffness) < 1.0 < growth(1.05 * gain * stiffness)
