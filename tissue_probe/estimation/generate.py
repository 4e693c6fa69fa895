"""Source of the Kalman filters' kernels: model, discretisation and equations in, functions out.

Contents: which functions a kernel module has, and how they are written.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable
from pathlib import Path
from types import ModuleType

import sympy as sp

from tissue_probe.estimation import considered_constants
from tissue_probe.estimation.equations import Filter
from tissue_probe.estimation.layout import (
    DERIVED,
    PER_STATE,
    SETTINGS,
    VERDICT_SIZE,
    StateLayout,
)
from tissue_probe.physics.effects.effect import POSITION_BEFORE
from tissue_probe.physics.model import Model

OPTIONS = 'error_model="numpy"'
TEMPLATES = Path(__file__).with_name("templates")
LOOP = TEMPLATES / "loop.py"
PAST_INPUTS = TEMPLATES / "past_inputs.py"
WINDOWS = TEMPLATES / "windows.py"
VERDICT = TEMPLATES / "verdict.py"
BY_HAND = TEMPLATES / "by_hand.py"
ENTRIES = TEMPLATES / "entries.py"

# A larger number is no measurement [m, N]: it counts as missing, as a NaN does.
LARGEST = 1e4
# Stands for a pivot of 0, which divides nothing but 0 where a matrix is semidefinite.
TINY = sp.Float(1e-300)
# The sums that ``windows`` keeps, from the first of these places on.
WINDOW_SUMS = {"WINDOWS": 0.0, **{f"WINDOWS_{place}": 0.0 for place in range(1, 8)}}
# How many numbers an estimator written by hand may carry along for itself: the first in ``memory``.
OWN_NUMBERS = 32

FILTER_HEADER = '''"""Generated from the symbols of model and filter; do not edit."""
from __future__ import annotations

import math
from functools import partial

import numba
import numpy as np
from numba import carray, cfunc

# The callers of these functions are compiled code, too: nobody calls them from Python or from C.
njit = partial(numba.njit, no_cpython_wrapper=True, no_cfunc_wrapper=True)

'''


def source(model: Model, discretisation: str, layout: StateLayout, equations: ModuleType) -> str:
    """Return the source of a kernel module.

    Its functions work on the arrays ``constants`` and ``memory`` (see ``StateLayout``): ``start``
    and ``reopen`` set them up, ``run`` filters samples. Each function has a part of the memory of
    its own for intermediate results, since one may call another.
    """
    size = layout.size

    def function(
        signature: str, write: Callable[[Filter], Iterable[sp.Expr] | None], given: bool = False
    ) -> str:
        nonlocal size
        filter = Filter(model, discretisation, layout, given, size)
        returns = write(filter) or ()
        size += filter.program.used
        body = filter.program.source(signature, ", ".join(map(str, returns)))
        return f"@njit({OPTIONS})\n{body}"

    states = ", ".join(layout.states)
    taking_in = WINDOWS if layout.windowed else PAST_INPUTS
    functions = [
        taking_in.read_text(),
        function("start(constants, memory)", _start),
        function("reopen(constants, memory)", _reopen),
        function("forget(constants, memory)", _forget),
        function("cap(constants, memory)", _cap),
        function("is_definite(constants, memory)", _is_definite),
        function("expected(constants, memory)", _expected),
        function("output(constants, memory)", _output),
        function(f"step(constants, memory, {states})", _step, given=True),
        function("true_position(constants, memory, position)", _true_position, given=True),
        function("tick(constants, memory)", _tick, given=True),
        function("predict(constants, memory)", lambda filter: _predict(filter, equations)),
        function(
            "update(constants, memory, innovation, S, R)",
            lambda filter: _update(filter, equations),
        ),
        function("is_bounded(constants, memory)", considered_constants.is_bounded),
        function("bound(constants, memory)", considered_constants.bound),
        function("told(constants, memory)", _told),
        function("inflate(constants, memory, factor, offset_factor)", _inflate),
        f"@njit({OPTIONS})\n{inspect.getsource(equations.weigh)}",
        VERDICT.read_text(),
        LOOP.read_text(),
        ENTRIES.read_text(),
    ]
    places = _places(layout, size, layout.verdict, equations.FOLLOWS)
    return FILTER_HEADER + places + "\n\n".join(functions)


def source_by_hand(layout: StateLayout, path: Path) -> str:
    """Return the source of a kernel module whose ``start``, ``reopen``, ``run`` are in a file."""
    texts = [text.read_text() for text in (VERDICT, BY_HAND, path, ENTRIES)]
    return (
        FILTER_HEADER
        + _places(layout, OWN_NUMBERS + VERDICT_SIZE, OWN_NUMBERS, False)
        + "\n\n".join(texts)
    )


def _places(layout: StateLayout, memory: int, verdict: int, follows: bool) -> str:
    """Return the names in capitals that the texts written by hand use."""
    states = layout.states
    names: dict[str, object] = {name.upper(): layout.constant(name) for name in SETTINGS}
    names |= {name.upper(): layout.constant(name) for name in DERIVED}
    names |= {name.upper(): layout.per_state(name) for name in PER_STATE}
    names |= {name: layout.carried(name) for name in layout.extra}
    names |= {
        "STATES": len(states),
        "DIAGONAL": tuple(layout.covariance(i, i) for i in range(len(states))),
        "STIFFNESS": states.index("stiffness"),
        "DAMPING": states.index("damping"),
        "STIFFNESS_DAMPING": layout.covariance(states.index("stiffness"), states.index("damping")),
        "OFFSET": "force_offset" in states,
        "HISTORY": layout.history,
        "PRIMED": layout.primed,
        "PREDICTED": layout.predicted,
        "LATEST": layout.latest,
        "VERDICT": verdict,
        "FOLLOWS": follows,
        "CONSTANTS": layout.constant_count,
        "MEMORY": memory,
        "FLOOR": 1e-24,
        "LARGEST": LARGEST,
        "STATE_NAMES": states,
        "EXTRA": layout.extra,
    }
    return "".join(f"{name} = {place!r}\n" for name, place in names.items()) + "\n\n"


def _forget(filter: Filter) -> None:
    """Know less than the prior: a constant force, too, may have any value within its bounds."""
    filter.assign(filter.per_state("prior"), sp.diag(*filter.per_state("largest_variance")))
    considered_constants.begin(filter)


def _start(filter: Filter) -> None:
    """Know nothing but the prior, and no input yet."""
    layout = filter.layout
    filter.assign(filter.per_state("prior"), sp.diag(*filter.per_state("prior_variance")))
    filter.program.store("memory", layout.history, [0.0] * 8)
    filter.program.store("memory", layout.verdict, [1.0] + (VERDICT_SIZE - 1) * [0.0])
    filter.program.store("memory", layout.verdict + VERDICT_SIZE, list(layout.extra.values()))
    considered_constants.begin(filter)


def _reopen(filter: Filter) -> None:
    """Keep the estimates of the tissue; forget the motion and the input's history."""
    names = filter.layout.states
    walks = {name for name, prior in filter.layout.priors.items() if prior.walk > 0.0}
    kept = [i >= len(filter.model.states) and name not in walks for i, name in enumerate(names)]
    prior = sp.diag(*filter.per_state("prior_variance"))
    P = sp.Matrix(*prior.shape, lambda i, j: filter.P[i, j] if kept[i] and kept[j] else prior[i, j])
    filter.assign(filter.X, P)
    considered_constants.reopen(filter, kept)
    filter.program.store("memory", filter.layout.primed, [0.0])


def _predict(filter: Filter, equations: ModuleType) -> None:
    """Advance by one sample."""
    if filter.considered:
        considered_constants.predict(filter)
    equations.predict(filter)


def _update(filter: Filter, equations: ModuleType) -> None:
    """Take in an innovation."""
    if filter.considered:
        considered_constants.update(filter)
    equations.update(filter)


def _told(filter: Filter) -> list[sp.Expr]:
    """Return stiffness, damping, the covariance's trace and its part of these two, the offset."""
    names, let = filter.layout.states, filter.program.let
    k, beta = names.index("stiffness"), names.index("damping")
    X, P = filter.X, filter.P
    if filter.considered:
        P += filter.W * filter.W.T
    trace = sp.Symbol("trace")
    filter.program.line(f"{trace} = 0.0")
    for i in range(len(names)):
        filter.program.line(f"{trace} += {let('variance', P[i, i])}")
    offset = X[names.index("force_offset")] if "force_offset" in names else sp.Integer(0)
    return [X[k], X[beta], trace, P[k, k], P[beta, beta], P[k, beta], offset]


def _is_definite(filter: Filter) -> list[sp.Expr]:
    """Whether P is one that numbers can have: no pivot of P = L D L^T is below 0."""
    P, size = filter.P, len(filter.layout.states)
    definite = sp.Symbol("definite")
    filter.program.line(f"{definite} = True")
    for j in range(size):
        filter.program.line(f"{definite} &= {P[j, j]} >= 0.0")
        pivot = filter.program.let("pivot", sp.Max(P[j, j], TINY))
        P = P.copy()
        for i in range(j + 1, size):
            ratio = filter.program.let("ratio", P[i, j] / pivot)
            for k in range(j + 1, i + 1):
                P[i, k] = filter.program.let("rest", P[i, k] - ratio * P[k, j])
    return [definite]


def _cap(filter: Filter) -> None:
    """Scale rows and columns of P so that no variance exceeds its ceiling: P stays definite."""
    ceilings = filter.per_state("largest_variance")
    shares = [ceiling / filter.P[i, i] for i, ceiling in enumerate(ceilings)]
    D = sp.diag(*filter.let("scale", sp.Matrix([sp.sqrt(sp.Min(1, share)) for share in shares])))
    filter.assign(filter.X, D * filter.P * D)


def _inflate(filter: Filter) -> None:
    """Multiply the variances by a factor, that of the force offset by one of its own."""
    factor, offset_factor = sp.symbols("factor offset_factor", real=True)
    factors = [offset_factor if s == "force_offset" else factor for s in filter.layout.states]
    D = sp.diag(*filter.let("root", sp.Matrix(factors).applyfunc(sp.sqrt)))
    filter.assign(filter.X, D * filter.P * D)


def _expected(filter: Filter) -> list[sp.Symbol]:
    """Predict the force."""
    return [filter.program.let("force", filter.force)]


def _output(filter: Filter) -> list[sp.Symbol]:
    """Predict the force and its variance."""
    program = filter.program
    return [program.let("force", filter.force), program.let("S", filter.force_variance)]


def _true_position(filter: Filter) -> list[sp.Symbol]:
    """Return the coil's place, computed from the encoder's; at first it was there already."""
    program, layout = filter.program, filter.layout
    if "POSITION_BEFORE" not in layout.extra:
        return [program.let("true", filter.model.position)]
    place = layout.carried("POSITION_BEFORE")
    program.load("memory", layout.primed, ["primed"])
    program.load("memory", place, [str(POSITION_BEFORE)])
    program.line(f"if primed == 0.0: {POSITION_BEFORE} = {filter.model.input}")
    true = program.let("true", filter.model.position)
    program.store("memory", place, [true])
    return [true]


def _tick(filter: Filter) -> None:
    """Count the samples, for a model that knows the time."""
    if "SAMPLES" in filter.layout.extra:
        place = filter.layout.carried("SAMPLES")
        (samples,) = filter.program.load("memory", place, ["samples"])
        filter.program.store("memory", place, [samples + 1])
    filter.program.line("return")


def _step(filter: Filter) -> list[sp.Symbol]:
    """Advance the motion of one point by one sample (a sigma point, eq. 34)."""
    if not filter.model.states:
        filter.program.line("return")
        return []
    return list(filter.motion(derivatives=False).states)
