# ruff: noqa: F821
"""The loop around every Kalman filter: input history, missing samples, bounds, status.

Never imported: this text becomes part of each generated kernel module, which supplies ``start``,
``reopen``, ``predict``, ``output``, ``update``, ``cap``, ``true_position`` and ``tick``, all from
symbols, the estimator's ``weigh``, and the names in capitals: places in ``constants`` and in
``memory``. All that a filter knows is in ``memory``, so that cutting the stream into blocks of any
size cannot change a bit of the estimates.
"""


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


@njit(error_model="numpy")
def keep_sound(constants, memory):
    """Hold estimates within their bounds and variances between their floor and their ceiling.

    Without a cap the covariance of a fading filter grows for ever in a direction that is not
    excited. Written so that a NaN counts as out of bounds.
    """
    sound = is_definite(constants, memory)
    for state in range(STATES):
        mean, variance = memory[state], memory[DIAGONAL[state]]
        prior = constants[PRIOR_VARIANCE + state]
        sound &= constants[LOWER + state] <= mean
        sound &= mean <= constants[UPPER + state]
        sound &= FLOOR * prior <= variance
        sound &= variance <= constants[LARGEST_VARIANCE + state]
    if not sound:
        repair(constants, memory)


@njit(error_model="numpy")
def repair(constants, memory):
    """Bring mean and covariance back into bounds; where numbers overflowed, start again.

    Rounding can leave a covariance that no numbers have, where a variance has just shrunk by many
    orders. Then all correlations shrink by the least share, of powers of ten, that makes it
    definite: variances stay, and at the latest without any correlation it is.
    """
    for index in range(HISTORY):
        if not math.isfinite(memory[index]):
            start(constants, memory)
            return
    for state in range(STATES):
        memory[state] = min(max(memory[state], constants[LOWER + state]), constants[UPPER + state])
        floor = FLOOR * constants[PRIOR_VARIANCE + state]
        memory[DIAGONAL[state]] = max(memory[DIAGONAL[state]], floor)
    cap(constants, memory)
    share = 1e-15
    while not (is_definite(constants, memory) or share > 2.0):
        for row in range(STATES):
            for place in range(DIAGONAL[row] + 1, DIAGONAL[row] + STATES - row):
                memory[place] *= max(1.0 - share, 0.0)
        share *= 10.0


@njit(error_model="numpy")
def record(constants, memory, estimates, sample):
    """Write down what is known after a sample."""
    stiffness = memory[STIFFNESS]
    damping = memory[DAMPING]
    stiffness_variance = memory[DIAGONAL[STIFFNESS]]
    damping_variance = memory[DIAGONAL[DAMPING]]
    trace = 0.0
    for state in range(STATES):
        trace += memory[DIAGONAL[state]]
    estimates[0, sample] = stiffness
    estimates[1, sample] = damping
    estimates[2, sample] = trace
    estimates[3, sample] = stiffness_variance
    estimates[4, sample] = damping_variance
    estimates[5, sample] = memory[STIFFNESS_DAMPING]
    estimates[6, sample] = memory[OFFSET] if OFFSET >= 0 else 0.0
    estimates[7, sample] = memory[PREDICTED]
    estimates[10, sample] = status(
        constants, memory, stiffness, damping, stiffness_variance, damping_variance
    )


@njit(error_model="numpy")
def run(constants, memory, position, force, estimates, begin, end):
    """Filter samples ``begin`` to ``end``; fill ``estimates`` (11, n); return how many missed."""
    missing = 0
    for sample in range(begin, end):
        innovation = normalized = math.nan
        if abs(position[sample]) < LARGEST:
            advance(constants, memory, true_position(constants, memory, position[sample]))
            predicted, variance = output(constants, memory)
            if variance < 0.5 * constants[FORCE_VARIANCE]:
                # Rounding has left a covariance that no numbers have: all begins anew.
                start(constants, memory)
                predicted, variance = output(constants, memory)
            memory[PREDICTED] = predicted
            innovation = force[sample] - predicted
            normalized = innovation * innovation / variance
        elif memory[PRIMED] > 0.0:
            reopen(constants, memory)
            interrupt(memory)
        if abs(force[sample]) < LARGEST and math.isfinite(normalized):
            judge_noise(memory, normalized)
            standard = math.copysign(math.sqrt(normalized), innovation)
            judge_model(constants, memory, position[sample], innovation, standard)
            S, R = weigh(constants, memory, innovation, variance)
            predicted, _ = output(constants, memory)  # anew, in case that all was forgotten
            update(constants, memory, force[sample] - predicted, S, R)
            if has_recovered(memory):
                start(constants, memory)
        else:
            innovation = normalized = math.nan
            missing += 1
        keep_sound(constants, memory)
        tick(constants, memory)
        record(constants, memory, estimates, sample)
        estimates[8, sample] = innovation
        estimates[9, sample] = normalized
    return missing
