"""How right stiffness and damping under an arm in MuJoCo are, and a contact written for MuJoCo.

Contents: the rows of both tables, their seeds and goals, the marks.

Each seed draws its own tool, bias, drift and motion. The sensor is identified from 60 s of free
air; its file gives mass, delay and drift to the identification of the contact, which knows nothing
of the force's zero nor of the place of touch. Nothing was chosen by seeds from ``FIRST`` on.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from rich.table import Table

import tissue_probe as tp
from benchmarks.live_loop import simulated
from benchmarks.live_loop.arm import Tissue, World
from benchmarks.live_loop.free_air import EPOCH, IDENTIFIED, WITHIN, runs_of
from tissue_probe.contact.contact import Contact, ContactNumber
from tissue_probe.sensor.compensation import compensation, save
from tissue_probe.sensor.identify import identify

FIRST = 1000
DAMPING = 3.0  # N s/m
#: Stiffness [N/m], and how long is pressed [s].
ROWS = ((300.0, 10.0), (1000.0, 2.0), (3000.0, 2.0))
#: Largest error of the stiffness.
GOAL = 0.03


@dataclass(frozen=True)
class Mark:
    """What one seed of a row got: errors relative to the truth, and whether the intervals held."""

    row: str
    seed: int
    verdict: str
    stiffness: float
    damping: float
    stiffness_deviation: float
    damping_deviation: float
    stiffness_held: bool
    damping_held: bool


@dataclass(frozen=True)
class Simulated:
    """What MuJoCo made of a contact: errors of stiffness, damping and force, relative."""

    model: str
    stiffness: float
    error_of_stiffness: float
    error_of_damping: float
    error_of_force: float


def measure(count: int, first: int = FIRST) -> list[Mark]:
    """Return the marks of so many seeds of each row."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sensor.yaml"
        return [mark for seed in range(first, first + count) for mark in _marks(seed, path)]


def _marks(seed: int, path: Path) -> list[Mark]:
    world = World(seed)
    air = runs_of(world.move(0.0, IDENTIFIED), joints=False)
    save(path, compensation(identify(air), air, EPOCH))
    return [_mark(world, seed, k, seconds, path) for k, seconds in ROWS]


def _mark(world: World, seed: int, stiffness: float, seconds: float, path: Path) -> Mark:
    measured, axis = world.press(IDENTIFIED, seconds, Tissue(stiffness, DAMPING))
    table = {
        "t": measured.time - measured.time[0],
        "position": (measured.position - measured.position[0]) @ axis,
        "force": -measured.wrench[:, 2],
    }
    found = tp.identify_contact(tp.read(table, force_polarity="compression"), sensor=path).contact
    k, beta = found.stiffness, found.damping
    return Mark(
        row=f"{stiffness:g} N/m, {seconds:g} s",
        seed=seed,
        verdict=found.verdict,
        stiffness=k.value / stiffness - 1.0,
        damping=beta.value / DAMPING - 1.0,
        stiffness_deviation=k.deviation / stiffness,
        damping_deviation=beta.deviation / DAMPING,
        stiffness_held=abs(k.value - stiffness) < WITHIN * k.deviation,
        damping_held=abs(beta.value - DAMPING) < WITHIN * beta.deviation,
    )


def simulate() -> list[Simulated]:
    """Return what MuJoCo makes of contacts, on a slider and on the arm."""
    models = {"slider": simulated.slider, "arm": simulated.arm}
    return [_felt(name, make, k) for name, make in models.items() for k, _ in ROWS]


def _felt(name: str, make: Callable[[str], str], stiffness: float) -> Simulated:
    known = ContactNumber(stiffness, 0.01 * stiffness), ContactNumber(DAMPING, 0.1 * DAMPING)
    contact = Contact(
        "adequate", *known, ContactNumber(0.8, 0.0), ContactNumber(0.0, 0.0), *[1.0] * 7
    )
    with tempfile.TemporaryDirectory() as folder:
        bare, whole = Path(folder) / "bare.xml", Path(folder) / "whole.xml"
        bare.write_text(make(""))
        whole.write_text(make('<include file="contact.xml"/>'))
        made = tp.mujoco_contact(contact, bare, tip="tip", tissue="tissue")
        made.save(Path(folder) / "contact.xml")
        felt = simulated.feel(whole, stiffness, DAMPING)
    return Simulated(
        name, stiffness, felt.stiffness / stiffness - 1.0, felt.damping / DAMPING - 1.0, felt.error
    )


def kept(marks: list[Mark], simulations: list[Simulated]) -> dict[str, object]:
    """Return both as plain values."""
    return {
        "marks": [asdict(mark) for mark in marks],
        "simulated": [asdict(each) for each in simulations],
    }


def tables(marks: list[Mark], simulations: list[Simulated]) -> list[Table]:
    """Return both as tables."""
    found = Table(title="Contact of the arm: errors of stiffness and damping")
    for name in (
        *("tissue", "seeds", "k within 3 % (goal 95 %)", "k: rms, worst", "k: stated"),
        *("beta: rms, worst", "beta: stated", "k held", "beta held (goal 90 %)", "verdicts"),
    ):
        found.add_column(name)
    for row in dict.fromkeys(mark.row for mark in marks):
        found.add_row(row, *_cells([mark for mark in marks if mark.row == row]))
    made = Table(title="The same contacts in MuJoCo (goal 1 %)")
    for name in ("model", "k [N/m]", "error of k", "of beta", "of the force, rms"):
        made.add_column(name)
    for each in simulations:
        errors = each.error_of_stiffness, each.error_of_damping, each.error_of_force
        made.add_row(each.model, f"{each.stiffness:g}", *(f"{100 * e:.3f} %" for e in errors))
    return [found, made]


def _cells(marks: list[Mark]) -> list[str]:
    k, beta = (
        np.array([getattr(mark, name) for mark in marks]) for name in ("stiffness", "damping")
    )
    stated = [
        np.mean([getattr(mark, f"{name}_deviation") for mark in marks])
        for name in ("stiffness", "damping")
    ]
    held = [
        sum(getattr(mark, f"{name}_held") for mark in marks) for name in ("stiffness", "damping")
    ]
    verdicts = [mark.verdict for mark in marks]
    return [
        str(len(marks)),
        str(sum(abs(k) <= GOAL)),
        _errors(k),
        f"{100 * stated[0]:.2f} %",
        _errors(beta),
        f"{100 * stated[1]:.1f} %",
        *map(str, held),
        ", ".join(f"{verdicts.count(each)} {each}" for each in sorted(set(verdicts))),
    ]


def _errors(errors: np.ndarray) -> str:
    rms = np.sqrt(np.mean(errors**2))
    return f"{100 * rms:.2f}, {100 * np.abs(errors).max():.2f} %"
