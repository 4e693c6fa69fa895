"""Contact by force: the tip goes down until the load cell feels the tissue, and no farther.

Contents: the way down, and how it ends.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from pydantic import BaseModel

from tissue_probe.errors import TissueProbeError
from tissue_probe.mapping.touch import Touch
from tissue_probe.nodes.robot import SETPOINT_INTERVAL, Robot
from tissue_probe.settings import setting
from tissue_probe.signals import NANOSECONDS, FloatArray, Leaving

#: Longest wait for a period of the motion in free air [s]: two of the slowest excitation, 0.1 Hz.
FREE_AIR = 20.0


class ContactSettings(BaseModel):
    """How contact is searched."""

    contact_search: float = setting(
        0.0,
        "m",
        "depth above and below the given surface in which contact is searched by force; "
        "0: the surface is where the goal says",
        ge=0.0,
        le=0.05,
    )
    contact_resolution: float = setting(
        1e-4,
        "m",
        "way down in a period of the drive while contact is searched; to this the surface is known",
        gt=0.0,
        le=1e-3,
    )
    contact_force: float = setting(
        0.02,
        "N",
        "change of the steady force over a period that is contact",
        gt=0.0,
        le=1.0,
    )
    contact_force_limit: float = setting(
        3.0, "N", "change of the force at which the tip goes no farther down", gt=0.0, le=100.0
    )


class NotTouched(Exception):
    """No surface was found; the message says why, ``leaving`` in one word."""

    def __init__(self, leaving: Leaving, told: str) -> None:
        super().__init__(told)
        self.leaving = leaving


def lower_to_contact(
    robot: Robot,
    touch: Touch,
    surface: FloatArray,
    normal: FloatArray,
    settings: ContactSettings,
    check: Callable[[], None],
    now: Callable[[], int],
) -> FloatArray:
    """Go down along the normal until contact is felt; return where the tissue's surface is [m].

    Parameters
    ----------
    robot : Robot
        It holds the tip in free air, above the surface.
    touch : Touch
        Fed by ``check`` with the samples from now on.
    surface, normal : array, shape (3,)
        Where the surface is thought to be [m], and its outward normal.
    settings : ContactSettings
        How far down, how fast, and up to which force.
    check : callable
        As in ``Robot.move``.
    now : callable
        Returns the time as the samples' stamps tell it [ns since the epoch].

    Raises
    ------
    NotTouched
        If the tip is in contact before it is lowered, none is felt in the whole depth, or the force
        passes its limit.
    NotMoved
        As ``Robot.move``.
    TissueProbeError
        If the coil does not move, so that nothing can be felt.
    """
    deadline = time.monotonic() + FREE_AIR
    robot.hold(lambda: touch.knows_free_air or time.monotonic() > deadline, check)
    if not touch.knows_free_air:
        raise TissueProbeError(
            f"no period of the coil's motion was seen within {FREE_AIR:g} s, so that contact "
            "cannot be felt: is there an excitation?"
        )

    def careful() -> None:
        check()
        if touch.most > settings.contact_force_limit:
            raise NotTouched(
                Leaving.FORCE_LIMIT,
                f"the force changed by {touch.most:.2f} N before contact was measured, more than "
                f"{settings.contact_force_limit:g} N (contact_force_limit)",
            )

    def stay() -> None:
        """Let a whole period of the samples be of the tip at rest here."""
        # By the samples' own time: they may come late.
        end = now() + round((touch.period + SETPOINT_INTERVAL) * NANOSECONDS)
        robot.hold(lambda: touch.reached >= end, careful)

    depth = settings.contact_search
    above = min(depth, robot.height(surface, normal))
    robot.move(surface + above * normal, careful)
    stay()
    if touch.is_felt:
        raise NotTouched(
            Leaving.IN_CONTACT,
            f"the tip was in contact {1e3 * above:.2f} mm above the given surface, before it was "
            "lowered to find it",
        )
    speed = min(settings.contact_resolution / touch.period, robot.settings.speed)
    if not robot.move(surface - depth * normal, careful, speed, lambda: touch.is_felt):
        stay()
    if not touch.is_felt:
        raise NotTouched(
            Leaving.NO_CONTACT,
            f"no contact was felt down to {1e3 * depth:.2f} mm below the given surface",
        )
    found = surface + robot.height(surface, normal) * normal
    robot.move(found, careful)
    return found
