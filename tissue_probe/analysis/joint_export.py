"""The friction of a driven axis put to use: a class of joints in MuJoCo.

Contents: from a model or its file to the file of a simulator.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tissue_probe import arguments as take
from tissue_probe.contact import mujoco_joint as made_by
from tissue_probe.likeness import Alike
from tissue_probe.physics.fitted_model import FittedModel
from tissue_probe.physics.model_file import load


@dataclass(frozen=True, eq=False, repr=False)
class JointResult(Alike):
    """The friction of a joint for MuJoCo.

    Attributes
    ----------
    joint : Joint
        Numbers with their errors as MuJoCo takes them.
    xml : str
        The file to include in the model.
    """

    joint: made_by.Joint
    xml: str

    @property
    def text(self) -> str:
        """The answer in words."""
        return "\n".join([f"class {self.joint.name}:", *self.joint.lines])

    def __repr__(self) -> str:
        return self.text

    @take.checks(path=take.path)
    def save(self, path: str | Path) -> None:
        """Write the file to include in the model."""
        Path(path).write_text(self.xml, encoding="utf-8")


def _model(name: str, given: Any) -> FittedModel:
    """Take a model, or the path of its file."""
    return given if isinstance(given, FittedModel) else load(take.path(name, given))


@take.checks(class_name=take.text)
def mujoco_joint(model: FittedModel | str | Path, *, class_name: str = "identified") -> JointResult:
    """Return a class of joints in MuJoCo that has the friction of a model.

    Parameters
    ----------
    model : FittedModel or path
        Of the driven axis in free air: ``model.yaml`` of a diagnosis.
    class_name : str
        Of the joints.

    Returns
    -------
    JointResult

    Raises
    ------
    TissueProbeError
        If the file is no model, or the name none of a class.
    """
    made = made_by.joint(_model("model", model), class_name)
    return JointResult(made, made.text)
