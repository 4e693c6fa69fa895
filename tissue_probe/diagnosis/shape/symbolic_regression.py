"""Forms of a learnt curve that no catalogue has, by symbolic regression.

Contents: expressions found by genetic programming, as forms to be refitted to the record.

pyoperon (B. Burlacu, G. Kronberger, M. Kommenda, Operon C++, GECCO Companion (2020), 1562) trades
the error on the curve against the length of an expression. It is an extra of the package: without
it there are no such forms.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from tissue_probe.diagnosis.shape.curve import curve
from tissue_probe.diagnosis.shape.forms import Form
from tissue_probe.diagnosis.shape.shape import Shape
from tissue_probe.signals import FloatArray

if TYPE_CHECKING:
    import sympy as sp

#: Constants inside an expression beyond which it is no simple formula: with its factor four, as
#: many as the largest law of the library has beside stiffness and damping.
MOST_CONSTANTS = 3
#: Nodes of the longest expression: three constants, and a function of each.
LONGEST = 12
#: How much wider or narrower an expression is tried than the curve says.
STRETCH = 1.1
SYMBOLS = "add,sub,mul,div,constant,variable,sin,exp,tanh,abs,square"


def regress_forms(found: Shape, signal: str) -> list[Form]:
    """Return forms of the curve of one signal, the simplest first; none without pyoperon.

    Parameters
    ----------
    found : Shape
        A function of the signal alone.
    signal : {"indentation", "velocity"}
        The signal.
    """
    try:
        from pyoperon.sklearn import SymbolicRegressor
    except ImportError:
        return []
    drawn = curve(found)
    if drawn is None:
        return []
    (grid,) = drawn.grid
    largest = float(np.max(np.abs(grid)))
    # One thread and one seed: the same record has the same answer.
    search = SymbolicRegressor(
        allowed_symbols=SYMBOLS,
        objectives=["mse", "length"],
        max_length=LONGEST,
        optimizer_iterations=5,
        population_size=500,
        generations=60,
        n_threads=1,
        random_state=0,
    )
    search.fit((grid / largest)[:, None], drawn.value / np.std(drawn.value))
    texts = [each["model"] for each in search.pareto_front_]
    visited = np.concatenate([np.zeros(1), *(getattr(path, signal) for path in found.paths)])
    return [each for each in _list_forms(texts, signal, largest) if _is_finite(each, visited)]


def _is_finite(form: Form, visited: FloatArray) -> bool:
    """Whether a form has a value where the record was, and at zero."""
    with np.errstate(all="ignore"):
        return bool(np.isfinite(form.law(visited, 1.0)).all())


def _list_forms(texts: list[str], signal: str, largest: float) -> Iterator[Form]:
    """Yield forms of expressions in ``X1``, the signal over the largest value of it.

    Of expressions that differ by their numbers alone the last is taken: it is the nearest.
    """
    import sympy as sp

    at = sp.Symbol("X1", real=True)
    laws: dict[sp.Expr, sp.Expr] = {}
    for text in texts:
        whole = sp.sympify(text.replace("^", "**"), locals={"X1": at})
        law = _leave_out_line(whole, at)
        numbers = law.atoms(sp.Float)
        if law != 0 and len(numbers) <= MOST_CONSTANTS:
            laws[law.xreplace(dict.fromkeys(numbers, sp.Symbol("number")))] = law
    for law in laws.values():
        yield _form(law, at, signal, largest)


def _leave_out_line(whole: sp.Expr, at: sp.Symbol) -> sp.Expr:
    """Return an expression without its level, slope and factor, which the record tells anew."""
    import sympy as sp

    terms = [each.as_independent(at, as_Add=False) for each in sp.Add.make_args(whole.expand())]
    bent = sp.Add(*(factor * law for factor, law in terms if law not in (1, at)))
    return bent.as_independent(at, as_Add=False)[1]


def _form(law: sp.Expr, at: sp.Symbol, signal: str, largest: float) -> Form:
    """Return c times an expression, which may be stretched by a."""
    import sympy as sp

    s, a = sp.symbols("s a", real=True)
    stretched = law.subs(at, a * s / largest)
    stretched = stretched.xreplace({each: sp.Float(each, 6) for each in stretched.atoms(sp.Float)})
    compiled = sp.lambdify((s, a), stretched, "numpy")

    def values(of: FloatArray, by: float) -> FloatArray:
        return np.asarray(compiled(of, by), dtype=float)

    return Form(
        f"by regression: {sp.sstr(stretched.subs(s, sp.Symbol(signal)))}",
        "c * " + sp.sstr(sp.Symbol("c") * stretched).removeprefix("c*").replace("Abs(", "abs("),
        values,
        least=1.0 / STRETCH,
        most=STRETCH,
        of="number",
        fixed=len(law.atoms(sp.Float)),
    )
