"""Make the recordings in this folder, from the simulator of the challenge.

Run as ``python examples/make.py``; an optional argument names another folder. The simulator shares
no code with the models that are fitted. The same files come out each time, but for the last digits
on another processor.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from tissue_probe.challenge.record import follow
from tissue_probe.challenge.simulator import SimulatedRecord, make_challenge
from tissue_probe.recording.bags.samples_bag import write_samples_bag
from tissue_probe.signals import NANOSECONDS, PalpationSite, Phase, SampleBlock

RATE = 2000.0
#: A day in 2026, so that the recordings' times look like times [ns since the epoch].
BEGIN = 1_780_000_000 * NANOSECONDS
#: The simulator draws a tissue by its seed: these have 436 to 503 N/m, and 1038 and 1119 N/m.
SOFT, STIFF = (47, 17, 8), {5: 1, 6: 28}


def main(folder: Path) -> None:
    """Write every example into a folder; files that are there are replaced."""
    folder.mkdir(parents=True, exist_ok=True)
    write_pair(folder)
    relaxing = moved("relaxation", ramp_and_hold(), ("standard_linear_solid",), seed=7)
    write_table(folder / "relaxation.csv", relaxing, every=4)
    cyclic = moved("cyclic", triangles(), ("hunt_crossley",), seed=21)
    write_table(folder / "cyclic.csv", cyclic, every=4)
    write_export(folder / "testing_machine.csv", cyclic, every=20)
    write_scan(folder / "scan.mcap")
    write_weights(folder)


def write_pair(folder: Path) -> None:
    """Write a sweep on tissue with a hidden effect, and a second recording of the same specimen."""
    made = make_challenge(25, ("hertz_contact",), "chirp60", "tolerant")
    write_table(folder / "sweep.csv", made.recording)
    write_table(folder / "sweep_second.csv", made.second)


def ramp_and_hold() -> np.ndarray:
    """Go in by 1.5 mm within 0.2 s, and hold for 5 s [m]."""
    time = np.arange(round(5.2 * RATE)) / RATE
    share = np.clip(time / 0.2, 0.0, 1.0)
    return 1.5e-3 * share**3 * (10.0 - 15.0 * share + 6.0 * share**2)


def triangles() -> np.ndarray:
    """Go in by 2 mm and out again at a constant rate, once in 2 s, five times [m]."""
    time = np.arange(round(10.0 * RATE)) / RATE
    return 2e-3 * (1.0 - np.abs(time % 2.0 - 1.0))


def moved(name: str, position: np.ndarray, effects: tuple[str, ...], seed: int) -> SimulatedRecord:
    """Return the recording of a coil that moves so, from rest."""
    time = np.arange(position.size) / RATE
    motion = follow(time, position, name, at_rest=True)
    return make_challenge(seed, effects, motion, "exact").recording


def write_table(path: Path, measured: SimulatedRecord, every: int = 1) -> None:
    """Write time [s], position [m] and force [N], positive in compression."""
    columns = (measured.time, measured.position, measured.force)
    rows = np.column_stack([column[::every] for column in columns])
    formats = ("%.4f", "%.7f", "%.5f")
    np.savetxt(path, rows, fmt=formats, delimiter=",", header="t,u,F", comments="")


def write_export(path: Path, measured: SimulatedRecord, every: int) -> None:
    """Write as a testing machine does: a preamble, a row of units, decimal commas, tension."""
    lines = ["Specimen;Gelatine 10 %", "Operator;A. Nother", "Date;2026-05-28", ""]
    lines += ["Time;Extension;Load", "(s);(mm);(N)"]
    columns = (measured.time, 1e3 * measured.position, -measured.force)
    for row in zip(*(column[::every] for column in columns), strict=True):
        lines.append(";".join(f"{value:.4f}" for value in row).replace(".", ","))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_scan(path: Path) -> None:
    """Write a scan of 4 x 4 sites, 8 mm apart, a quarter second each; two of them are stiffer."""
    path.unlink(missing_ok=True)
    time = np.arange(round(0.5 * RATE)) / RATE
    motion = follow(time, 1e-3 * np.sin(2 * np.pi * 10.0 * time), "sine", at_rest=False)
    blocks, sites = [], []
    for site in range(16):
        row, column = divmod(site, 4)
        seed = STIFF.get(site, SOFT[site % len(SOFT)])
        taken = make_challenge(seed, (), motion, "exact", preload=0.0).recording
        begin, first = BEGIN + site * NANOSECONDS, site * taken.force.size
        unknown = np.full(taken.force.size, np.nan)
        blocks.append(SampleBlock(begin, first, 1.0 / RATE, taken.position, taken.force, unknown))
        place = (8e-3 * column, 8e-3 * row, 0.0)
        end = begin + round(taken.force.size / RATE * NANOSECONDS)
        sites += [
            PalpationSite(begin, site, place, Phase.DWELL),
            PalpationSite(end, site, place, Phase.LIFTED),
        ]
    write_samples_bag(path, blocks, sites)


def write_weights(folder: Path) -> None:
    """Write the load cell's volts under known weights: 0.5 V/N, 20 mV without load, 5 mN noise."""
    random = np.random.default_rng(1)
    for kilograms in (0.0, 0.1, 0.2, 0.5):
        volts = 0.02 + 0.5 * 9.80665 * kilograms + 2.5e-3 * random.standard_normal(1000)
        rows = np.column_stack([np.arange(volts.size) / RATE, volts])
        path = folder / f"weight_{kilograms:g}.csv"
        np.savetxt(path, rows, fmt="%.5f", delimiter=",", header="t,V", comments="")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
