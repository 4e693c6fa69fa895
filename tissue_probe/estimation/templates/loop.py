# ruff: noqa: F821
"""The loop around every Kalman filter: missing samples, bounds, status.

Never imported: this text becomes part of each generated kernel module, which supplies ``start``,
``reopen``, ``predict``, ``expected``, ``output``, ``update``, ``told``, ``cap``,
``is_bounded``, ``bound``, ``true_position`` and ``tick``, all from symbols, the estimator's
``weigh``, the rig's ``take_in`` and ``noise`` (``past_inputs`` or ``windows``), and the names in
capitals: places in ``constants`` and in ``memory``. All that a filter knows is in ``memory``, so
that cutting the stream into blocks of any size cannot change a bit of the estimates.
"""


@njit(error_model="numpy")
def keep_sound(constants, memory):
    """Hold estimates within their bounds and variances between their floor and their ceiling.

    Without a cap the covariance of a fading filter grows for ever in a direction that is not
    excited. Written so that a NaN counts as out of bounds.
    """
    sound = is_definite(constants, memory) and is_bounded(constants, memory)
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
    bound(constants, memory)
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
    """Write the estimates after a sample."""
    stiffness, damping, trace, stiffness_variance, damping_variance, covariance, offset = told(
        constants, memory
    )
    estimates[0, sample] = stiffness
    estimates[1, sample] = damping
    estimates[2, sample] = trace
    estimates[3, sample] = stiffness_variance
    estimates[4, sample] = damping_variance
    estimates[5, sample] = covariance
    estimates[6, sample] = offset
    estimates[7, sample] = memory[PREDICTED]
    estimates[10, sample] = status(
        constants, memory, stiffness, damping, stiffness_variance, damping_variance
    )


@njit(error_model="numpy")
def run(constants, memory, position, force, estimates, begin, end):
    """Filter samples ``begin`` to ``end``; fill ``estimates`` (11, n); return how many missed."""
    missing = 0
    for sample in range(begin, end):
        innovation = normalized = measured = math.nan
        due = True
        if abs(position[sample]) < LARGEST:
            true = true_position(constants, memory, position[sample])
            due, measured = take_in(constants, memory, true, force[sample])
        elif memory[PRIMED] > 0.0:
            reopen(constants, memory)
            interrupt(memory)
        if due and memory[PRIMED] > 0.0:
            predicted, variance = output(constants, memory)
            least = 0.5 * noise(constants, memory)
            if not (least <= variance < math.inf and math.isfinite(predicted)):
                # Rounding has left a covariance that no numbers have: all begins anew.
                start(constants, memory)
                predicted, variance = output(constants, memory)
            memory[PREDICTED] = predicted
            innovation = measured - predicted
            normalized = innovation * innovation / variance
        if due and abs(measured) < LARGEST and math.isfinite(normalized):
            memory[LATEST], memory[LATEST + 1] = innovation, normalized
            judge_noise(memory, normalized)
            standard = math.copysign(math.sqrt(normalized), innovation)
            judge_model(constants, memory, position[sample], innovation, standard)
            S, R = weigh(constants, memory, innovation, variance)
            predicted = expected(constants, memory)  # anew, in case that all was forgotten
            update(constants, memory, measured - predicted, S, R)
            if has_recovered(memory):
                start(constants, memory)
        elif due:
            innovation = normalized = math.nan
            missing += 1
        elif memory[PRIMED] >= constants[WINDOW]:  # part of a window: the latest one's hold
            innovation, normalized = memory[LATEST], memory[LATEST + 1]
        keep_sound(constants, memory)
        tick(constants, memory)
        record(constants, memory, estimates, sample)
        estimates[8, sample] = innovation
        estimates[9, sample] = normalized
    return missing
