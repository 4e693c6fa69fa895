"""Robust extended Kalman filter: a constant force as fifth state, and a gate on the innovations.

Once the tissue is roughly known, the step is the extended filter's. Before, it is the unscented
filter's: tangents at wild first estimates would make the filter surer of them than the data allow.

When the mean NIS of the last ten samples shows that the tissue has changed, the covariance is
re-opened just as far as the innovations ask for, and never beyond the prior. The force offset is
re-opened little at first, since a change of tissue under an unloaded tip leaves it alone, and
farther with each further opening that comes soon after. For some 50 samples after an opening,
stiffness and damping are taken to go on changing, both by the same share: as where the tip sinks in
and its contact grows. The damping is invisible for 10 ms around each turn of the motion; without
the information that the stiffness holds of it, no filter could follow a ramp there. The price is
paid where one of the two steps alone, or the damping alone is ramped: see these rows of ``python -m
benchmarks estimators``.

Where several openings within some 50 samples did not help, the filter has lost its way: it forgets
everything and begins anew, which takes hardly longer than a first contact.

A model that is wrong, and hum, make the gate fire again and again. Then the filter calls itself
disturbed, and instead of jumping lets the past fade, with the noise that the innovations show.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tissue_probe.estimation import ekf, few_points
from tissue_probe.estimation.ekf import update

if TYPE_CHECKING:
    from tissue_probe.estimation.equations import Filter
    from tissue_probe.estimation.kernel_names import (
        DAMPING,
        DIAGONAL,
        DISTURBED,
        MANY_OPENINGS,
        MEAN_NIS,
        OPENINGS,
        RECENT_NIS,
        RECENT_SQUARE,
        STIFFNESS,
        STIFFNESS_DAMPING,
        cap,
        forget,
        inflate,
        noise,
        output,
    )
    from tissue_probe.signals import FloatArray

__all__ = ["EXTRA", "FOLLOWS", "predict", "update", "weigh"]

FOLLOWS = True
# Means of NIS and of the squared innovations [N^2] over the last ten samples; openings of late,
# within some 50 samples and within some 1000.
EXTRA: dict[str, float] = {
    "RECENT_NIS": 1.0,
    "RECENT_SQUARE": 0.0,
    "OPENINGS": 0.0,
    "MANY_OPENINGS": 0.0,
}


def predict(filter: Filter) -> None:
    """Advance by sigma points where the tangent leaves out more than the process noise."""
    if not filter.model.states:
        ekf.predict(filter)
        return
    filter.step()  # which both need
    filter.program.begin(f"if {few_points.tangent_is_poor(filter, filter.P)}:")
    few_points.spread(filter, tangent=len(filter.model.states))
    filter.program.line("return")
    filter.program.end()
    ekf.predict(filter)


def weigh(
    constants: FloatArray, memory: FloatArray, innovation: float, S: float
) -> tuple[float, float]:
    """Return the variances of innovation and force; re-open the covariance where these say so."""
    R = predicted = noise(constants, memory)
    memory[RECENT_NIS] = 0.9 * memory[RECENT_NIS] + 0.1 * innovation * innovation / S
    memory[RECENT_SQUARE] = 0.9 * memory[RECENT_SQUARE] + 0.1 * innovation * innovation
    memory[OPENINGS] *= 0.98
    memory[MANY_OPENINGS] *= 0.999
    if memory[OPENINGS] > 5.0 or (memory[DISTURBED] > 0.0 and memory[RECENT_NIS] > 1000.0):
        forget(constants, memory)
        memory[OPENINGS] = 0.0
        memory[RECENT_NIS] = 1.0
        memory[RECENT_SQUARE] = 0.0
    elif memory[DISTURBED] > 0.0:
        inflate(constants, memory, 1.003, 1.003)
        R *= max(1.0, memory[MEAN_NIS])
    elif memory[RECENT_NIS] > 3.5:
        factor = max(2.0, (memory[RECENT_SQUARE] - R) / (S - R))
        inflate(constants, memory, factor, min(factor, 2.0 * 3.0 ** memory[OPENINGS]))
        memory[RECENT_NIS] = 1.0
        memory[OPENINGS] += 1.0
        memory[MANY_OPENINGS] += 1.0
        if memory[MANY_OPENINGS] > 12.0:
            memory[DISTURBED] = 1.0
            memory[MANY_OPENINGS] = 0.0
    elif memory[OPENINGS] < 0.01 or memory[MANY_OPENINGS] > 4.0:
        return S, R  # nothing has changed of late, or goes on so long that the model is wrong
    else:
        # 0.3 % a sample: less would lag behind a ramp, more would blur a step.
        k, beta, walk = memory[STIFFNESS], memory[DAMPING], 1e-5 * min(memory[OPENINGS], 1.0)
        memory[DIAGONAL[STIFFNESS]] += walk * k * k
        memory[DIAGONAL[DAMPING]] += walk * beta * beta
        memory[STIFFNESS_DAMPING] += walk * k * beta
        return S, R
    cap(constants, memory)
    _, S = output(constants, memory)
    return S - predicted + R, R
