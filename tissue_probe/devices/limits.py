"""What must not be passed while the coil is driven, and how it is told from samples."""

from __future__ import annotations

import math
import time

import numpy as np
from pydantic import BaseModel, ConfigDict

from tissue_probe.devices.device import Samples
from tissue_probe.excitation import Excitation
from tissue_probe.settings import setting
from tissue_probe.signals import FloatArray

ADVICE = "the coil is at zero; look at the probe before you reset and activate it again"


class Limits(BaseModel):
    """What must not be passed while the coil is driven."""

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


class LimitExceeded(RuntimeError):
    """A limit was passed; the coil is at zero.

    Attributes
    ----------
    samples : Samples or None
        What was read with it, since it shows what happened; None where nothing was.
    """

    def __init__(self, reason: str, samples: Samples | None = None) -> None:
        super().__init__(reason)
        self.samples = samples


class LimitMonitor:
    """Judges excitations before and samples after they are played.

    Parameters
    ----------
    limits : Limits
        What must not be passed.
    sample_period : float
        Time between two samples [s].
    current_per_volt : float
        Coil current for each volt of the command, for a coil at rest [A/V].
    force_range : tuple of float
        Smallest and largest force that can be measured [N]; at these the true force is unknown.

    Attributes
    ----------
    limits : Limits
        May be replaced at any time; the next samples are judged by them.
    """

    def __init__(
        self,
        limits: Limits,
        sample_period: float,
        current_per_volt: float,
        force_range: tuple[float, float] = (-math.inf, math.inf),
    ) -> None:
        self.limits = limits
        self._period = sample_period
        self._current_per_volt = current_per_volt
        self._force_range = force_range
        self._heat = 0.0  # mean square of the current [A^2]
        self._ended = time.monotonic()
        self.begin()

    def begin(self) -> None:
        """Expect sample 0 of an activation; the coil has cooled down since the last one."""
        pause = time.monotonic() - self._ended
        self._heat *= math.exp(-pause / self.limits.heating_time)
        self._force = math.nan
        self._position = math.nan
        self._still_commands = (math.inf, -math.inf)
        self._unknown = 0

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

        NaN passes none: it is what was measured, and those who use it say so. But it may not last.
        """
        self._ended = time.monotonic()
        limits = self.limits
        try:
            self._judge_saturation(samples.force)
            _judge("force", samples.force, limits.force_limit, "N")
            steps = np.diff(samples.force, prepend=self._force)
            _judge("rate of the force", steps / self._period, limits.force_rate_limit, "N/s")
            _judge("position", samples.position, limits.travel_limit, "m")
            _judge("command", samples.command, limits.command_limit, "V")
            current = self._current_per_volt * samples.command
            _judge("coil current", current, limits.current_limit, "A")
            self._judge_heating(current)
            self._judge_encoder(samples)
            self._judge_unknown(samples)
        except LimitExceeded as exceeded:
            exceeded.samples = samples
            raise
        self._force = samples.force[-1]

    def _judge_saturation(self, force: FloatArray) -> None:
        low, high = self._force_range
        if np.any((force <= low) | (force >= high)):
            raise LimitExceeded(
                f"the load cell's input is saturated, at {low:.4g} or {high:.4g} N, and the true "
                f"force unknown: {ADVICE}"
            )

    def _judge_heating(self, current: FloatArray) -> None:
        """Average the squared current with one time constant, as a coil's temperature does."""
        keep = math.exp(-self._period / self.limits.heating_time)
        for square in np.square(current).tolist():
            self._heat = keep * self._heat + (1.0 - keep) * square
        _judge(
            "root mean square of the coil current",
            np.array([math.sqrt(self._heat)]),
            self.limits.rms_current_limit,
            "A",
        )

    def _judge_encoder(self, samples: Samples) -> None:
        for position, command in zip(
            samples.position.tolist(), samples.command.tolist(), strict=True
        ):
            if position != self._position:  # NaN, too, is no standstill
                self._position = position
                self._still_commands = (command, command)
                continue
            low, high = self._still_commands
            self._still_commands = low, high = min(low, command), max(high, command)
            if high - low > self.limits.stuck_limit:
                raise LimitExceeded(
                    f"the encoder stayed at {position:.7g} m while the command changed by "
                    f"{high - low:.3g} V, so it or the coil is stuck: {ADVICE}"
                )

    def _judge_unknown(self, samples: Samples) -> None:
        known = np.flatnonzero(np.isfinite(samples.force) & np.isfinite(samples.position))
        count = samples.force.size
        self._unknown = count - 1 - known[-1] if known.size else self._unknown + count
        if self._unknown * self._period > self.limits.stale_limit:
            raise LimitExceeded(
                f"force or position were unknown for {self._unknown * self._period:.3g} s, beyond "
                f"the limit of {self.limits.stale_limit:g} s: {ADVICE}"
            )


def _judge(name: str, values: FloatArray, limit: float, unit: str) -> None:
    beyond = np.flatnonzero(np.abs(values) > limit)
    if beyond.size:
        raise LimitExceeded(
            f"the {name} was {values[beyond[0]]:.4g} {unit}, beyond its limit of {limit:g} {unit}: "
            f"{ADVICE}"
        )
