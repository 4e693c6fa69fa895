"""One matrix of all columns, blocks of each record apart: every subset is fitted from it alone.

Contents: columns over the noise, their products, and those of the values that the model may still
change.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.outcome import HELD_OUT_PARTS
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.fitting.sensitivities import by_unknown, precision, unknown
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.shape.free_functions import Group
from tissue_probe.diagnosis.shape.paths import Path
from tissue_probe.diagnosis.shape.tip_response import Respond
from tissue_probe.signals import FloatArray, IntArray

#: Samples that are enough to tell a shape: of more every second, third ... is taken.
ENOUGH_SAMPLES = 40_000
#: Pieces of a record that are left out together: each block has some of every motion in it, as of
#: every frequency of a sweep.
PIECES = 5


@dataclass(frozen=True, eq=False)
class Gram:
    """Products of columns with one another and with the residual, all over the noise.

    Attributes
    ----------
    products : array, shape (b, p, p)
        Of each block of samples.
    towards : array, shape (b, p)
        Of the columns with the residual.
    squares : array, shape (b,)
        Of the residual.
    samples : int
        That were used.
    own : int
        How many of the first columns are those of the model itself, which may change: values,
        constants of the rig within their tolerances, and starts.
    precision, departure : array, shape (own,)
        Knowledge of these beforehand.
    starts : array of int
        Which of the own columns are starts.
    unknowns : array of int, shape (own,)
        The places of the own columns among all that ``by_unknown`` has.
    places : mapping of str to array
        Columns of each group.
    scale : array, shape (p,)
        By which each column was divided.
    """

    products: FloatArray
    towards: FloatArray
    squares: FloatArray
    samples: int
    own: int
    precision: FloatArray
    departure: FloatArray
    starts: IntArray
    unknowns: IntArray
    places: Mapping[str, IntArray]
    scale: FloatArray

    @classmethod
    def of(
        cls,
        fit: Fit,
        instrument: Instrument,
        found: Sequence[Path],
        groups: Sequence[Group],
        respond: Respond,
    ) -> Gram:
        """Return the products of all columns along the paths of a fit."""
        problem = Problem(fit.composition, fit.measurements, instrument)
        own, known, departure, unknowns = _own(problem, fit)
        step = -(-fit.samples // ENOUGH_SAMPLES)
        blocks, places = [], {}
        lengths = [path.time.size for path in found]
        ends = np.cumsum([0, *lengths])
        for index, path in enumerate(found):
            parts = [own[ends[index] : ends[index + 1]][::step]]
            at = own.shape[1]
            for group in groups:
                part = group.columns(path)
                parts.append(_weighed(problem, index, path, part, group.at_tip, respond)[::step])
                places[group.name] = at + np.arange(part.shape[1])
                at += part.shape[1]
            left = problem.weighed(index, fit.residuals[index][:, None])[::step]
            pieces = np.array_split(np.concatenate([*parts, left], axis=1), HELD_OUT_PARTS * PIECES)
            blocks += [
                np.concatenate(pieces[first::HELD_OUT_PARTS]) for first in range(HELD_OUT_PARTS)
            ]
        whole = np.stack([block.T @ block for block in blocks])
        scale = np.sqrt(np.diag(whole.sum(axis=0))[:-1])
        scale = np.where(scale > 0.0, scale, 1.0)
        first = own.shape[1]
        own_scale = scale[:first]
        used = sum(int(np.sum(path.measurement.used[::step])) for path in found)
        return cls(
            whole[:, :-1, :-1] / np.multiply.outer(scale, scale),
            whole[:, :-1, -1] / scale,
            whole[:, -1, -1],
            used,
            first,
            known / own_scale**2,
            departure * own_scale,
            np.flatnonzero(unknowns >= problem.count),
            unknowns,
            places,
            scale,
        )


def _weighed(
    problem: Problem, index: int, path: Path, forces: FloatArray, at_tip: bool, respond: Respond
) -> FloatArray:
    changes = respond(forces, path.measurement) if at_tip else forces
    return problem.weighed(index, changes)


def _own(problem: Problem, fit: Fit) -> tuple[FloatArray, FloatArray, FloatArray, IntArray]:
    """Return columns of a fit's unknowns over the noise; their precisions; departures; places.

    Stiffness and damping of a tissue without effects are not among them: a straight line along the
    path changes the output as they do, along any path.
    """
    columns = by_unknown(problem, fit.values, fit.starts)
    known = precision(problem, fit.values)
    expected = [begun.mean for begun in problem.begin(fit.values)]
    off = np.concatenate([problem.nominal - fit.values, *expected - np.array(fit.starts)])
    used = unknown(problem) & np.isfinite(columns).all(axis=0) & np.any(columns != 0.0, axis=0)
    composition = fit.composition
    if not composition.effects and composition.tissue != "maxwell":
        used[: problem.count] &= ~np.isin(problem.runs.names, ("stiffness", "damping"))
    off = np.where(np.isfinite(off), off, 0.0)
    return columns[:, used], known[used], off[used], np.flatnonzero(used)


def names_of(groups: Sequence[Group], variables: frozenset[str]) -> Iterator[str]:
    """Yield the groups that depend on nothing but some variables."""
    for group in groups:
        if group.variables <= variables:
            yield group.name
