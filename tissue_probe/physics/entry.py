"""A number of a model, as far as fits and files know it: by name, without its symbol."""

from __future__ import annotations

from dataclasses import dataclass, replace

from tissue_probe.physics.scale import Scale


@dataclass(frozen=True)
class Entry:
    """A constant or parameter: name, unit, where a search begins, and between which bounds it lies.

    ``default`` is a typical value, and the scale of the search.
    """

    name: str
    unit: str
    default: float
    lower: float
    upper: float

    def times(self, scale: Scale) -> Entry:
        """Return the same for a record that is by so much larger than usual."""
        factor = scale.of(self.unit)
        default, lower, upper = (factor * each for each in (self.default, self.lower, self.upper))
        return replace(self, default=default, lower=lower, upper=upper)
