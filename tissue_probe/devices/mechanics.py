"""The simulated probe's motion, in Numba's Python.

What belongs here: the equations of ``simulated``, and their integration.
What does not: clock, noise, encoder (``simulated``).

Never imported: this text is the module of which ``machine_code`` makes machine code.
"""

from numba import carray, cfunc, njit
from numba.np.unsafe.ndarray import to_fixed_tuple

from tissue_probe.devices.simulated import ATTACHED, STAGE_TIME_CONSTANT, SUCTION_REACH

_P = "CPointer(float64)"


@njit(error_model="numpy")
def _derivative(state, attached, voltage, constants):
    """Right-hand side of the module's equations; the state is i, u, u', x, x', d."""
    i, u, v, x, w, d = state
    inductance, resistance, force_constant, coil_mass, c, s, k0, beta0, m, k, beta, target = (
        constants
    )
    d_rate = (target - d) / STAGE_TIME_CONSTANT
    cell = k0 * (u - x) + beta0 * (v - w)
    tissue = k * (x + d) + beta * (w + d_rate) if attached else 0.0
    return (
        (voltage - resistance * i - force_constant * v) / inductance,
        v,
        (force_constant * i - c * v - s * u - cell) / coil_mass,
        w,
        (cell - tissue) / m,
        d_rate,
    )


@njit(error_model="numpy")
def _axpy(state, scale, slope):
    """State + scale * slope, entry by entry."""
    return (
        state[0] + scale * slope[0],
        state[1] + scale * slope[1],
        state[2] + scale * slope[2],
        state[3] + scale * slope[3],
        state[4] + scale * slope[4],
        state[5] + scale * slope[5],
    )


@njit(error_model="numpy")
def _runge_kutta_step(state, attached, voltage, constants, h):
    """One classical Runge-Kutta step of length h."""
    s1 = _derivative(state, attached, voltage, constants)
    s2 = _derivative(_axpy(state, h / 2, s1), attached, voltage, constants)
    s3 = _derivative(_axpy(state, h / 2, s2), attached, voltage, constants)
    s4 = _derivative(_axpy(state, h, s3), attached, voltage, constants)
    state = _axpy(state, h / 6, s1)
    state = _axpy(state, h / 3, s2)
    state = _axpy(state, h / 3, s3)
    return _axpy(state, h / 6, s4)


@cfunc(f"void({_P}, {_P}, {_P})", error_model="numpy")
def derivative(state, constants, filled):
    """Fill the rate of a state in contact, with no voltage on the coil."""
    now = to_fixed_tuple(carray(state, 6), 6)
    rate = _derivative(now, True, 0.0, to_fixed_tuple(carray(constants, 12), 12))
    for k in range(6):
        filled[k] = rate[k]


@cfunc(f"void({_P}, {_P}, {_P}, int32, float64, int32, {_P})", error_model="numpy")
def simulate(state, constants, command, count, sample_period, substeps, filled):
    """Sample coil displacement and load-cell force, then move on by one period, for each command.

    ``state`` is carried from call to call, changed in place. Displacements are filled in first.
    """
    now = to_fixed_tuple(carray(state, 6), 6)
    known = to_fixed_tuple(carray(constants, 12), 12)
    for n in range(count):
        filled[n] = now[1]
        filled[count + n] = known[6] * (now[1] - now[3])
        if now[5] >= -1e-6:
            state[ATTACHED] = 1.0
        elif now[5] < -SUCTION_REACH:
            state[ATTACHED] = 0.0
        for _ in range(substeps):
            now = _runge_kutta_step(
                now, state[ATTACHED] != 0.0, command[n], known, sample_period / substeps
            )
    for k in range(6):
        state[k] = now[k]
