"""The shape of hidden forces, learnt and tried on a second record.

Contents: one record's outcome, and the rows of all.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import count, product
from typing import Any

import numpy as np

from benchmarks.free_form.cases import EXCITATIONS, STRENGTHS, TERMS, Record, record
from tissue_probe.challenge.instrument import CHALLENGE_RATE, FORCE_NOISE
from tissue_probe.diagnosis.diagnosis import fit_plainly
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.other_runs import carry_model
from tissue_probe.diagnosis.shape.free_functions import in_order
from tissue_probe.diagnosis.shape.shape_report import FoundShape, find_shape
from tissue_probe.physics.composition import Composition
from tissue_probe.signals import BoolArray

RIG = "compliant_probe"
#: The rig is known, and its load cell has white noise only.
KNOWN = Instrument(RIG, flicker_noise=0.0).exact()
#: Clean records for each excitation.
CLEAN = 2
#: Errors on the second record over the noise that count as right, and as far off.
RIGHT, FAR = 1.15, 1.5


@dataclass(frozen=True)
class Outcome:
    """What was learnt of one record.

    ``second`` is the error of the learnt effect on the second record over the noise, inside the
    range that the first one visited; None where no shape is claimed, or none is told.
    """

    term: str
    excitation: str
    strength: float
    seed: int
    truth: tuple[str, ...]
    variables: tuple[str, ...]
    alternatives: tuple[tuple[str, ...], ...]
    claimed: bool
    told: bool
    over_noise: float
    heldout_over_noise: float
    second: float | None
    formula: str
    seconds: float


def outcomes(first_seed: int, terms: tuple[str, ...] = tuple(TERMS)) -> Iterator[Outcome]:
    """Yield each term under each excitation, at strengths in turn, then clean records."""
    seeds = count(first_seed)
    for (row, term), (column, excitation) in product(enumerate(terms), enumerate(EXCITATIONS)):
        strength = STRENGTHS[(row + column) % len(STRENGTHS)]
        yield outcome(term, excitation, strength, next(seeds))
    for excitation, _ in product(EXCITATIONS, range(CLEAN)):
        yield outcome("clean", excitation, 1.0, next(seeds))


def outcome(term: str, excitation: str, strength: float, seed: int) -> Outcome:
    """Learn the shape of one record."""
    made = record(term, excitation, strength, seed)
    still = excitation != "sine10ss"
    measured = Measurement(*made.first, 1.0 / CHALLENGE_RATE, at_rest=still)
    base = fit_plainly(Composition(RIG), [measured], KNOWN)
    begun = time.process_time()
    found = find_shape([base], KNOWN)
    seconds = time.process_time() - begun
    return Outcome(
        term,
        excitation,
        strength,
        seed,
        in_order(made.truth),
        found.variables,
        found.rivals,
        found.accepted,
        found.told,
        found.ratio,
        found.heldout,
        _second(found, made) if found.accepted and found.told else None,
        found.formula.name if found.formula else "",
        seconds,
    )


def _second(found: FoundShape, made: Record) -> float:
    """Return the error of the learnt effect on the second record, over the noise."""
    final = found.as_effect.fit
    other = Measurement(*made.second, 1.0 / CHALLENGE_RATE, at_rest=True)
    moved = carry_model(final.composition, final.named(), [other], KNOWN)
    if moved is None:
        return float("inf")
    inside = _inside(final, moved)
    return float(np.sqrt(np.mean(moved.residuals[0][inside] ** 2)) / FORCE_NOISE)


def _inside(first: Fit, second: Fit) -> BoolArray:
    """Return which samples of a record lie within the depths and speeds of another."""
    inside = np.ones(second.tip[0].size, dtype=bool)
    for one, other in (
        (first.tip[0], second.tip[0]),
        (np.gradient(first.tip[0]), np.gradient(second.tip[0])),
    ):
        inside &= (other >= one.min()) & (other <= one.max())
    return inside


def rows(found: list[Outcome]) -> dict[str, Any]:
    """Return the numbers of all outcomes, each with how many records it rests on."""
    hidden = [each for each in found if each.truth]
    steady = [each for each in hidden if each.excitation == EXCITATIONS[-1]]
    moving = [each for each in hidden if each.excitation != EXCITATIONS[-1]]
    clean = [each for each in found if not each.truth]
    accepted = [each for each in hidden if each.second is not None]

    def share(name: str, of: list[Outcome], right: list[bool]) -> tuple[str, str]:
        return name, f"{sum(right)} of {len(of)}"

    weak, strong = ([e for e in moving if (e.strength > 6.0) == far] for far in (False, True))
    return dict(
        [
            share("right variables first, 2 and 6 x noise", weak, list(map(_right, weak))),
            share("right variables first, 20 x noise", strong, list(map(_right, strong))),
            share("steady sine: right, or said that it cannot be told, or nothing claimed", steady,
                  [_right(e) or not e.told or not e.claimed for e in steady]),
            share("hidden and claimed", hidden, [e.claimed for e in hidden]),
            share("claimed: second record <= 1.15 noise", accepted,
                  [e.second <= RIGHT for e in accepted]),
            share("claimed: second record <= 1.5 noise", accepted,
                  [e.second <= FAR for e in accepted]),
            share("clean: shape claimed", clean, [e.claimed for e in clean]),
            ("longest processor time of a shape [s]", f"{max(e.seconds for e in found):.1f}"),
        ]
    )  # fmt: skip


def _right(each: Outcome) -> bool:
    return each.variables == each.truth


def measure(first_seed: int) -> dict[str, Any]:
    """Measure, print each record's line and the rows, and return all."""
    found = []
    for each in outcomes(first_seed):
        found.append(each)
        second = "" if each.second is None else f"{each.second:.2f}"
        mark = "right" if _right(each) else "WRONG"
        print(
            f"{each.term:30s}{each.excitation:10s}{each.strength:4.0f}  {mark} "
            f"{'+'.join(each.variables):24s}{each.over_noise:6.2f}{each.heldout_over_noise:6.2f} "
            f"{'claimed' if each.claimed else '':8s}{'' if each.told else 'not told':9s}{second:6s}"
            f"{each.formula:14s}{each.seconds:5.1f} s",
            flush=True,
        )
    told = rows(found)
    for name, value in told.items():
        print(f"{name:75s} {value}")
    return {"rows": told, "records": [asdict(each) for each in found]}
