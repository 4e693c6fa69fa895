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


# A function that is linked later, by its name, and what calls it.
CALLER = """
import ctypes

import llvmlite.binding as llvm
from numba import cfunc, types

LINKED = ("wanted",)
llvm.add_symbol("wanted", ctypes.cast(ctypes.pythonapi.Py_FatalError, ctypes.c_void_p).value)
wanted = types.ExternalFunction("wanted", types.float64(types.float64))


@cfunc("float64(float64)")
def one_more(number):
    return wanted(number) + 1.0
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


def test_functions_of_two_modules_are_linked_by_their_names(folder, monkeypatch):
    (folder / "caller_of_wanted.py").write_text(CALLER)
    monkeypatch.syspath_prepend(str(folder))
    for name, factor in (("first", 2.0), ("second", 3.0)):
        write = TWICE.replace("2.0", str(factor)).replace("twice", "wanted").__str__
        code = machine_code.load(name, write, ("ANSWER",), beside=lambda _: "caller_of_wanted")
        call = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(code.addresses["one_more"])
        assert call(1.5) == factor * 1.5 + 1.0


def test_code_that_needs_numba_is_refused_when_it_is_made(folder):
    """A process without Numba would be ended by LLVM."""
    with pytest.raises(RuntimeError, match="NRT_"):
        machine_code.load("needs_numba", lambda: NEEDS_NUMBA, ())
    assert not list(folder.glob("*.o"))


def warm(text, monkeypatch):
    """What a second process prints, which finds what this one has compiled."""
    monkeypatch.delenv("TISSUE_PROBE_CACHE")
    exec(text, {})
    run = subprocess.run(
        [sys.executable, "-c", text],
        capture_output=True, text=True, check=True, env=os.environ | {"PYTHONPATH": "."},
    )  # fmt: skip
    return run.stdout.strip()


@pytest.mark.parametrize("name", ["robust_ekf", "lock_in"])
def test_a_warm_start_needs_neither_symbols_nor_numba(name, monkeypatch):
    """SymPy would cost a process that only filters half a second, Numba nearly a whole one."""
    text = (
        "import sys; from tissue_probe.estimation import Estimator, EstimatorSettings;"
        f"Estimator({name!r}, EstimatorSettings());"
        "print([name for name in ('sympy', 'numba', 'scipy') if name in sys.modules])"
    )
    assert warm(text, monkeypatch) == "[]"


@pytest.mark.parametrize("effect", ["generalized_maxwell", "contact_loss"])
def test_a_model_is_simulated_again_without_numba(effect, monkeypatch):
    """One that is linear, and one in which something switches."""
    text = (
        "import sys, numpy as np; from tissue_probe.physics.composition import Composition;"
        "from tissue_probe.physics.effects import EFFECTS;"
        "from tissue_probe.physics.response import course, respond;"
        f"model = Composition(effects=(EFFECTS[{effect!r}],)); kernel = model.kernel;"
        "values = np.array([entry.default for entry in model.values]);"
        "coil = course(kernel, 1e-4 * np.sin(np.arange(99.0)), 5e-4, values);"
        "start = np.zeros(len(kernel.states));"
        "print(np.ptp(respond(kernel, values, start, coil).output) > 0.1, 'numba' in sys.modules)"
    )
    assert warm(text, monkeypatch) == "True False"
