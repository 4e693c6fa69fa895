"""A composed model with its numbers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from tissue_probe import arguments as take
from tissue_probe.physics.composition import Composition

if TYPE_CHECKING:
    from tissue_probe.physics.model_file import Data


@dataclass(frozen=True)
class FittedModel:
    """A composed model with its numbers.

    Attributes
    ----------
    composition : Composition
        Rig, tissue and effects.
    values, deviations : dict of float
        Constants and parameters by name (SI), and the standard deviations of their errors.
    data : Data or None
        Their origin, where that is told.
    effect_files : tuple of Path
        Python files with effects of the user's own, as the user named them.
    """

    composition: Composition
    values: dict[str, float]
    deviations: dict[str, float]
    data: Data | None = None
    effect_files: tuple[Path, ...] = ()

    @take.checks(path=take.path)
    def save(self, path: str | Path) -> None:
        """Write it as a model file, as ``model_file.save`` does."""
        from tissue_probe.physics.model_file import save

        save(path, self.composition, self.values, self.deviations, self.data, self.effect_files)
