"""Gains of an admittance with stated margins, for ros2_controllers' admittance controller.

Contents: the least damping with which margins hold, and the parameters as the controller declares
them (`admittance_controller_parameters.yaml` of ros2_controllers).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
import yaml

from tissue_probe.contact.contact import Contact
from tissue_probe.contact.loop import Admittance, Margins
from tissue_probe.errors import ParameterError
from tissue_probe.likeness import Alike
from tissue_probe.quantities import SIDE

TOOL_AXES = ("x", "y", "z", "rx", "ry", "rz")
#: Bounds of the controller's declaration [kg], [N/m].
MASSES, SPRINGS = (1e-4, 1e6), (0.0, 1e8)
#: The search for the damping: from how much above the tissue's own answer on, and by which steps. A
#: damper D moves k by the rate k / D: a hundredth of what the delay allows has margins of any size.
DAMPING_BEGINS, DAMPING_STEP, EXACTLY = 100.0, 1.2, 1e-3


@dataclass(frozen=True)
class Gains(Alike):
    """An admittance that keeps its margins on tissue.

    Attributes
    ----------
    admittance : Admittance
        The controller's own mass, damping and spring, with the delay and the lag as stated.
    stiffest : float
        Stiffness for which it was made [N/m].
    margins : Margins
        The least, with the stiffest tissue and any of the dampings that are likely.
    """

    admittance: Admittance
    stiffest: float
    margins: Margins

    @property
    def damping_ratio(self) -> float:
        """The damping as the controller has it: D / (2 sqrt(M S))."""
        own = self.admittance
        return own.damping / (2.0 * math.sqrt(own.mass * own.spring))

    @property
    def notes(self) -> list[str]:
        """The gains and their margins, a line each."""
        own, margins = self.admittance, self.margins
        lag = f", position loop {1e3 * own.lag:.4g} ms" if own.lag else ""
        return [
            f"mass {own.mass:.4g} kg, damping {own.damping:.4g} N s/m, stiffness "
            f"{own.spring:.4g} N/m, on tissue of up to {self.stiffest:.5g} N/m",
            f"delay {1e3 * own.delay:.4g} ms{lag}, force not filtered, joint_damping 0",
            f"gain margin {margins.gain:.3g}, phase margin {np.degrees(margins.phase):.3g} "
            f"degrees, crossover {margins.crossover:.3g} Hz",
        ]

    def parameters(self, axes: Sequence[str], frame: str, node: str) -> dict[str, Any]:
        """Return the controller's parameters.

        Parameters
        ----------
        axes : sequence of str
            Those of ``TOOL_AXES`` along which the robot yields; the tissue was pressed along one.
        frame : str
            The control frame, whose axes they are.
        node : str
            The controller's name.
        """
        own = self.admittance
        # Axes that are not selected have the same numbers: the controller asks for all six.
        admittance = {
            "selected_axes": [each in axes for each in TOOL_AXES],
            "mass": [float(own.mass)] * 6,
            "damping_ratio": [float(self.damping_ratio)] * 6,
            "stiffness": [float(own.spring)] * 6,
            "joint_damping": 0.0,
        }
        parameters = {
            "ft_sensor": {"filter_coefficient": 1.0},
            "control": {"frame": {"id": frame}},
            "admittance": admittance,
        }
        return {node: {"ros__parameters": parameters}}


def design(
    contacts: Sequence[Contact],
    admittance: Admittance,
    gain: float,
    phase: float,
    stiffest: float = 0.0,
) -> Gains:
    """Return the admittance with the least damping with which margins hold, and hold with more.

    Parameters
    ----------
    contacts : sequence of Contact
        Tissues, each with its errors.
    admittance : Admittance
        Mass, spring, delay and lag; its damping is not used.
    gain, phase : float
        Margins asked for: factor; [rad].
    stiffest : float
        A stiffness that is known otherwise, as the map's highest [N/m].

    Raises
    ------
    ParameterError
        If the stiffness of a contact is not told, or no damping holds the margins.
    """
    tissues = [tissue for each in contacts for tissue in _likely(each, stiffest)]

    def held(damping: float) -> Gains:
        made = replace(admittance, damping=damping)
        found = [made.margins(*tissue) for tissue in tissues]
        least = Margins(
            gain=min(each.gain for each in found),
            phase=min(each.phase for each in found),
            crossover=max(each.crossover for each in found),
        )
        return Gains(made, max(tissue[0] for tissue in tissues), least)

    def holds(damping: float) -> bool:
        margins = held(damping).margins
        return margins.gain >= gain and margins.phase >= phase

    late = admittance.delay + admittance.lag
    high = DAMPING_BEGINS * max(
        max(k * late + beta for k, beta in tissues),
        2.0 * np.sqrt(admittance.mass * max(k for k, _ in tissues)),
    )
    if not holds(high):
        raise ParameterError(
            f"`gain_margin` {gain:g} and `phase_margin` {np.degrees(phase):g} are held by no "
            "damping: ask for less, or for a larger `mass` or `stiffness`"
        )
    low = high
    while holds(low / DAMPING_STEP):
        low /= DAMPING_STEP
        if low < high * 1e-9:  # nothing to hold back: any damping does
            return held(low)
    high, low = low, low / DAMPING_STEP
    while high > low * (1.0 + EXACTLY):
        middle = float(np.sqrt(low * high))
        low, high = (low, middle) if holds(middle) else (middle, high)
    return held(high)


def _likely(contact: Contact, stiffest: float) -> list[tuple[float, float]]:
    """Return the stiffest tissue that a contact may be, with the least and most damping."""
    if not contact.stiffness.told:
        raise ParameterError(
            "the stiffness of a contact is not told, so that no gain is safe: press again as "
            "`tissue_probe contact` says"
        )
    stiff = max(contact.stiffness.value + SIDE * contact.stiffness.deviation, stiffest)
    middle, side = contact.damping.value, SIDE * contact.damping.deviation
    return list(product([stiff], sorted({max(middle - side, 0.0), middle + side})))


def text(gains: Gains, contacts: Sequence[Contact], parameters: dict[str, Any]) -> str:
    """Return the YAML file, with the errors and the range of the contacts as comments."""
    lines = ["Gains of an admittance by `tissue_probe admittance`.", *gains.notes]
    for number, contact in enumerate(contacts, 1):
        lines += [f"contact {number}: {contact.notes[0]}", *contact.notes[1:]]
    head = "".join(f"# {line}\n" for line in lines)
    return head + str(yaml.safe_dump(parameters, sort_keys=False, default_flow_style=None))
