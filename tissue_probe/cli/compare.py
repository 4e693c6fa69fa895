"""``tissue_probe compare``: measured against predicted force, and where they part."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tissue_probe.cli import diagnosing as asked
from tissue_probe.cli import fit_shown, measured
from tissue_probe.cli.arguments import EffectFiles, picture

if TYPE_CHECKING:
    from tissue_probe.diagnosis.fitting.fit import Fit


def compare(
    files: measured.Measurements,
    position: measured.Position = None,
    force: measured.Force = None,
    time: measured.Time = None,
    sample_rate: measured.SampleRate = None,
    position_unit: measured.PositionUnit = None,
    force_unit: measured.ForceUnit = None,
    time_unit: measured.TimeUnit = None,
    force_polarity: measured.ForcePolarity = None,
    position_polarity: measured.PositionPolarity = measured.Direction.into,
    topic: measured.SamplesTopic = None,
    clock: measured.ClockOption = None,
    site: measured.Site = None,
    lowpass: measured.Lowpass = None,
    starts: measured.StartsOption = measured.Starts.auto,
    rig: asked.Rig = None,
    tissue: asked.TissueOption = None,
    known_rig: asked.KnownRig = False,
    constant: asked.Constants = None,
    model: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Compare this model.yaml, its values held."),
    ] = None,
    effects: EffectFiles = None,
    json: asked.Json = None,
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", metavar="FILE", callback=picture, help="Picture: .png, .svg or .pdf."
        ),
    ] = Path("compare.png"),
) -> None:
    """Compare a model with measurements, and show where it fails.

    The model is fitted first, unless --model names one that was. Errors are of the force, or of the
    position where a force drives; the noise floor is what a right model would leave.
    """
    measured.check_there(files)
    layout = measured.layout(
        position, force, time, sample_rate, position_unit, force_unit, time_unit,
        force_polarity, position_polarity, topic, clock,
    )  # fmt: skip
    begun = asked.begun(model, rig, tissue, effects or [])
    composition = begun.composition
    instrument = asked.instrument(composition.rig, known_rig, constant or [])
    segments = measured.read_measured(files, layout, starts, site, lowpass)
    taken = asked.measurements(segments, composition.output)
    # Only now: what fits takes longer to import than a file takes to be refused.
    from tissue_probe.diagnosis.diagnosis import cleaned
    from tissue_probe.diagnosis.ranking.candidates import fit_base

    if model:
        fit = asked.held(begun, taken)
    else:
        fit = fit_base(composition, cleaned(taken)[0], instrument)
    asked.note_fit(fit, fit)
    _print_errors(fit, model)
    sources = [segment.source for segment in segments]
    _print_failures(fit, sources)
    fit_shown.picture(fit, fit.worst, sources).savefig(output, dpi=100)
    print(f"The picture is in {output}.")
    if json:
        asked.write_answer(json, fit, begun, taken, instrument)


def _print_errors(fit: Fit, model: Path | None) -> None:
    """Print values and errors; what is held, as a model file has it, is held out of nothing."""
    import numpy as np

    output = fit.output
    signal = np.concatenate([m.output_values for m in fit.measurements])
    share = f"{100 * fit.rmse / output.size(signal):.3g} % of the {output.name}'s rms"
    if not output.zeroed:
        share += " about its mean"
    values = f"values held, as in {model}" if model else "values +- 95 % intervals"
    print(f"{fit_shown.title(fit)}, {values}:")
    for name, value, unit in fit_shown.table(fit):
        print(f"  {name:26s} {value} {unit}{fit_shown.AT_LIMIT if name in fit.exhausted else ''}")
    print(f"  error                      {output.tell(fit.rmse, 4)} rms, {share}")
    if not model:
        print(f"  error on held-out blocks   {output.tell(fit.heldout_rmse, 4)} rms")
    print(f"  noise floor                {output.tell(fit.noise, 4)} rms: what noise alone leaves")
    print(f"  error / noise              {fit.rmse / fit.noise:.3g}")
    noisy = any(m.whitening is not None for m in fit.measurements)
    counted = "the noise of the force" if noisy else "known 1/f noise and rounding"
    print(f"  whitened error / noise     {fit.ratio:.3g}, {counted} counted too")
    if not fit.converged:
        print("  the fit did not settle: take its values for a guess")
    if fit.exhausted:
        print(fit_shown.exhaustion([fit]))


def _print_failures(fit: Fit, sources: Sequence[str]) -> None:
    """Print where a model fails, in the measurement that it predicts worst."""
    import numpy as np

    if shown := fit_shown.stretch(fit, fit.worst, sources):
        error = fit.output.tell(fit.error(fit.worst), 4)
        print(f"What follows, and the picture, is of {shown}; the error in it is {error} rms.")
    tests = fit_shown.tests(fit, fit.worst)
    failed = [t for t in tests if not t.passed and np.isfinite(t.statistic)]
    where = fit_shown.where(fit, fit.worst)
    if failed or where.here:
        print("Where it fails, known 1/f noise taken out:")
    for test in failed:
        print(f"- {test.name}: {test.finding}. {test.hint}")
    print(f"Here: {where.here.describe()}" if where.here else "The error stands out nowhere.")
