"""The order in which searches for effects go on."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.diagnosis.candidates import _by_turns


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
