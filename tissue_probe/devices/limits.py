"""The limits while the coil is driven, and how samples are checked."""

from __future__ import annotations

import math
import time

import numpy as np
from pydantic import BaseModel, ConfigDict

from tissue_probe.devices.device import Samples
from tissue_probe.devices.limit_codes import (
    COMMAND,
    CURRENT,
    FORCE,
    HEAT,
    HEATING,
    NONE,
    POSITION,
    RATE,
    SATURATION,
    STUCK,
    TRAVEL,
    UNKNOWN,
)
from tissue_probe.excitation import Excitation
from tissue_probe.settings import setting
from tissue_probe.signals import LONGEST_SILENCE, NANOSECONDS

#: Longest silence between two signs of life that a scan node promises while the tip may be in the
#: tissue [s]: fifty of its steps, and as long as a silent DAQ is borne (``stale_limit``). A watcher
#: of it may allow more, not less: nobody can be held to more than was promised.
PALPATION_LEASE = LONGEST_SILENCE / NANOSECONDS

ADVICE = "the coil is at zero; look at the probe before you reset and activate it again"


class Limits(BaseModel):
    """The limits while the coil is driven."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    force_limit: float = setting(
        8.0,
        "N",
        "largest force on the load cell, either way; above it the coil goes to zero",
        gt=0.0,
        le=22.0,
    )
    force_rate_limit: float = setting(
        2000.0,
        "N/s",
        "fastest change of the force from one sample to the next, either way",
        gt=0.0,
        le=1e5,
    )
    travel_limit: float = setting(
        0.006,
        "m",
        "largest displacement of the coil, either way; beyond it the coil goes to zero",
        gt=0.0,
        le=0.0065,
    )
    command_limit: float = setting(
        5.0,
        "V",
        "largest voltage on the coil, either way; an excitation above it is refused",
        gt=0.0,
        le=10.0,
    )
    current_limit: float = setting(
        1.4,
        "A",
        "largest coil current by the calibration's current_per_volt, either way",
        gt=0.0,
        le=10.0,
    )
    rms_current_limit: float = setting(
        0.7, "A", "largest root mean square of the coil current over heating_time", gt=0.0, le=10.0
    )
    heating_time: float = setting(
        10.0, "s", "time constant with which the coil's heating is averaged", gt=0.0, le=600.0
    )
    stuck_limit: float = setting(
        0.3,
        "V",
        "the encoder is stuck if the command changes by more while the position does not at all",
        gt=0.0,
        le=20.0,
    )
    stale_limit: float = setting(
        0.5,
        "s",
        "longest time without a sample, or with force or position unknown",
        gt=0.0,
        le=5.0,
    )
    palpation_timeout: float = setting(
        PALPATION_LEASE,
        "s",
        "longest silence of the scan node from a site's APPROACH to LIFTED, and of the node "
        "identify while the excitation is changed for a record",
        ge=PALPATION_LEASE,
        le=5.0,
    )


class LimitExceeded(RuntimeError):
    """A limit was passed; the coil is at zero.

    Attributes
    ----------
    samples : Samples or None
        The samples read with it, since they show the event; None where none were.
    """

    def __init__(self, reason: str, samples: Samples | None = None) -> None:
        super().__init__(reason)
        self.samples = samples


class LimitMonitor:
    """Judges excitations before and samples after they are played.

    Parameters
    ----------
    limits : Limits
        The limits.
    sample_period : float
        Time between two samples [s].
    current_per_volt : float
        Coil current for each volt of the command, for a coil at rest [A/V].
    force_range : tuple of float
        Smallest and largest force that can be measured [N]; at these the true force is unknown.
    """

    def __init__(
        self,
        limits: Limits,
        sample_period: float,
        current_per_volt: float,
        force_range: tuple[float, float] = (-math.inf, math.inf),
    ) -> None:
        self._period = sample_period
        self._current_per_volt = current_per_volt
        self._force_range = force_range
        self._state = np.zeros(6)
        self._ended = time.monotonic()
        self.limits = limits
        # Nodes that need no more than the settings are spared Numba, which takes a second.
        from tissue_probe.devices.limit_check import first_passed

        self._first_passed = first_passed
        nothing = np.zeros(1)
        # Compiled, or loaded from the cache, before the clock runs.
        first_passed(nothing, nothing, nothing, self._state, self._bounds)
        self._state[:] = 0.0
        self.begin()

    @property
    def limits(self) -> Limits:
        """The limits; may be replaced at any time, for the next samples."""
        return self._limits

    @limits.setter
    def limits(self, limits: Limits) -> None:
        self._limits = limits
        self._bounds = (
            *self._force_range,
            limits.force_limit,
            limits.force_rate_limit * self._period,
            limits.travel_limit,
            limits.command_limit,
            limits.current_limit,
            limits.rms_current_limit**2,
            limits.stuck_limit,
            limits.stale_limit / self._period,
            self._current_per_volt,
            math.exp(-self._period / limits.heating_time),
        )

    def begin(self) -> None:
        """Expect sample 0 of an activation; the coil has cooled down since the last one."""
        pause = time.monotonic() - self._ended
        heat = self._state[HEAT] * math.exp(-pause / self._limits.heating_time)
        self._state[:] = math.nan, math.nan, math.inf, -math.inf, heat, 0.0

    def judge_excitation(self, excitation: Excitation) -> None:
        """Raise LimitExceeded if the excitation would pass a limit of command or current."""
        limits, amplitude = self.limits, excitation.amplitude
        if amplitude > limits.command_limit:
            raise LimitExceeded(
                f"the excitation's amplitude is {amplitude:g} V, above the command limit of "
                f"{limits.command_limit:g} V: lower it"
            )
        current = amplitude * self._current_per_volt
        if current > limits.current_limit:
            raise LimitExceeded(
                f"the excitation's amplitude of {amplitude:g} V is {current:.3g} A in the coil, "
                f"above the current limit of {limits.current_limit:g} A: lower it"
            )

    def judge(self, samples: Samples) -> None:
        """Raise LimitExceeded, with the samples, if they passed a limit.

        NaN passes none: it was measured so, and those who use it say so. But it may not last.
        """
        self._ended = time.monotonic()
        passed, value = self._first_passed(
            np.ascontiguousarray(samples.position),
            np.ascontiguousarray(samples.force),
            np.ascontiguousarray(samples.command),
            self._state,
            self._bounds,
        )
        if passed != NONE:
            raise LimitExceeded(f"{self._describe_limit(passed, value)}: {ADVICE}", samples)

    def _describe_limit(self, passed: int, value: float) -> str:
        limits = self._limits
        if passed == SATURATION:
            low, high = self._force_range
            return (
                f"the load cell's input is saturated, at {low:.4g} or {high:.4g} N, and the true "
                "force unknown"
            )
        if passed == STUCK:
            return (
                f"the encoder stayed at {self._state[POSITION]:.7g} m while the command changed by "
                f"{value:.3g} V, so it or the coil is stuck"
            )
        if passed == UNKNOWN:
            return (
                f"force or position were unknown for {value * self._period:.3g} s, beyond the "
                f"limit of {limits.stale_limit:g} s"
            )
        name, limit, unit = {
            FORCE: ("force", limits.force_limit, "N"),
            RATE: ("rate of the force", limits.force_rate_limit, "N/s"),
            TRAVEL: ("position", limits.travel_limit, "m"),
            COMMAND: ("command", limits.command_limit, "V"),
            CURRENT: ("coil current", limits.current_limit, "A"),
            HEATING: ("root mean square of the coil current", limits.rms_current_limit, "A"),
        }[passed]
        if passed == RATE:
            value /= self._period
        return f"the {name} was {value:.4g} {unit}, beyond its limit of {limit:g} {unit}"
