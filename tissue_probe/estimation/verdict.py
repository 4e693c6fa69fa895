# ruff: noqa: F821
"""What an estimate is worth: the status of every estimator.

Never imported: this text becomes part of each kernel module (see ``loop``).
"""


@njit(error_model="numpy")
def judge_model(memory, normalized):
    """Reject the model while the mean NIS of the last 500 samples or so is far from 1.

    With the right model it is 1.00 +- 0.05. A single outlier counts as 10 at most.
    """
    mean = 0.998 * memory[MEAN_NIS] + 0.002 * min(normalized, 10.0)
    memory[MEAN_NIS] = mean
    if mean > 2.0:
        memory[REJECTED] = 1.0
    elif mean < 1.5:
        memory[REJECTED] = 0.0


@njit(error_model="numpy")
def status(constants, memory, stiffness, damping, stiffness_variance, damping_variance):
    """Return the number of the ``Status``, claimed only where two standard deviations prove it.

    Converged: 2 sd <= 5 % of the value, for stiffness and for damping. No contact: stiffness + 2 sd
    below ``contact_stiffness``. Model rejected: see ``judge_model``.
    """
    if memory[REJECTED] > 0.0:
        return 3.0
    room = constants[CONTACT_STIFFNESS] - stiffness
    if room > 0.0 and 4.0 * stiffness_variance < room * room:
        return 2.0
    known = 1600.0 * stiffness_variance <= stiffness * stiffness
    known &= 1600.0 * damping_variance <= damping * damping
    return 1.0 if known else 0.0
