"""A question as it is answered: the order of all that comes before the first fit.

Contents: that order.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from tissue_probe.diagnosis.cleaning import (
    SPOILING_CAUSES,
    clean_measurements,
    from_touch,
    with_any_touch,
)
from tissue_probe.diagnosis.input_course import COURSE, with_input
from tissue_probe.diagnosis.inspection.finding import Finding
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.waves import fastest_shown, slowest_wave
from tissue_probe.diagnosis.sizing import library_of_size, of_size, report_size, size_question
from tissue_probe.errors import MeasurementError
from tissue_probe.physics.composition import Composition

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect
    from tissue_probe.physics.rigs import Rig


@dataclass(frozen=True)
class Prepared:
    """A question about measurements that are inspected, and all that belongs to it, of their size.

    Attributes
    ----------
    composition : Composition
        The model that is asked about.
    measurements : list of Measurement
        Without spoilt samples, from the touch on, and with the course of the input.
    instrument : Instrument
        Constants of the rig with their tolerances.
    findings : list of Finding
        Of reading and of the inspection, on all measurements.
    library : mapping of str to Effect
        Effects that the rig has something for, and that the measurements can tell.
    wanted : list of Effect
        Effects that are asked for.
    validation : list of Measurement
        Other recordings, inspected as well.
    given : tuple of str
        Names of the revisions that are not made: the user has given their result.
    """

    composition: Composition
    measurements: list[Measurement]
    instrument: Instrument
    findings: list[Finding]
    library: Mapping[str, Effect]
    wanted: list[Effect]
    validation: list[Measurement]
    given: tuple[str, ...]

    @property
    def spoilt(self) -> tuple[str, ...]:
        """The faults of samples that are left out."""
        return tuple(name for name in SPOILING_CAUSES if any(f.name == name for f in self.findings))


def prepare_question(
    composition: Composition,
    measurements: Sequence[Measurement],
    instrument: Instrument,
    library: Mapping[str, Effect] | None = None,
    validation: Sequence[Measurement] = (),
    wanted: Sequence[str] = (),
    begin_at: Mapping[str, float] | None = None,
) -> Prepared:
    """Inspect measurements, and return the question as it is answered.

    The arguments are those of ``diagnose``.

    Raises
    ------
    MeasurementError
        If any samples are such that a fit would be worthless, or the rig has nothing that a
        wanted effect acts on; says why, and the remedy.
    """
    read = [Finding("as_read", n) for each in (*measurements, *validation) for n in each.notes]
    given = (COURSE,) if any(each.between is not None for each in measurements) else ()
    composition, measurements, instrument = size_question(composition, measurements, instrument)
    scale = composition.scale
    library = library_of_size(library or {}, scale, wanted)
    asked_for = [library[name] for name in wanted]
    _refuse(composition.rig, asked_for)
    if composition.rig.tip_is_position and any(effect.zero for effect in asked_for):
        instrument = replace(instrument, any_zero=False)
    clean, found = clean_measurements(measurements)
    clean, instrument, touched = from_touch(clean, instrument)
    instrument = with_any_touch(clean, instrument)
    clean, held = with_input(composition, clean, instrument, begin_at)
    others, of_others = clean_measurements([of_size(each, scale) for each in validation])
    others, _, touched_there = from_touch(others, instrument)
    findings = [
        *(*read, *report_size(scale), *found, *touched, *held),
        *(*of_others, *touched_there),
    ]
    _refuse_unheard(composition, asked_for, [*clean, *others])
    admitted = _admit_effects(composition, library, clean, instrument)
    return Prepared(composition, clean, instrument, findings, admitted, asked_for, others, given)


def _admit_effects(
    composition: Composition,
    library: Mapping[str, Effect],
    measurements: Sequence[Measurement],
    instrument: Instrument,
) -> dict[str, Effect]:
    """Return the effects that act on something that the rig has, and that can be told.

    Parts of a run tell by how much they differ; a place of touch that is free is a constant of the
    force as well. Effects without odds are those that nobody asks for.
    """
    runs = [each.run for each in measurements if each.run]
    parts = len(runs) > len(set(runs))
    heard = all(each.input2 is not None for each in measurements)
    asked_for = {name: each for name, each in library.items() if each.odds}
    return {
        name: each
        for name, each in asked_for.items()
        if composition.rig.admits(each)
        and (parts or not each.of_part)
        and (heard or not each.hears_input2)
        and not (each.absolute and slowest_wave(each) > fastest_shown(measurements))
        and not (instrument.free_touch and [p.name for p in each.parameters] == [each.zero])
    }


def _refuse_unheard(
    composition: Composition, wanted: list[Effect], measurements: Sequence[Measurement]
) -> None:
    """Refuse recordings of which only some have a second input, or a model that needs one."""
    deaf = [each for each in measurements if each.input2 is None]
    if deaf and (len(deaf) < len(measurements)):
        raise MeasurementError(
            f"{deaf[0].source or 'a recording'} has no second input and another recording has one: "
            "give `input2` for all of them, or for none"
        )
    needs = [e.name for e in (*composition.all_effects, *wanted) if e.hears_input2]
    if deaf and needs:
        raise MeasurementError(
            f"{needs[0]} follows a second input, and none is given: name its channel by `input2`"
        )


def _refuse(rig: Rig, wanted: Sequence[Effect]) -> None:
    for effect in wanted:
        told = [rig.obstacle(form) for form in effect.every_form]
        if all(told):
            raise MeasurementError(
                f"{effect.name} cannot be fitted to these measurements of a {rig}: it {told[0]}"
            )
