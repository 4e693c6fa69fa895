"""Why a cell of the map has a value, or none."""

from __future__ import annotations

from collections.abc import Iterable
from enum import IntEnum

from tissue_probe.signals import Status

#: An estimator counts in a cell if it ended the dwell with one of these.
USABLE = (Status.CONVERGED, Status.DISTURBED)


class CellVerdict(IntEnum):
    """The reason of each cell (the constants of ``StiffnessMap.msg``)."""

    NOT_PALPATED = 0
    MEASURED = 1
    NO_ESTIMATE = 2
    NOT_CONVERGED = 3
    NO_CONTACT = 4
    MODEL_REJECTED = 5
    DISTURBED = 6
    CONTACT_NOT_FOUND = 7


#: Which reason is told where estimators of one dwell differ and none is usable: the gravest first.
_GRAVEST = (
    (Status.MODEL_REJECTED, CellVerdict.MODEL_REJECTED),
    (Status.NO_CONTACT, CellVerdict.NO_CONTACT),
    (Status.CONVERGING, CellVerdict.NOT_CONVERGED),
)


def verdict_of(statuses: Iterable[int]) -> CellVerdict:
    """Return the verdict of a dwell from the status with which each estimator ended it.

    A usable estimator settles it; a disturbance that one usable estimator saw is told.
    """
    ended = set(statuses)
    if Status.DISTURBED in ended:
        return CellVerdict.DISTURBED
    if Status.CONVERGED in ended:
        return CellVerdict.MEASURED
    return next((why for status, why in _GRAVEST if status in ended), CellVerdict.NO_ESTIMATE)
