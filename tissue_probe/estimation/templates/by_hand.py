# ruff: noqa: F821
"""How the estimators without a Kalman filter write an estimate down.

Never imported: this text becomes part of their kernel modules (see ``lock_in``, ``rls``), which
keep the first eight rows of the latest estimate in ``memory`` from ``LAST`` on.
"""


@njit(error_model="numpy")
def noise(constants, memory):
    """Return the variance of the force's noise [N^2]."""
    return constants[FORCE_VARIANCE]


@njit(error_model="numpy")
def record(constants, memory, estimates, sample, innovation, normalized):
    """Write the estimates after a sample."""
    for row in range(8):
        estimates[row, sample] = memory[LAST + row]
    estimates[8, sample] = innovation
    estimates[9, sample] = normalized
    estimates[10, sample] = status(
        constants, memory, memory[LAST], memory[LAST + 1], memory[LAST + 3], memory[LAST + 4]
    )
