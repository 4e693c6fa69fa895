"""How an input goes on between its samples: smoothly, straight, held by a converter, or jumping.

Contents: telling it from the record.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tissue_probe.diagnosis.evidence.adequacy import leaves_only_noise
from tissue_probe.diagnosis.evidence.posterior import RIVAL
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.inspection.finding import Finding
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.candidates import fit_base, fit_candidates, refit
from tissue_probe.errors import MeasurementError
from tissue_probe.jumps import jumps
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.response import Between
from tissue_probe.physics.rigs import name_rigs
from tissue_probe.quantities import FORCE

#: Share of its range by which the spline through a force overshoots a jump: half of the tenth by
#: which it overshoots a single step.
OVERSHOT = 0.05
DELAY_NAME = "channel_delay"
#: Name of the finding.
COURSE = "course"
HELD_COURSE = (
    "The model follows the force better as a command that a converter puts out, and that stays as "
    "each sample has it until the next: it is taken for one (`course`)."
)
STRAIGHT = (
    "The model follows the force better along straight lines from sample to sample: so it is "
    "taken to go on (`course`)."
)
JUMPING = (
    "The model follows the force better where it goes on smoothly up to each jump, and jumps at a "
    "sample: so it is taken to go on (`course`)."
)
NOT_DRIVEN = (
    "`course`: the position drives a {}, and it is measured: it moves on between two samples; "
    f"leave it out, or give rig {name_rigs(lambda rig: rig.input is FORCE)} if a force drives"
)


def with_input(
    composition: Composition,
    measurements: Sequence[Measurement],
    instrument: Instrument,
    begin_at: Mapping[str, float] | None = None,
) -> tuple[list[Measurement], list[Finding]]:
    """Return measurements with the course of their input by which the model fits best.

    Only of a force, and where nobody has said it. A force that jumps and has no noise is a command,
    and held unless another course is likelier by much; any other force goes on smoothly unless
    another course is likelier by much. On a smooth course being held is a delay of half a sample,
    which is an effect of its own: where nothing jumps, held is told only where that effect does no
    better. There the model must leave noise only, too, lest a missing effect choose the course.

    Raises
    ------
    MeasurementError
        If a position that drives is said to be straight or held.
    """
    given = list(measurements)
    if composition.input is not FORCE:
        if any(each.between not in (None, Between.smooth) for each in given):
            raise MeasurementError(NOT_DRIVEN.format(composition.rig))
        return given, []
    if any(each.between is not None for each in given):
        return given, []
    best = _likeliest(composition, given, instrument, begin_at)
    return (given, []) if best is Between.smooth else (_with(given, best), report_course(best))


def _likeliest(
    composition: Composition,
    given: list[Measurement],
    instrument: Instrument,
    begin_at: Mapping[str, float] | None,
) -> Between:
    taken = {kind: _with(given, kind) for kind in _kinds(given)}
    fits = {kind: fit_base(composition, taken[kind], instrument, begin_at) for kind in taken}
    at_once = any(map(_overshoots, given))
    commanded = at_once and all(each.is_commanded for each in given)
    usual = Between.held if commanded else Between.smooth
    best = min(taken, key=lambda kind: fits[kind].bic - 2.0 * RIVAL * (kind is usual))
    smooth = fits[Between.smooth]
    if not at_once and best is not Between.smooth:
        delayed = _fit_delay(smooth, instrument) if best is Between.held else []
        if not (leaves_only_noise(fits[best]) and _is_as_good(fits[best], delayed)):
            return Between.smooth
    return best


def choose_course_anew(final: Fit, instrument: Instrument) -> list[Measurement]:
    """Return the measurements of a fit on another course by which it fits better; empty if on none.

    The course was chosen by a model that lacks an effect. A held force is late against straight
    lines by half a sample: so a model with a delay need fit no better on another course without it.
    """
    if final.composition.input is not FORCE:
        return []
    delayed = DELAY_NAME in final.composition.names
    model = final.composition.without(DELAY_NAME) if delayed else final.composition
    kinds = _kinds(final.measurements)
    others = [_with(final.measurements, kind) for kind in kinds if kind is not _course(final)]
    fits = [refit(final, model, instrument, each) for each in others]
    most = final.bic + (2.0 if delayed else -2.0) * RIVAL
    found = [fit for fit in fits if fit is not None and fit.bic < most]
    return list(min(found, key=lambda fit: fit.bic).measurements) if found else []


def report_course(course: Between | None) -> list[Finding]:
    """Return the finding of a course that the record told; a smooth course needs none."""
    sentences = {Between.held: HELD_COURSE, Between.straight: STRAIGHT, Between.jumping: JUMPING}
    return [Finding(COURSE, sentences[course])] if course in sentences else []


def _kinds(measurements: Sequence[Measurement]) -> list[Between]:
    """Return the courses that differ; a force that is measured jumps with its noise."""
    known = all(each.is_commanded for each in measurements)
    jumping = known and any(jumps(np.diff(each.force)).size for each in measurements)
    return [kind for kind in Between if jumping or kind is not Between.jumping]


def _course(fit: Fit) -> Between:
    return fit.measurements[0].between or Between.smooth


def _with(measurements: Sequence[Measurement], kind: Between) -> list[Measurement]:
    return [replace(each, between=kind) for each in measurements]


def _is_as_good(held: Fit, delayed: Sequence[Fit]) -> bool:
    return all(held.bic < fit.bic + 2.0 * RIVAL for fit in delayed)


def _fit_delay(fit: Fit, instrument: Instrument) -> list[Fit]:
    """Return the model with a delay between its channels, if that can be fitted."""
    from tissue_probe.physics.effect_scale import resize_effect
    from tissue_probe.physics.effects import EFFECTS

    return fit_candidates(
        fit, [resize_effect(EFFECTS[DELAY_NAME], fit.composition.scale)], instrument
    )


def _overshoots(measurement: Measurement) -> bool:
    """Whether a smooth course through the samples of the force would overshoot them."""
    from scipy.interpolate import CubicSpline  # only where a force drives that has no noise

    force = measurement.force
    between = CubicSpline(np.arange(force.size), force)(np.arange(force.size - 1) + 0.5)
    beyond = max(float(between.max() - force.max()), float(force.min() - between.min()))
    return beyond > OVERSHOT * float(np.ptp(force))
