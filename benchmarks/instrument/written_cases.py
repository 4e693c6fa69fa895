"""Recordings in a folder whose truth is known, by the command line.

Contents: the recordings' names, options and truths, and marks of ``--json``.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import starmap
from pathlib import Path
from tempfile import TemporaryDirectory

from rich.markup import escape
from rich.table import Table

from benchmarks.instrument.case import Truth
from benchmarks.instrument.measure import ONE_THREAD, told
from benchmarks.instrument.outcome import (
    Answer,
    Outcome,
    finds,
    joint_half_width,
    law_is_right,
    off_by,
    off_in_words,
    outside,
    said,
)

_DRIVEN = ("--rig", "force_driven", "--force-polarity", "compression")
_RIGID = ("--rig", "rigid_probe", "--force-polarity", "compression")
_MASSLESS = (*_RIGID, "--constant", "tip_mass=0")
_CUBIC = {"cubic_stiffening": "stiffening"}
#: Errors beyond it are not the noise's; in a record that begins in motion, where the start is told
#: by a few samples only, more.
NOISE, NOISE_IN_MOTION = 1.1, 1.2


@dataclass(frozen=True)
class Written:
    """A recording, how it is asked about, and what is right.

    Attributes
    ----------
    options : tuple of str
        Of the command line.
    truth : Truth
        What is in it.
    second : str
        Name of the recording to validate on; empty for none.
    noise : float
        Largest error on it [m].
    close : float
        Share by which values may be off; where 0 they must be in their intervals.
    finding : tuple of str
        Words of which a finding must have one.
    """

    options: tuple[str, ...]
    truth: Truth
    second: str = ""
    noise: float = 0.0
    close: float = 0.0
    finding: tuple[str, ...] = field(default=())


WRITTEN = {
    "resonance_10_samples": Written(
        (*_DRIVEN, "--starts", "at-rest", "--constant", "contact_position=0+-1e-9"),
        Truth(
            _CUBIC,
            {
                "tip_mass": 0.01, "damping": 0.251327, "stiffness": 3947.84,
                "cubic_stiffness": 3.15028e10,
            },
        ),
        "resonance_10_samples_second", NOISE * 2e-8,
    ),
    "fast_first": Written(
        _DRIVEN,
        Truth(
            _CUBIC,
            {"tip_mass": 0.02, "damping": 0.8, "stiffness": 4200.0, "cubic_stiffness": 9e7},
        ),
        "fast_second", NOISE * 2e-6,
    ),
    "in_motion_first": Written(
        _DRIVEN,
        Truth(
            _CUBIC,
            {
                "tip_mass": 5.377e-6, "damping": 2.2013e-4, "stiffness": 0.99024,
                "cubic_stiffness": 3.96,
            },
        ),
        "in_motion_second", NOISE_IN_MOTION * 2e-4,
    ),
    "plain_zero_off_by_13mm": Written(
        _RIGID, Truth({}, {"stiffness": 420.0, "damping": 1.8}, besides=("offset",)), close=0.03
    ),
    "hertz_zero_off_by_13mm": Written(
        _RIGID,
        Truth(
            {"hertz_contact": "stiffening"},
            # 9500 N/m^1.5 is 9500 sqrt(1 mm) as the secant's stiffness at 1 mm.
            {"stiffness": 9500.0 * 1e-3**0.5, "damping": 1.8, "contact_exponent": 1.5},
        ),
        close=0.03,
    ),
    "rezero_gap": Written(
        _MASSLESS, Truth({}, {"stiffness": 320.0}, besides=("offset",)), close=0.02
    ),
    "sls_and_rezero": Written(
        _MASSLESS,
        Truth(
            {"standard_linear_solid": "relaxation"},
            {"stiffness": 300.0, "relaxing_stiffness": 250.0, "relaxation_rate": 2.0},
            besides=("offset",),
        ),
        close=0.02,
    ),
    "hx711_flips": Written(
        _MASSLESS, Truth({}, {"stiffness": 320.0}), close=0.02,
        finding=("stand alone", "outlier", "sign"),
    ),
    "two_rates": Written(
        (*_MASSLESS, "--starts", "at-rest"), Truth({"generalized_maxwell": "relaxation"}, {})
    ),
}  # fmt: skip


def measure(folder: Path, say: Callable[[str], None] = print) -> list[Outcome]:
    """Return the marks of every recording; those that the folder has not are refused."""
    outcomes = []
    for name, written in WRITTEN.items():
        outcomes.append(_outcome(folder, name, written))
        say(told(outcomes[-1]))
    return outcomes


def table(outcomes: list[Outcome]) -> Table:
    """Return what was said of each recording, and what is wrong with it."""
    right = sum(not each.wrong for each in outcomes)
    shown = Table("recording", "told", "wrong", title_justify="left")
    shown.title = f"Recordings of a folder: {right} of {len(outcomes)} right"
    for each in outcomes:
        shown.add_row(each.kind, escape(each.told), escape("\n".join(each.wrong)), end_section=True)
    return shown


def judge(outcome: Outcome, answer: Answer, written: Written) -> None:
    """Mark an answer for programs."""
    outcome.told = said(answer)
    truth = written.truth
    outcome.mark("law", law_is_right(answer, truth, by_name=True), "another law")
    if written.close:
        off = {name: by for name, by in off_by(answer, truth.values).items() if by > written.close}
        outcome.mark("values", not off, "; ".join(starmap(off_in_words, off.items())))
    elif truth.values:
        missed = outside(answer, truth.values, joint_half_width(len(truth.values)))
        outcome.mark("values", not missed, "; ".join(missed.values()))
    if written.second:
        error = answer["rmse"]["heldout"]["final"]
        kept = answer["carries_over"] is True and error <= written.noise
        outcome.mark(
            "second", kept,
            f"second: {error:.3g} m (at most {written.noise:.3g}), carries_over "
            f"{answer['carries_over']}",
        )  # fmt: skip
    if written.finding:
        outcome.mark("finding", finds(answer, written.finding), "spoilt samples not told")


def _outcome(folder: Path, name: str, written: Written) -> Outcome:
    outcome, began = Outcome("cases", name, 0), time.perf_counter()
    answer = _asked(folder, name, written)
    outcome.seconds = time.perf_counter() - began
    if isinstance(answer, str):
        outcome.told, outcome.refused = answer, True
        outcome.wrong.append("refused")
    else:
        judge(outcome, answer, written)
    return outcome


def _asked(folder: Path, name: str, written: Written) -> Answer | str:
    """Return the answer for programs, or the last line of what was said instead."""
    second = ("--validate", str(folder / f"{written.second}.csv")) if written.second else ()
    with TemporaryDirectory() as own:
        path = Path(own) / "answer.json"
        command = [
            sys.executable, "-m", "tissue_probe", "diagnose", str(folder / f"{name}.csv"),
            *written.options, *second, "--json", str(path),
        ]  # fmt: skip
        ended = subprocess.run(
            command, env={**os.environ, **ONE_THREAD}, capture_output=True, text=True
        )
        if path.exists():
            answer: Mapping[str, object] = json.loads(path.read_text())
            return answer
    return (ended.stderr.strip() or ended.stdout.strip() or "no answer").splitlines()[-1]
