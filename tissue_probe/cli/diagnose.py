"""``tissue_probe diagnose``: which physical effect a model misses."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table

from tissue_probe.cli import diagnosing as asked
from tissue_probe.cli import measured

SHOWN = 8
#: What the mark before a name means.
UNSETTLED = (
    "* gave up or did not settle: the search came not near the best, or ran out of steps; the "
    "numbers are a guess, no result."
)


def diagnose(
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
    rig: asked.Rig = None,
    tissue: asked.TissueOption = None,
    model: asked.ModelOption = None,
    known_rig: asked.KnownRig = False,
    constant: asked.Constants = None,
    effects: asked.EffectFiles = None,
    validate: asked.Validate = None,
    json: asked.Json = None,
) -> None:
    """Say which physical effect a model misses, if any can be told.

    Every effect of the library is added to the model, fitted, and judged by what it does to the
    error on data it was not fitted to. Further effects follow while the error falls.
    """
    from tissue_probe.diagnosis.answer import answer

    layout = measured.layout(
        position, force, time, sample_rate, position_unit, force_unit, force_polarity,
        position_polarity, topic,
    )  # fmt: skip
    begun = asked.begun(model, rig, tissue, effects or [])
    diagnosis = asked.diagnosis(
        measured.read_measured(files, layout, starts, site, lowpass),
        measured.read_measured(validate or [], layout, starts, site, lowpass),
        begun,
        asked.instrument(begun.composition.rig, known_rig, constant or []),
    )
    told = answer(diagnosis)
    table = Table(title="The model with one effect more, the best first", title_justify="left")
    base = diagnosis.ladder.base
    small, per_small = base.output.small, base.output.per_small
    for name in ("effect", "family", f"error [{small}]", f"held out [{small}]", "BIC gain"):
        table.add_column(name, justify="left" if name in ("effect", "family") else "right")
    errors = [f"{per_small * e:.4g}" for e in (base.rmse, diagnosis.heldout(base))]
    table.add_row(_marked("none", base.converged), "", *errors, "")
    shown = told.ranking[:SHOWN]
    for each in shown:
        errors = [
            "" if e is None else f"{per_small * e:.4g}" for e in (each.rmse, each.heldout_rmse)
        ]
        gain = "" if each.gain is None else f"{each.gain:.0f}"
        table.add_row(_marked(each.effect, each.converged), each.family, *errors, gain)
    Console(markup=False, highlight=False).print(table)  # units stand in square brackets
    if not (base.converged and all(each.converged for each in shown)):
        print(UNSETTLED)
    asked.tell(diagnosis)
    if json:
        json.write_text(told.model_dump_json(indent=2) + "\n", encoding="utf-8")


def _marked(name: str, settled: bool) -> str:
    """Return a name with a mark before it, which no narrow window cuts off."""
    return name if settled else f"* {name}"
