"""What is stated in Python is checked where it comes in."""

import gc
import weakref

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import tissue_probe as tp
from tissue_probe.analysis import fit_shown

TIME = np.arange(2000) / 1000.0
DEPTH = 1e-3 * (1.0 + np.sin(20 * np.pi * TIME))
FORCE = 450.0 * DEPTH + 3.0 * np.gradient(DEPTH, TIME)
FORCE = FORCE + np.random.default_rng(0).normal(0.0, 2e-3, TIME.size)
STATED = {"rig": "rigid_probe", "constants": {"tip_mass": 0.0}}


def read(**columns):
    table = {"t": TIME, "u": DEPTH, "F": FORCE} | columns
    return tp.read(table, force_polarity="compression")


@given(st.text(max_size=12).filter(lambda word: word not in ("compression", "tension")))
@settings(max_examples=30, deadline=None)
def test_a_polarity_that_is_none_is_refused_and_never_guessed(word):
    with pytest.raises(tp.TissueProbeError, match="give compression or tension"):
        tp.read({"t": TIME, "u": DEPTH, "F": FORCE}, force_polarity=word)


@pytest.mark.parametrize(
    ("name", "known"), [("position_polarity", "into or out"), ("clock", "stamps or recorder")]
)
def test_so_are_the_other_choices(name, known):
    table = {"t": TIME, "u": DEPTH, "F": FORCE}
    with pytest.raises(tp.TissueProbeError, match=f"`{name}` is 'Up'; give {known}"):
        tp.read(table, force_polarity="compression", **{name: "Up"})


@given(begin=st.integers(0, 1500), length=st.integers(1, 150))
@settings(max_examples=20, deadline=None)
def test_masked_values_are_missing_values(begin, length):
    masked = np.zeros(TIME.size, dtype=bool)
    masked[begin : begin + length] = True
    spoilt = np.where(masked, 0.5 * FORCE, FORCE)
    one = read(F=np.ma.array(spoilt, mask=masked))
    other = read(F=np.where(masked, np.nan, FORCE))
    np.testing.assert_array_equal(one.force, other.force)


def test_a_force_that_is_masked_all_over_is_no_force():
    with pytest.raises(tp.TissueProbeError, match="has no number"):
        read(F=np.ma.array(FORCE, mask=True))


def test_what_is_kept_of_a_result_goes_with_it():
    result = tp.compare(read(), **STATED)
    assert str(result)
    assert result.fit in fit_shown._WHERE
    kept = weakref.ref(result.fit)
    del result
    gc.collect()
    assert kept() is None
