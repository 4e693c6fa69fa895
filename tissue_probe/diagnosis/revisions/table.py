"""Which revisions there are of samples and of their weights: by which model each is told, and when.

Contents: the tables, in the order in which a model is asked.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

from tissue_probe.diagnosis.evidence.adequacy import is_quiet, leaves_only_noise
from tissue_probe.diagnosis.fitting.corners import without_corners
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.force_errors import feels_force, filter_measurements
from tissue_probe.diagnosis.fitting.outliers import without_outliers
from tissue_probe.diagnosis.fitting.position_errors import estimate_motion_anew
from tissue_probe.diagnosis.fitting.undecided_samples import without_undecided
from tissue_probe.diagnosis.input_course import COURSE, choose_course_anew
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.revisions.fineness import finer
from tissue_probe.diagnosis.revisions.noise import louder, quieter

#: Name of the revision by which no 1/f noise is counted.
NO_FLICKER = "flicker"

Revise = Callable[[Fit, Instrument], Sequence[Measurement] | None]
"""Returns the measurements of a fit, revised; None where there is nothing to revise."""


class Revision(NamedTuple):
    """A revision of an observation by a fit.

    Attributes
    ----------
    name : str
        As it is told.
    revise : callable
        From a fit and the instrument to measurements; None where the fit gives no reason.
    when : callable
        Whether a fit is one that may tell it.
    once : bool
        Whether it is made once at the most; it takes no round then.
    ends : bool
        Whether it ends by itself, and takes no round.
    """

    name: str
    revise: Revise
    when: Callable[[Fit], bool] = lambda fit: True
    once: bool = False
    ends: bool = False


def leaves_more(fit: Fit) -> bool:
    """Whether a fit leaves something other than the noise that it counts."""
    return not leaves_only_noise(fit)


def _is_louder(fit: Fit) -> bool:
    return leaves_more(fit) and not is_quiet(fit)


def _corners(fit: Fit, _: Instrument) -> list[Measurement] | None:
    return without_corners(fit)


def _outliers(fit: Fit, _: Instrument) -> list[Measurement] | None:
    return without_outliers(fit)


def _without_flicker(fit: Fit, instrument: Instrument) -> Sequence[Measurement] | None:
    return fit.measurements if instrument.flicker_noise else None


def apply_to_instrument(instrument: Instrument, revisions: Sequence[str]) -> Instrument:
    """Return the instrument after revisions."""
    return replace(instrument, flicker_noise=0.0) if NO_FLICKER in revisions else instrument


_FINENESS = Revision("fineness", finer, ends=True)
#: By the model that is asked about. There is no more noise than it leaves, also where it lacks an
#: effect; and corners of the motion tell wrong values of a model that explains them, too.
OF_BASE = (
    Revision("quieter", partial(quieter, least=True), is_quiet),
    Revision("corners", _corners),
    _FINENESS,
)
#: By the best model. The noise first: by it outliers are told, and where more is counted there are
#: none.
OF_BEST = (
    _FINENESS,
    Revision("quieter", quieter, is_quiet),
    Revision("louder", louder, _is_louder),
    Revision("motion", estimate_motion_anew, leaves_more),
    Revision("undecided", without_undecided, leaves_more),
    Revision("outliers", _outliers, leaves_more),
)
#: By the best model of one effect: noise of a force that drives has the colour of its response.
OF_SINGLE = (Revision("colour", filter_measurements, feels_force, once=True), *OF_BEST)
#: By the model at the end of a search.
OF_LAST = (
    *OF_BEST,
    Revision(COURSE, choose_course_anew, once=True),
    Revision(NO_FLICKER, _without_flicker, is_quiet, once=True),
)
