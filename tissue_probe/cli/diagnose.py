"""``tissue_probe diagnose``: which physical effect a model misses."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table

from tissue_probe.cli import diagnosing as asked
from tissue_probe.cli import measured
from tissue_probe.cli import verdict_in_words as words
from tissue_probe.cli.arguments import EffectFiles

if TYPE_CHECKING:
    from tissue_probe.diagnosis.answer import Answer
    from tissue_probe.diagnosis.diagnosis import Diagnosis

SHOWN = 8
NAME = 30  # characters of an effect with its mark up to which it stays on one line
#: What the mark before a name means.
UNSETTLED = (
    "* gave up or did not settle: the search would not come near the best, or near what counts, "
    "or ran out of steps; the numbers are a guess, no result."
)


def diagnose(
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
    model: asked.ModelOption = None,
    known_rig: asked.KnownRig = False,
    constant: asked.Constants = None,
    effects: EffectFiles = None,
    validate: asked.Validate = None,
    json: asked.Json = None,
) -> None:
    """Say which physical effect a model misses, if any can be told.

    Every effect of the library is added to the model and fitted. They are ranked by the Bayesian
    information criterion, which counts parameters, and known 1/f noise as such; beside it stands
    the error on data they were not fitted to. Further effects follow while the error falls.
    """
    from tissue_probe.diagnosis.answer import answer

    layout = measured.layout(
        position, force, time, sample_rate, position_unit, force_unit, time_unit,
        force_polarity, position_polarity, topic, clock,
    )  # fmt: skip
    asked.check_validation(files, validate or [])
    begun = asked.begun(model, rig, tissue, effects or [])
    diagnosis = asked.diagnosis(
        measured.read_measured(files, layout, starts, site, lowpass),
        measured.read_measured(validate or [], layout, starts, site, lowpass),
        begun,
        asked.instrument(begun.composition.rig, known_rig, constant or []),
    )
    told = answer(diagnosis)
    # Units stand in square brackets.
    Console(markup=False, highlight=False).print(ranked(diagnosis, told))
    shown = told.ranking[:SHOWN]
    if not (diagnosis.ladder.base.converged and all(each.converged for each in shown)):
        print(UNSETTLED)
    words.tell(diagnosis)
    if json:
        asked.write_json(json, told)


def ranked(diagnosis: Diagnosis, told: Answer) -> Table:
    """Return the base model's errors, and those with each of the best effects."""
    base, shown = diagnosis.ladder.base, told.ranking[:SHOWN]
    small, per_small = base.output.small, base.output.per_small
    errors = [f"{per_small * e:.4g}" for e in (base.rmse, diagnosis.heldout(base))]
    rows = [(_marked("none", base.converged), "", *errors, "")]
    for each in shown:
        errors = [
            "" if e is None else f"{per_small * e:.4g}" for e in (each.rmse, each.heldout_rmse)
        ]
        gain = "" if each.gain is None else f"{each.gain:.0f}"
        rows.append((_marked(each.effect, each.converged), each.family, *errors, gain))
    table = Table(title="With one effect more, the best by the BIC first", title_justify="left")
    # A name that breaks behind its mark looks like two.
    table.add_column("effect", no_wrap=max(len(row[0]) for row in rows) <= NAME)
    table.add_column("family")
    for name in (f"error [{small}]", f"held out [{small}]", "BIC gain"):
        table.add_column(name, justify="right")
    for row in rows:
        table.add_row(*row)
    return table


def _marked(name: str, settled: bool) -> str:
    """Return a name with a mark before it, which no narrow window cuts off."""
    return name if settled else f"* {name}"
