"""``tissue_probe compare``: measured against predicted force, and where they part."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from tissue_probe.cli import diagnosing as asked
from tissue_probe.cli import measured


def compare(
    files: measured.Measurements,
    position: measured.Position = None,
    force: measured.Force = None,
    time: measured.Time = None,
    sample_rate: measured.SampleRate = None,
    position_unit: measured.PositionUnit = None,
    force_unit: measured.ForceUnit = None,
    force_polarity: measured.ForcePolarity = None,
    position_polarity: measured.PositionPolarity = measured.Direction.into,
    topic: measured.SamplesTopic = None,
    site: measured.Site = None,
    lowpass: measured.Lowpass = None,
    starts: measured.StartsOption = measured.Starts.auto,
    rig: asked.Rig = asked.RigName.compliant_probe,
    tissue: asked.TissueOption = asked.TissueName.kelvin_voigt,
    known_rig: asked.KnownRig = False,
    constant: asked.Constants = None,
    model: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Compare this model.yaml, its values held."),
    ] = None,
    json: asked.Json = None,
    output: Annotated[
        Path,
        typer.Option("--output", "-o", metavar="FILE", help="Picture: .png, .svg or .pdf."),
    ] = Path("compare.png"),
) -> None:
    """Compare a model with measurements, and show where it fails.

    The model is fitted first, unless --model names one that was. Errors are in newtons and as a
    share of the force's rms; the noise floor is what a right model would leave.
    """
    from tissue_probe.diagnosis.candidates import fit_base
    from tissue_probe.diagnosis.localise import localise
    from tissue_probe.diagnosis.residuals import residual_tests
    from tissue_probe.figures.compare import draw_comparison

    layout = measured.layout(
        position, force, time, sample_rate, position_unit, force_unit, force_polarity,
        position_polarity, topic,
    )  # fmt: skip
    taken = asked.measurements(measured.read_measured(files, layout, starts, site, lowpass))
    instrument = asked.instrument(rig, known_rig, constant or [])
    if model:
        fit = asked.held(model, taken)
    else:
        fit = fit_base(asked.composition(rig, tissue), taken, instrument)
    first, residual = fit.measurements[0], fit.residuals[0]
    _print_errors(fit)
    tests = residual_tests(residual, first.position, first.sample_period, first.noise)
    for test in tests:
        if not test.passed and np.isfinite(test.statistic):
            print(f"- {test.name}: {test.finding}. {test.hint}")
    predicted = fit.predicted[0]
    stiffness = fit.named().get("load_cell_stiffness", np.inf)
    tip = first.position - predicted / stiffness
    where = localise(residual, first.position, tip, first.sample_period, first.noise)
    print(f"Here: {where.here.describe()}" if where.here else "The error stands out nowhere.")
    draw_comparison(first.times, first.force, predicted, where, first.noise).savefig(
        output, dpi=100
    )
    print(f"The picture is in {output}.")
    if json:
        asked.write_answer(json, fit.composition, taken, instrument)


def _print_errors(fit) -> None:
    measured_rms = float(np.sqrt(np.mean(np.concatenate([m.force for m in fit.measurements]) ** 2)))
    print(f"{asked.title(fit)}:")
    for name, value in asked.table(fit):
        print(f"  {name:26s} {value}")
    print(f"  error                      {1e3 * fit.rmse:.4g} mN rms, "
          f"{100 * fit.rmse / measured_rms:.3g} % of the force's rms")  # fmt: skip
    print(f"  error on held-out blocks   {1e3 * fit.heldout_rmse:.4g} mN rms")
    print(f"  noise floor                {1e3 * fit.noise:.4g} mN rms: what noise alone leaves")
    print(f"  error / noise              {fit.ratio:.3g}")
    if not fit.converged:
        print("  the fit did not settle: take its values for a guess")
