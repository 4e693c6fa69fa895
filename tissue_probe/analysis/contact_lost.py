"""Samples in which a robot's tip has left the tissue.

Contents: finding them in a fit that leaves more than noise.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.ndimage import binary_dilation

from tissue_probe.analysis.contact_told import DELAY_NAME
from tissue_probe.diagnosis.evidence.posterior import RIVAL
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.problem import CONTACT_NAME
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.candidates import refit
from tissue_probe.errors import MeasurementError
from tissue_probe.quantities import SIDE
from tissue_probe.signals import BoolArray

#: Out of contact in more of the samples than this, the recording is mostly not of the tissue.
MOST_LOST = 0.5
#: Shares of the travel at which the search for a touch begins: cost has a valley about each.
TOUCHES = np.arange(0.1, 0.95, 0.1)
#: In the air the force does not go with the position: its slope is 0 within so many deviations,
#: which chance exceeds in .3 % of records, and these are less than this share of the tissue's
#: stiffness. A tissue that is softer there, by less than four times, is so told apart from the air.
CERTAIN_ERRORS, SOFTER = 3.0, 0.25
MAY_LEAVE = (
    "Below {:.4g} mm the tip may be out of contact, or the tissue softer: press deeper, or let "
    "`tissue_probe diagnose` tell."
)


def in_contact(fit: Fit, instrument: Instrument) -> tuple[list[Measurement] | None, str]:
    """Return the measurements without samples out of contact, None if there are none; and a note.

    Parameters
    ----------
    fit : Fit
        A model that never loses contact, with a delay.
    instrument : Instrument
        Constants of the rig with their tolerances.

    Raises
    ------
    MeasurementError
        If the tip is out of contact in most of the samples.
    """
    from tissue_probe.physics.effects import EFFECTS

    low = min(float(each.position.min()) for each in fit.measurements)
    travel = max(float(each.position.max()) for each in fit.measurements) - low
    free = {**(instrument.constants or {}), CONTACT_NAME: (low, travel)}
    anywhere = replace(instrument, constants=free)
    lossy = fit.composition.plus(EFFECTS["contact_loss"])
    # From a touch below all of the motion no slope leads to one within it.
    tried = [
        refit(fit, lossy, anywhere, held={CONTACT_NAME: low + share * travel}) for share in TOUCHES
    ]
    best = min((each for each in tried if each), key=lambda each: each.cost, default=None)
    found = refit(best, lossy, anywhere) if best else None
    # By the residual alone: strained constants are no loss of contact.
    if found is None or sum(fit.misfits) - sum(found.misfits) < 2.0 * RIVAL:
        return None, ""
    touch = found.named()[CONTACT_NAME] + SIDE * found.deviations()[CONTACT_NAME]
    late = max(found.named()[DELAY_NAME], 0.0)
    away = [_out_of_contact(each, touch, late) for each in found.measurements]
    slope, doubt = _slope_in_air(found, touch)
    if not abs(slope) < CERTAIN_ERRORS * doubt < SOFTER * found.named()["stiffness"]:
        return None, MAY_LEAVE.format(1e3 * touch)
    share = sum(int(np.sum(each)) for each in away) / sum(each.size for each in away)
    kept = fit.without(away, MOST_LOST)
    if kept is None:
        raise MeasurementError(
            f"the tip is out of contact in {100 * share:.3g} % of the samples, where the position "
            f"is below {1e3 * touch:.4g} mm: press deeper, so that it stays in the tissue"
        )
    told = (
        f"The tip is out of contact in {100 * share:.3g} % of the samples, where the position is "
        f"below {1e3 * touch:.4g} mm: left out."
    )
    return kept, told


def _out_of_contact(measurement: Measurement, touch: float, late: float) -> BoolArray:
    """Return the samples whose force comes from a position below the touch."""
    away = measurement.position < touch
    reach = math.ceil(late / measurement.sample_period) + 1
    return np.asarray(binary_dilation(away, iterations=reach), dtype=bool)


def _slope_in_air(fit: Fit, touch: float) -> tuple[float, float]:
    """Return how the force left over goes with the position below a touch, and its doubt [N/m]."""
    normal, right = np.zeros((3, 3)), np.zeros(3)
    for measurement, left in zip(fit.measurements, fit.residuals, strict=True):
        speed = np.gradient(measurement.position, measurement.times)
        inside = (measurement.position < touch) & measurement.counted
        columns = np.stack([np.ones_like(speed), measurement.position, speed], axis=1)[inside]
        columns /= measurement.noise.own
        normal += columns.T @ columns
        right += columns.T @ left[inside] / measurement.noise.own
    inverse = np.linalg.pinv(normal, hermitian=True)
    return float((inverse @ right)[1]), float(np.sqrt(inverse[1, 1]))
