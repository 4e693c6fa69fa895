"""From one filter to another in the middle of a stream: what is known of the tissue goes along.

Contents: which numbers of a filter's memory another one begins with.

Two filters of one estimator differ in their model alone. States of one name are one quantity: the
tip's motion, stiffness and damping, strengths of effects. Their means and covariance go over, and
so do the last inputs, so that the motion goes on without a jump. Numbers that only the new model
has begin with their priors, uncorrelated with the others: the covariance is then one of two blocks,
each of them definite. What the innovations said of the old model says nothing of the new one, so
all tests begin anew.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tissue_probe.estimation.layout import OF_THE_MODEL, StateLayout

if TYPE_CHECKING:
    from tissue_probe.estimation.run import Run

FloatArray = NDArray[np.float64]


def carry_over(before: Run, after: Run) -> None:
    """Let a run go on from where another one of the same estimator is.

    Where the old model was rejected, its covariance is not that of its errors: the means go over,
    each with the variance of its prior. Where the two models read the position or its delay in
    other ways, the tip's motion is forgotten, as in a gap.

    Parameters
    ----------
    before : Run
        Stays as it is.
    after : Run
        Has begun, and has taken in no sample.
    """
    if not after.kernel.plan.is_kalman:  # which has no other model
        after.resume(before.memory)
        return
    old, new = before.kernel.plan.layout, after.kernel.plan.layout
    here, there = before.memory, after.memory
    _carry_states(here, old, there, new)
    _carry_constants(before, here, after, there)
    there[new.history : new.verdict] = here[old.history : old.verdict]
    for name in OF_THE_MODEL:
        if name in old.extra and name in new.extra:
            there[new.carried(name)] = here[old.carried(name)]
    after.resume(there)
    if not _read_alike(before, after):
        after.reopen()


def _carry_states(here: FloatArray, old: StateLayout, there: FloatArray, new: StateLayout) -> None:
    """Carry means and covariance of the states that both have."""
    both = [name for name in new.states if name in old.states]
    for name in both:
        there[new.states.index(name)] = here[old.states.index(name)]
    if here[old.rejected] > 0.0:
        return
    for first in both:
        for second in both:
            place = old.covariance(old.states.index(first), old.states.index(second))
            own = new.covariance(new.states.index(first), new.states.index(second))
            there[own] = here[place]


def _read_alike(before: Run, after: Run) -> bool:
    old, new = before.kernel.plan, after.kernel.plan
    return (old.delay, old.moved) == (new.delay, new.moved)


def _carry_constants(before: Run, here: FloatArray, after: Run, there: FloatArray) -> None:
    """Carry what is known of the rig's constants, whose nominal values may be others now.

    Errors are counted in standard deviations s about a value c. So c + s d stays, s L, and W.
    """
    old, new = before.kernel.plan.layout, after.kernel.plan.layout
    if not new.considered:
        return
    value, deviation = _nominal(before, old)
    value_now, deviation_now = _nominal(after, new)
    scale = deviation / deviation_now
    W, d, L = old.view_considered(here)
    W_now, d_now, L_now = new.view_considered(there)
    for name in (n for n in new.states if n in old.states):
        W_now[new.states.index(name)] = W[old.states.index(name)]
    d_now[:] = (value + deviation * d - value_now) / deviation_now
    L_now[:] = scale[:, np.newaxis] * L


def _nominal(run: Run, layout: StateLayout) -> tuple[FloatArray, FloatArray]:
    """Return values and standard deviations of the considered constants."""
    names = layout.considered
    value = np.array([run.constants[layout.constant(name)] for name in names])
    share = np.array([run.constants[layout.constant(f"{name}_tol")] for name in names])
    return value, share * value
