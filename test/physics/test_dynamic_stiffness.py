"""Sharing the tissue's dynamic stiffness with a law that relaxes."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.physics.dynamic_stiffness import hand_over, of_branch
from tissue_probe.physics.effects.effect import Extent
from tissue_probe.physics.effects.hertz_contact import near

EXTENT = Extent(
    duration=2.0, indentation=1e-3, depth=2.6e-3, speed=0.06, force=0.3, pull=0.2, step=1e-7
)
positive = st.floats(1e-2, 1e4)


@given(positive, positive, positive, positive, positive, positive, st.floats(0.0, 1.0))
def test_tissue_and_branch_are_together_as_stiff_as_before(k, beta, branch, old, new, omega, share):
    known, unit = branch * of_branch(omega, old), of_branch(omega, new)
    strength, tissue = hand_over(omega, {"stiffness": k, "damping": beta}, known, unit, share)
    before = k + 1j * omega * beta + known
    after = tissue["stiffness"] + 1j * omega * tissue["damping"] + strength * unit
    assert after == pytest.approx(before, rel=1e-9)
    assert strength >= 0.0
    assert min(tissue["stiffness"], omega * tissue["damping"]) >= -1e-9 * abs(before)


@given(positive, positive)
def test_a_branch_is_a_spring_far_above_its_rate_and_a_damper_far_below(omega, rate):
    assert of_branch(omega, 1e-6 * omega) == pytest.approx(1.0, abs=1e-5)
    assert of_branch(omega, 1e6 * omega) == pytest.approx(1e-6j, abs=1e-10)
    assert 0.0 <= of_branch(omega, rate).real <= 1.0


@given(st.floats(10.0, 1e4), st.floats(0.8, 3.5))
def test_contact_is_proposed_as_stiff_where_it_is_deepest_or_as_steep_midway(k, exponent):
    def force(values, depth):
        return values["stiffness"] * 1e-3 * (depth / 1e-3) ** values["contact_exponent"]

    def slope(values, depth):
        return force(values, depth) * values["contact_exponent"] / depth

    found = {"stiffness": k, "contact_exponent": exponent}
    middle = EXTENT.depth - EXTENT.indentation
    for proposed in near(EXTENT, found):
        deepest = force(proposed, EXTENT.depth) == pytest.approx(force(found, EXTENT.depth))
        midway = slope(proposed, middle) == pytest.approx(slope(found, middle))
        assert deepest or midway
