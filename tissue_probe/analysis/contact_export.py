"""A contact put to use: gains of an admittance controller, and a contact in MuJoCo.

Contents: from a contact or its file to the files of a controller and of a simulator.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tissue_probe import arguments as take
from tissue_probe.analysis.contacting import ContactResult
from tissue_probe.analysis.stiffest import find_stiffest
from tissue_probe.contact import admittance as gains_of
from tissue_probe.contact import mujoco_pair
from tissue_probe.contact.contact import Contact, load
from tissue_probe.contact.loop import Admittance
from tissue_probe.likeness import Alike

if TYPE_CHECKING:
    from tissue_probe.analysis.mapping import MapResult

Given = ContactResult | Contact | str | Path
"""A contact, as itself or by its file."""


def _contact(name: str, given: Any) -> Contact:
    """Take a contact, its result, or the path of its file."""
    if isinstance(given, ContactResult):
        return given.contact
    return given if isinstance(given, Contact) else load(take.path(name, given))


def _contacts(name: str, given: Any) -> list[Contact]:
    """Take a contact or several."""
    if isinstance(given, (list, tuple)):
        if not given:
            take.refuse(name, given, "a contact, or several")
        return [_contact(name, each) for each in given]
    return [_contact(name, given)]


def _bounded(bounds: tuple[float, float], unit: str) -> take.Kind:
    """Take a number above 0 within the controller's bounds."""
    return take.number(above=0.0, least=bounds[0], below=bounds[1], unit=unit)


@dataclass(frozen=True, eq=False, repr=False)
class AdmittanceResult(Alike):
    """Gains of an admittance controller.

    Attributes
    ----------
    gains : Gains
        The admittance and its margins.
    yaml : str
        The controller's parameters, with contacts and margins as comments.
    doubts : tuple of str
        Why contacts may not be as they say, in sentences.
    """

    gains: gains_of.Gains
    yaml: str
    doubts: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """The answer in words."""
        return "\n".join([*self.gains.notes, *self.doubts])

    def __repr__(self) -> str:
        return self.text

    @take.checks(path=take.path)
    def save(self, path: str | Path) -> None:
        """Write the controller's parameters, a file of parameters."""
        Path(path).write_text(self.yaml, encoding="utf-8")


@take.checks(
    mass=_bounded(gains_of.MASSES, "kg"),
    stiffness=_bounded(gains_of.SPRINGS, "N/m"),
    delay=take.number(least=0.0, below=1.0, unit="s"),
    lag=take.number(least=0.0, below=10.0, unit="s"),
    gain_margin=take.number(above=1.0, below=100.0),
    phase_margin=take.number(above=0.0, below=90.0, unit="degrees"),
    axes=take.several(take.choice(*gains_of.TOOL_AXES), "axes"),
    frame=take.text,
    node=take.text,
)
def design_admittance(
    contacts: Given | Sequence[Given],
    *,
    mass: float,
    stiffness: float,
    delay: float,
    lag: float = 0.0,
    stiffest: float | MapResult | str | Path | None = None,
    gain_margin: float = 2.0,
    phase_margin: float = 45.0,
    axes: Sequence[str] = ("z",),
    frame: str = "tool0",
    node: str = "admittance_controller",
) -> AdmittanceResult:
    """Return gains with which an admittance controller presses on tissue with stated margins.

    For ros2_controllers' ``admittance_controller``. The damping is the least with which the margins
    hold; a larger one is safe, and slower.

    Parameters
    ----------
    contacts : ContactResult, path, or a sequence of these
        Tissues; the margins hold on each, its errors counted.
    mass, stiffness : float
        The virtual mass [kg], and the spring that draws back to the commanded pose [N/m].
    delay : float
        From a motion to the force that the controller uses: of sensor, filter, bus, and one and a
        half of the controller's periods [s].
    lag : float
        Time constant of the robot's position loop [s].
    stiffest : float, MapResult, or path, optional
        A stiffness that is known otherwise [N/m]; or a map, as itself or by the file that
        ``tissue_probe map`` writes for programs: the highest upper end of its 95 % intervals.
    gain_margin, phase_margin : float
        By which factor the tissue may be stiffer, and by how much the loop may turn further
        [degrees] (K. Åström and R. Murray, Feedback Systems (2008), section 9.3: 2 to 5, 30 to 60).
    axes : sequence of str
        Along which the robot yields: x, y, z, rx, ry, rz of the frame.
    frame : str
        The controller's control frame.
    node : str
        The controller's name.

    Returns
    -------
    AdmittanceResult

    Raises
    ------
    TissueProbeError
        If a file is no contact or no map, the stiffness is not told, or no damping holds the
        margins.
    """
    tissues = _contacts("contacts", contacts)
    begun = Admittance(mass, damping=1.0, spring=stiffness, delay=delay, lag=lag)
    highest = 0.0 if stiffest is None else find_stiffest("stiffest", stiffest)
    gains = gains_of.design(tissues, begun, gain_margin, math.radians(phase_margin), highest)
    written = gains_of.text(gains, tissues, gains.parameters(axes, frame, node))
    doubts = dict.fromkeys(each.doubt for each in tissues if each.doubt)
    return AdmittanceResult(gains, written, tuple(doubts))


@dataclass(frozen=True, eq=False, repr=False)
class MujocoResult(Alike):
    """A contact for MuJoCo.

    Attributes
    ----------
    pair : Pair
        Geoms and values as MuJoCo takes them.
    xml : str
        The file to include in the model.
    """

    pair: mujoco_pair.Pair
    xml: str

    @property
    def text(self) -> str:
        """The answer in words."""
        made = self.pair
        return "\n".join(
            [
                f"{made.tip} on {made.tissue}: solref {made.solref[0]:.6g} {made.solref[1]:.6g}, "
                f"solimp {' '.join(f'{each:g}' for each in made.solimp)}",
                *made.notes,
            ]
        )

    def __repr__(self) -> str:
        return self.text

    @take.checks(path=take.path)
    def save(self, path: str | Path) -> None:
        """Write the file to include in the model."""
        Path(path).write_text(self.xml, encoding="utf-8")


@take.checks(model=take.path, tip=take.text, tissue=take.text)
def mujoco_contact(contact: Given, model: str | Path, *, tip: str, tissue: str) -> MujocoResult:
    """Return a contact of two geoms in MuJoCo that has a measured stiffness and damping.

    Parameters
    ----------
    contact : ContactResult or path
        The tissue.
    model : path
        The user's model in MJCF: the values depend on the weights of the bodies in it.
    tip, tissue : str
        Names of the geoms.

    Returns
    -------
    MujocoResult

    Raises
    ------
    TissueProbeError
        If MuJoCo is not installed, does not read the model, or it has no such geoms.
    """
    felt = _contact("contact", contact)
    made = mujoco_pair.pair(felt, model, tip, tissue)
    return MujocoResult(made, made.text(felt))
