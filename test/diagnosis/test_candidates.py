"""The order in which searches for effects go on."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import pytest
from hidden import EXACT, TOLERANT, challenge, measurement
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.diagnosis.ranking.candidates import _by_turns, fit_base, fit_candidates
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS


@given(st.lists(st.integers(0, 4), max_size=6), st.integers(1, 3))
def test_every_search_ends_and_none_goes_on_before_all_have_begun(lengths, threads):
    taken = []

    def search(name):
        for step in range(lengths[name]):
            taken.append((name, step))
            yield name, step

    with ThreadPoolExecutor(threads) as pool:
        found = _by_turns(pool, [search(name) for name in range(len(lengths))])
    assert sorted(found) == [
        (name, step) for name, most in enumerate(lengths) for step in range(most)
    ]
    others = [step > 0 for _, step in taken]
    first = others.index(True) if any(others) else len(taken)
    assert first > sum(most > 0 for most in lengths) - threads  # so many may be under way


def test_a_search_that_fails_is_not_passed_over():
    def search():
        yield "found"
        raise ValueError("diverged")

    with ThreadPoolExecutor(1) as pool, pytest.raises(ValueError, match="diverged"):
        _by_turns(pool, [search()])


def test_a_form_is_searched_that_only_where_it_is_fitted_differs_from_another():
    """By a model without it the tissue never pulls: there both forms of Hertz's contact are one."""
    hidden = ("structural_mode", "hertz_contact")
    made = challenge(994788119, *hidden, excitation="chirp60", rig="tolerant")
    base = fit_base(Composition(), [measurement(made.recording)], TOLERANT)
    (plain,) = fit_candidates(base, [EFFECTS["hertz_contact"].plain], TOLERANT)
    (best,) = fit_candidates(base, [EFFECTS["hertz_contact"]], TOLERANT)
    assert best.ratio < 0.7 * plain.ratio
    assert len(best.composition.kernel.first) == 2  # touching, pushing


def test_a_form_begins_where_a_better_one_ended():
    """To where a tip sticks and slides the way led through friction that only creeps."""
    made = challenge(480002, "stribeck_friction", excitation="stepped30")
    base = fit_base(Composition(), [measurement(made.recording)], EXACT)
    (best,) = fit_candidates(base, [EFFECTS["stribeck_friction"]], EXACT)
    assert best.composition.effects[-1].moving != 1
    assert best.ratio < 1.02  # from its own starts the sticking form ended at 1.12
