"""A learnt shape as an effect of the user's own: a Python file that a user may read and change.

Contents: the text of that file, of a formula or of tables.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, cast

import numpy as np
from scipy.optimize import nnls

from tissue_probe.diagnosis.shape.free_functions import TURNS, in_order
from tissue_probe.diagnosis.shape.shape import Shape
from tissue_probe.diagnosis.shape.splines import Spline
from tissue_probe.errors import MeasurementError
from tissue_probe.signals import FloatArray

if TYPE_CHECKING:
    from tissue_probe.diagnosis.shape.formula import Formula
    from tissue_probe.diagnosis.shape.shape_report import FoundShape

#: The effect's name.
NAME = "free_form"
#: What a surface's products may leave along the record, over the noise: its square adds to that of
#: the noise, half a per cent of its size.
ROUGH = 0.1
#: Share of a relaxation's size that its branches may leave, rms.
FEW = 0.03
#: Exponent of the law by which a spring slides: it turns within a tenth of its way.
SHARP = 8


@dataclass
class _Text:
    """The parts of the file: lines before the effect, terms of its force, lines of its states."""

    terms: list[str] = field(default_factory=list)
    before: list[str] = field(default_factory=list)
    states: list[str] = field(default_factory=list)

    def table(self, signal: str, name: str, at: FloatArray, values: FloatArray, unit: str) -> None:
        """Add a function that is given by a table."""
        self.before += [f"#: {name}: at these points, and the values there [{unit}]."]
        self.before += [f"{name}_AT = {_numbers(at)}", f"{name}_VALUES = {_numbers(values)}"]
        self.terms.append(f"tabulated({signal}, {name}_AT, {name}_VALUES)")


def effect_text(found: FoundShape) -> str:
    """Return the file of the effect.

    Raises
    ------
    MeasurementError
        If no shape is claimed, or the motion cannot tell it from another.
    """
    text = write_effect(found.learnt, found.formula) if found.accepted and found.told else None
    if text is None:
        raise MeasurementError(
            "no shape of the missing force is claimed, so that no effect can be made of it: record "
            "another motion, such as a multisine, or give `add` the name of an effect"
        )
    return text


def write_effect(learnt: Shape, formula: Formula | None = None) -> str | None:
    """Return the file of a formula, or of tables; None for variables that no effect is made of."""
    if formula is not None:
        return _of_formula(formula)
    variables = in_order(learnt.choice.chosen)
    write = _WRITERS.get(variables)
    if write is None:
        return None
    text = _Text()
    write(learnt, text)
    return _FILE.format(
        imports="from tissue_probe.physics.tabulated import tabulated\n",
        about=f"a function of {' and '.join(variables)}",
        before="\n".join(text.before),
        parameters='    parameters=(Parameter(STRENGTH, "1", default=1.0, lower=0.0, upper=4.0),),',
        force="STRENGTH * (\n        " + "\n        + ".join(text.terms) + "\n    )",
        states="".join(f"\n        {each}," for each in text.states),
        assumptions="Learnt from one record: no law; straight beyond the range that was visited",
    )


_FILE = '''"""A force that no law of the library explains: {about}, learnt from a record.

Name this file among the effects of your own, and add ``free_form``.
"""

import sympy as sp

from tissue_probe.physics.effects.effect import (
    INDENTATION,
    TIP_VELOCITY,
    Effect,
    Parameter,
    State,
)
{imports}
STRENGTH = sp.Symbol("free_form_strength", real=True)
{before}

FREE_FORM = Effect(
    name="free_form",
    family="free form",
    physics="A force of a shape that was learnt: {about}",
{parameters}
    force={force},
    states=({states}),
    assumptions="{assumptions}",
)
'''


def _of_formula(formula: Formula) -> str:
    """Return the file of a formula: its constants are the effect's parameters."""
    symbol = {"indentation": "INDENTATION", "velocity": "TIP_VELOCITY"}[formula.signal]
    words = {"abs": "Abs", "max": "Max"}
    written = re.sub(
        r"\b([a-z]+)\(", lambda word: f"sp.{words.get(word[1], word[1])}(", formula.written
    )
    # A power's slope by its exponent has no value at 0.
    written = re.sub(r"sp\.Abs\((s / [0-9.]+)\)\*\*", r"sp.Max(sp.Abs(\1), 1e-9)**", written)
    by = {"s": symbol, "c": "STRENGTH", "a": "SHAPE"}
    written = "".join(by.get(each, each) for each in _tokens(written))
    strength, *rest = formula.constants
    size = abs(strength.value) or 1.0
    lines = [f'Parameter(STRENGTH, "{strength.unit}", default={strength.value:.6g}, '
             f"lower={-100.0 * size:.6g}, upper={100.0 * size:.6g}),"]  # fmt: skip
    before = []
    for each in rest:
        before = ['SHAPE = sp.Symbol("free_form_shape", positive=True)']
        lines.append(
            f'Parameter(SHAPE, "{each.unit}", default={each.value:.6g}, '
            f"lower={0.1 * each.value:.6g}, upper={10.0 * each.value:.6g}),"
        )
    return _FILE.format(
        imports="",
        about=formula.text,
        before="\n".join(before),
        parameters="    parameters=(\n        " + "\n        ".join(lines) + "\n    ),",
        force=written,
        states="",
        assumptions="A formula that explains one record: no law; others may explain it as well",
    )


def _tokens(text: str) -> list[str]:
    return re.findall(r"[A-Za-z_.]+|[^A-Za-z_.]", text)


def _weights(found: Shape, name: str) -> FloatArray:
    best, places = found.choice.best, found.gram.places[name]
    own = [int(np.flatnonzero(best.columns == place)[0]) for place in places]
    return np.asarray(best.weights[own])


def _numbers(values: Sequence[float] | FloatArray) -> str:
    return "(" + ", ".join(f"{each:.8g}" for each in values) + ",)"


def _depth(found: Shape, text: _Text) -> None:
    spline = found.functions.depth
    values = spline.at_knots(_weights(found, "depth")) + _weights(found, "level")[0]
    text.table("INDENTATION", "DEPTH", spline.knots, values, "N")


def _speed(found: Shape, text: _Text) -> None:
    spline, functions = found.functions.speed, found.functions
    weights = _weights(found, "speed")
    values = spline.at_knots(weights) - float(spline.columns(np.zeros(1))[0] @ weights)
    text.table("TIP_VELOCITY", "SPEED", spline.knots, values, "N")
    *turns, size = _weights(found, "turns")
    for share, weight in zip(TURNS, turns, strict=True):
        text.terms.append(f"{weight:.8g} * sp.tanh(TIP_VELOCITY / {share * functions.fastest:.8g})")
    text.terms.append(f"{size / functions.fastest:.8g} * sp.Abs(TIP_VELOCITY)")


def _both(found: Shape, text: _Text) -> None:
    """Write sums of each variable's functions, and few products that stand for the surface."""
    _depth(found, text)
    _speed(found, text)
    functions = found.functions
    depth, speed = functions.few_depth, functions.few_speed
    table = _weights(found, "speed by depth").reshape(depth.count + 1, speed.count + 3)
    for number, (of_depth, of_speed) in enumerate(_products(found, table)):
        own = _Text()
        forces = _of_straight(depth, of_depth)
        shares = _of_straight(speed, of_speed[: speed.count + 1], functions.fastest)
        own.table("INDENTATION", f"DEPTH_{number}", depth.knots, forces, "N")
        own.table("TIP_VELOCITY", f"SPEED_{number}", speed.knots, shares, "1")
        text.before += own.before
        turns, size = of_speed[-2:]
        fast = f"{own.terms[1]} + {turns:.8g} * sp.tanh(TIP_VELOCITY / "
        fast += f"{functions.fastest * TURNS[1]:.8g})"
        fast += f" + {size / functions.fastest:.8g} * sp.Abs(TIP_VELOCITY)"
        text.terms.append(f"{own.terms[0]} * ({fast})")


def _products(found: Shape, table: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
    """Return weights of depths and of speeds, few pairs whose products sum to a table of them.

    Each takes the most of the force where the record was, and so many are taken that the others
    are far below the noise.
    """
    depths: FloatArray = np.concatenate([found.functions.depths(path) for path in found.paths])
    speeds: FloatArray = np.concatenate([found.functions.speeds(path) for path in found.paths])
    noise = min(path.measurement.noise.own for path in found.paths)
    # Numpy's types have the answer of another mode.
    of_depth, of_speed = (
        cast(FloatArray, np.linalg.qr(each, mode="r")) for each in (depths, speeds)
    )
    left, sizes, right = np.linalg.svd(of_depth @ table @ of_speed.T, full_matrices=False)
    left, right = np.linalg.solve(of_depth, left) * sizes, np.linalg.solve(of_speed, right.T)
    products = depths @ left * (speeds @ right)
    # What is left without the products from each one on.
    rest = np.sqrt(np.mean(np.cumsum(products[:, ::-1], axis=1)[:, ::-1] ** 2, axis=0))
    return [(left[:, n], right[:, n]) for n in np.flatnonzero(rest > ROUGH * noise)]


def _of_straight(spline: Spline, weights: FloatArray, fastest: float = 0.0) -> FloatArray:
    """Return values at knots of a straight function and bent ones: of speeds zero at rest."""
    straight, *bent = weights
    values = spline.at_knots(np.array(bent)) + straight * spline.knots / (
        fastest or float(np.ptp(spline.knots))
    )
    if fastest:
        values = values - float(spline.columns(np.zeros(1))[0] @ bent)
    return np.asarray(values)


def _past(found: Shape, text: _Text) -> None:
    """Write the few branches that relax as the learnt function does."""
    rates, weights = found.functions.rates, _weights(found, "relaxation")
    times = np.geomspace(0.1 / rates[-1], 1.0 / rates[0], 200)
    left = np.exp(-np.multiply.outer(times, rates))
    wanted = left @ weights
    finer = np.geomspace(rates[0], rates[-1], 4 * rates.size)
    own = np.exp(-np.multiply.outer(times, finer))
    both = np.concatenate([own, -own[:, [0, -1]]], axis=1)
    found_weights, rest = nnls(both, wanted)
    if rest > FEW * float(np.linalg.norm(wanted)):
        finer, found_weights = rates, weights
    for number, (rate, weight) in enumerate(_joined(finer, found_weights[: finer.size])):
        _branch(text, number, f"TIP_VELOCITY - {rate:.8g} * BRANCH_{number}", f"{weight:.8g} * ")


def _joined(rates: FloatArray, weights: FloatArray) -> list[tuple[float, float]]:
    """Join branches of neighbouring rates into one."""
    found: list[tuple[float, float]] = []
    last = -2
    for index in np.flatnonzero(weights):
        rate, weight = float(rates[index]), float(weights[index])
        if index == last + 1 and found and found[-1][1] * weight > 0.0:
            before, other = found.pop()
            whole = other + weight
            middle = (other * np.log(before) + weight * np.log(rate)) / whole
            rate, weight = float(np.exp(middle)), whole
        found.append((rate, weight))
        last = int(index)
    return found


def _branch(text: _Text, number: int, motion: str, factor: str = "") -> None:
    text.before.append(f'BRANCH_{number} = sp.Symbol("free_form_branch_{number}", real=True)')
    text.terms.append(f"{factor}BRANCH_{number}")
    text.states.append(f'State(BRANCH_{number}, {motion}, spread="branch")')


def _path(found: Shape, text: _Text) -> None:
    """Write springs that slide, each a state."""
    ways, weights = found.functions.ways, _weights(found, "slides")
    large = np.abs(weights) > FEW * np.max(np.abs(weights))
    for number, (way, weight) in enumerate(zip(ways[large], weights[large], strict=True)):
        name = f"BRANCH_{number}"
        share = f"sp.Abs({name} / {way:.8g}) ** {SHARP}"
        slides = f"{share} * (1 + sp.sign(TIP_VELOCITY) * sp.sign({name})) / 2"
        _branch(text, number, f"TIP_VELOCITY * (1 - {slides})", f"{weight / way:.8g} * ")


def _relaxing_function(found: Shape, text: _Text) -> None:
    """Write a spring, branches, and branches whose springs are curved."""
    _depth(found, text)
    _past(found, text)
    spline, rates = found.functions.few_depth, found.functions.few_rates
    weights = _weights(found, "relaxation of a function").reshape(rates.size, spline.count)
    first = len(text.states)
    for number, (rate, own) in enumerate(zip(rates, weights, strict=True), start=first):
        text.before += [
            f"BENT_{number} = tabulated(\n    INDENTATION,\n    {_numbers(spline.knots)},\n"
            f"    {_numbers(spline.at_knots(own))},\n).diff(INDENTATION)"
        ]
        _branch(text, number, f"BENT_{number} * TIP_VELOCITY - {rate:.8g} * BRANCH_{number}")


_WRITERS: dict[tuple[str, ...], Callable[[Shape, _Text], None]] = {
    ("indentation",): _depth,
    ("velocity",): _speed,
    ("indentation", "velocity"): _both,
    ("past",): _past,
    ("path",): _path,
    ("indentation", "past"): _relaxing_function,
}
