# ruff: noqa: F821
"""Samples of a rig that moves by itself: each is predicted by a step from the inputs before it.

Never imported: this text becomes part of a kernel module (see ``loop``).
"""


@njit(error_model="numpy")
def take_in(constants, memory, position, force):
    """Take in a sample; return that a force is to be predicted, and the one that was measured."""
    advance(constants, memory, position)
    return True, force


@njit(error_model="numpy")
def noise(constants, memory):
    """Return the variance of the force's noise [N^2]."""
    return constants[FORCE_VARIANCE]


@njit(error_model="numpy")
def advance(constants, memory, position):
    """Take in the coil's position and, from the second sample on, predict.

    The cubic of the exact step needs u[t-3..t]. After a start it has fewer points, and the missing
    ones are extrapolated by the straight line, then the parabola through those there are.
    """
    u1, u2, u3 = memory[HISTORY], memory[HISTORY + 1], memory[HISTORY + 2]
    primed = memory[PRIMED]
    if primed < 4.0:
        memory[PRIMED] = primed + 1.0
        if primed == 1.0:
            u2 = 2.0 * u1 - position
        if primed <= 2.0:
            u3 = 3.0 * u2 - 3.0 * u1 + position
    memory[HISTORY] = position
    memory[HISTORY + 1] = u1
    memory[HISTORY + 2] = u2
    memory[HISTORY + 3] = u3
    if primed == 0.0:
        return
    predict(constants, memory)
