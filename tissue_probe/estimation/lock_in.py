"""Lock-in: the complex impedance at the drive frequency, without any Kalman filter.

Position and force are fitted, all by themselves, with a sine, a cosine and a constant at the known
``drive_frequency``, older samples weighing less with a time constant of one period. From the
amplitudes U and F the tip moves by X = U - F / k0, and eq. 1 becomes

    k + i w beta = F (1 + i w beta0 / k0) / X + m w^2

with an infinite k0 where the probe is rigid.

A cross-check: constant errors of force and contact point drop out, but it sees one tone only and
needs an established motion: where the position deviates from its fit by more than a hundredth of
its motion (a pause, another frequency, a sweep), the window holds no steady drive, and nothing is
known. Never imported: this text becomes part of a kernel module.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import math

    from numba import njit

    from tissue_probe.estimation.kernel_names import (
        DRIVE_FREQUENCY,
        ENCODER_RESOLUTION,
        FLOOR,
        FORCE_VARIANCE,
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


# Places in memory: products of [cos, sin, 1] with themselves (upper triangle), with the position
# and with the force, of the position with itself; phase [rad]; samples since the start; squared
# weights, added up; then the rows of the estimate made last.
WITH_POSITION, WITH_FORCE, SQUARE_POSITION = 6, 9, 12
PHASE, COUNT, SQUARED_WEIGHTS, LAST = 13, 14, 15, 16
STIFFNESS = LAST
FOLLOWS = True
OFFSET = True  # which the fit's constant takes up
# The share of the motion's square that is not the steady drive's: a hundredth, squared, since
# the damping may be a small part of the impedance.
UNSTEADY = 1e-4
# Periods after which hardly anything (e^-3) is left of how the motion began.
SETTLED_PERIODS = 3.0


@njit(error_model="numpy")
def start(constants: FloatArray, memory: FloatArray) -> None:
    """Know nothing but the prior."""
    memory[:] = 0.0
    memory[LAST] = constants[PRIOR + 2]
    memory[LAST + 1] = constants[PRIOR + 3]
    memory[MEAN_NIS] = 1.0
    claim_nothing(constants, memory)


@njit(error_model="numpy")
def claim_nothing(constants: FloatArray, memory: FloatArray) -> None:
    """Make the estimate as uncertain as before the first sample."""
    memory[LAST + 3] = constants[PRIOR_VARIANCE + 2]
    memory[LAST + 4] = constants[PRIOR_VARIANCE + 3]
    memory[LAST + 2] = memory[LAST + 3] + memory[LAST + 4]


@njit(error_model="numpy")
def reopen(constants: FloatArray, memory: FloatArray) -> None:
    """Keep the last estimate, and collect a new period."""
    memory[:LAST] = 0.0
    interrupt(memory)


@njit(error_model="numpy")
def is_determined(memory: FloatArray) -> bool:
    """Whether the amplitudes are: a sine that is sampled too rarely is like a constant."""
    a, b, c, d, e, f = memory[0], memory[1], memory[2], memory[3], memory[4], memory[5]
    determinant = a * (d * f - e * e) + b * (c * e - b * f) + c * (b * e - c * d)
    return bool(determinant > 1e-9 * a * d * f)


@njit(error_model="numpy")
def solve(memory: FloatArray, products: int) -> tuple[float, float, float]:
    """Return the amplitudes of [cos, sin, 1] from their products with a signal."""
    a, b, c, d, e, f = memory[0], memory[1], memory[2], memory[3], memory[4], memory[5]
    x, y, z = memory[products], memory[products + 1], memory[products + 2]
    p, q, r = d * f - e * e, c * e - b * f, b * e - c * d
    determinant = a * p + b * q + c * r
    s, t, v = a * f - c * c, b * c - a * e, a * d - b * b
    return (
        (p * x + q * y + r * z) / determinant,
        (q * x + s * y + t * z) / determinant,
        (r * x + t * y + v * z) / determinant,
    )


@njit(error_model="numpy")
def collect(
    constants: FloatArray,
    memory: FloatArray,
    cosine: float,
    sine: float,
    position: float,
    force: float,
) -> None:
    """Take in a sample; those before it weigh less."""
    keep = math.exp(-constants[SAMPLE_PERIOD] * constants[DRIVE_FREQUENCY])
    for place in range(PHASE):
        memory[place] *= keep
    memory[0] += cosine * cosine
    memory[1] += cosine * sine
    memory[2] += cosine
    memory[3] += sine * sine
    memory[4] += sine
    memory[5] += 1.0
    for first, signal in ((WITH_POSITION, position), (WITH_FORCE, force)):
        memory[first] += cosine * signal
        memory[first + 1] += sine * signal
        memory[first + 2] += signal
    memory[SQUARE_POSITION] += position * position
    memory[SQUARED_WEIGHTS] = keep * keep * memory[SQUARED_WEIGHTS] + 1.0
    memory[COUNT] += 1.0


@njit(error_model="numpy")
def is_steady(memory: FloatArray, u: tuple[float, float, float]) -> bool:
    """Whether the position is its fit, but for a small part of its motion."""
    fitted = u[0] * memory[WITH_POSITION] + u[1] * memory[WITH_POSITION + 1]
    fitted += u[2] * memory[WITH_POSITION + 2]
    motion = 0.5 * (u[0] * u[0] + u[1] * u[1]) * memory[5]
    return bool(memory[SQUARE_POSITION] - fitted <= UNSTEADY * motion)


@njit(error_model="numpy")
def estimate(constants: FloatArray, memory: FloatArray, w: float) -> None:
    """Turn the amplitudes into k and beta, unless the prior knows more."""
    k0, m = constants[LOAD_CELL_STIFFNESS], constants[TIP_MASS]
    u, f = solve(memory, WITH_POSITION), solve(memory, WITH_FORCE)
    U, F = complex(u[0], -u[1]), complex(f[0], -f[1])
    X = complex(u[0] - f[0] / k0, f[1] / k0 - u[1])
    c = complex(1.0, w * constants[LOAD_CELL_DAMPING] / k0)
    # Each quadrature of F has the variance 2 R (sum of w^2) / (sum of w)^2, and dZ/dF = c U / X^2.
    # The position's noise is in R, seen through k0; a rigid probe's is seen through all that moves.
    rounding = constants[ENCODER_RESOLUTION] ** 2 / 12.0 if math.isinf(k0) else 0.0
    R = constants[FORCE_VARIANCE] + rounding * abs(F) ** 2 / abs(X) ** 2
    R *= max(1.0, memory[MEAN_NIS])
    noise = 2.0 * R * memory[SQUARED_WEIGHTS] / memory[5] ** 2
    variance = max(noise * abs(c * U) ** 2 / abs(X) ** 4, FLOOR)
    # A motion that is not ten times its noise is none.
    if not is_steady(memory, u):
        claim_nothing(constants, memory)
        interrupt(memory)
        return
    known = min(abs(k0 * U), abs(k0 * X)) ** 2 > 100.0 * noise
    known &= variance < constants[PRIOR_VARIANCE + 2]
    known &= variance < constants[PRIOR_VARIANCE + 3] * w * w
    if not known:
        return
    # F c / X + m w^2; Numba's division of complex numbers could raise, and here nothing must.
    impedance, square = F * c * X.conjugate(), abs(X) ** 2
    k, beta = impedance.real / square + m * w * w, impedance.imag / square / w
    memory[LAST] = min(max(k, constants[LOWER + 2]), constants[UPPER + 2])
    memory[LAST + 1] = min(max(beta, constants[LOWER + 3]), constants[UPPER + 3])
    memory[LAST + 2] = variance + variance / (w * w)
    memory[LAST + 3] = variance
    memory[LAST + 4] = variance / (w * w)


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
    """Fit samples ``begin`` to ``end``; fill ``estimates`` (11, n); return how many missed."""
    missing = 0
    w = 2.0 * math.pi * constants[DRIVE_FREQUENCY]
    one_period = 1.0 / (constants[SAMPLE_PERIOD] * constants[DRIVE_FREQUENCY])
    for sample in range(begin, end):
        cosine, sine = math.cos(memory[PHASE]), math.sin(memory[PHASE])
        memory[PHASE] = (memory[PHASE] + w * constants[SAMPLE_PERIOD]) % (2.0 * math.pi)
        innovation = normalized = math.nan
        if abs(position[sample]) < LARGEST and abs(force[sample]) < LARGEST:
            settled = memory[COUNT] >= one_period and is_determined(memory)
            variance = constants[FORCE_VARIANCE] * (1.0 + 1.5 / one_period)
            if settled:
                f = solve(memory, WITH_FORCE)
                memory[LAST + 7] = f[0] * cosine + f[1] * sine + f[2]
            innovation = force[sample] - memory[LAST + 7]
            if settled:
                judge_noise(memory, innovation * innovation / variance)
                standard = innovation / math.sqrt(variance)
                if memory[COUNT] >= SETTLED_PERIODS * one_period:
                    judge_model(constants, memory, position[sample], innovation, standard)
            else:  # nothing was predicted yet
                variance += innovation * innovation
            normalized = innovation * innovation / variance
            collect(constants, memory, cosine, sine, position[sample], force[sample])
            if memory[COUNT] >= one_period and is_determined(memory):
                estimate(constants, memory, w)
            if has_recovered(memory):
                start(constants, memory)
        else:
            missing += 1
        record(constants, memory, estimates, sample, innovation, normalized)
    return missing
