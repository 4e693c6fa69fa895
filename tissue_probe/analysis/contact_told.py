"""Whether a fit tells stiffness and damping, and what would tell them.

Contents: the names of the values, their correlations, and the sentences.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from tissue_probe.contact.contact import ContactNumber
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.problem import CONTACT_NAME

#: The numbers that are asked for, with their units.
ASKED_UNITS = {"stiffness": "N/m", "damping": "N s/m"}
ASKED_NUMBERS = tuple(ASKED_UNITS)
DELAY_NAME, DRIFT_NAME, MASS_NAME = "channel_delay", "force_drift", "tip_mass"
#: Of two values the error of one is mostly that of the other if these go together by more: half of
#: the variance.
MOSTLY_SHARED = math.sqrt(0.5)
#: What tells two values apart that this motion does not.
TELLS = {
    MASS_NAME: "state `constants` tip_mass with its error (weigh the tool, or give the file of "
    "`tissue_probe sensor` as `sensor`), or move at several frequencies, the fastest at least "
    "twice the slowest",
    DELAY_NAME: "state `delay` with its error, or give the file of `tissue_probe sensor` as "
    "`sensor`; motion hardly tells it",
    DRIFT_NAME: "move to and fro for several cycles, or state `drift` with its error",
    CONTACT_NAME: "state `constants` contact_position with a smaller error, or leave it out",
}


def to_tell(fit: Fit) -> Iterator[str]:
    """Yield what would tell stiffness and damping, of those that are not told."""
    for name in ASKED_NUMBERS:
        number = ContactNumber(fit.named()[name], fit.deviations()[name])
        if number.told:
            continue
        other, together = _partner(fit, name)
        if abs(together) > MOSTLY_SHARED:
            yield (
                f"{name} and {other} are hardly told apart by this motion (correlation "
                f"{together:.2f}): {TELLS[other]}"
            )
        else:
            yield (
                f"{name} is hidden by the noise ({number.text(ASKED_UNITS[name])}): "
                "move farther or faster, or record longer"
            )


def errors_of_others(fit: Fit) -> Iterator[str]:
    """Yield which error makes most of that of a number that is told."""
    for name in ASKED_NUMBERS:
        other, together = _partner(fit, name)
        if (
            abs(together) > MOSTLY_SHARED
            and ContactNumber(fit.named()[name], fit.deviations()[name]).told
        ):
            yield (
                f"Most of the error of {name} is that of {other} (correlation {together:.2f}): "
                f"with a smaller one {name} is known better."
            )


def _partner(fit: Fit, name: str) -> tuple[str, float]:
    """Return which other value goes with one most, and their correlation."""
    names, covariance = list(fit.names), fit.covariance
    others = [each for each in TELLS if each in names and fit.deviations()[each] > 0.0]
    own = names.index(name)

    def together(other: str) -> float:
        place = names.index(other)
        size = math.sqrt(covariance[own, own] * covariance[place, place])
        return float(covariance[own, place] / size) if size > 0.0 else 0.0

    found = {each: together(each) for each in others}
    most = max(found, key=lambda each: abs(found[each]), default="")
    return most, found.get(most, 0.0)
