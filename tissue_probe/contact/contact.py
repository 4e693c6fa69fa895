"""A contact as it was identified: its numbers, where they held, and its file.

Contents: the numbers, their file, and the lines that go with every export.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, Literal

import yaml

from tissue_probe import bounded_yaml
from tissue_probe.bounded_yaml import YamlError
from tissue_probe.errors import MeasurementError, check_file
from tissue_probe.likeness import Alike
from tissue_probe.quantities import SIDE, engineering

CONTACT_FORMAT = "tissue_probe contact 1"
#: Digits of a number in the file: those that the errors of any contact need.
DIGITS = 9

Verdict = Literal["adequate", "missing", "cannot tell"]
VERDICTS: dict[Verdict, str] = {
    "adequate": "adequate: the force is explained to its noise, and stiffness and damping are told",
    "missing": "missing: the force has something that a spring and a damper do not make",
    "cannot tell": "cannot tell: this motion tells too little",
}


@dataclass(frozen=True)
class ContactNumber:
    """A value, and the standard deviation of its error: 0 where it was given."""

    value: float
    deviation: float

    @property
    def told(self) -> bool:
        """Whether it is not 0, by two deviations."""
        return abs(self.value) > SIDE * self.deviation

    def text(self, unit: str) -> str:
        """Return value and 95 % interval."""
        return f"{self.value:.5g} +- {SIDE * self.deviation:.2g} {unit}"


@dataclass(frozen=True)
class Contact(Alike):
    """A spring and a damper under a robot's tip, as they were identified.

    Attributes
    ----------
    verdict : str
        ``adequate``, ``missing`` or ``cannot tell``.
    stiffness, damping : Number
        [N/m], [N s/m].
    tip_mass, delay : Number
        Mass between sensor and tissue [kg]; of the force after the position [s].
    error : float
        Of the model, rms [N].
    error_over_noise : float
        The same over the noise of the force: 1 where the model leaves noise only.
    lowest, highest : float
        Between which positions it held [m].
    fastest : float
        Up to which speed it held [m/s].
    slow, fast : float
        Between which frequencies the tip moved [Hz].
    """

    verdict: Verdict
    stiffness: ContactNumber
    damping: ContactNumber
    tip_mass: ContactNumber
    delay: ContactNumber
    error: float
    error_over_noise: float
    lowest: float
    highest: float
    fastest: float
    slow: float
    fast: float

    @property
    def notes(self) -> list[str]:
        """The error of the model and the range in which it held, a line each."""
        return [
            f"stiffness {self.stiffness.text('N/m')}, damping {self.damping.text('N s/m')} (95 %)",
            f"error of the model {engineering(self.error, 'N')} rms, "
            f"{self.error_over_noise:.3g} times the noise ({self.verdict})",
            f"held over {engineering(self.highest - self.lowest, 'm')} of travel "
            f"({1e3 * self.lowest:.4g} to {1e3 * self.highest:.4g} mm), up to "
            f"{engineering(self.fastest, 'm/s')}, from {self.slow:.3g} to {self.fast:.3g} Hz",
        ]

    @property
    def doubt(self) -> str:
        """Why gains or a contact made from it may be wrong; empty where it is adequate."""
        if self.verdict == "adequate":
            return ""
        return f"the contact's verdict is {VERDICTS[self.verdict]}: do not rely on its numbers"

    def text(self) -> str:
        """Return the file's text."""
        plain = {name: _rounded(value) for name, value in asdict(self).items()}
        content = {"format": CONTACT_FORMAT, **plain}
        return str(yaml.safe_dump(content, sort_keys=False, default_flow_style=None))


def _rounded(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _rounded(each) for name, each in value.items()}
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value


def load(path: str | Path) -> Contact:
    """Read the file that ``Contact.text`` is the text of.

    Raises
    ------
    MeasurementError
        If it is none.
    OSError
        If it cannot be read.
    """
    check_file(Path(path))
    try:
        return _of_content(bounded_yaml.read(path))
    except YamlError as error:
        raise MeasurementError(f"{path} {error}") from None
    except ValueError as error:
        raise MeasurementError(f"{path}: {error}") from None


def _of_content(content: Any) -> Contact:
    if not isinstance(content, dict) or content.get("format") != CONTACT_FORMAT:
        raise ValueError("it is no contact: give a file that `tissue_probe contact` wrote")
    if content.get("verdict") not in VERDICTS:
        raise ValueError(f"its verdict is none of {', '.join(VERDICTS)}")
    given: dict[str, Any] = {"verdict": content["verdict"]}
    for each in fields(Contact):
        if each.type == ContactNumber.__name__:
            parts = (_number(content, each.name, part) for part in ("value", "deviation"))
            given[each.name] = ContactNumber(*parts)
        elif each.type == "float":
            given[each.name] = _number(content, each.name)
    return Contact(**given)


def _number(content: dict[str, Any], name: str, part: str = "") -> float:
    value = content.get(name)
    if part:
        value = value.get(part) if isinstance(value, dict) else None
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) < 1e15:
        raise ValueError(f"its {' '.join([name, part]).strip()} is no finite number")
    if value < 0.0 and (part == "deviation" or name in ("stiffness", "damping")):
        raise ValueError(f"its {' '.join([name, part]).strip()} is below 0")
    return float(value)
