"""The files of a diagnosis: model file, pictures, report.

What belongs here: from a diagnosis to files. What does not: their layout (``report``, ``figures``).
"""

from __future__ import annotations

import datetime
import platform
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path

import sympy as sp
from matplotlib.figure import Figure

from tissue_probe.analysis import fit_shown
from tissue_probe.analysis import verdict_in_words as words
from tissue_probe.analysis.diagnosing import DiagnosisResult
from tissue_probe.analysis.measurements import Measurements, ReadRecording
from tissue_probe.diagnosis.diagnosis import Diagnosis
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.ranking.rules import added
from tissue_probe.figures.compare import Comparison
from tissue_probe.figures.ladder import Rungs, draw_ladder
from tissue_probe.figures.story import Candidate, draw_story
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.fitted_model import FittedModel
from tissue_probe.physics.model_file import Data, DataFile
from tissue_probe.quantities import FORCE
from tissue_probe.report.contents import (
    Report,
    ReportCandidate,
    ReportExcitation,
    ReportParameter,
    ReportSignals,
    ReportSource,
    ReportStep,
)
from tissue_probe.report.page import render

#: Samples of a record that the report carries; a longer one is shown from its beginning.
DRAWN = 8000
UNSETTLED = " The fit did not settle."
#: What the field writes for the symbols that every model has.
LETTERS = {
    "tip_position": "x",
    "tip_velocity": "\\dot{x}",
    "position": "u",
    "position_rate": "\\dot{u}",
    "force": "F",
    "stiffness": "k",
    "damping": "\\beta",
    "tip_mass": "m",
    "load_cell_stiffness": "k_0",
    "load_cell_damping": "\\beta_0",
    "contact_position": "u_0",
    "force_offset": "F_0",
    "time": "t",
}


def write(result: DiagnosisResult, folder: Path) -> None:
    """Write model.yaml, story.png, ladder.png, compare.png and report.html into a folder."""
    ladder = result.found.ladder
    folder.mkdir(parents=True, exist_ok=True)
    kept_model(result).save(folder / "model.yaml")
    draw_ladder(_rungs(result.found)).savefig(folder / "ladder.png", dpi=100)
    story(result).savefig(folder / "story.png", dpi=100)
    drawn = fit_shown.picture(ladder.base, ladder.base.worst, result.sources)
    drawn.savefig(folder / "compare.png", dpi=100)
    write_report(result, folder / "report.html")


def kept_model(result: DiagnosisResult) -> FittedModel:
    """Return the last model of the ladder, with what it was fitted to."""
    final = result.found.ladder.final
    data = Data(
        files=tuple(
            DataFile(name=Path(part.name).name, sha256=part.digest())
            for part in result.fitted.parts
        ),
        date=datetime.date.today(),
        noise=final.noise,
        rmse_training=final.rmse,
        rmse_heldout=result.found.heldout(final),
        converged=final.converged,
    )
    return fit_shown.model_of(final, result.asked.model.effect_files, data)


def write_report(result: DiagnosisResult, path: Path) -> None:
    """Write the report as one page of HTML."""
    page = report(
        result.found,
        result.fitted,
        result.sources,
        result.validated,
        result.wording,
        result.asked.head,
    )
    path.write_text(render(page), encoding="utf-8")


def _rungs(diagnosis: Diagnosis) -> Rungs:
    ladder = diagnosis.ladder
    steps = (ladder.base, *ladder.steps)
    return Rungs(
        [_rung(fit, before) for fit, before in zip(steps, (None, *steps), strict=False)],
        [fit.rmse for fit in steps],
        [diagnosis.heldout(fit) for fit in steps],
        ladder.final.noise,
        ladder.final.output,
    )


def story(result: DiagnosisResult) -> Figure:
    """Draw the diagnosis on one page; of several stretches that which the base predicts worst.

    Effects that were asked for were not chosen among others: there is no ranking.
    """
    diagnosis, sources = result.found, result.sources
    ladder = diagnosis.ladder
    base, shown = ladder.base, ladder.base.worst
    measurement = base.measurements[shown]
    compared = Comparison(
        measurement.times,
        measurement.output_values,
        base.predicted[shown],
        fit_shown.where(base, shown),
        measurement.noise.own,
        base.output,
    )
    ranking = [
        Candidate(
            added(fit).name,
            diagnosis.heldout(fit),
            added(fit).name in diagnosis.effects,
            added(fit).name in diagnosis.indistinguishable,
        )
        for fit in (() if ladder.asked else ladder.ranking)
    ]
    verdict, *_ = words.verdict(diagnosis)[0].split(". ")
    name = fit_shown.stretch(base, shown, sources)
    return draw_story(verdict.rstrip("."), compared, ranking, _rungs(diagnosis), name)


def report(
    diagnosis: Diagnosis,
    fitted: Measurements,
    sources: Sequence[str],
    validated: Measurements,
    wording: Callable[[str], str] = str,
    head: str = "",
) -> Report:
    """Put a diagnosis into a report; of several stretches it shows what the base predicts worst."""
    files = [Path(part.name) for part in fitted.parts]
    ladder = diagnosis.ladder
    base, final = ladder.base, ladder.final
    shown = base.worst
    signals = _signals(base, final, shown, fit_shown.stretch(base, shown, sources) or files[0].name)
    steps = (base, *ladder.steps)
    return Report(
        title=f"What the model misses: {', '.join(path.name for path in files)}",
        verdict=diagnosis.verdict,
        asked=wording(head),
        summary=tuple(words.verdict(diagnosis)),
        noise_floor=final.noise,
        steps=tuple(
            ReportStep(
                _rung(fit, before),
                _reason(diagnosis, fit, before) + ("" if fit.converged else UNSETTLED),
                equations(fit.composition),
                _parameters(fit),
                fit.rmse,
                diagnosis.heldout(fit),
            )
            for fit, before in zip(steps, (None, *steps), strict=False)
        ),
        ranking=tuple(
            ReportCandidate(
                added(fit).name,
                added(fit).family,
                added(fit).physics,
                diagnosis.heldout(fit),
                base.bic - fit.bic,
                _parameters(fit, {entry.name for entry in added(fit).parameters}),
                added(fit).name in diagnosis.indistinguishable,
                fit.converged,
            )
            for fit in ladder.ranking
        ),
        signals=(signals,),
        findings=tuple(wording(finding.sentence) for finding in diagnosis.findings),
        base_tests=fit_shown.tests(base, shown),
        final_tests=fit_shown.tests(final, shown) if final is not base else (),
        excitations=_next(diagnosis, wording),
        sources=(
            *(_source(part, "fitted") for part in fitted.parts),
            *(_source(part, "held out") for part in validated.parts),
        ),
        versions={
            "tissue_probe": version("tissue_probe"),
            "numpy": version("numpy"),
            "python": platform.python_version(),
        },
        created=datetime.datetime.now().astimezone().isoformat(timespec="seconds"),
        seconds=diagnosis.seconds,
        exhaustion=wording(fit_shown.exhaustion(steps)),
        output=base.output,
    )


def _signals(base: Fit, final: Fit, shown: int, name: str) -> ReportSignals:
    measurement, cut = base.measurements[shown], slice(0, DRAWN)
    errors = " to ".join(base.output.tell(fit.error(shown)) for fit in dict.fromkeys((base, final)))
    drawn = ""
    if measurement.times.size > DRAWN:
        drawn = (
            f" (drawn: the first {measurement.times[DRAWN]:.3g} of {measurement.times[-1]:.3g} s)"
        )
    return ReportSignals(
        f"{name}, fitted, error {errors}{drawn}",
        measurement.times[cut],
        measurement.output_values[cut],
        base.predicted[shown][cut],
        final.predicted[shown][cut],
        fit_shown.where(base, shown),
        fit_shown.where(final, shown) if final is not base else None,
    )


def equations(composition: Composition) -> tuple[str, ...]:
    """Return a model's equations in LaTeX: each state's rate, what is measured, and switches."""
    model = composition.model
    lines = [
        f"\\frac{{d}}{{dt}} {_latex(state)} = {_latex(rate)}"
        for state, rate in zip(model.states, model.motion, strict=True)
    ]
    measured = "F" if composition.output is FORCE else "u"
    turns = [
        f"{_latex(each.symbol)}: \\; {turn} \\text{{ as soon as }} {_latex(past)} < 0"
        for each in model.switches
        for turn, past in (("1 \\to 0", each.on), ("0 \\to 1", each.off))
    ]
    return (*lines, f"{measured} = {_latex(model.output)}", *turns)


def _latex(expression: sp.Expr) -> str:
    """Set an expression with the letters of the field, and words where it has none.

    Factors have dots between them: a mere space would not part words from words.
    """
    names = {symbol: LETTERS.get(str(symbol)) or _words(str(symbol))
             for symbol in expression.free_symbols}  # fmt: skip
    return str(sp.latex(expression, symbol_names=names, mul_symbol="dot"))


def _words(name: str) -> str:
    """Set a name such as relaxation_rate_1 upright, its number as an index."""
    stem, _, number = name.rpartition("_")
    if not number.isdigit():
        stem, number = name, ""
    return f"\\text{{{stem.replace('_', ' ')}}}" + (f"_{{{number}}}" if number else "")


def _rung(fit: Fit, before: Fit | None) -> str:
    if before is None:
        return fit_shown.title(fit)
    gained = [name for name in fit.composition.names if name not in before.composition.names]
    lost = [name for name in before.composition.names if name not in fit.composition.names]
    return ", ".join([*(f"+ {name}" for name in gained), *(f"− {name}" for name in lost)])


def _reason(diagnosis: Diagnosis, fit: Fit, before: Fit | None) -> str:
    if before is None:
        return "The model that was asked about."
    fall = 100 * (1 - diagnosis.heldout(fit) / diagnosis.heldout(before))
    return f"The held-out error falls by {fall:.3g} %."


def _parameters(fit: Fit, only: set[str] | None = None) -> tuple[ReportParameter, ...]:
    values, deviations = fit.named(), fit.deviations()
    return tuple(
        ReportParameter(
            entry.name,
            _latex(sp.Symbol(entry.name)),
            values[entry.name],
            values[entry.name] - 1.96 * deviations[entry.name],
            values[entry.name] + 1.96 * deviations[entry.name],
            "" if entry.unit == "1" else entry.unit,
            entry.name in fit.exhausted,
        )
        for entry in fit.entries
        if deviations[entry.name] > 0 and (only is None or entry.name in only)
    )


def _next(diagnosis: Diagnosis, wording: Callable[[str], str]) -> tuple[ReportExcitation, ...]:
    suggestion = diagnosis.suggestion
    if suggestion is None:
        return ()
    if not suggestion.excitation:
        return (ReportExcitation(suggestion.calibration),)
    apart = f"It would tell {', '.join(diagnosis.indistinguishable)} apart."
    shown = f"It would show {', '.join(suggestion.shows)} if there."
    command = diagnosis.command
    found = [
        ReportExcitation(
            shown if suggestion.shows else apart,
            command.line if command else "",
            words.settings(suggestion),
            tuple(map(wording, command.notes)) if command else (),
        )
    ]
    if suggestion.calibration:
        found.append(ReportExcitation(suggestion.calibration))
    return tuple(found)


def _source(part: ReadRecording, role: str) -> ReportSource:
    return ReportSource(Path(part.name).name, role, part.digest()[:16])
