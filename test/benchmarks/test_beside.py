"""The comparison with other tools ends, whatever a tool does."""

import time
from pathlib import Path

import numpy as np
import pytest

from benchmarks.beside.data import SETS
from benchmarks.beside.limited import limited
from benchmarks.beside.measure import tables
from benchmarks.beside.results import Result

SET, NOWHERE = SETS[0], Path("nowhere")


def work_on(of, data):
    """Never end."""
    while True:
        time.process_time()


def fail_at_once(of, data):
    """Fail."""
    raise ValueError("no such file")


def test_a_tool_that_does_not_end_is_ended_and_shown_as_such():
    found = limited("endless", work_on, SET, NOWHERE, most=1.0)
    assert (found.set, found.tool, found.seconds) == (SET.name, "endless", np.inf)
    assert np.isnan(found.errors).all()
    assert next(iter(tables([found])[0].columns[-1].cells)).startswith("over ")


def test_a_result_comes_back_as_the_tool_returns_it():
    result = Result(SET.name, "quick", "missing: nothing", (1.0, 2.0, 3.0), 0.5)
    assert limited("quick", lambda of, data: result, SET, NOWHERE) == result


def test_a_tool_that_fails_is_told_by_its_name():
    with pytest.raises(RuntimeError, match="broken failed on Silverbox"):
        limited("broken", fail_at_once, SET, NOWHERE)
