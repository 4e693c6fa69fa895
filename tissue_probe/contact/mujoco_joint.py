"""The friction of a driven axis for MuJoCo: a class of joints with damping and dry friction.

MuJoCo's joint answers its speed v with `damping` v, holds itself by a dry friction of at most
`frictionloss`, and adds `armature` to its inertia (MuJoCo's documentation, XML reference, "joint").
Each is the number of the model itself: no weight of a body changes it.

Contents: which number of a model is which of a joint's, the class and its file.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from xml.sax.saxutils import quoteattr

from tissue_probe.contact.contact import ContactNumber
from tissue_probe.errors import ParameterError
from tissue_probe.likeness import Alike
from tissue_probe.physics.effects.added_mass import ADDED_MASS
from tissue_probe.physics.effects.coulomb_friction import COULOMB_FRICTION
from tissue_probe.physics.effects.effect import DAMPING, STIFFNESS
from tissue_probe.physics.effects.stribeck_friction import BREAKAWAY, STRIBECK, STRIBECK_FRICTION
from tissue_probe.physics.fitted_model import FittedModel
from tissue_probe.physics.rigs.constants import TIP_MASS
from tissue_probe.quantities import engineering

#: The effects that a joint of MuJoCo has, or has a part of: their first value is the joint's.
FRICTIONS, MASSES = (COULOMB_FRICTION, STRIBECK_FRICTION), (ADDED_MASS,)
UNITS = {"damping": "N s/m", "frictionloss": "N", "armature": "kg"}


@dataclass(frozen=True)
class Joint(Alike):
    """A class of joints for MuJoCo.

    Attributes
    ----------
    name : str
        Of the class.
    numbers : dict of str to ContactNumber
        MuJoCo's attributes; SI units of a slide.
    notes : tuple of str
        Facts that a user of it needs, in sentences.
    """

    name: str
    numbers: dict[str, ContactNumber]
    notes: tuple[str, ...]

    @property
    def lines(self) -> tuple[str, ...]:
        """Each number with its error, and the notes."""
        told = (f"{name} {number.text(UNITS[name])}" for name, number in self.numbers.items())
        return (*told, *self.notes)

    @property
    def text(self) -> str:
        """The file, to be included in the model."""
        told = ("Class by `tissue_probe joint`:", *self.lines)
        # XML has no two hyphens in a comment, and names of files may have.
        comment = "\n".join(f"  {line}" for line in told).replace("--", "- -")
        values = " ".join(f'{name}="{each.value:.9g}"' for name, each in self.numbers.items())
        kind = f"<default class={quoteattr(self.name)}>\n      <joint {values}/>\n    </default>"
        return f"<!--\n{comment}\n-->\n<mujoco>\n  <default>\n    {kind}\n  </default>\n</mujoco>\n"


def joint(model: FittedModel, class_name: str) -> Joint:
    """Return the class of joints that have the friction of a model.

    Parameters
    ----------
    model : FittedModel
        With the effects that were found.
    class_name : str
        Of the joints.

    Raises
    ------
    ParameterError
        If the name is none that MuJoCo takes in a file.
    """
    if not re.fullmatch(r"[\w.\-]+", class_name):
        raise ParameterError(
            f"`class_name` {class_name!r}: give letters, digits, dots, dashes or underscores"
        )
    found = {effect.name: effect for effect in model.composition.effects}
    numbers = {"damping": _number(model, str(DAMPING))}
    for kind, effects in (("frictionloss", FRICTIONS), ("armature", MASSES)):
        for effect in effects:
            if effect.name in found:
                numbers[kind] = _number(model, effect.parameters[0].name)
    known = {effect.name for effect in (*FRICTIONS, *MASSES)}
    others = [each for each in found if each not in known]
    return Joint(class_name, numbers, (*_notes(model, numbers), *_left_out(others)))


def _number(model: FittedModel, name: str) -> ContactNumber:
    return ContactNumber(model.values[name], model.deviations.get(name, 0.0))


def _notes(model: FittedModel, numbers: dict[str, ContactNumber]) -> list[str]:
    values = model.values
    notes = [
        "for a slide; for a hinge the position must have been the angle in rad, the force the "
        "torque in N m",
        _range(model),
    ]
    untold = [name for name, number in numbers.items() if not number.told]
    if untold:
        notes.append(f"not told, may be 0: {', '.join(untold)}")
    if STRIBECK_FRICTION.name in model.composition.names:
        excess, speed = values[str(BREAKAWAY)], values[str(STRIBECK)]
        notes.append(
            f"MuJoCo has no Stribeck friction: the {engineering(excess, 'N')} that it takes more "
            f"to break away, below some {engineering(speed, 'm/s')}, are left out"
        )
    stiffness = _number(model, str(STIFFNESS)) if str(STIFFNESS) in values else None
    if stiffness is not None and stiffness.told:
        notes.append(
            f"the stiffness {stiffness.text('N/m')} is the tissue's and not in the class: it is "
            "the contact's (`tissue_probe mujoco`), and then the damping is, too"
        )
    if TIP_MASS.name in values:
        mass = _number(model, TIP_MASS.name)
        notes.append(f"the mass {mass.text('kg')} is the body's, and not in the class")
    return notes


def _range(model: FittedModel) -> str:
    """Say where the numbers held, as far as the model's file tells."""
    data = model.data
    if data is None:
        return "the model does not say where its numbers held"
    where = f"fitted to {', '.join(each.name for each in data.files) or 'samples'} on {data.date}"
    if data.fastest is None or data.lowest is None or data.highest is None:
        return where
    between = f"{engineering(data.lowest, 'm')} and {engineering(data.highest, 'm')}"
    return f"{where}: held between {between}, up to {engineering(data.fastest, 'm/s')}"


def _left_out(effects: list[str]) -> list[str]:
    """Say which effects of the model no joint of MuJoCo has."""
    if not effects:
        return []
    return [f"MuJoCo's joint has nothing like {', '.join(effects)}: left out"]
