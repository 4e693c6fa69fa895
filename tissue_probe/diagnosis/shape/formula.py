"""A simple formula for a learnt function, if there is one: each form is refitted to the record.

Contents: the form that explains the record best, its constants, and its rivals.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.shape.choice import ALIKE_FACTOR, FITS
from tissue_probe.diagnosis.shape.forms import FORMS, SIGNALS, Form
from tissue_probe.diagnosis.shape.free_functions import Group
from tissue_probe.diagnosis.shape.gram import Gram
from tissue_probe.diagnosis.shape.paths import Path
from tissue_probe.diagnosis.shape.shape import Shape
from tissue_probe.diagnosis.shape.symbolic_regression import regress_forms
from tissue_probe.diagnosis.shape.tip_response import tip_response
from tissue_probe.quantities import SIDE
from tissue_probe.signals import FloatArray, IntArray

#: By how much the cost may rise within a 95 % interval.
COST_WITHIN_INTERVAL = 3.84


@dataclass(frozen=True)
class FormConstant:
    """A constant of a formula, with its 95 % interval."""

    name: str
    unit: str
    value: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Formula:
    """A formula that explains a record as well as a free function.

    Attributes
    ----------
    name : str
        Of its form.
    written : str
        Its form in Python's words, of ``s``, ``c`` and ``a``.
    signal : str
        The signal that it is a function of.
    constants : tuple of FormConstant
        c, then a where the form has it.
    probability : float
        Among the forms that explain the record.
    rivals : tuple of str
        Names of other forms within the noise.
    """

    name: str
    written: str
    signal: str
    constants: tuple[FormConstant, ...]
    probability: float
    rivals: tuple[str, ...]

    @property
    def text(self) -> str:
        """The formula with its signal's name."""
        return re.sub(r"\bs\b", self.signal, self.written)


@dataclass(frozen=True, eq=False)
class _Tried:
    form: Form
    at: FloatArray
    costs: FloatArray
    weights: FloatArray
    deviations: FloatArray

    @property
    def best(self) -> int:
        return int(np.argmin(self.costs))

    @property
    def is_told(self) -> bool:
        """Whether its second constant lies within the range: at an end it is another form."""
        return not self.form.of or 0 < self.best < self.at.size - 1


def formula(found: Shape, instrument: Instrument) -> Formula | None:
    """Return the best simple formula; None where no one explains the record as well as the curve.

    Each form is fitted in the place of the free function: its second constant by trial, all that is
    linear with it, the model's own values among them. Where no form of the catalogue does, those
    are tried that symbolic regression finds on the curve, where that is installed.
    """
    if len(found.choice.chosen) != 1 or not found.choice.chosen <= set(SIGNALS):
        return None
    (signal,) = found.choice.chosen
    catalogue = [form for form in FORMS if signal in form.signals]
    named = _choose_form(found, instrument, signal, catalogue)
    return named or _choose_form(found, instrument, signal, regress_forms(found, signal))


def _choose_form(
    found: Shape, instrument: Instrument, signal: str, forms: Sequence[Form]
) -> Formula | None:
    """Return the formula of the most probable form that explains as much as the curve."""
    tried = [each for each in _tried(found, instrument, signal, forms) if each.is_told]
    samples = found.gram.samples
    most = min(FITS, ALIKE_FACTOR * found.choice.best.ratio) ** 2 * samples
    good = [each for each in tried if each.costs[each.best] <= most]
    if not good:
        return None
    # Each constant costs as much as the Bayesian criterion asks; the noise is known.
    scores = np.array([_criterion(each, samples) for each in good])
    shares = np.exp(-0.5 * (scores - scores.min()))
    shares /= shares.sum()
    first = int(np.argmax(shares))
    rivals = [each.form.name for n, each in enumerate(good) if n != first]
    best = good[first]
    return Formula(
        best.form.name,
        best.form.text,
        signal,
        _constants(best, signal),
        float(shares[first]),
        tuple(rivals),
    )


def _criterion(tried: _Tried, samples: int) -> float:
    return float(tried.costs[tried.best] + tried.form.constants * np.log(samples))


def _tried(
    found: Shape, instrument: Instrument, signal: str, forms: Sequence[Form]
) -> Iterator[_Tried]:
    if not forms:
        return
    largest = max(float(np.max(np.abs(getattr(path, signal)))) for path in found.paths)
    groups = [g for g in found.groups if g.name in ("straight", "level")]
    groups += [
        Group(form.name, frozenset(), _columns(form, signal, form.values(largest)))
        for form in forms
    ]
    gram = Gram.of(found.fit, instrument, found.paths, groups, tip_response(found.fit))
    beside = [gram.places["straight"], *([gram.places["level"]] * (signal == "indentation"))]
    for form in forms:
        yield _fitted(gram, beside, form, form.values(largest), gram.places[form.name])


def _columns(form: Form, signal: str, values: FloatArray) -> Callable[[Path], FloatArray]:
    def columns(path: Path) -> FloatArray:
        own = getattr(path, signal)
        return np.stack([form.law(own, a) for a in values], axis=1)

    return columns


def _fitted(
    gram: Gram, beside: Sequence[IntArray], form: Form, at: FloatArray, places: IntArray
) -> _Tried:
    """Fit a form at each value of its second constant, beside the model's own values."""
    whole, right = gram.products.sum(axis=0), gram.towards.sum(axis=0)
    square = float(gram.squares.sum() + gram.precision @ gram.departure**2)
    own = np.concatenate([np.arange(gram.own), *beside]).astype(int)
    right = right.copy()
    right[: gram.own] += gram.precision * gram.departure
    costs, weights, deviations = (np.empty(at.size) for _ in range(3))
    for index, place in enumerate(places):
        columns = np.append(own, place)
        matrix = whole[np.ix_(columns, columns)].copy()
        matrix[np.arange(gram.own), np.arange(gram.own)] += gram.precision
        matrix.flat[:: columns.size + 1] += 1e-12
        solution = np.linalg.solve(matrix, right[columns])
        costs[index] = square - right[columns] @ solution
        weights[index] = solution[-1] / gram.scale[place]
        deviations[index] = np.sqrt(abs(np.linalg.inv(matrix)[-1, -1])) / gram.scale[place]
    return _Tried(form, at, costs, weights, deviations)


def _constants(tried: _Tried, signal: str) -> tuple[FormConstant, ...]:
    best = tried.best
    near = tried.costs <= tried.costs[best] + COST_WITHIN_INTERVAL
    low = (tried.weights - SIDE * tried.deviations)[near].min()
    high = (tried.weights + SIDE * tried.deviations)[near].max()
    at, form = tried.at, tried.form
    slope = {"indentation": "N/m", "velocity": "N s/m"}[signal]
    unit = slope if form.name in ("rational", "beyond a depth") else "N"
    if not form.of:
        return (FormConstant("c", unit, float(tried.weights[best]), float(low), float(high)),)
    value, lower, upper = _refined(at, tried.costs)
    strength = float(np.interp(np.log(value), np.log(at), tried.weights))
    return (
        FormConstant("c", unit, strength, min(float(low), strength), max(float(high), strength)),
        FormConstant("a", form.unit(signal), value, lower, upper),
    )


def _refined(at: FloatArray, costs: FloatArray) -> tuple[float, float, float]:
    """Return the least of a parabola through the best three values, and where it costs too much."""
    best = int(np.argmin(costs))
    if best in (0, at.size - 1):
        return float(at[best]), float(at[max(best - 1, 0)]), float(at[min(best + 1, at.size - 1)])
    logs = np.log(at[best - 1 : best + 2])
    bend, slope, _ = np.polyfit(logs - logs[1], costs[best - 1 : best + 2], 2)
    middle = logs[1] - slope / (2.0 * bend)
    wide = float(np.sqrt(COST_WITHIN_INTERVAL / bend))
    return float(np.exp(middle)), float(np.exp(middle - wide)), float(np.exp(middle + wide))
