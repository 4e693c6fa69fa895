"""Machine code is made once, found again without Numba, and never calls what is not there."""

import ctypes
import os
import subprocess
import sys

import pytest

from tissue_probe.physics import machine_code

TWICE = """
from numba import cfunc

ANSWER = 42


@cfunc("float64(float64)")
def twice(number):
    return 2.0 * number
"""
# An array that is made, and a division that may raise.
NEEDS_NUMBA = """
import numpy as np
from numba import cfunc


@cfunc("float64(int64, float64)")
def share(count, number):
    return np.ones(count).sum() / number
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("TISSUE_PROBE_CACHE", str(tmp_path))
    return tmp_path


def test_code_is_made_once_and_kept(folder):
    calls = []

    def write():
        calls.append(1)
        return TWICE

    code = machine_code.load("twice", write, ("ANSWER",))
    assert machine_code.load("twice", write, ("ANSWER",)) is code
    (path,) = folder.glob("tissue_probe_twice_*.o")
    del machine_code._loaded[path]
    again = machine_code.load("twice", write, ("ANSWER",))
    assert again is not code
    assert calls == [1]
    for each in (code, again):
        assert each.facts == {"ANSWER": 42}
        twice = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(each.addresses["twice"])
        assert twice(1.5) == 3.0


def test_code_that_needs_numba_is_refused_when_it_is_made(folder):
    """A process without Numba would be ended by LLVM."""
    with pytest.raises(RuntimeError, match="NRT_"):
        machine_code.load("needs_numba", lambda: NEEDS_NUMBA, ())
    assert not list(folder.glob("*.o"))


@pytest.mark.parametrize("name", ["robust_ekf", "lock_in"])
def test_a_warm_start_needs_neither_symbols_nor_numba(name, monkeypatch):
    """SymPy would cost a process that only filters half a second, Numba nearly a whole one."""
    monkeypatch.delenv("TISSUE_PROBE_CACHE")
    text = (
        "import sys; from tissue_probe.estimation import Estimator, EstimatorSettings;"
        f"Estimator({name!r}, EstimatorSettings());"
        "print([name for name in ('sympy', 'numba', 'scipy') if name in sys.modules])"
    )
    for _ in range(2):  # the first may have to generate
        run = subprocess.run(
            [sys.executable, "-c", text],
            capture_output=True, text=True, check=True, env=os.environ | {"PYTHONPATH": "."},
        )  # fmt: skip
    assert run.stdout.strip() == "[]"
