"""The experiments that a driver can make where its probe stands, within all limits.

Contents: the bounds of an excitation, the motions within them, the driver's settings for one.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass

from tissue_probe.devices.limits import Limits
from tissue_probe.diagnosis.advice.driver_command import coil_gain
from tissue_probe.diagnosis.advice.separation import (
    PROBE_AMPLITUDE,
    PROBE_EXPERIMENTS,
    PossibleExperiments,
)
from tissue_probe.excitation import EXCITATIONS
from tissue_probe.settings import SettingsError
from tissue_probe.signals import FloatArray

#: Share of a limit that the coil is to reach: where it goes beyond what was measured, force and
#: travel may grow faster than the command, and the driver's own limits stop it.
SHARE_OF_LIMIT = 0.5
#: The quantities of an excitation that are frequencies [Hz].
FREQUENCY_QUANTITIES = {"frequency", "start", "stop"}


@dataclass(frozen=True)
class ExcitationBounds:
    """What the coil may be told.

    Attributes
    ----------
    amplitude : float
        Largest command [V].
    lowest, highest : float
        Frequencies [Hz].
    force, travel : float
        Limits of force [N] and displacement [m] at which the driver stops the coil.
    """

    amplitude: float
    lowest: float
    highest: float
    force: float
    travel: float


@dataclass(frozen=True)
class CoilResponse:
    """How the coil answered to its command in a record.

    Attributes
    ----------
    gain : float
        Way for each volt, both rms [m/V].
    position : float
        Mean displacement [m].
    volts : float
        Largest command [V].
    force, travel : float
        Largest force [N] and displacement [m].
    """

    gain: float
    position: float
    volts: float
    force: float
    travel: float


def find_bounds(
    limits: Limits,
    current_per_volt: float,
    amplitude: float = 0.0,
    lowest: float = 0.0,
    highest: float = 0.0,
) -> ExcitationBounds:
    """Return a driver's own bounds, tightened.

    Of all excitations of one amplitude a sine has the largest root mean square but for a square
    wave, which the driver has not: so a sine's current is held to the limit of that.

    Parameters
    ----------
    limits : Limits
        Of the driver.
    current_per_volt : float
        Current of the coil for each volt [A/V]; 0 where there is none.
    amplitude : float
        Largest command that is allowed besides [V]; 0 for the driver's own.
    lowest, highest : float
        The same of the frequencies [Hz].

    Raises
    ------
    SettingsError
        If no experiment is left.
    """
    current = min(limits.current_limit, math.sqrt(2.0) * limits.rms_current_limit)
    volts = min(limits.command_limit, current / current_per_volt if current_per_volt else math.inf)
    bounds = ExcitationBounds(
        min(volts, amplitude or math.inf),
        lowest,
        highest or math.inf,
        limits.force_limit,
        limits.travel_limit,
    )
    motions = [excitation for excitation, _ in list_motions()]
    if not any(is_within(each, bounds) for each in motions):
        bands = ", ".join(f"{low:g} to {high:g} Hz" for low, high in map(_find_band, motions))
        raise SettingsError(
            f"no experiment is within {lowest:g} to {bounds.highest:g} Hz: give limits that hold "
            f"one of {bands}"
        )
    return bounds


def own_settings(excitation: Mapping[str, object]) -> dict[str, object]:
    """Return the settings of an excitation that count for its kind, of all that a driver has."""
    kind = str(excitation["kind"])
    names = EXCITATIONS[kind].model_fields
    return {name: excitation[name] for name in names if name in excitation}


def refuse_beyond(excitation: Mapping[str, object], bounds: ExcitationBounds) -> None:
    """Refuse an excitation of the driver beyond bounds.

    Raises
    ------
    SettingsError
        If its amplitude or a frequency is.
    """
    own = own_settings(excitation)
    if float(str(own["amplitude"])) <= bounds.amplitude and is_within(own, bounds):
        return
    told = ", ".join(f"{name} {value}" for name, value in own.items())
    raise SettingsError(
        f"the first record is of the driver's own excitation ({told}), which is beyond the limits "
        f"of {bounds.amplitude:g} V, {bounds.lowest:g} to {bounds.highest:g} Hz: lower it, or give "
        "wider limits"
    )


def measure_coil_response(
    position: FloatArray, force: FloatArray, command: FloatArray
) -> CoilResponse:
    """Return how the coil answered in a record.

    Parameters
    ----------
    position, force, command : array, shape (n,)
        Displacement of the coil [m], force [N], voltage commanded [V]; finite.

    Raises
    ------
    SettingsError
        If the coil was not driven, or does not move.
    """
    gain = float(coil_gain(position, command))
    if not gain > 0.0:
        raise SettingsError(
            "the coil is told nothing, or does not move: give the driver an excitation that moves "
            "it, then ask again"
        )
    return CoilResponse(
        gain,
        float(position.mean()),
        float(abs(command).max()),
        float(abs(force).max()),
        float(abs(position).max()),
    )


def find_possible_experiments(
    bounds: ExcitationBounds,
    coil: CoilResponse,
    made: Collection[Mapping[str, object]] = (),
    probability: float = 0.0,
) -> PossibleExperiments:
    """Return the experiments within bounds, at the place where the probe stands.

    Parameters
    ----------
    bounds : ExcitationBounds
        Of command and frequency.
    coil : CoilResponse
        As measured on this specimen.
    made : collection of mapping
        Excitations of the records that there are: what such a motion tells is told.
    probability : float
        That the answer is to have.
    """
    motions = tuple(
        (excitation, coil.position, duration)
        for excitation, duration in list_motions()
        if is_within(excitation, bounds) and not any(_is_alike(excitation, each) for each in made)
    )
    return PossibleExperiments(motions, largest_volts(bounds, coil) * coil.gain, probability)


def list_motions() -> list[tuple[dict[str, object], float]]:
    """Return excitation and duration [s] of each stock experiment once, whatever its preload."""
    found: list[tuple[dict[str, object], float]] = []
    for excitation, _, duration in PROBE_EXPERIMENTS:
        if (excitation, duration) not in found:
            found.append((excitation, duration))
    return found


def is_within(excitation: Mapping[str, object], bounds: ExcitationBounds) -> bool:
    """Whether all frequencies of an excitation are within bounds."""
    low, high = _find_band(excitation)
    return bounds.lowest <= low and high <= bounds.highest


def largest_volts(bounds: ExcitationBounds, coil: CoilResponse) -> float:
    """Return the amplitude of the experiments [V]: the stock way, or what the limits leave of it.

    Force and travel are taken to grow as the command does, up to a share of their limits.
    """
    grows = min(bounds.force / coil.force, bounds.travel / coil.travel)
    return min(PROBE_AMPLITUDE / coil.gain, bounds.amplitude, SHARE_OF_LIMIT * grows * coil.volts)


def _find_band(excitation: Mapping[str, object]) -> tuple[float, float]:
    """Return the lowest and the highest frequency of an excitation [Hz]."""
    found = [float(str(excitation[name])) for name in FREQUENCY_QUANTITIES & {*excitation}]
    return min(found), max(found)


def _is_alike(excitation: Mapping[str, object], made: Mapping[str, object]) -> bool:
    """Whether an excitation is the one of a record, but for its amplitude."""
    others = own_settings({**made, "amplitude": None})
    return own_settings({**excitation, "amplitude": None}) == others
