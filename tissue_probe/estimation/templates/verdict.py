# ruff: noqa: F821
"""The status of an estimate: one test of the noise, one of the model.

Never imported: this text becomes part of each kernel module, which says where in ``memory`` the
block of these numbers begins (``VERDICT``).

**The model** is tested by the innovations that recur with the drive. Under the right model
innovations are white for any motion of the coil; under a wrong one they repeat with its motion, as
harmonics of it. The motion itself tells its phase angle phi, so that no frequency need be known,
and chirps and sums of sines are as good as a sine:

    cos phi + i sin phi = z / |z|,  z = (u - mean u) / rms + i u' / rms

The sums A_n of nu / sqrt(S) exp(i n phi), n from 0 to 3, over a batch of samples are held against
those of the batch before. Of white noise, the real part of A_n A_n'* over the samples of a batch
exceeds a limit L less often than exp(-L): 6e-6 for L = 12. Three batches of 50 ms must agree so, or
two of four times that length: the short ones tell soon, the long ones hold more of a slow motion's
turn. A line away from the harmonics (hum) turns its phase from batch to batch; a change that the
filter follows does not last so long. More noise than was set is divided out: the sums are over the
greater of the two. Even laws of force have a second harmonic, odd ones a third: no wrong tissue
lacks both. Harmonics that the filter takes up itself say nothing: 0 where it estimates a constant
force or where the tissue begins, 1 where it also follows a change of stiffness and damping.

**The noise** is tested by the mean NIS: where innovations are greater than predicted, but do not
recur with the drive, a force away from the drive's frequency disturbs the filter.
"""

# Mean NIS; whether disturbed; whether rejected; batches of late that contradicted nothing.
MEAN_NIS, DISTURBED, REJECTED, CALM = range(VERDICT, VERDICT + 4)
# Of the position: smoothed; samples seen; mean; mean squares of the deviation from it and of u'.
SMOOTH, SEEN, MEAN, SQUARE, RATE_SQUARE = range(VERDICT + 4, VERDICT + 9)
# Of a batch: its samples, and the sum of nu^2 [N^2]; short batches in the long one under way.
TAKEN, FORCE_SQUARE, JOINED = range(VERDICT + 9, VERDICT + 12)
# Of a short batch, and of a long one, from these places on: the sum of (nu / sqrt(S))^2; real and
# imaginary parts of A_0 to A_3; the same of the batch before; for each harmonic, how often in a row
# a batch contradicted.
SHORT, LONG, END = VERDICT + 12, VERDICT + 34, VERDICT + 56
HARMONICS, BEFORE, IN_A_ROW = 1, 9, 18

# L above; how often in a row short and long batches must exceed it; short ones in a long one.
LIMIT, ENOUGH_SHORT, ENOUGH_LONG, PARTS = 12.0, 2.0, 1.0, 4.0
# Least share of a harmonic in the innovations' excess over their noise: less is hum's leakage.
SHARE = 0.2
# A single innovation counts as 3.2 standard deviations at most: outliers are no harmonics.
LARGEST_NIS = 10.0
# Harmonics below this share of the tissue's force are no contradiction: they would shift the
# stiffness by less than the 5 % of "converged" (by three times their share for a cubic law, by four
# for a quadratic one), of which a filter that follows takes away a part.
TOLERATED = 0.01
# After as many batches without a contradiction a filter that rejected its model begins anew: 10 s,
# in which a drive of 1 Hz has turned ten times.
UNTIL_ANEW = 200.0


@njit(error_model="numpy")
def judge_noise(memory, normalized):
    """Call the filter disturbed while the mean NIS of the last 500 samples or so is far from 1.

    With the right model and noise it is 1.00 +- 0.05. A single outlier counts as 10 at most.
    """
    mean = 0.998 * memory[MEAN_NIS] + 0.002 * min(normalized, LARGEST_NIS)
    memory[MEAN_NIS] = mean
    if mean > 2.0:
        memory[DISTURBED] = 1.0
    elif mean < 1.5:
        memory[DISTURBED] = 0.0


@njit(error_model="numpy")
def judge_model(constants, memory, position, innovation, standard):
    """Take in an innovation [N] and the same over its standard deviation; compare full batches."""
    cosine, sine = turn(constants, memory, position)
    limit = math.sqrt(LARGEST_NIS)
    standard = min(max(standard, -limit), limit)
    memory[TAKEN] += 1.0
    memory[FORCE_SQUARE] += innovation * innovation
    memory[SHORT] += standard * standard
    memory[SHORT + HARMONICS] += standard
    x, y = standard, 0.0
    for place in range(SHORT + HARMONICS + 2, SHORT + BEFORE, 2):
        x, y = x * cosine - y * sine, x * sine + y * cosine
        memory[place] += x
        memory[place + 1] += y
    if memory[TAKEN] >= constants[BATCH]:
        compare(constants, memory)


@njit(error_model="numpy")
def turn(constants, memory, position):
    """Return cosine and sine of the motion's phase angle; 0 and 0 of a coil at rest.

    The position is smoothed over five samples, so that an encoder's steps leave a speed; the lag
    turns each harmonic by a constant. Means are of the last five batches or so.
    """
    seen = min(memory[SEEN] + 1.0, 5.0 * constants[BATCH])
    if memory[SEEN] == 0.0:
        memory[SMOOTH] = memory[MEAN] = position
    rate = 0.2 * (position - memory[SMOOTH])
    memory[SEEN] = seen
    memory[SMOOTH] += rate
    memory[MEAN] += (memory[SMOOTH] - memory[MEAN]) / seen
    deviation = memory[SMOOTH] - memory[MEAN]
    square = memory[SQUARE] + (deviation * deviation - memory[SQUARE]) / seen
    rate_square = memory[RATE_SQUARE] + (rate * rate - memory[RATE_SQUARE]) / seen
    memory[SQUARE] = square
    memory[RATE_SQUARE] = rate_square
    length = math.sqrt(deviation * deviation * rate_square + rate * rate * square)
    if not length > 0.0:
        return 0.0, 0.0
    return deviation * math.sqrt(rate_square) / length, rate * math.sqrt(square) / length


@njit(error_model="numpy")
def compare(constants, memory):
    """Hold a full batch against the one before: reject the model, or count the batch as calm."""
    taken = memory[TAKEN]
    elastic = TOLERATED * max(abs(memory[STIFFNESS]), constants[CONTACT_STIFFNESS])
    more_than_noise = memory[FORCE_SQUARE] / taken - noise(constants, memory)
    matters = more_than_noise > elastic * elastic * memory[SQUARE]
    memory[SHORT] = max(memory[SHORT], taken)
    for place in range(BEFORE):
        memory[LONG + place] += memory[SHORT + place]
    memory[TAKEN] = memory[FORCE_SQUARE] = 0.0
    memory[JOINED] += 1.0
    contradicts = agree(memory, SHORT, taken, matters, ENOUGH_SHORT)
    if memory[JOINED] >= PARTS:
        memory[JOINED] = 0.0
        contradicts |= agree(memory, LONG, PARTS * taken, matters, ENOUGH_LONG)
    memory[CALM] = 0.0 if contradicts else memory[CALM] + 1.0


@njit(error_model="numpy")
def agree(memory, batch, taken, matters, enough):
    """Whether a harmonic of a batch is that of the batch before; begin the next batch."""
    contradicts = False
    power = math.sqrt(memory[batch] * memory[batch + BEFORE])
    # A harmonic of amplitude a has a^2 / 2 in every sample, and a / 2 in the mean of A_n.
    limit = max(LIMIT * power, 0.5 * SHARE * (power - taken) * taken)
    for n in range(4):
        if (n == 0 and OFFSET) or (n == 1 and FOLLOWS):
            continue
        real, imaginary = batch + HARMONICS + 2 * n, batch + HARMONICS + 2 * n + 1
        product = memory[real] * memory[real + BEFORE]
        product += memory[imaginary] * memory[imaginary + BEFORE]
        if matters and product > limit:
            contradicts = True
            memory[batch + IN_A_ROW + n] += 1.0
            if memory[batch + IN_A_ROW + n] >= enough:
                memory[REJECTED] = 1.0
        else:
            memory[batch + IN_A_ROW + n] = 0.0
    for place in range(batch, batch + BEFORE):
        memory[place + BEFORE] = memory[place]
        memory[place] = 0.0
    return contradicts


@njit(error_model="numpy")
def interrupt(memory):
    """Begin a new batch that has none before: samples are missing, the phase is another."""
    for place in range(TAKEN, END):
        memory[place] = 0.0


@njit(error_model="numpy")
def has_recovered(memory):
    """Whether nothing has contradicted the model for so long that a rejected one is to be tried."""
    return memory[REJECTED] > 0.0 and memory[CALM] >= UNTIL_ANEW


@njit(error_model="numpy")
def status(constants, memory, stiffness, damping, stiffness_variance, damping_variance):
    """Return the number of the ``Status``, claimed only where two standard deviations prove it.

    Converged: 2 sd <= 5 % of the value, for stiffness and for damping; disturbed: the same, but see
    ``judge_noise``. No contact: stiffness + 2 sd below ``contact_stiffness``. Model rejected: see
    ``judge_model``; until the filter starts.
    """
    if memory[REJECTED] > 0.0:
        return 3.0
    room = constants[CONTACT_STIFFNESS] - stiffness
    if room > 0.0 and 4.0 * stiffness_variance < room * room:
        return 2.0
    known = 1600.0 * stiffness_variance <= stiffness * stiffness
    known &= 1600.0 * damping_variance <= damping * damping
    if not known:
        return 0.0
    return 4.0 if memory[DISTURBED] > 0.0 else 1.0
