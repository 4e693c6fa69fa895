"""The file that the steps of ``tissue_probe calibrate`` share: read, updated, and told."""

from __future__ import annotations

import datetime
from collections.abc import Sequence
from pathlib import Path

from tissue_probe.configuration import stock_configuration
from tissue_probe.devices.calibration import Calibration
from tissue_probe.identification.line import Interval
from tissue_probe.settings import meaning


def load(path: Path) -> Calibration:
    """Return the calibration of a file, or the nominal values where there is no file yet.

    Raises
    ------
    ValueError
        If the file is no calibration.
    """
    return Calibration.load(path if path.exists() else stock_configuration("calibration.yaml"))


def update(
    path: Path,
    instruments: Sequence[str],
    values: dict[str, float | str],
    intervals: dict[str, Interval],
) -> None:
    """Write newly measured values, their intervals and the day into a file, and name the new ones.

    Parameters
    ----------
    path : Path
        The file; made if not there.
    instruments : sequence of str
        Each ``name=serial``.
    values : dict
        By the name of a field of ``Calibration``.
    intervals : dict
        95 % intervals; a value without one loses its former one, too.

    Raises
    ------
    ValueError
        If the file is no calibration, an instrument is written otherwise, or a value is out of
        its range; the file stays as it was.
    """
    before = load(path)
    kept = {name: each for name, each in before.intervals.items() if name not in values}
    changed = before.changed(
        **values,
        intervals={**kept, **intervals},
        instruments={**before.instruments, **dict(_serial(each) for each in instruments)},
        date=datetime.date.today(),
    )
    changed.save(path)
    for name in values:
        print(_describe_constant(changed, name))
    print(f"Written to {path}")


def _serial(given: str) -> tuple[str, str]:
    name, equals, serial = given.partition("=")
    if not equals:
        raise ValueError(f"--instrument {given}: write NAME=SERIAL")
    return name.strip(), serial.strip()


def _describe_constant(calibration: Calibration, name: str) -> str:
    value = getattr(calibration, name)
    told = f"{name} = {value:.6g}" if isinstance(value, float) else f"{name} = {value}"
    if name in calibration.intervals:
        low, high = calibration.intervals[name]
        told += f" (95 %: {low:.6g} to {high:.6g})"
    return f"{told}: {meaning(Calibration.model_fields[name])}"
