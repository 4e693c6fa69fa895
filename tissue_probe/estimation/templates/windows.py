# ruff: noqa: F821
"""Samples of a rigid probe, window by window: no measured signal is differentiated.

The force follows the position with no motion in between (``Rig.tip_is_position``),

    F = m u'' + k u + beta u' + d,

but u' and u'' are not measured, and the differences of a noisy position are mostly noise, by which
the damping would come out too small. So both sides are multiplied by a weight phi that vanishes
with its derivatives at both ends of a window, and integrated by parts (modulating functions:
Shinbrot, Trans. ASME 79, 1957; Preisig and Rippin, Computers and Chemical Engineering 17, 1993):

    <phi F> = m <phi'' u> + k <phi u> - beta <phi' u> + d,  <phi> = 1

This is exact for any motion. With phi = sin^4(pi t / T) sums over the samples, each in the
middle of its share of the window, stand for the integrals to (pi / n)^4 / 13, n samples to a
window. Windows follow one another by half their length: then they hold nearly all that the samples
tell, and the noise of neighbours has the correlation 3/35 only. A motion of f > 1.5 / T hardly
gets through. Each complete window is one measured force of the filter, whose u, u', u'' lie where
other rigs keep their past inputs.

Never imported: this text becomes part of a kernel module (see ``loop``).
"""

# Sums of a window: of phi u, -phi' u, phi'' u, phi F. PRIMED counts the samples since the begin.
SUMS = 4
# By how much the correlation of neighbours enlarges the variance of a slow motion's estimate.
OVERLAP = 1.0 + 2.0 * 3.0 / 35.0


@njit(error_model="numpy")
def take_in(constants, memory, position, force):
    """Add a sample to both windows; return whether one is complete, and its force [N]."""
    if not abs(force) < LARGEST:
        memory[PRIMED] = 0.0
        return True, math.nan
    length, taken = constants[WINDOW], memory[PRIMED]
    if taken == 0.0:
        memory[WINDOWS : WINDOWS + 2 * SUMS] = 0.0
    else:
        predict(constants, memory)
    memory[PRIMED] = taken + 1.0
    due, measured = False, math.nan
    for window in range(2):
        since = taken - 0.5 * length * window
        place = WINDOWS + SUMS * window
        if since < 0.0:
            continue
        inside = since % length
        add(memory, place, math.pi * (inside + 0.5) / length, position, force)
        if inside == length - 1.0:
            due, measured = True, complete(constants, memory, place)
    return due, measured


@njit(error_model="numpy")
def add(memory, place, angle, position, force):
    """Add a sample to a window's sums; ``angle`` goes from 0 to pi. By t the factor is pi / T."""
    s, c = math.sin(angle), math.cos(angle)
    weight = s * s * s * s
    memory[place] += weight * position
    memory[place + 1] -= 4.0 * s * s * s * c * position
    memory[place + 2] += (12.0 * s * s * c * c - 4.0 * weight) * position
    memory[place + 3] += weight * force


@njit(error_model="numpy")
def complete(constants, memory, place):
    """Make of a window's sums the regressors u, u', u''; return its force, and empty it."""
    whole = 3.0 / 8.0 * constants[WINDOW]
    rate = math.pi / (constants[WINDOW] * constants[SAMPLE_PERIOD])
    memory[HISTORY] = memory[place] / whole
    memory[HISTORY + 1] = rate * memory[place + 1] / whole
    memory[HISTORY + 2] = rate * rate * memory[place + 2] / whole
    force = memory[place + 3] / whole
    memory[place : place + SUMS] = 0.0
    return force


@njit(error_model="numpy")
def noise(constants, memory):
    """Return the variance [N^2] of a window's force against one of the model: of both channels.

    Noise of the position acts as k phi - beta phi' + m phi'' make of it.
    """
    k, beta, m = memory[STIFFNESS], memory[DAMPING], constants[TIP_MASS]
    square = (math.pi / (constants[WINDOW] * constants[SAMPLE_PERIOD])) ** 2
    through = 35.0 / 18.0 * k * k + 40.0 / 9.0 * square * (beta * beta - 2.0 * k * m)
    through += 256.0 / 9.0 * square * square * m * m
    position = constants[ENCODER_RESOLUTION] ** 2 / 12.0
    force = 35.0 / 18.0 * constants[FORCE_VARIANCE]
    return OVERLAP * (force + position * through) / constants[WINDOW]
