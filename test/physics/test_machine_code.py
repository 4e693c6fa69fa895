"""Machine code is made once, found again without Numba, and never calls what is not there."""

import ctypes
import os
import subprocess
import sys
from functools import partial

import pytest
import sympy as sp
from llvmlite import ir

from tissue_probe.physics import code_cache, llvm_code, machine_code, numba_code
from tissue_probe.physics.llvm_code import Function
from tissue_probe.physics.machine_code import Text

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


NUMBER = sp.Symbol("number", real=True)


def made(value, name="answer"):
    """A function of one number, kept with a fact."""
    module = ir.Module()
    function = Function(module, name, {"number": llvm_code.NUMBER}, llvm_code.NUMBER)
    function.name(NUMBER, "number")
    function.end(value)
    return Text(str(module), (name,), {"ANSWER": 42})


def called(code, name, number):
    return ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(code.addresses[name])(number)


def test_code_is_made_once_and_kept(folder):
    calls = []

    def write():
        calls.append(1)
        return made(2 * NUMBER)

    code = machine_code.load("twice", write)
    assert machine_code.load("twice", write) is code
    (path,) = folder.glob("tissue_probe_twice_*.o")
    del machine_code._loaded[path]
    again = machine_code.load("twice", write)
    assert again is not code
    assert calls == [1]
    for each in (code, again):
        assert each.facts == {"ANSWER": 42}
        assert called(each, "answer", 1.5) == 3.0


def test_functions_of_two_texts_are_linked_by_their_names():
    caller = ir.Module()
    signature = ir.FunctionType(llvm_code.NUMBER, [llvm_code.NUMBER])
    wanted = ir.Function(caller, signature, "answer")
    calls = ir.Function(caller, signature, "calls")
    builder = ir.IRBuilder(calls.append_basic_block())
    builder.ret(builder.call(wanted, calls.args))
    beside = ("caller", lambda: Text(str(caller), ("calls",), {}, ("answer",)))
    for factor in (2, 3):
        write = partial(made, factor * NUMBER)
        code = machine_code.load(f"times_{factor}", write, beside=lambda _: beside)
        assert called(code, "calls", 1.5) == factor * 1.5


def test_code_that_needs_numba_is_refused_when_it_is_made(folder):
    """A process without Numba would be ended by LLVM."""
    module = code_cache.module("needs_numba", lambda: NEEDS_NUMBA)
    with pytest.raises(RuntimeError, match="NRT_"):
        machine_code.load("needs_numba", lambda: numba_code.text(module))
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
