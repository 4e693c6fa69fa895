"""A driver whose simulated probe writes every voltage on its coil to a file, and fails on demand.

Run as a program with the driver's arguments. WITNESS names the file; WITNESS_FAILS_AFTER, if set,
is the number of samples after which reading fails; -1 fails while it is configured.
"""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from tissue_probe.devices.registry import DEVICES
from tissue_probe.devices.simulated import SimulatedProbe


class Witness(SimulatedProbe):
    """The simulated probe; each change of the coil's voltage becomes a line of the file."""

    @property
    def commanded_voltage(self) -> float:
        return self._voltage

    @commanded_voltage.setter
    def commanded_voltage(self, value: float) -> None:
        self._voltage = value
        with Path(os.environ["WITNESS"]).open("a") as file:
            file.write(f"{value}\n")

    @property
    def description(self):
        self._fail_after(-1)
        return super().description

    def read(self, count):
        self._fail_after(self._taken)
        return super().read(count)

    def _fail_after(self, taken):
        if taken >= int(os.environ.get("WITNESS_FAILS_AFTER", "1000000000")):
            raise ZeroDivisionError("a fault that nobody foresaw")


if __name__ == "__main__":
    DEVICES["simulated"] = replace(DEVICES["simulated"], place="__main__:Witness")
    from tissue_probe.nodes.driver import main

    raise SystemExit(main())
