"""A composed model with its numbers."""

from __future__ import annotations

from dataclasses import dataclass, field
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
    content : str
        Text of the model file that it was read from; empty where it was not.
    """

    composition: Composition
    values: dict[str, float]
    deviations: dict[str, float]
    data: Data | None = None
    effect_files: tuple[Path, ...] = ()
    content: str = field(default="", compare=False, repr=False)

    @take.checks(path=take.path)
    def save(self, path: str | Path) -> None:
        """Write it as a model file, as ``model_file.save`` does."""
        from tissue_probe.physics.model_file import save

        save(path, self.composition, self.values, self.deviations, self.data, self.effect_files)
