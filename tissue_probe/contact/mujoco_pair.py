"""A contact for MuJoCo: a pair of geoms that answers with a stiffness and a damping.

MuJoCo's contact is a constraint on accelerations. Of impedance d its force is (MuJoCo's
documentation, Computation, "Constraint model")

    f = d / (1 - d) / w (K d r + B r'),    solref = (-K d^2, -B d)

beside a part d of all other forces at the contact; r is the depth, w the inverse
weight of both bodies, as compiled in the pose of the model. With a small d the rest is a spring and
a damper,

    solref = -(1 - d) w (k, beta),    solimp = d d

Contents: inverse weight and friction of a user's model, the pair and its file.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from tissue_probe.contact.contact import Contact
from tissue_probe.errors import MeasurementError, ParameterError, check_file
from tissue_probe.likeness import Alike

#: d: the smallest that MuJoCo takes (mjMINIMP). The contact takes a part of other forces away that
#: grows with it: the force under an arm is 1 % off at 0.01, and 9 % at 0.1.
IMPEDANCE = 1e-4
#: The depth over which the impedance changes, from d to d, and its course there: MuJoCo's own.
IMPEDANCE_WIDTH, IMPEDANCE_MIDDLE, IMPEDANCE_POWER = 0.001, 0.5, 2.0


@dataclass(frozen=True)
class Pair(Alike):
    """A pair of geoms for MuJoCo.

    Attributes
    ----------
    tip, tissue : str
        Names of the geoms.
    solref : tuple of float
        Stiffness and damping as MuJoCo takes them, below 0.
    condim : int
        Dimensions of the contact, as the geoms have it without the pair.
    friction : tuple of float
        Five coefficients, likewise.
    inverse_weight : float
        w [1/kg].
    notes : tuple of str
        Facts that a user of it needs, in sentences.
    """

    tip: str
    tissue: str
    solref: tuple[float, float]
    condim: int
    friction: tuple[float, ...]
    inverse_weight: float
    notes: tuple[str, ...]

    @property
    def solimp(self) -> tuple[float, ...]:
        """Impedance as MuJoCo takes it."""
        return (IMPEDANCE, IMPEDANCE, IMPEDANCE_WIDTH, IMPEDANCE_MIDDLE, IMPEDANCE_POWER)

    def text(self, contact: Contact) -> str:
        """Return the file, to be included in the model, with the contact's error and range."""
        lines = [
            "Contact by `tissue_probe mujoco`: include it in the model that it was made for.",
            *contact.notes,
            f"inverse weight of both bodies {self.inverse_weight:.6g} 1/kg: another start pose, or "
            "another mass, has another one, and needs another file",
            *self.notes,
        ]
        values = {
            "geom1": self.tissue,
            "geom2": self.tip,
            "condim": str(self.condim),
            "friction": _row(self.friction),
            "solref": _row(self.solref),
            "solimp": _row(self.solimp),
        }
        pair = " ".join(f"{name}={quoteattr(value)}" for name, value in values.items())
        comment = "\n".join(f"  {line}" for line in lines)
        content = f"<!--\n{comment}\n-->\n  <contact>\n    <pair {pair}/>\n  </contact>"
        return f"<mujoco>\n{content}\n</mujoco>\n"


def _row(values: tuple[float, ...]) -> str:
    return " ".join(f"{value:.9g}" for value in values)


def pair(contact: Contact, path: str | Path, tip: str, tissue: str) -> Pair:
    """Return the pair that gives two geoms of a user's model a contact.

    Parameters
    ----------
    contact : Contact
        With its stiffness told.
    path : path
        Of the model in MJCF.
    tip, tissue : str
        Names of the geoms.

    Raises
    ------
    ParameterError
        If MuJoCo is not there, reads no such model, or it has no such geoms.
    MeasurementError
        If the stiffness is not told.
    """
    if not contact.stiffness.told:
        raise MeasurementError(
            "the stiffness of the contact is not told: press again as `tissue_probe contact` says"
        )
    check_file(Path(path))
    mujoco = _mujoco()
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        model = spec.compile()
    except ValueError as error:
        raise ParameterError(f"`model` {path}: MuJoCo does not read it ({error})") from None
    geoms = [
        _geom(mujoco, model, name, which) for name, which in ((tip, "tip"), (tissue, "tissue"))
    ]
    if geoms[0] == geoms[1]:
        raise ParameterError("`tissue` is the `tip`: name two geoms")
    if model.opt.enableflags & mujoco.mjtEnableBit.mjENBL_OVERRIDE:
        raise ParameterError(
            f"`model` {path} overrides all contacts (its flag override is enabled): disable it"
        )
    weight = float(sum(model.body_invweight0[model.geom_bodyid[geom], 0] for geom in geoms))
    if not weight > 0.0:
        raise ParameterError(
            f"`model` {path}: neither {tip} nor {tissue} can move: give one of them a joint"
        )
    scale = (1.0 - IMPEDANCE) * weight
    condim, friction = _touch(model, geoms)
    made = Pair(
        tip,
        tissue,
        solref=(-scale * contact.stiffness.value, -scale * contact.damping.value),
        condim=condim,
        friction=friction,
        inverse_weight=weight,
        notes=_notes(mujoco, model, geoms[0], contact),
    )
    _read_back(mujoco, spec, made)
    return made


def _mujoco() -> Any:
    try:
        import mujoco
    except ImportError:
        raise ParameterError(
            "`model` needs MuJoCo, which is not installed: pip install mujoco"
        ) from None
    return mujoco


def _geom(mujoco: Any, model: Any, name: str, which: str) -> int:
    found = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, name)
    if found < 0:
        names = [model.geom(each).name for each in range(model.ngeom)]
        there = ", ".join(each for each in names if each) or "none with a name"
        raise ParameterError(f"`{which}` {name}: the model has no such geom; it has {there}")
    return int(found)


def _touch(model: Any, geoms: list[int]) -> tuple[int, tuple[float, ...]]:
    """Return dimensions and friction of the contact that the geoms have without a pair.

    Those of the geom of higher priority, else the larger ones.
    """
    first, second = model.geom_priority[geoms]
    deciding = [geom for geom, least in zip(geoms, (second, first), strict=True)
                if model.geom_priority[geom] >= least]  # fmt: skip
    slides, spins, rolls = model.geom_friction[deciding].max(axis=0).tolist()
    return int(model.geom_condim[deciding].max()), (slides, slides, spins, rolls, rolls)


def _notes(mujoco: Any, model: Any, tip: int, contact: Contact) -> tuple[str, ...]:
    notes = [contact.doubt] if contact.doubt else []
    if int(model.geom_type[tip]) not in (
        int(mujoco.mjtGeom.mjGEOM_SPHERE),
        int(mujoco.mjtGeom.mjGEOM_ELLIPSOID),
    ):
        notes.append(
            "a tip that is neither a sphere nor an ellipsoid may touch in several points, each "
            "with all of the stiffness"
        )
    if not contact.damping.told:
        notes.append("the damping is not told: it may be 0")
    return tuple(notes)


def _read_back(mujoco: Any, spec: Any, made: Pair) -> None:
    """Check that MuJoCo takes the values as they are."""
    added = spec.add_pair(geomname1=made.tissue, geomname2=made.tip, condim=made.condim)
    added.solref, added.solimp = made.solref, made.solimp
    added.friction = made.friction
    model = spec.compile()
    if not np.allclose(model.pair_solref[-1], made.solref, rtol=1e-6):
        raise ParameterError("`model`: MuJoCo has changed the values of the pair")
