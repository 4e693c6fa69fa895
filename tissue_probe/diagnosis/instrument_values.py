"""Values that belong to the instrument and not to the tissue, run by run and part by part.

Contents: where a run touches, by how much zeros differ, and effects that cannot be told from them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.problem import CONTACT_NAME, Problem
from tissue_probe.diagnosis.fitting.runs import of_part
from tissue_probe.diagnosis.inspection.finding import Finding
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.quantities import SIDE

#: Standard deviations from which on a value is told as one of the instrument's: one in a thousand
#: is by chance.
SURE_DEVIATIONS = 3.3
#: The effect that is a constant of the force.
BIAS_NAME = "force_bias"
ZERO_OR_PLACE = (
    "{}The force's zero is {:.3g} N off, or the position's zero {:.4g} mm: one and the same in "
    "this recording; the stiffness does not depend on it."
)
PLACE = "{}The tip touches at {:.4g} +- {:.2g} mm: the position's own zero is not at the touch."
PART = "{}In part {} the force's zero is {:.3g} +- {:.2g} N off that of the first part."


@dataclass(frozen=True)
class FoundInstrumentValue:
    """A value of the instrument in a recording, or in a part of it.

    Attributes
    ----------
    name, unit : str
        Of the value.
    recording : str
        Where it was measured; empty where that has no name.
    part : int or None
        Number of the part, from 1; None where it is that of the whole recording.
    value, deviation : float
        With the standard deviation of its error [unit].
    degenerate_with : tuple of str
        Effects that would change the output in the same way.
    force : float
        Force that it amounts to, where it is degenerate with a constant of the force [N]; else NaN.
    """

    name: str
    unit: str
    recording: str
    part: int | None
    value: float
    deviation: float
    degenerate_with: tuple[str, ...] = ()
    force: float = float("nan")


def instrument_values(fit: Fit, instrument: Instrument) -> tuple[FoundInstrumentValue, ...]:
    """Return the values of the instrument that a fit found."""
    problem = Problem(fit.composition, fit.measurements, instrument)
    unknown = instrument.any_zero and instrument.constants.get(CONTACT_NAME, (0.0, 0.0))[1] > 0.0
    touches = _touches(fit, problem) if instrument.free_touch or unknown else []
    return (*touches, *_of_parts(fit, problem), *_of_channels(fit, problem))


def findings(values: tuple[FoundInstrumentValue, ...]) -> list[Finding]:
    """Say where the tip touches, unless that is at the position's zero, and how parts differ.

    Effects on a channel are named by the verdict.
    """
    told = [each for each in values if each.name == CONTACT_NAME or each.part is not None]
    told = [each for each in told if abs(each.value) > SURE_DEVIATIONS * each.deviation]
    return [Finding("instrument", _sentence(each)) for each in told]


def _touches(fit: Fit, problem: Problem) -> list[FoundInstrumentValue]:
    """Return the place of touch of each run."""
    runs, deviations = problem.runs, fit.deviations()
    contact = fit.composition.kernel.values.index(CONTACT_NAME)
    found = []
    for number in range(runs.count):
        first = runs.numbers.index(number)
        name = runs.names[runs.places[first][contact]]
        value, force = fit.named()[name], _as_force(fit, problem, first, name)
        same = () if np.isnan(force) else (BIAS_NAME,)
        source = fit.measurements[first].source
        found.append(
            FoundInstrumentValue(
                CONTACT_NAME, "m", source, None, value, deviations[name], same, force
            )
        )
    return found


def _as_force(fit: Fit, problem: Problem, index: int, name: str) -> float:
    """Return the constant force that the place of touch amounts to; NaN where it is none.

    It is one where the output changes by a constant with it, as far as noise lets that be told.
    """
    measurement = fit.measurements[index]
    _, sensitivity = problem.simulate(fit.values, fit.starts)[index]
    change = sensitivity[:, problem.states + fit.names.index(name)][measurement.used]
    moved = fit.named()[name] * change
    rest = float(np.linalg.norm(moved - moved.mean()))
    return float(moved.mean()) if rest < measurement.noise.own else float("nan")


def _of_parts(fit: Fit, problem: Problem) -> list[FoundInstrumentValue]:
    """Return by how much each part of a run differs from its first."""
    own, runs, deviations = of_part(fit.composition), problem.runs, fit.deviations()
    found = []
    for index, places in enumerate(runs.places):
        part = index - runs.numbers.index(runs.numbers[index])
        for place in places if part else ():
            if runs.meanings[place] in own:
                name, entry = runs.names[place], runs.entries[place]
                source, value = fit.measurements[index].source, fit.named()[name]
                told = (runs.meanings[place], entry.unit, source, part + 1, value)
                found.append(FoundInstrumentValue(*told, deviations[name]))
    return found


def _of_channels(fit: Fit, problem: Problem) -> list[FoundInstrumentValue]:
    """Return the values of effects that act on a channel, such as a delay between both."""
    own, runs, deviations = of_part(fit.composition), problem.runs, fit.deviations()
    effects = [each for each in fit.composition.effects if each.acts_on_channels]
    meant = {value.name for each in effects for value in each.parameters} - own
    found = []
    for place, (name, meaning) in enumerate(zip(runs.names, runs.meanings, strict=True)):
        if meaning in meant:
            within = [index for index, places in enumerate(runs.places) if place in places]
            of_one = len({runs.numbers[index] for index in within}) == 1 < runs.count
            source = fit.measurements[within[0]].source if of_one else ""
            told = (meaning, runs.entries[place].unit, source, None, fit.named()[name])
            found.append(FoundInstrumentValue(*told, deviations[name]))
    return found


def _sentence(found: FoundInstrumentValue) -> str:
    told = f"{found.recording}: " if found.recording else ""
    doubt = SIDE * found.deviation
    if found.part is not None:
        return PART.format(told, found.part, found.value, doubt)
    if found.degenerate_with:
        return ZERO_OR_PLACE.format(told, found.force, 1e3 * found.value)
    return PLACE.format(told, 1e3 * found.value, 1e3 * doubt)
