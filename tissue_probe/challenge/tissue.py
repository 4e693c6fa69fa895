"""Forces of the tissue on the tip, positive where the tissue pushes back.

Contents: the textbook formulas, compiled.
"""

from __future__ import annotations

import math

from numba import njit

from tissue_probe.challenge.specimen import Specimen


@njit(cache=True, nogil=True, error_model="numpy")
def surface(p: Specimen, time: float) -> tuple[float, float]:
    """Displacement and velocity of the tissue's surface: d = D sin(2 pi f t + phase)."""
    if p.surface_amplitude == 0.0:
        return 0.0, 0.0
    rate = 2.0 * math.pi * p.surface_frequency
    angle = rate * time + p.surface_phase
    return p.surface_amplitude * math.sin(angle), p.surface_amplitude * rate * math.cos(angle)


@njit(cache=True, nogil=True, error_model="numpy")
def stiffness(p: Specimen, time: float, rate: float, strain: float) -> float:
    """Spring of the tissue at this time, rate of indentation and recent strain amplitude [N/m].

    k (1 + step + ramp t)(1 + c |e'|) / (1 + s a): the last is the softening under vibration that
    filled rubbers and gels show (Payne, 1962).
    """
    k = p.stiffness * (1.0 + p.ramp * max(time, 0.0))
    if time >= p.step_time:
        k += p.stiffness * p.step
    return k * (1.0 + p.rate_stiffening * abs(rate)) / (1.0 + p.softening * strain)


@njit(cache=True, nogil=True, error_model="numpy")
def elastic(p: Specimen, k: float, depth: float) -> float:
    """Return the spring's force.

    Fung (1993), section 7.5: (k/a)(exp(a e) - 1). Hertz-like: K e^n, none for e < 0, with K so that
    it is k e at ``hertz_depth``. Saturating: k L tanh(e / L), or k e / (1 + |e| / L). With a knee
    (Shaw and Holmes, 1983) another slope beyond it. Else k e + k3 e^3.
    """
    if p.fung != 0.0:
        return k / p.fung * math.expm1(p.fung * depth)
    if p.hertz_exponent != 0.0:
        return float(k * p.hertz_depth * (max(depth, 0.0) / p.hertz_depth) ** p.hertz_exponent)
    if p.saturation_depth != 0.0:
        return k * p.saturation_depth * math.tanh(depth / p.saturation_depth)
    if p.hyperbola_depth != 0.0:
        return k * depth / (1.0 + abs(depth) / p.hyperbola_depth)
    if p.knee_stiffness != 0.0 and depth > p.knee:
        return k * depth + k * p.knee_stiffness * (depth - p.knee)
    return k * depth + p.cubic * depth**3


@njit(cache=True, nogil=True, error_model="numpy")
def share_after_depth(p: Specimen, depth: float, largest: float) -> float:
    """Share of the spring's force that tissue has kept which was pressed in so far (Mullins, 1969).

    By the largest depth m: 1 - d (1 - exp(-m / D)) (Simo, 1987). Or by how far it is from there:
    1 - d erf((m^2 - e^2) / D^2), the energy of a straight spring in Ogden and Roxburgh's (1999).
    """
    most = max(largest, depth, 0.0)
    if p.damage_returns != 0.0:
        missing = max(most * most - depth * depth, 0.0)
        return 1.0 - p.damage * math.erf(missing / p.damage_depth**2)
    return 1.0 + p.damage * math.expm1(-most / p.damage_depth)


@njit(cache=True, nogil=True, error_model="numpy")
def share_after_way(p: Specimen, way: float) -> float:
    """Share of the spring's force left after a way in and out (Fung, 1993, preconditioning)."""
    return 1.0 - p.worked_off + p.worked_off * math.exp(-(way + p.worked_before) / p.working_path)


@njit(cache=True, nogil=True, error_model="numpy")
def bond(p: Specimen, depth: float) -> float:
    """Pull that a bond bears across a gap, falling evenly or as an exponential [N]."""
    gap = max(-depth, 0.0) / p.bond_range
    if p.bond_threads != 0.0:
        return p.pull_off * math.exp(-gap)
    return p.pull_off * max(1.0 - gap, 0.0)


@njit(cache=True, nogil=True, error_model="numpy")
def steepness(p: Specimen, depth: float) -> float:
    """Slope of ``elastic`` over k, of k as it is at the beginning [-]."""
    if p.fung != 0.0:
        return math.exp(p.fung * depth)
    if p.hertz_exponent != 0.0:
        n = p.hertz_exponent
        return float(n * (max(depth, 0.0) / p.hertz_depth) ** (n - 1.0))
    if p.saturation_depth != 0.0:
        return 1.0 / math.cosh(depth / p.saturation_depth) ** 2
    if p.hyperbola_depth != 0.0:
        return 1.0 / (1.0 + abs(depth) / p.hyperbola_depth) ** 2
    if p.knee_stiffness != 0.0:
        return 1.0 + (p.knee_stiffness if depth > p.knee else 0.0)
    return 1.0 + 3.0 * p.cubic * depth**2 / p.stiffness


@njit(cache=True, nogil=True, error_model="numpy")
def viscous(p: Specimen, time: float, depth: float, rate: float, agility: float) -> float:
    """Return the damper's force: (beta + lambda e^n) e' + c |e'| e' + further ones of the speed.

    The second term is of Hunt and Crossley (1975), and is none for e < 0. Further ones: a power of
    the speed, |e'| by its direction, and e' times the recent speed (``agility``; Barnes, 1997).
    """
    beta = p.damping
    if p.damping_wave != 0.0:
        angle = 2.0 * math.pi * p.damping_wave_frequency * time
        beta *= 1.0 + p.damping_wave * math.sin(angle)
    if p.depth_damping != 0.0 and depth > 0.0:
        beta += p.depth_damping * depth**p.depth_exponent
    if p.power_damping != 0.0:
        force = p.power_damping * 0.01 * (abs(rate) / 0.01) ** p.power_exponent
        return beta * rate + math.copysign(force, rate)
    beta += p.drag * abs(rate) + p.agile_damping * agility
    return beta * rate + p.one_way_damping * abs(rate)
