"""Whether a residual is noise, by its cosines."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.diagnosis.evidence.adequacy import EVEN
from tissue_probe.diagnosis.residuals.whiteness import SMALL_SHARE, colour, unevenness

COUNT = 4000


def noise(seed, count=COUNT):
    return np.random.default_rng(seed).standard_normal(count)


@given(st.integers(0, 10_000), st.integers(500, 20_000), st.floats(1e-6, 1e6))
def test_noise_of_any_level_is_white(seed, count, level):
    cosines = [level * noise(seed, count)]
    assert abs(colour(cosines) - 1.0) < 6.0 / np.sqrt(count / 4)
    assert unevenness(cosines) < EVEN


@given(st.integers(0, 10_000), st.integers(0, COUNT // 8 - 1))
def test_a_slow_line_stands_out_wherever_it_lies(seed, order):
    cosines = noise(seed)
    octave = max(2, 1 << int(np.log2(max(order, 1))))
    cosines[order] = np.sqrt(2.5 * EVEN * (1.0 + np.sqrt(2.0 * octave)))
    assert unevenness([cosines]) > EVEN


def test_a_line_that_the_colour_of_all_slow_cosines_hardly_shows_stands_out():
    cosines = noise(4)
    cosines[5] = 7.0
    assert colour([cosines]) < 1.12
    assert unevenness([cosines]) > EVEN


def test_what_is_fast_is_no_slow_excess():
    cosines = noise(1)
    cosines[COUNT // 2] = 100.0
    assert unevenness([cosines]) < EVEN
    assert colour([cosines]) < 1.0


def test_what_hardly_matters_does_not_count_on_a_long_recording():
    short, long = noise(2), noise(2, 100 * COUNT)
    for cosines in (short, long):
        cosines[5] = 7.0
    assert unevenness([short]) > EVEN
    assert unevenness([long]) < 49.0 / (SMALL_SHARE * long.size)


def test_octaves_of_several_recordings_add_up():
    alone = noise(3)
    alone[2:4] = 4.5, 1.0
    assert unevenness([alone] * 4) > EVEN > unevenness([alone])
