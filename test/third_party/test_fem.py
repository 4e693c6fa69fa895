"""Blocks by finite elements: closed forms, two solvers on one block, and records."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("skfem", reason="scikit-fem is not installed: pip install scikit-fem")
pytest.importorskip("felupe", reason="felupe is not installed: pip install felupe")

from benchmarks.third_party.fem_block import Block, linear_stiffness, neo_hookean_force
from benchmarks.third_party.fem_records import LEAST, MOST, deal

BLOCK = Block(30e-3, 20e-3, 8e-3, 2e4, 0.4)


def test_a_column_that_is_pressed_all_over_is_a_spring_of_its_area():
    # Without lateral contraction the bonded punch changes nothing.
    column = Block(10e-3, 20e-3, 10e-3, 2e4, 0.0)
    expected = 2e4 * np.pi * 10e-3**2 / 20e-3
    assert linear_stiffness(column) == pytest.approx(expected, rel=1e-6)


def test_a_small_punch_on_a_large_block_is_near_the_half_space():
    # Bonded, and of finite height: a little stiffer than 2 a E / (1 - nu^2).
    large = Block(0.12, 0.12, 5e-3, 2e4, 0.3)
    half_space = 2.0 * 5e-3 * 2e4 / (1.0 - 0.3**2)
    assert 1.0 < linear_stiffness(large, 48) / half_space < 1.25


def test_finer_elements_give_nearly_the_same_stiffness():
    assert linear_stiffness(BLOCK, 48) == pytest.approx(linear_stiffness(BLOCK, 24), rel=0.05)


def test_a_neo_hookean_block_begins_linear_and_stiffens():
    force = neo_hookean_force(BLOCK, np.array([0.0, 1e-5, 2e-5, 5e-3]))
    assert force[0] == pytest.approx(0.0, abs=1e-9)
    assert force[2] / force[1] == pytest.approx(2.0, rel=1e-3)
    assert force[3] / force[1] > 1.02 * 500.0


def test_the_force_is_in_proportion_to_the_modulus():
    twice = replace(BLOCK, modulus=2.0 * BLOCK.modulus)
    assert linear_stiffness(twice) == pytest.approx(2.0 * linear_stiffness(BLOCK))
    depths = np.array([0.0, 2e-3])
    np.testing.assert_allclose(
        neo_hookean_force(twice, depths), 2.0 * neo_hookean_force(BLOCK, depths), rtol=1e-6
    )


def test_records_hold_what_their_truth_says():
    clean, hidden = deal(1, False), deal(1, True)
    record, values = clean.first, clean.truth.values
    spread = np.ptp(record.position)
    assert values["stiffness"] * spread == pytest.approx(np.ptp(record.force), rel=0.3)
    assert not clean.truth.hidden
    assert hidden.truth.families == ("stiffening",)
    assert LEAST <= hidden.truth.ratio <= MOST
