"""Recursive least squares on filtered signals, without any Kalman filter.

With the tip at x = u - F / k0, eq. 1 is linear in k and beta,

    y = F + (beta0 / k0) F' - m x'' = k x + beta x',

and stays so if all signals pass the same filter, 1 / (1 + s / w_f)^3 at 100 Hz, whose states are
the derivatives; at a twentieth of the sample rate where that is less, since signals are taken as
straight between samples. Of a rigid probe k0 is infinite. Samples count less the older they are
(``forgetting``). A cross-check with hardly a prior and no motion to estimate; a constant error of
force or contact point biases it. Never imported: this text becomes part of a kernel module.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import math

    from numba import njit

    from tissue_probe.estimation.kernel_names import (
        ENCODER_RESOLUTION,
        FLOOR,
        FORCE_VARIANCE,
        FORGETTING,
        LARGEST,
        LOAD_CELL_DAMPING,
        LOAD_CELL_STIFFNESS,
        LOWER,
        MEAN_NIS,
        PRIOR,
        PRIOR_VARIANCE,
        SAMPLE_PERIOD,
        TIP_MASS,
        UPPER,
        has_recovered,
        interrupt,
        judge_model,
        judge_noise,
        record,
    )
    from tissue_probe.signals import FloatArray


# Places in memory: filter states of x and of F (signal, first, second derivative); their last
# samples; sums of phi phi^T (upper triangle) and of phi y; samples since the filters began; then
# the rows of the estimate made last.
X, F, LAST_X, LAST_F, SUMS, COUNT, LAST = 0, 3, 6, 7, 8, 13, 14
STIFFNESS = LAST

CUTOFF, CUTOFF_SHARE = 100.0, 0.05


@njit(error_model="numpy")
def start(constants: FloatArray, memory: FloatArray) -> None:
    """Know nothing but the prior."""
    memory[:] = 0.0
    for row, variance in ((0, 3), (1, 4)):
        memory[LAST + row] = constants[PRIOR + 2 + row]
        memory[LAST + variance] = constants[PRIOR_VARIANCE + 2 + row]
        weight = constants[FORCE_VARIANCE] / memory[LAST + variance]
        memory[SUMS + 2 * row] = weight
        memory[SUMS + 3 + row] = weight * memory[LAST + row]
    memory[LAST + 2] = memory[LAST + 3] + memory[LAST + 4]
    memory[MEAN_NIS] = 1.0


@njit(error_model="numpy")
def reopen(constants: FloatArray, memory: FloatArray) -> None:
    """Keep the estimates of the tissue; the filters begin again."""
    memory[COUNT] = 0.0


@njit(error_model="numpy")
def advance(memory: FloatArray, state: int, last: int, signal: float, steps: float) -> None:
    """Let a signal, straight between samples, pass the filter in closed form.

    In units of 1 / w_f the filter is (D + 1)^3 y = a + b t. It follows a - 3 b + b t, and any
    deviation from that goes as a polynomial of second degree times e^(-t).
    """
    slope = (signal - memory[last]) / steps
    followed = memory[last] - 3.0 * slope
    y, dy, ddy = memory[state] - followed, memory[state + 1] - slope, memory[state + 2]
    linear, square = dy + y, 0.5 * (ddy + 2.0 * dy + y)
    decay = math.exp(-steps)
    value = y + steps * (linear + steps * square)
    rate = linear + 2.0 * steps * square
    memory[state] = followed + slope * steps + decay * value
    memory[state + 1] = slope + decay * (rate - value)
    memory[state + 2] = decay * (2.0 * square - 2.0 * rate + value)
    memory[last] = signal


@njit(error_model="numpy")
def begin_filters(memory: FloatArray, x: float, force: float) -> None:
    """Begin as if both signals had always had their present value."""
    memory[:LAST_X] = 0.0
    memory[X] = memory[LAST_X] = x
    memory[F] = memory[LAST_F] = force


@njit(error_model="numpy")
def regress(constants: FloatArray, memory: FloatArray, y: float, x: float, v: float) -> None:
    """Weigh in one equation y = k x + beta v, and solve for k and beta."""
    R, keep = constants[FORCE_VARIANCE], constants[FORGETTING]
    for place in range(SUMS, COUNT):
        memory[place] *= keep
    for row in range(2):
        weight = (1.0 - keep) * R / constants[PRIOR_VARIANCE + 2 + row]
        memory[SUMS + 2 * row] += weight
        memory[SUMS + 3 + row] += weight * constants[PRIOR + 2 + row]
    memory[SUMS] += x * x
    memory[SUMS + 1] += x * v
    memory[SUMS + 2] += v * v
    memory[SUMS + 3] += x * y
    memory[SUMS + 4] += v * y
    a, b, d = memory[SUMS], memory[SUMS + 1], memory[SUMS + 2]
    determinant = a * d - b * b
    if not determinant > 1e-12 * a * d:  # x and v in step: k and beta cannot be told apart
        return
    k = (d * memory[SUMS + 3] - b * memory[SUMS + 4]) / determinant
    beta = (a * memory[SUMS + 4] - b * memory[SUMS + 3]) / determinant
    noise = R * max(1.0, memory[MEAN_NIS])
    memory[LAST] = min(max(k, constants[LOWER + 2]), constants[UPPER + 2])
    memory[LAST + 1] = min(max(beta, constants[LOWER + 3]), constants[UPPER + 3])
    share = min(
        1.0,
        constants[PRIOR_VARIANCE + 2] * determinant / (noise * d),
        constants[PRIOR_VARIANCE + 3] * determinant / (noise * a),
    )
    memory[LAST + 3] = max(share * noise * d / determinant, FLOOR)
    memory[LAST + 4] = max(share * noise * a / determinant, FLOOR)
    memory[LAST + 5] = -share * noise * b / determinant
    memory[LAST + 2] = memory[LAST + 3] + memory[LAST + 4]


@njit(error_model="numpy")
def run(
    constants: FloatArray,
    memory: FloatArray,
    position: FloatArray,
    force: FloatArray,
    estimates: FloatArray,
    begin: int,
    end: int,
) -> int:
    """Filter samples ``begin`` to ``end``; fill ``estimates`` (11, n); return how many missed."""
    missing = 0
    m, k0, R = constants[TIP_MASS], constants[LOAD_CELL_STIFFNESS], constants[FORCE_VARIANCE]
    c = constants[LOAD_CELL_DAMPING] / k0
    cutoff = 2.0 * math.pi * min(CUTOFF, CUTOFF_SHARE / constants[SAMPLE_PERIOD])
    steps = cutoff * constants[SAMPLE_PERIOD]
    # White noise of the force comes through (1 + p s + q s^2) / (1 + s)^3 in units of w_f.
    p, q = c * cutoff, m * cutoff**2 / k0
    passed = steps * (3.0 + p * p - 2.0 * q + 3.0 * q * q) / 16.0
    # That of the position is in R, seen through k0; a rigid probe's is seen through the tissue.
    rounding = constants[ENCODER_RESOLUTION] ** 2 / 12.0 if math.isinf(k0) else 0.0
    for sample in range(begin, end):
        innovation = normalized = math.nan
        if abs(position[sample]) < LARGEST and abs(force[sample]) < LARGEST:
            tip = position[sample] - force[sample] / k0
            if memory[COUNT] == 0.0:
                begin_filters(memory, tip, force[sample])
            memory[COUNT] += 1.0
            advance(memory, X, LAST_X, tip, steps)
            advance(memory, F, LAST_F, force[sample], steps)
            x, v = memory[X], cutoff * memory[X + 1]
            y = memory[F] + c * cutoff * memory[F + 1] - m * cutoff**2 * memory[X + 2]
            innovation = y - memory[LAST] * x - memory[LAST + 1] * v
            spread = x * (x * memory[LAST + 3] + 2.0 * v * memory[LAST + 5])
            spread += v * v * memory[LAST + 4]
            k, b, i = memory[LAST], memory[LAST + 1] * cutoff, m * cutoff**2
            seen = rounding * steps * (3.0 * k * k + b * b - 2.0 * k * i + 3.0 * i * i) / 16.0
            normalized = innovation * innovation / (R * passed + seen + max(spread, 0.0))
            memory[LAST + 7] = force[sample] - innovation
            if memory[COUNT] * steps > 12.0:
                judge_noise(memory, normalized)
                # Filtered noise is not white, but at the drive's frequencies it is as dense.
                standard = innovation / math.sqrt(R + max(spread, 0.0))
                judge_model(constants, memory, position[sample], innovation, standard)
                regress(constants, memory, y, x, v)
                if has_recovered(memory):
                    start(constants, memory)
        else:
            missing += 1
            reopen(constants, memory)
            interrupt(memory)
        record(constants, memory, estimates, sample, innovation, normalized)
    return missing
