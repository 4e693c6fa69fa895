"""The model that is asked about, and how the samples begin: what a page may state of both.

What belongs here: that alone. What does not: its meaning (``analysis.question``).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from tissue_probe.analysis.choices import OWN_RIG, RIG_NAMES, STARTS, TISSUE_NAMES
from tissue_probe.workbench.refused import Refused

CHOICES = {"rig": RIG_NAMES, "tissue": TISSUE_NAMES, "starts": STARTS}


@dataclass(frozen=True)
class Asked:
    """Parameters of ``tissue_probe.compare``; None where the user states nothing.

    ``constants`` holds (value, standard deviation) by name.
    """

    rig: str = OWN_RIG
    tissue: str = "kelvin_voigt"
    starts: str = "auto"
    known_rig: bool = False
    constants: dict[str, tuple[float, float]] = field(default_factory=dict)
    site: int | None = None
    lowpass: float | None = None

    def changed(self, given: Any) -> Asked:
        """Return it with what a page states.

        Raises
        ------
        Refused
            If something is no parameter, or has no such value.
        """
        if not isinstance(given, dict):
            raise Refused("the question must be an object")
        return replace(self, **{name: _checked(name, value) for name, value in given.items()})

    def parameters(self) -> dict[str, Any]:
        """Return it as ``compare`` and ``diagnose`` take it."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}

    def of_samples(self) -> dict[str, Any]:
        """Return the part that is of the samples, and not of the model."""
        return {name: getattr(self, name) for name in ("starts", "site", "lowpass")}


def _checked(name: str, value: Any) -> Any:
    if name in CHOICES:
        if value not in CHOICES[name]:
            raise Refused(f"`{name}` is {value!r}; give one of {', '.join(CHOICES[name])}")
        return value
    try:
        if name == "known_rig":
            return bool(value)
        if name == "site":
            return None if value in (None, "") else int(value)
        if name == "lowpass":
            return None if value in (None, "") else float(value)
        if name == "constants":
            return {str(key): (float(one), float(sd)) for key, (one, sd) in value.items()}
    except (TypeError, ValueError, AttributeError):
        raise Refused(f"`{name}` is {value!r}; give a number") from None
    raise Refused(f"there is no parameter {name} of a comparison")
