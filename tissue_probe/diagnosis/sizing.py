"""The size of a record, and the question put in that size: the one door of every comparison.

Contents: telling the size, and turning model, instrument and library by it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tissue_probe.diagnosis.fitting.outliers import LONGEST
from tissue_probe.diagnosis.inspection.finding import Finding
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import LEAST_NOISE, Measurement
from tissue_probe.diagnosis.transforms import lasting_range
from tissue_probe.errors import ParameterError
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.scale import USUAL, Scale, UnitError, nearest
from tissue_probe.signals import FloatArray

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect

#: Travel [m], range of the force [N], and time [s], of which records of laboratories that press on
#: tissue, and of robots, are at most some thirty times more or less. The time is the geometric mean
#: of the record's and of that between two samples.
TRAVEL, RANGE, TIME = 1e-2, 3.0, 0.2
#: Range of a second input in its unit: a few volts, degrees or kilopascals.
SECOND_RANGE = 3.0
#: The sentence on a record's size and its consequences.
SIZE_TOLD = (
    "The record is of another size than is usual: bounds and typical values are taken {} times "
    "larger, and so are constants of the rig that nobody gave. A law that refers to 1 mm "
    "refers to {:g} m, one that refers to 1 s to {:g} s, and one that refers to 10 mm/s "
    "(`damping_at_10_mm_s`) to {:g} m/s."
)
#: Share of the samples at either end of a range that may be disturbed.
DISTURBED_SHARE = 0.005


def size_of(measurements: Sequence[Measurement]) -> Scale:
    """Return the size of the largest of some measurements, in whole prefixes of units."""
    travel = max(_range(each.position) for each in measurements)
    force = max(_range(each.force) for each in measurements)
    longest = max(measurements, key=lambda each: each.sample_period * each.force.size)
    time = longest.sample_period * np.sqrt(longest.force.size)
    heard = [_range(each.input2) for each in measurements if each.input2 is not None]
    second = nearest(max(heard, default=0.0), SECOND_RANGE)
    return Scale(nearest(travel, TRAVEL), nearest(force, RANGE), nearest(time, TIME), second)


def size_question(
    composition: Composition, measurements: Sequence[Measurement], instrument: Instrument
) -> tuple[Composition, list[Measurement], Instrument]:
    """Return a question about measurements in their own size.

    A model with effects of its own keeps its size: the meaning of its values depends on it.
    """
    own = bool(composition.effects) or not composition.scale.is_usual
    scale = composition.scale if own else size_of(measurements)
    if scale.is_usual:
        return composition, list(measurements), instrument
    taken = [of_size(each, scale) for each in measurements]
    return replace(composition, scale=scale), taken, instrument.of_size(scale)


def of_size(measurement: Measurement, scale: Scale) -> Measurement:
    """Return a measurement of a record of a size."""
    if measurement.scale == scale:
        return measurement
    noise = measurement.noise
    # Where there is none, there is none of this size either.
    if noise.own <= LEAST_NOISE * measurement.scale.of(measurement.output.unit):
        noise = noise.restart_estimate()
    return replace(measurement, scale=scale, noise=noise)


def report_size(scale: Scale) -> list[Finding]:
    """Say the consequences of a record's size; nothing where it is usual."""
    if replace(scale, input2=1.0).is_usual:
        return []
    factors = ((name, getattr(scale, name)) for name in ("length", "force", "time"))
    larger = " and ".join(f"in {name} {each:g}" for name, each in factors if each != 1.0)
    speed = 1e-2 * scale.of("m/s")
    return [Finding("size", SIZE_TOLD.format(larger, 1e-3 * scale.length, scale.time, speed))]


def library_of_size(
    library: Mapping[str, Effect], scale: Scale, wanted: Sequence[str] = ()
) -> Mapping[str, Effect]:
    """Return the effects that may be missing in a record of a size.

    An effect of the user's own is as it was written: its bounds are meant for this record. An
    effect of the surroundings does not occur in a record with other times, unless it is ``wanted``.

    Raises
    ------
    ParameterError
        If the unit of a parameter of the user's own says nothing.
    """
    if scale.is_usual:
        return library
    from tissue_probe.physics.effect_scale import over, resize_effect
    from tissue_probe.physics.effects import EFFECTS

    found = {}
    for name, effect in library.items():
        if effect.absolute and scale.time != USUAL.time:
            if name in wanted:
                found[name] = effect
        elif (own := EFFECTS.get(name)) and own.with_odds(effect.odds) == effect:
            found[name] = resize_effect(own, scale).with_odds(effect.odds)
        else:
            try:
                over(effect, scale)
            except UnitError as error:
                raise ParameterError(f"`effects` {name}: {error}") from None
            found[name] = effect
    return found


def _range(values: FloatArray) -> float:
    """Return the range of the samples, disturbed ones apart.

    Where most of a record holds still, the few samples that are beyond tell its size, and not the
    noise of the others: those that stay there for longer than a disturbance, or begin the record.
    """
    low, high = np.quantile(values, [DISTURBED_SHARE, 1.0 - DISTURBED_SHARE])
    return max(float(high - low), lasting_range(values, LONGEST))
