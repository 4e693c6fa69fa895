"""The constants that turn a probe's volts and counts into SI units and back, as one YAML file.

Contents: the numbers, their intervals, and the two conversions.
"""

from __future__ import annotations

import datetime
from pathlib import Path
from typing import Literal

import numpy as np
import yaml
from numpy.typing import ArrayLike
from pydantic import BaseModel, ConfigDict, model_validator

from tissue_probe import bounded_yaml
from tissue_probe.settings import SettingsError, build, setting
from tissue_probe.signals import FloatArray

FORCE_SIGNS = {"compression": 1.0, "tension": -1.0}


class Tare(BaseModel):
    """A zero of the force that was found in free air during a run."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    stamp: int = setting(..., "ns", "stamp of the first sample that it holds for", ge=0)
    force: float = setting(..., "N", "taken off the calibrated force from then on")


class Calibration(BaseModel):
    """The calibration of one instrument.

    F = polarity * force_per_volt * (V - force_offset_volts) - tare, in compression positive
    u = position_per_count * counts, positive into the tissue
    i = current_per_volt * command
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    date: datetime.date = setting(..., "", "day of the latest step of calibration, as 2026-11-20")
    instruments: dict[str, str] = setting({}, "", "type and serial number of each instrument")
    force_per_volt: float = setting(..., "N/V", "force for each volt of the load cell", gt=0.0)
    force_offset_volts: float = setting(..., "V", "volts of the load cell without load")
    force_polarity: Literal["compression", "tension"] = setting(
        ..., "", "which forces raise the voltage"
    )
    position_per_count: float = setting(
        ..., "m", "displacement for each count; negative if the encoder counts up out of the tissue"
    )
    current_per_volt: float = setting(
        ..., "A/V", "coil current for each volt of the command, at rest", gt=0.0
    )
    tip_mass: float = setting(..., "kg", "mass m of the tip", gt=0.0)
    load_cell_stiffness: float = setting(..., "N/m", "stiffness k0", gt=0.0)
    load_cell_damping: float = setting(..., "N s/m", "damping beta0", ge=0.0)
    force_delay: float = setting(
        0.0,
        "s",
        "by how much the force channel comes after the position channel; taken out of the samples",
        ge=-0.1,
        le=0.1,
    )
    intervals: dict[str, tuple[float, float]] = setting(
        {}, "", "95 % confidence intervals of the quantities above that were measured"
    )
    tares: tuple[Tare, ...] = setting(
        (), "", "zeros found during a run, in order; none in a calibration file"
    )

    @model_validator(mode="after")
    def _go_together(self) -> Calibration:
        if self.position_per_count == 0.0:
            raise ValueError("position_per_count is 0 m: give the displacement for each count")
        for name, (low, high) in self.intervals.items():
            if not isinstance(getattr(self, name, None), float):
                raise ValueError(f"intervals has '{name}', which is no quantity of a calibration")
            if not low <= high:
                raise ValueError(f"the interval of {name} ends before it begins")
        return self

    @staticmethod
    def load(path: str | Path) -> Calibration:
        """Read a calibration file.

        Raises
        ------
        OSError
            If the file cannot be read.
        ValueError
            If it is no calibration; says file, field, and the values that it takes.
        """
        try:
            return _calibration(bounded_yaml.read(path))
        except bounded_yaml.YamlError as error:
            raise ValueError(f"{path} {error}") from None
        except SettingsError as error:
            raise ValueError(f"{path}: {error}") from None

    @staticmethod
    def parse(text: str) -> Calibration:
        """Read a calibration from YAML, as ``text`` writes it.

        Raises
        ------
        SettingsError
            If it is no calibration.
        """
        try:
            return _calibration(bounded_yaml.parse(text))
        except bounded_yaml.YamlError as error:
            raise SettingsError(f"it {error}") from None

    def save(self, path: str | Path) -> None:
        """Write a calibration file, in place of one that is there."""
        Path(path).write_text(self.text, encoding="utf-8")

    @property
    def text(self) -> str:
        """The calibration in YAML, every digit kept."""
        return str(yaml.safe_dump(self.model_dump(mode="json"), sort_keys=False))

    def changed(self, **values: object) -> Calibration:
        """Return this calibration with other values, checked as when it is read.

        Raises
        ------
        SettingsError
            If a value is out of its range.
        """
        return build(Calibration, self.model_dump() | values)

    def force(self, volts: ArrayLike, tare: ArrayLike = 0.0) -> FloatArray:
        """Return the force [N], positive in compression, of load-cell volts."""
        sign = FORCE_SIGNS[self.force_polarity]
        read, at_rest = np.asarray(volts, float), np.asarray(tare, float)
        force: FloatArray = sign * self.force_per_volt * (read - self.force_offset_volts) - at_rest
        return force

    def volts(self, force: ArrayLike, tare: ArrayLike = 0.0) -> FloatArray:
        """Return the load-cell volts of a force [N], positive in compression."""
        sign = FORCE_SIGNS[self.force_polarity]
        whole = np.asarray(force, float) + np.asarray(tare, float)
        volts: FloatArray = sign * whole / self.force_per_volt + self.force_offset_volts
        return volts

    def position(self, counts: ArrayLike) -> FloatArray:
        """Return the displacement [m], positive into the tissue, of encoder counts."""
        return self.position_per_count * np.asarray(counts)

    def counts(self, position: ArrayLike) -> FloatArray:
        """Return the encoder counts of a displacement [m]; whole numbers but for rounding."""
        return np.asarray(position) / self.position_per_count

    def current(self, command: ArrayLike) -> FloatArray:
        """Return the coil current [A] of a command [V], for a coil at rest."""
        return self.current_per_volt * np.asarray(command)

    def tare_at(self, stamps: ArrayLike) -> FloatArray:
        """Return the tare [N] that held at each stamp [ns since the epoch]."""
        forces = np.array([0.0, *(tare.force for tare in self.tares)])
        begins = [tare.stamp for tare in self.tares]
        return forces[np.searchsorted(begins, np.asarray(stamps), side="right")]


def _calibration(values: object) -> Calibration:
    if not isinstance(values, dict):
        raise SettingsError("no calibration: give one 'name: value' a line")
    return build(Calibration, values)
