"""The shape of the force that a model misses, where no law of the library explains it.

Contents: from the models of a ladder to the variables of the missing force.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.shape.choice import Choice, choose_variables
from tissue_probe.diagnosis.shape.free_functions import Functions, Group
from tissue_probe.diagnosis.shape.gram import Gram
from tissue_probe.diagnosis.shape.paths import Path, paths
from tissue_probe.diagnosis.shape.tip_response import Respond, tip_response
from tissue_probe.signals import FloatArray

#: Rounds in which the path of a tip that moves by itself follows the shape.
ROUNDS = 3


@dataclass(frozen=True, eq=False)
class Shape:
    """Variables and functions of a missing force, beside one model.

    Attributes
    ----------
    fit : Fit
        The model that it is missing in.
    choice : Choice
        The variables.
    functions : Functions
        The free functions.
    gram : Gram
        Their products along ``paths``.
    paths : list of Path
        Where the tip is, with the shape.
    """

    fit: Fit
    choice: Choice
    functions: Functions
    gram: Gram
    paths: list[Path]

    @property
    def groups(self) -> list[Group]:
        """The functions in groups."""
        return self.functions.groups()


def shape(fit: Fit, instrument: Instrument) -> Shape:
    """Return the shape of the force that a model misses.

    Where the tip moves by itself, it moves otherwise with the force that is missing: the path is
    found again with the force that was learnt along the one before.
    """
    respond = tip_response(fit)
    found = _along(fit, instrument, paths(fit), respond)
    if fit.composition.rig.tip_is_position:
        return found
    for _ in range(ROUNDS - 1):
        moved = paths(fit, compute_added_outputs(found, instrument, respond))
        if not all(np.isfinite(each.indentation).all() for each in moved):
            break
        found = _along(fit, instrument, moved, respond)
    return found


def _along(fit: Fit, instrument: Instrument, found: list[Path], respond: Respond) -> Shape:
    functions = Functions.of(found)
    groups = functions.groups()
    gram = Gram.of(fit, instrument, found, groups, respond)
    return Shape(fit, choose_variables(gram, groups), functions, gram, found)


def compute_added_outputs(
    found: Shape, instrument: Instrument, respond: Respond
) -> list[FloatArray]:
    """Return the part of each output that the chosen shape and the values beside it add."""
    best, gram, fit = found.choice.best, found.gram, found.fit
    weight = dict(zip(best.columns.tolist(), best.weights.tolist(), strict=True))
    problem = Problem(fit.composition, fit.measurements, instrument)
    changed = np.zeros(problem.count + problem.states * len(found.paths))
    changed[gram.unknowns] = [weight[place] for place in range(gram.own)]
    own, starts = changed[: problem.count], changed[problem.count :].reshape(-1, problem.states)
    simulated = problem.simulate(fit.values, fit.starts)
    result = []
    for path, (_, sensitivity), start in zip(found.paths, simulated, starts, strict=True):
        at_tip, channel = np.zeros((2, path.time.size))
        for group in found.groups:
            places = gram.places[group.name]
            if places[0] not in weight:
                continue
            force = group.columns(path) @ [weight[place] for place in places.tolist()]
            if group.at_tip:
                at_tip = at_tip + force
            else:
                channel = channel + force
        of_model = sensitivity @ np.concatenate([start, own])
        result.append(of_model + respond(at_tip[:, None], path.measurement)[:, 0] + channel)
    return result
