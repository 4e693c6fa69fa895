"""One fitted model, shown: its name, its values, and where it fails.

Contents: the parts that ``compare``, ``diagnose`` and ``improve`` show alike of one model.
"""

from __future__ import annotations

import html
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

from tissue_probe.analysis.result_table import Column, ResultTable, number, write_mark
from tissue_probe.physics.fitted_model import FittedModel
from tissue_probe.quantities import SIDE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tissue_probe.diagnosis.fitting.fit import Fit
    from tissue_probe.diagnosis.residuals.localise import Localisation
    from tissue_probe.diagnosis.residuals.residual_test import ResidualTest
    from tissue_probe.physics.model_file import Data

#: Where fits fail, by the number of the measurement: pictures and page show it again.
_WHERE: WeakKeyDictionary[Fit, dict[int, Localisation]] = WeakKeyDictionary()
#: Said of a value that the rig's tolerance, or the model, lets go no farther.
AT_LIMIT = ", at its limit"


def title(fit: Fit) -> str:
    """Name a model by its tissue and effects."""
    names = {"kelvin_voigt": "Kelvin-Voigt", "maxwell": "Maxwell"}
    tissue = names.get(fit.composition.tissue, "Kelvin-Voigt")
    return " + ".join([tissue, *fit.composition.names])


def table(fit: Fit) -> list[tuple[str, str, str]]:
    """Return the name of every fitted value, itself with its 95 % interval, and its unit."""
    deviations, values = fit.deviations(), fit.named()
    fitted = [entry for entry in fit.entries if deviations[entry.name] > 0]
    return [
        (e.name, f"{values[e.name]:.5g} +- {SIDE * deviations[e.name]:.2g}", e.unit) for e in fitted
    ]


def lines(fit: Fit) -> list[str]:
    """Return a line a value, with its 95 % interval."""
    return [
        f"  {name:26s} {value} {unit if unit != '1' else ''}".rstrip()
        + (AT_LIMIT if name in fit.exhausted else "")
        for name, value, unit in table(fit)
    ]


def over_noise(fit: Fit) -> str:
    """Say how many times the noise the error is, and where other errors count as noise besides."""
    told = f"{fit.rmse / fit.noise:.2f} times the noise"
    counted = f"{fit.ratio:.2f} times"
    if told.startswith(counted):
        return told
    return f"{told}, {counted} where {fit.counted_too} counts as noise"


def parameters(fit: Fit) -> ResultTable:
    """Return every fitted value with its standard deviation and 95 % interval, in SI units."""
    deviations, values = fit.deviations(), fit.named()
    columns = (
        Column("name", "parameter"),
        Column("value", "value", number(5), right=True),
        Column("deviation", ""),
        Column("low", "from", number(5), right=True),
        Column("high", "to", number(5), right=True),
        Column("unit", "unit"),
        Column("at_limit", "at its limit", write_mark),
    )
    rows = tuple(
        (
            e.name,
            values[e.name],
            deviations[e.name],
            values[e.name] - SIDE * deviations[e.name],
            values[e.name] + SIDE * deviations[e.name],
            e.unit,
            e.name in fit.exhausted,
        )
        for e in fit.entries
        if deviations[e.name] > 0
    )
    return ResultTable("Fitted values, 95 % intervals", columns, rows)


def model_of(fit: Fit, effect_files: Sequence[Path], data: Data | None = None) -> FittedModel:
    """Return a fitted model as a model file holds it."""
    return FittedModel(
        fit.composition, dict(fit.named()), dict(fit.deviations()), data, tuple(effect_files)
    )


def as_html(lines: Sequence[str]) -> str:
    """Return lines of text as paragraphs of HTML."""
    return "".join(f"<p>{html.escape(line)}</p>" for line in lines if line)


def exhaustion(fits: Sequence[Fit]) -> str:
    """Explain values at their limit; empty where none is."""
    from tissue_probe.diagnosis.fitting.problem import FARTHEST

    # A right model may have no mass, and no damping.
    if not any(fit.named()[name] for fit in fits for name in fit.exhausted):
        return ""
    return (
        "At its limit is a value that the samples alone would put beyond: of the rig's constants "
        f"{FARTHEST:g} standard deviations of the tolerance off, of others where the model ends. "
        "If the true value is not there, something is missing in the model, or the instrument "
        "couples to the tissue in another way (`rig`), or the stated tolerance (`constant`) is too "
        "small. The interval holds on the inner side only."
    )


def where(fit: Fit, index: int) -> Localisation:
    """Say where in one of its measurements a model fails; kept as long as the fit is."""
    from tissue_probe.diagnosis.residuals.localise import localise

    kept = _WHERE.setdefault(fit, {})
    if index not in kept:
        shown = fit.measurements[index]
        kept[index] = localise(
            fit.evened[index], shown.position, fit.tip[index], shown.sample_period, shown.noise.own
        )
    return kept[index]


def tests(fit: Fit, index: int) -> tuple[ResidualTest, ...]:
    """Test a model's residual of one of its measurements."""
    from tissue_probe.diagnosis.residuals.all_tests import residual_tests

    shown = fit.measurements[index]
    return residual_tests(
        fit.evened[index], shown.input_values, shown.sample_period, shown.noise.own, fit.output
    )


def stretch(fit: Fit, index: int, sources: Sequence[str]) -> str:
    """Say which of several measurements is shown; empty where there is one only."""
    if len(sources) == 1:
        return ""
    number = f"stretch {index + 1} of {len(sources)}, most of the squared error over noise"
    return f"{Path(sources[index]).name} ({number})"


def picture(fit: Fit, index: int, sources: Sequence[str]) -> Figure:
    """Draw a comparison of one of the measurements with a model's prediction of it."""
    from tissue_probe.figures.compare import draw_comparison

    shown = fit.measurements[index]
    return draw_comparison(
        shown.times,
        shown.output_values,
        fit.predicted[index],
        where(fit, index),
        shown.noise.own,
        fit.output,
        shown.used,
        stretch(fit, index, sources),
    )
