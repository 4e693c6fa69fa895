"""How far a robot presses, and which part of its wrench that is.

Contents: directions and frames.
"""

from __future__ import annotations

import math

from tissue_probe.recording.robot.settings import UNIT_ROUNDING, RobotDescription
from tissue_probe.settings import SettingsError

Vector = tuple[float, ...]

#: A faster turn is a jump [rad/s]: joints of robots turn by half a turn a second, or little
#: more, and none does so while it palpates.
FASTEST_TURN = 2.0 * math.pi


class Pressing:
    """Displacement into the tissue and force on it, by the user's statements on the robot.

    The displacement of a place p is u = a (p - zero), a the direction of pressing; the force is
    F = d f, d the same direction in the axes of the wrench f. Where a is fixed in the tool it turns
    with it; where wrench and a have different axes, d does.

    Attributes
    ----------
    zero : tuple of float, or None
        Where the displacement is zero, as soon as it is known [m].

    Raises
    ------
    SettingsError
        If the polarity of the force is not stated: the parameters of a robot are complete with it.
    """

    def __init__(self, settings: RobotDescription) -> None:
        self._settings = settings
        self._axis = _unit(settings.axis)
        self._of_wrench = _unit(settings.force_rotation)
        self._sign = _sign(settings)
        self._turns = (settings.axis_frame, settings.force_axes) != ("base", "base")
        self._lever = settings.fastest / FASTEST_TURN
        self.zero: Vector | None = tuple(settings.zero) or None

    def pose(self, place: Vector, orientation: Vector) -> tuple[Vector, Vector]:
        """Return displacement and direction, shape (4,), and the values that may not jump.

        Parameters
        ----------
        place : tuple
            x, y, z in the base [m].
        orientation : tuple
            Quaternion x, y, z, w that turns the tool's axes into the base's.

        Raises
        ------
        ValueError
            If something is not finite, or the orientation none where it is needed.
        """
        if not all(map(math.isfinite, (*place, *orientation))):
            raise ValueError("is not finite")
        axis = along = self._axis
        if self._turns:
            if not abs(math.hypot(*orientation) - 1.0) <= UNIT_ROUNDING:
                raise ValueError("has an orientation that is none: a quaternion has length 1")
            turn = _unit(orientation)
            if self._settings.axis_frame == "tool":
                axis = _turn_vector(self._axis, turn)
            if self._settings.force_axes == "base":
                along = axis
            elif self._settings.axis_frame == "base":
                along = _turn_vector(self._axis, _invert_turn(turn))
        if self.zero is None:
            self.zero = place
        displacement = sum(a * (p - z) for a, p, z in zip(axis, place, self.zero, strict=True))
        # A turn counts as the way of a lever so long that both limits are one.
        return (displacement, *along), (*place, *(self._lever * each for each in (*axis, *along)))

    def travel(self, value: float) -> tuple[Vector, Vector]:
        """Return the same of a joint's value.

        Raises
        ------
        ValueError
            If it is not finite.
        """
        if not math.isfinite(value):
            raise ValueError("is not finite")
        if self.zero is None:
            self.zero = (value,)
        displacement = self._settings.joint_travel * (value - self.zero[0])
        return (displacement, *self._axis), (displacement,)

    def force(self, force: Vector) -> Vector:
        """Return a wrench's force, x, y, z [N], in the axes of the direction, compression positive.

        Raises
        ------
        ValueError
            If it is not finite.
        """
        if not all(map(math.isfinite, force)):
            raise ValueError("is not finite")
        return tuple(self._sign * each for each in _turn_vector(force, self._of_wrench))


def _sign(settings: RobotDescription) -> float:
    """Return the factor that makes a force along the axis positive in compression."""
    if not settings.force_polarity:
        raise SettingsError(
            "parameter force_polarity is not stated: press on something by hand; give compression "
            "where the force along the axis grows then, tension where it falls"
        )
    return -1.0 if settings.force_polarity == "tension" else 1.0


def _unit(values: Vector | list[float]) -> Vector:
    length = math.hypot(*values)
    return tuple(each / length for each in values)


def _invert_turn(turn: Vector) -> Vector:
    x, y, z, w = turn
    return -x, -y, -z, w


def _turn_vector(vector: Vector, turn: Vector) -> Vector:
    """Turn a vector by a unit quaternion: v + 2 w (q x v) + 2 q x (q x v)."""
    x, y, z, w = turn
    once = _cross((x, y, z), vector)
    twice = _cross((x, y, z), once)
    return tuple(v + 2.0 * (w * a + b) for v, a, b in zip(vector, once, twice, strict=True))


def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
