"""Where the search for an effect begins: values proposed for it, beside those of a fitted model.

Contents: values and states at the start.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.problem import CONTACT_NAME, Problem
from tissue_probe.diagnosis.fitting.search import search
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.transforms import peaks
from tissue_probe.physics.extent import Extent
from tissue_probe.quantities import FORCE
from tissue_probe.signals import FloatArray

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect

Values = Mapping[str, float]
#: Points to a sample at which the tension of the tissue is looked at.
TENSION_POINTS = 4
#: Share of the samples that must be in contact to tell the tissue there.
LEAST_PRESSED = 0.05
#: How many samples about a touch tell how far apart they are; how many steps of the motion to
#: either side others are tried; and at how many places at the most.
ABOUT, SIDE, MOST = 9, 3.0, 24


def fit_in_contact(base: Fit, instrument: Instrument) -> list[Values]:
    """Return the values of a fit to the samples sure to be in contact, if there are enough.

    Elsewhere the base is wrong if contact is lost.
    """
    stiffness = base.named().get("load_cell_stiffness", np.inf)
    inside = [replace(m, used=m.find_pressed(stiffness)) for m in base.measurements]
    if min(np.mean(m.used) for m in inside) < LEAST_PRESSED:
        return []
    problem = Problem(base.composition, inside, instrument)
    fit = search(problem, base.values, base.starts)
    return [] if fit is None else [fit.named()]


def from_touch(base: Fit, instrument: Instrument) -> list[Values]:
    """Return the values of a fit to the samples after a touch that was seen, with the touch there.

    A model that never lets go is fitted best by a touch that is far from it, and the way back leads
    over a jump of the cost at every sample.
    """
    place, deviation = instrument.constants.get(CONTACT_NAME, (0.0, 0.0))
    if np.isfinite(deviation) or base.composition.input is FORCE:
        return []
    inside = [replace(m, used=m.used & (m.position > place)) for m in base.measurements]
    if min(np.mean(m.used) for m in inside) < LEAST_PRESSED:
        return []
    problem = Problem(base.composition, inside, instrument, {CONTACT_NAME: place})
    values = start_values(problem, base.named(), None, {})
    fit = search(problem, values, [begun.mean for begun in problem.begin(values)])
    return [] if fit is None else [fit.named()]


def of_first_parts(base: Fit, instrument: Instrument) -> list[Values]:
    """Return the values of a fit to the first part of each run, where one has several.

    Parts may differ: a model by which they do not is fitted best by values that are far off.
    """
    runs = [each.run or object() for each in base.measurements]
    first = [m for n, m in enumerate(base.measurements) if runs[n] not in runs[:n]]
    if len(first) == len(runs):
        return []
    problem = Problem(base.composition, first, instrument)
    nominal = zip(problem.runs.names, map(float, problem.nominal), strict=True)
    constants = {name: value for name, value in nominal if name in problem.instrument.constants}
    values = start_values(problem, constants, None, {})
    fit = search(problem, values, [begun.mean for begun in problem.begin(values)])
    return [] if fit is None else [fit.named()]


def propose_starts(
    base: Fit, effect: Effect, known: Sequence[Values]
) -> Iterator[tuple[Values, Values]]:
    """Yield values known of a model, and with each the values to try for an effect beside it.

    Parameters
    ----------
    base : Fit
        The model without the effect.
    effect : Effect
        The effect that is added.
    known : sequence of mapping of str to float
        Its values, then those of fits to a part of the samples: ``fit_in_contact`` and the others.
    """
    for each in known if effect.changes_contact or effect.of_part else known[:1]:
        reach = extent(base, each, effect)
        tried = list(effect.starts(reach))
        if effect.states and not all(measurement.at_rest for measurement in base.measurements):
            instead = _instead(effect, each, reach)
            tried += _strong(effect, tried) if instead is None else instead
        for proposal in tried:
            yield each, proposal


def instants(effect: Effect) -> list[str]:
    """Name the values of a run that are no strengths: any strength is a step away, no instant."""
    strengths = [each.name for each in effect.parameters[: effect.strengths]]
    return [name for name in effect.of_run if name not in strengths]


def with_instant(
    problem: Problem, named: Values, effect: Effect, number: int, tried: Values
) -> FloatArray:
    """Return known values, but in a run an effect at the instants that are to be tried."""
    instant = {name: tried[name] for name in instants(effect) if name in tried}
    return start_values(
        problem, {**named, **problem.runs.name_among_all(number, instant)}, None, {}
    )


def extent(fit: Fit, known: Values, effect: Effect) -> Extent:
    """How far the longest measurement reaches, by a fitted model with these values of its tissue.

    Its run may be longer. The tension of tissue that never lets go is taken from the motion of the
    tip, for effects by which it may.
    """
    index = max(range(len(fit.measurements)), key=lambda i: fit.measurements[i].extent.duration)
    measurement = fit.measurements[index]
    duration = max(each.begins + each.extent.duration for each in fit.measurements)
    reach = replace(measurement.extent, duration=duration, left_at=fit.left_at[index])
    if not effect.changes_contact:
        return reach
    from scipy.interpolate import CubicSpline  # only for effects by which tissue lets go

    tip = CubicSpline(measurement.times, fit.tip[index] - known.get(CONTACT_NAME, 0.0))
    often = np.linspace(0.0, measurement.times[-1], TENSION_POINTS * measurement.times.size)
    pull = -known.get("stiffness", 0.0) * tip(often) - known.get("damping", 0.0) * tip(often, 1)
    tensions = np.sort(pull[peaks(pull, 0.0)])[::-1]
    return replace(reach, tensions=tuple(map(float, tensions)))


def touches(problem: Problem, fit: Fit) -> list[Values]:
    """Propose to touch between other samples than those between which a fit does.

    Where damping is felt at once, each sample that comes to lie in the air, or in the tissue, is a
    jump of the cost: no search steps over it. Only where nothing is known of the touch.
    """
    names = problem.runs.names
    known = CONTACT_NAME not in names or np.isfinite(problem.deviation[names.index(CONTACT_NAME)])
    if known or problem.composition.input is FORCE:
        return []
    places = np.concatenate([each.position for each in problem.measurements])
    steps = np.concatenate([np.abs(np.diff(each.position)) for each in problem.measurements])
    off = np.abs(places - fit.named()[CONTACT_NAME])
    nearest = np.argsort(off)[:ABOUT]
    # A step of a motion that passes there: at a rest there are none.
    reach = SIDE * float(np.median(steps[np.minimum(nearest, steps.size - 1)]))
    about = np.unique(places[off < reach])
    between = 0.5 * (about[1:] + about[:-1])
    few = between[:: 1 + between.size // MOST]
    return [{CONTACT_NAME: float(place)} for place in few]


def _strong(effect: Effect, tried: Iterable[Values]) -> list[Values]:
    """Propose the usual strength too, where an effect remembers the time before the first sample.

    At strength zero its memory has no influence, and the way up may begin downhill.
    """
    usual = {each.name: each.default for each in effect.parameters[: effect.strengths]}
    return [{**usual, **each} for each in tried]


def _instead(effect: Effect, known: Values, reach: Extent) -> list[Values] | None:
    """Propose the same of an effect that tells which part of the tissue it may stand for."""
    if effect.near is None:
        return None
    none = {each.name: effect.neutral for each in effect.parameters[: effect.strengths]}
    others = {each.name: each.default for each in effect.parameters[effect.strengths :]}
    return list(effect.near(reach, {**known, **others, **none}))


def start_values(
    problem: Problem,
    known: Values,
    effect: Effect | None,
    proposed: Values,
) -> FloatArray:
    """Values to begin a search with: those known, no strength, the proposed ones, defaults."""
    strengths = {}
    if effect is not None:
        named = effect.parameters[: effect.strengths]
        strengths = {parameter.name: effect.neutral for parameter in named}
    given = {**known, **strengths, **proposed}
    runs = problem.runs
    default = {entry.name: given.get(entry.name, entry.default) for entry in runs.entries}
    pairs = zip(runs.names, runs.meanings, strict=True)
    values = np.array([given.get(name, default[meaning]) for name, meaning in pairs])
    values = np.where(problem.free, values, problem.nominal)  # a value that is held is not proposed
    found: FloatArray = np.clip(values, problem.lower, problem.upper)
    return found


def begin_states(problem: Problem, base: Fit, values: FloatArray) -> list[FloatArray]:
    """Start where a fit does, and states that it has not where a probe at rest has them."""
    known = [dict(zip(base.composition.kernel.states, start, strict=True)) for start in base.starts]
    return [
        np.array([of.get(name, at) for name, at in zip(problem.kernel.states, rest, strict=True)])
        for of, (rest, _, _) in zip(known, problem.begin(values), strict=True)
    ]
