"""A modulus of a tissue: numbers, units and words.

Contents: Young's modulus, viscosity, storage and loss, of a tip or of a bar.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from tissue_probe.quantities import SIDE, engineering

NOT_KNOWN = (math.nan, math.nan)


@dataclass(frozen=True)
class ComplexModulus:
    """Storage and loss modulus at one frequency.

    Attributes
    ----------
    frequency : float
        [Hz].
    storage, storage_deviation, loss, loss_deviation : float
        [Pa], and standard deviations, NaN where the model has none of its stiffness.
    """

    frequency: float
    storage: float
    storage_deviation: float
    loss: float
    loss_deviation: float

    def __str__(self) -> str:
        storage = _tell(1e-3 * self.storage, 1e-3 * self.storage_deviation, "kPa")
        loss = _tell(1e-3 * self.loss, 1e-3 * self.loss_deviation, "kPa")
        return f"At {self.frequency:g} Hz: storage modulus {storage}, loss modulus {loss}."


@dataclass(frozen=True)
class Modulus:
    """Young's modulus of a tissue.

    Attributes
    ----------
    value, deviation : float
        [Pa], and the standard deviation by that of the fitted values, and of a bar's length and
        area; tip and Poisson's ratio are taken as given. NaN where the model has no deviation of
        its stiffness.
    depth : float
        At which it holds [m]; NaN where it is the same at all depths.
    notes : tuple of str
        Facts that a reader needs, in sentences.
    viscosity, viscosity_deviation : float
        Of the damper beside the spring [Pa s]; NaN where no linear damper is beside it, or where it
        differs with a depth that is not stated.
    spectrum : tuple of ComplexModulus
        Storage and loss modulus at the frequencies that were asked for.
    strain, stress : tuple of two float
        Of a bar: at the lowest and the highest position that the model was fitted to the strain
        [-], and the stress after all relaxation [Pa]; NaN where these are not known.
    """

    value: float
    deviation: float
    depth: float
    notes: tuple[str, ...] = ()
    viscosity: float = math.nan
    viscosity_deviation: float = math.nan
    spectrum: tuple[ComplexModulus, ...] = ()
    strain: tuple[float, float] = NOT_KNOWN
    stress: tuple[float, float] = NOT_KNOWN

    def __str__(self) -> str:
        at = "" if math.isnan(self.depth) else f" at a depth of {engineering(self.depth, 'm')}"
        lines = [f"Modulus{at}: {_tell(1e-3 * self.value, 1e-3 * self.deviation, 'kPa')}."]
        if not math.isnan(self.viscosity):
            lines.append(f"Viscosity: {_tell(self.viscosity, self.viscosity_deviation, 'Pa s')}.")
        lines += map(str, self.spectrum)
        if not math.isnan(self.strain[0]):
            strain = " to ".join(f"{100.0 * each:.3g}" for each in self.strain)
            stress = " to ".join(f"{1e-3 * each:.3g}" for each in self.stress)
            lines.append(f"Strain {strain} %, stress {stress} kPa.")
        return "\n".join([*lines, *self.notes])

    def to_dict(self) -> dict[str, Any]:
        """Return the answer in plain types, in SI units; None for a number that is not known."""
        return {name: _convert_unknown(each) for name, each in asdict(self).items()}


def _convert_unknown(given: Any) -> Any:
    """Write NaN as None, and tuples as lists, as JSON has them."""
    if isinstance(given, dict):
        return {name: _convert_unknown(each) for name, each in given.items()}
    if isinstance(given, (list, tuple)):
        return [_convert_unknown(each) for each in given]
    return None if isinstance(given, float) and math.isnan(given) else given


def _tell(value: float, deviation: float, unit: str) -> str:
    """Return a value with its 95 % interval in words."""
    half = "" if math.isnan(deviation) else f" +- {SIDE * deviation:.2g}"
    return f"{value:.4g}{half} {unit}"
