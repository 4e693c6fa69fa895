"""The files of a diagnosis: model file, pictures, report.

Contents: from a diagnosis to files.
"""

from __future__ import annotations

import datetime
import platform
from collections.abc import Callable, Mapping
from importlib.metadata import version
from pathlib import Path
from shlex import quote

import numpy as np
import sympy as sp
from matplotlib.figure import Figure

from tissue_probe.analysis import fit_shown
from tissue_probe.analysis import verdict_in_words as words
from tissue_probe.analysis.as_options import as_options
from tissue_probe.analysis.diagnosing import FREE_FORM, DiagnosisResult
from tissue_probe.analysis.measurements import ReadRecording
from tissue_probe.analysis.symbols import latex, letter
from tissue_probe.diagnosis.answer import correlations, values
from tissue_probe.diagnosis.diagnosis import Diagnosis
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.ranking.rules import find_added_effect
from tissue_probe.figures.compare import Comparison
from tissue_probe.figures.ladder import Rungs, draw_ladder
from tissue_probe.figures.shape import draw_shape
from tissue_probe.figures.story import TriedEffect, draw_story
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.fitted_model import FittedModel
from tissue_probe.physics.model_file import Data, DataFile
from tissue_probe.quantities import FORCE, SIDE, engineering
from tissue_probe.report.contents import (
    Report,
    ReportCandidate,
    ReportExcitation,
    ReportParameter,
    ReportRig,
    ReportShape,
    ReportSignals,
    ReportSource,
    ReportStep,
    ReportSymbol,
)
from tissue_probe.report.page import render

#: Samples of a record that the report carries; a longer one is shown from its beginning.
REPORT_SAMPLES = 8000
#: Pairs of values that are told, whose errors go together most.
PAIRS_TOLD = 6
#: Signals that stand in equations, and their units.
SIGNAL_UNITS = {
    "position": "m", "position_rate": "m/s", "position_acceleration": "m/s^2", "force": "N",
    "tip_position": "m", "tip_velocity": "m/s", "indentation": "m", "time": "s",
}  # fmt: skip
NOT_SETTLED = " The fit did not settle."


def write(result: DiagnosisResult, folder: Path) -> None:
    """Write model.yaml, story.png, ladder.png, compare.png and report.html into a folder."""
    ladder = result.found.ladder
    folder.mkdir(parents=True, exist_ok=True)
    make_kept_model(result).save(folder / "model.yaml")
    draw_ladder(_rungs(result.found)).savefig(folder / "ladder.png", dpi=100)
    story(result).savefig(folder / "story.png", dpi=100)
    drawn = fit_shown.picture(ladder.base, ladder.base.worst, result.sources)
    drawn.savefig(folder / "compare.png", dpi=100)
    write_report(result, folder / "report.html")
    write_shape(result, folder)


def write_shape(result: DiagnosisResult, folder: Path) -> None:
    """Write shape.png, the curve or surface of a missing force, if one is claimed.

    A picture that an earlier run left is taken away, but that of the effect that the model has.
    """
    found = result.found.shape
    if found is not None and found.curve is not None:
        draw_shape(found.curve).savefig(folder / "shape.png", dpi=100)
    elif FREE_FORM not in result.found.ladder.final.composition.names:
        (folder / "shape.png").unlink(missing_ok=True)


def make_kept_model(result: DiagnosisResult) -> FittedModel:
    """Return the last model of the ladder, with the recordings that it was fitted to."""
    final = result.found.ladder.final
    ways = [each.position for each in final.measurements]
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
        lowest=min(float(way.min()) for way in ways),
        highest=max(float(way.max()) for way in ways),
        fastest=max(each.extent.speed for each in final.measurements),
    )
    return fit_shown.model_of(final, result.asked.model.effect_files, data)


def write_report(result: DiagnosisResult, path: Path) -> None:
    """Write the report as one page of HTML."""
    path.write_text(render(report(result)), encoding="utf-8")


def _rungs(diagnosis: Diagnosis) -> Rungs:
    ladder = diagnosis.ladder
    steps = (ladder.base, *ladder.steps)
    return Rungs(
        [_write_rung(fit, before) for fit, before in zip(steps, (None, *steps), strict=False)],
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
        TriedEffect(
            find_added_effect(fit).name,
            diagnosis.heldout(fit),
            find_added_effect(fit).name in diagnosis.effects,
            find_added_effect(fit).name in diagnosis.indistinguishable,
        )
        for fit in (() if ladder.asked else ladder.ranking)
        if fit.converged or find_added_effect(fit).name in diagnosis.effects
    ]
    verdict, *_ = words.verdict(diagnosis)[0].split(". ")
    name = fit_shown.stretch(base, shown, sources)
    return draw_story(verdict.rstrip("."), compared, ranking, _rungs(diagnosis), name)


def report(result: DiagnosisResult) -> Report:
    """Put a diagnosis into a report, which shows the part that the base predicts worst."""
    diagnosis, wording, sources = result.found, result.wording, result.sources
    fitted, validated = result.fitted, result.validated
    rig = result.asked.composition.rig
    files = [Path(part.name) for part in fitted.parts]
    ladder = diagnosis.ladder
    base, final = ladder.base, ladder.final
    shown = base.worst
    signals = _signals(base, final, shown, fit_shown.stretch(base, shown, sources) or files[0].name)
    steps = (base, *ladder.steps)
    return Report(
        title=f"Missing effects: {', '.join(path.name for path in files)}",
        verdict=diagnosis.verdict,
        asked=wording(result.asked.head),
        rig=ReportRig(rig.name, f"{rig.summary}; {rig.whose}", rig.drawing),
        command=command(result),
        symbols=symbols(final.composition, {entry.name: entry.unit for entry in final.entries}),
        correlations=_correlations(final),
        summary=tuple(words.verdict(diagnosis)),
        noise_floor=final.noise,
        steps=tuple(
            ReportStep(
                _write_rung(fit, before),
                _reason(diagnosis, fit, before) + ("" if fit.converged else NOT_SETTLED),
                equations(fit.composition),
                _parameters(fit),
                fit.rmse,
                diagnosis.heldout(fit),
            )
            for fit, before in zip(steps, (None, *steps), strict=False)
        ),
        ranking=tuple(
            ReportCandidate(
                find_added_effect(fit).name,
                find_added_effect(fit).family,
                find_added_effect(fit).physics,
                diagnosis.heldout(fit),
                base.bic - fit.bic,
                _parameters(fit, {entry.name for entry in find_added_effect(fit).parameters}),
                find_added_effect(fit).name in diagnosis.indistinguishable,
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
            *(_source(part, "second recording") for part in validated.parts),
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
        shape=_shape(result),
    )


def _shape(result: DiagnosisResult) -> ReportShape | None:
    found, picture = result.found.shape, result.draw_shape()
    if found is None or picture is None or found.as_effect is None:
        return None
    return ReportShape(picture, found.fit.heldout_rmse, found.as_effect.fit.heldout_rmse)


def _signals(base: Fit, final: Fit, shown: int, name: str) -> ReportSignals:
    measurement, cut = base.measurements[shown], slice(0, REPORT_SAMPLES)
    errors = " to ".join(base.output.tell(fit.error(shown)) for fit in dict.fromkeys((base, final)))
    drawn = ""
    if measurement.times.size > REPORT_SAMPLES:
        first, whole = measurement.times[REPORT_SAMPLES], measurement.times[-1]
        drawn = f" (drawn: the first {first:.3g} of {whole:.3g} s)"
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
    """Return a model's equations in LaTeX: each state's rate, the outputs, and switches."""
    model = composition.model
    lines = [
        f"\\frac{{d}}{{dt}} {latex(state)} = {latex(rate)}"
        for state, rate in zip(model.states, model.motion, strict=True)
    ]
    measured = "F" if composition.output is FORCE else "u"
    turns = [
        f"{latex(each.symbol)}: \\; {turn} \\text{{ as soon as }} {latex(past)} < 0"
        for each in model.switches
        for turn, past in (("1 \\to 0", each.on), ("0 \\to 1", each.off))
    ]
    return (*lines, f"{measured} = {latex(model.output)}", *turns)


def symbols(composition: Composition, units: Mapping[str, str]) -> tuple[ReportSymbol, ...]:
    """Return the symbols of a model's equations, the signals first."""
    model = composition.model
    expressions = [*model.motion, model.output, *(each.on for each in model.switches)]
    used = {str(symbol) for each in expressions for symbol in sp.sympify(each).free_symbols}
    used |= {str(state) for state in model.states}
    signals = [name for name in SIGNAL_UNITS if name in used]
    values = [name for name in units if name in used]
    rest = sorted(used.difference(signals, values))
    return tuple(
        ReportSymbol(
            letter(name), name.replace("_", " "), SIGNAL_UNITS.get(name) or units.get(name, "")
        )
        for name in (*signals, *values, *rest)
    )


def _correlations(fit: Fit) -> tuple[tuple[str, str, float], ...]:
    """Return the pairs of values whose errors go together most."""
    named, rows = values(fit), correlations(fit)
    pairs = [
        (letter(named[i].name), letter(named[j].name), together)
        for i in range(len(named))
        for j in range(i)
        if (together := rows[i][j]) is not None
    ]
    return tuple(sorted(pairs, key=lambda pair: -abs(pair[2]))[:PAIRS_TOLD])


def command(result: DiagnosisResult) -> str:
    """Return the command line that repeats a diagnosis."""
    stated = {**result.asked.stated, "add": result.found.ladder.asked and result.effects}
    words = ["tissue_probe improve", *(quote(part.name) for part in result.fitted.parts)]
    layouts = {pair: None for part in result.fitted.parts for pair in part.layout}
    words += [option for name, value in layouts for option in as_options({name: value})]
    words += as_options({**stated, "validate": [part.name for part in result.validated.parts]})
    return " ".join(words)


def _write_rung(fit: Fit, before: Fit | None) -> str:
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
            latex(sp.Symbol(entry.name)),
            values[entry.name],
            values[entry.name] - SIDE * deviations[entry.name],
            values[entry.name] + SIDE * deviations[entry.name],
            "" if entry.unit == "1" else entry.unit,
            entry.name in fit.exhausted,
            entry.default,
            entry.lower,
            entry.upper,
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
            words.settings(suggestion, diagnosis.ladder.final.composition.rig),
            tuple(map(wording, command.notes)) if command else (),
        )
    ]
    if suggestion.calibration:
        found.append(ReportExcitation(suggestion.calibration))
    return tuple(found)


def _source(part: ReadRecording, role: str) -> ReportSource:
    recording = part.recording
    period = recording.blocks[0].sample_period if recording.blocks else float("nan")
    travel, felt = (float(np.ptp(each[np.isfinite(each)])) if len(each) else float("nan")
                    for each in (recording.position, recording.force))  # fmt: skip
    return ReportSource(
        name=Path(part.name).name,
        role=role,
        description=" ".join(part.notes),
        digest=part.digest()[:16],
        facts=(
            f"{len(recording)} samples at {1.0 / period:.4g} Hz",
            f"{period * len(recording):.4g} s",
            f"travel {engineering(travel, 'm')}",
            f"force {engineering(felt, 'N')} from least to most",
            "forces positive in compression, positions into the tissue, after reading",
        ),
    )
