"""Effects in the mechanics: tissue, contact, friction, inertia, motion of the body.

Contents: what each sets, from textbooks.
"""

from __future__ import annotations

from math import gamma, pi

import numpy as np

from tissue_probe.challenge.change import Change, HiddenEffect, Situation, log_uniform, sign

Random = np.random.Generator

FASTEST, SLOWEST, LOG_STEP = 6000.0, 0.01, 0.6  # rates of a springpot's branches [1/s]


def _standard_linear_solid(strength: float, at: Situation, random: Random) -> Change:
    """Spring k1 in series with a damper, beside k and beta (Fung, 1993, section 2.11)."""
    return _branches(at, [strength], [log_uniform(random, 0.01, 0.3)])


def _generalized_maxwell(strength: float, at: Situation, random: Random) -> Change:
    """Two such branches, their times apart (Findley et al., 1976, section 5.5)."""
    share = random.uniform(0.3, 0.7)
    times = [log_uniform(random, 0.005, 0.03), log_uniform(random, 0.1, 0.6)]
    return _branches(at, [strength * share, strength * (1.0 - share)], times)


def _branches(at: Situation, shares: list[float], times: list[float]) -> Change:
    stiffness = tuple(share * at.specimen.stiffness for share in shares)
    return Change({"branch_stiffness": stiffness, "branch_rate": tuple(1.0 / t for t in times)})


def _springpot(strength: float, at: Situation, random: Random) -> Change:
    """Power law c D^alpha x: relaxation as c t^-alpha / Gamma(1 - alpha) (Bagley and Torvik, 1983).

    t^-alpha = integral of r^(alpha - 1) exp(-r t) dr / Gamma(alpha), taken by the trapezoidal rule
    in log r. What relaxes more slowly than 0.01 /s is a spring, what faster than 6000 /s a damper.
    """
    order = random.uniform(0.15, 0.6)
    scale = strength * at.specimen.stiffness / (2.0 * pi * 10.0) ** order
    density = scale / (gamma(order) * gamma(1.0 - order))
    rates = np.exp(np.arange(np.log(SLOWEST) + LOG_STEP / 2.0, np.log(FASTEST), LOG_STEP))
    last = rates[-1] * np.exp(LOG_STEP / 2.0)
    return Change(
        {
            "branch_stiffness": tuple((density * LOG_STEP * rates**order).tolist()),
            "branch_rate": tuple(rates.tolist()),
            "stiffness": at.specimen.stiffness + density * SLOWEST**order / order,
            "damping": at.specimen.damping + density * last ** (order - 1.0) / (1.0 - order),
        }
    )


def _quasi_linear_relaxation(strength: float, at: Situation, random: Random) -> Change:
    """One to three branches whose springs are curved as the tissue's own (Fung, 1993, 7.6)."""
    times = [log_uniform(random, 0.01, 0.03), log_uniform(random, 0.1, 0.6)]
    times = [times, times[:1], [*times, log_uniform(random, 1.0, 3.0)]][random.integers(3)]
    change = _branches(at, [strength / len(times)] * len(times), times)
    return Change({**change.specimen, "branch_curved": 1.0})


#: (a, b, c) of g(T) = a exp(-b T^1/2) + (1 - a) exp(-c T) under a sphere, a cone and a flat punch.
POROELASTIC = ((0.491, 0.908, 1.679), (0.493, 0.822, 1.348), (1.304, 1.0, 0.254))


def _poroelastic_relaxation(strength: float, at: Situation, random: Random) -> Change:
    """Fluid in pores: the part g(T) of a force is left, T the time over that of diffusion.

    (Hu et al., 2010.) The first term of g is an integral over rates r of exp(-r T) with the density
    b / (2 pi^1/2) r^-3/2 exp(-b^2 / 4r) (P. Levy, 1939), taken by the trapezoidal rule in log r;
    what relaxes faster than 6000 /s is a damper.
    """
    a, b, c = POROELASTIC[random.integers(len(POROELASTIC))]
    fastest = FASTEST * (time := log_uniform(random, 0.02, 0.6))
    rates = np.exp(np.arange(np.log(fastest) - LOG_STEP / 2.0, np.log(0.01), -LOG_STEP))
    density = a * b / (2.0 * pi**0.5) * rates**-0.5 * np.exp(-(b**2) / (4.0 * rates))
    springs = strength * at.specimen.stiffness * np.append(LOG_STEP * density, 1.0 - a)
    damper = strength * at.specimen.stiffness * a * b * time / (3.0 * pi**0.5) * fastest**-1.5
    return Change(
        {
            "branch_stiffness": tuple(springs.tolist()),
            "branch_rate": tuple((np.append(rates, c) / time).tolist()),
            "damping": at.specimen.damping + damper,
        }
    )


def _cubic_stiffening(strength: float, at: Situation, random: Random) -> Change:
    return Change({"cubic": strength * at.specimen.stiffness / at.depth**2})


def _saturating_spring(strength: float, at: Situation, random: Random) -> Change:
    """Soften by a hyperbola (Kondner, 1963), or, as often, by a tanh."""
    law = ("hyperbola_depth", "saturation_depth")[random.integers(2)]
    return Change({law: at.depth / strength})


def _exponential_stiffening(strength: float, at: Situation, random: Random) -> Change:
    return Change({"fung": strength / at.depth})


def _hertz_contact(strength: float, at: Situation, random: Random) -> Change:
    """Force as x^n, n = 1 + strength, in contact that cannot pull; never from the surface itself.

    Without a preload, or with next to none, the loss of contact would hide the exponent.
    """
    light = random.uniform(1.0, 1.4) * _find_holding_preload(at, 0.0)
    return Change(
        {"hertz_exponent": 1.0 + strength, "hertz_depth": at.depth, "unilateral": 1.0},
        preload=at.preload if at.preload > 0.5 * at.amplitude else light,
    )


def _hunt_crossley(strength: float, at: Situation, random: Random) -> Change:
    exponent = float(random.choice((1.0, 1.5)))
    growth = strength * at.specimen.damping / at.depth**exponent
    return Change({"depth_damping": growth, "depth_exponent": exponent})


def _bilinear_spring(strength: float, at: Situation, random: Random) -> Change:
    """Turn stiffer, or, as often, softer, at the surface or within the travel (Shaw, 1983)."""
    low, high = at.preload - at.amplitude, at.preload + at.amplitude
    knee = low + random.uniform(0.3, 0.7) * (high - low)
    surface = random.random() < 0.5
    change = strength if random.random() < 0.5 else -strength / (1.0 + strength)
    return Change({"knee_stiffness": change, "knee": 0.0 if surface and low < 0.0 else knee})


def _damage_by_depth(strength: float, at: Situation, random: Random) -> Change:
    """Lose stiffness by the largest depth (Simo, 1987), or, as often, off it (Ogden, 1999)."""
    law = {"damage": strength, "damage_depth": random.uniform(0.3, 1.5) * at.depth}
    return Change({**law, "damage_returns": float(random.integers(2))})


def _preconditioning(strength: float, at: Situation, random: Random) -> Change:
    """Lose stiffness by the way of some cycles, or of many (Fung, 1993, chapter 7)."""
    cycles = log_uniform(random, 2.0, 30.0)
    return Change({"worked_off": strength, "working_path": 4.0 * cycles * at.amplitude})


def _nonlinear_damping(strength: float, at: Situation, random: Random) -> Change:
    """Quadratic, a power (Cross, 1965), by the direction, or of the recent speed (Barnes, 1997)."""
    beta, law = at.specimen.damping, random.integers(4)
    exponent, time = random.choice((0.5, 2.5)), log_uniform(random, 0.05, 0.3)
    if law == 0:
        return Change({"drag": strength * beta / at.speed})
    if law == 1:
        return Change({"power_damping": strength * beta, "power_exponent": exponent})
    if law == 2:
        return Change({"one_way_damping": strength * beta})
    return Change({"agile_damping": strength * beta / at.speed, "agile_time": time})


def _contact_loss(strength: float, at: Situation, random: Random) -> Change:
    """Press the tip in lightly: the more so, the longer it is in the air."""
    return Change({"unilateral": 1.0}, preload=(1.0 - strength) * _find_holding_preload(at, 0.0))


def _adhesion(strength: float, at: Situation, random: Random) -> Change:
    """Let the contact tear off at a pull; it and the time in the air grow with the strength.

    The weakest pull is a share of the tissue's force that a load cell can tell from none, since
    what is left without it is another effect (``contact_loss``).
    """
    share = random.uniform(0.25, 0.5) * np.sqrt(strength)
    pull = float(share * at.specimen.stiffness * at.amplitude)
    preload = (1.0 - strength) * _find_holding_preload(at, pull)
    return Change({"unilateral": 1.0, "pull_off": pull}, preload=preload)


def _adhesion_within_range(strength: float, at: Situation, random: Random) -> Change:
    """Let the bond give way over a part of the travel, evenly or, as often, as an exponential.

    It pulls as adhesion at once does, and the tip is as lightly pressed in (Barenblatt, 1962).
    """
    change = _adhesion(strength, at, random)
    law = {"bond_range": log_uniform(random, 0.05, 0.6) * at.amplitude}
    law["bond_threads"] = float(random.integers(2))
    return Change({**change.specimen, **law}, preload=change.preload)


def _find_holding_preload(at: Situation, pull: float) -> float:
    """Preload that keeps the tip on the tissue throughout [m], 4 mm at the most.

    The tissue's force swings by |k + i w beta| |x|, most at one of the excitation's frequencies.
    """
    rig, w = at.specimen, 2.0 * pi * np.arange(1.0, at.highest + 1.0)
    cell = rig.load_cell_stiffness + 1j * w * rig.load_cell_damping
    tissue = rig.stiffness + 1j * w * rig.damping
    swing = at.amplitude * np.abs(tissue * cell / (cell + tissue - rig.tip_mass * w**2)).max()
    preload: float = min(max(1.1 * swing - pull, 0.1 * swing) / rig.stiffness, 4e-3)
    return preload


def _coulomb_friction(strength: float, at: Situation, random: Random) -> Change:
    force = strength * _vibration(at)
    return Change({"coulomb": force, "static": force})


def _stribeck_friction(strength: float, at: Situation, random: Random) -> Change:
    force = strength * _vibration(at)
    static = force * random.uniform(1.5, 2.5)
    velocity = log_uniform(random, 2e-3, 1e-2)
    return Change({"coulomb": force, "static": static, "stribeck_velocity": velocity})


def _bouc_wen_hysteresis(strength: float, at: Situation, random: Random) -> Change:
    """Friction that yields first: with beta = gamma, or, as often, with a loop of another shape.

    It slides at z = 1 / (beta + gamma) = 1; the less gamma, the fuller the loop. One in three is
    of beta = gamma and weakens with the work done (Baber and Wen, 1981), by half within the way of
    4 to 60 sines.
    """
    yielding = log_uniform(random, 3e-5, 2e-4)
    beta = float(random.choice((0.5, random.uniform(0.3, 2.0))))
    weakening = 0.25 / (log_uniform(random, 4.0, 60.0) * at.amplitude)
    weakens = random.random() < 1.0 / 3.0
    return Change(
        {
            "bouc_force": strength * _vibration(at),
            "bouc_yield": yielding,
            "bouc_beta": 0.5 if weakens else beta,
            "bouc_gamma": 0.5 if weakens else 1.0 - beta,
            "bouc_weakening": weakening if weakens else 0.0,
        }
    )


def _prandtl_ishlinskii(strength: float, at: Situation, random: Random) -> Change:
    """Twelve springs behind sliders, whose shares of the force go as a power of their reach.

    Reaches are spread by their logarithm over a decade and a half (Segalman, 2005, on the power).
    """
    longest = log_uniform(random, 0.2, 1.0) * at.amplitude
    reaches = longest * np.geomspace(1.0 / 30.0, 1.0, 12)
    shares = (reaches / longest) ** random.uniform(0.0, 1.0)
    forces = strength * _vibration(at) * shares / shares.sum()
    return Change(
        {
            "slider_stiffness": tuple((forces / reaches).tolist()),
            "slider_reach": tuple(reaches.tolist()),
        }
    )


def _vibration(at: Situation) -> float:
    """Amplitude of the tissue's force in a sine of 10 Hz [N]."""
    k, beta = at.specimen.stiffness, at.specimen.damping
    return at.amplitude * abs(complex(k, 2.0 * pi * 10.0 * beta))


def _backlash(strength: float, at: Situation, random: Random) -> Change:
    """Play shows only where the force changes its sign: so pressed in lightly."""
    return Change({"play": strength}, preload=random.uniform(0.0, 0.5) * at.amplitude)


def _added_mass(strength: float, at: Situation, random: Random) -> Change:
    return Change({"tip_mass": (1.0 + strength) * at.specimen.tip_mass})


def _structural_mode(strength: float, at: Situation, random: Random) -> Change:
    """Mass on spring and damper on the tip (Den Hartog, 1956, section 3.2)."""
    mass = strength * at.specimen.tip_mass
    rate = 2.0 * pi * log_uniform(random, 15.0, 80.0)
    ratio = log_uniform(random, 0.03, 0.2)
    return Change(
        {
            "mode_mass": mass,
            "mode_stiffness": mass * rate**2,
            "mode_damping": 2.0 * ratio * mass * rate,
        }
    )


def _load_cell_stiffness_error(strength: float, at: Situation, random: Random) -> Change:
    k0 = at.specimen.load_cell_stiffness
    return Change({"load_cell_stiffness": k0 * (1.0 + sign(random) * strength)})


def _tissue_motion(strength: float, at: Situation, random: Random) -> Change:
    """Breathing (0.2 to 0.5 Hz) or heartbeat (1 to 2 Hz)."""
    low, high = ((0.2, 0.5), (1.0, 2.0))[random.integers(2)]
    return Change(
        {
            "surface_amplitude": strength,
            "surface_frequency": random.uniform(low, high),
            "surface_phase": random.uniform(0.0, 2.0 * pi),
        }
    )


def _stiffness_step(strength: float, at: Situation, random: Random) -> Change:
    time = random.uniform(0.2, 0.8) * at.duration
    return Change({"step": sign(random) * strength, "step_time": time})


def _stiffness_ramp(strength: float, at: Situation, random: Random) -> Change:
    return Change({"ramp": sign(random) * strength / at.duration})


MECHANICAL: dict[str, HiddenEffect] = {
    "standard_linear_solid": HiddenEffect("relaxation", _standard_linear_solid, 3e-3, 0.5, 10.0),
    "generalized_maxwell": HiddenEffect("relaxation", _generalized_maxwell, 3e-3, 0.5, 10.0),
    "springpot": HiddenEffect("relaxation", _springpot, 3e-3, 0.5, 10.0),
    "quasi_linear_relaxation": HiddenEffect(
        *("relaxation", _quasi_linear_relaxation, 3e-3, 0.5, 10.0),
        beside=(
            *("cubic_stiffening", "exponential_stiffening", "hertz_contact"),
            "saturating_spring",
        ),
    ),
    "cubic_stiffening": HiddenEffect("stiffening", _cubic_stiffening, 1e-3, 0.3, 10.0),
    "exponential_stiffening": HiddenEffect("stiffening", _exponential_stiffening, 1e-3, 0.5, 3.0),
    "hertz_contact": HiddenEffect("stiffening", _hertz_contact, 0.1, 0.5, 1.5, sets_preload=True),
    "saturating_spring": HiddenEffect("stiffening", _saturating_spring, 0.03, 0.7, 6.0),
    "bilinear_spring": HiddenEffect("stiffening", _bilinear_spring, 1e-3, 0.5, 10.0),
    "damage_by_depth": HiddenEffect("damage", _damage_by_depth, 1e-3, 0.4, 0.95),
    "preconditioning": HiddenEffect("damage", _preconditioning, 1e-3, 0.4, 0.95),
    "nonlinear_damping": HiddenEffect("damping", _nonlinear_damping, 1e-3, 0.3, 30.0),
    "hunt_crossley": HiddenEffect("stiffening", _hunt_crossley, 3e-3, 1.0, 30.0),
    "contact_loss": HiddenEffect("contact", _contact_loss, 0.01, 0.5, 1.0, sets_preload=True),
    "adhesion": HiddenEffect("contact", _adhesion, 0.1, 0.5, 1.0, sets_preload=True),
    "adhesion_within_range": HiddenEffect(
        *("contact", _adhesion_within_range, 0.1, 0.5, 1.0), sets_preload=True
    ),
    "coulomb_friction": HiddenEffect("friction", _coulomb_friction, 1e-3, 0.1, 0.6),
    "stribeck_friction": HiddenEffect("friction", _stribeck_friction, 1e-3, 0.1, 0.4),
    "bouc_wen_hysteresis": HiddenEffect("friction", _bouc_wen_hysteresis, 1e-3, 0.2, 2.0),
    "prandtl_ishlinskii": HiddenEffect("friction", _prandtl_ishlinskii, 1e-3, 0.2, 2.0),
    "backlash": HiddenEffect("lost motion", _backlash, 1e-7, 3e-5, 3e-4, sets_preload=True),
    "added_mass": HiddenEffect("inertia", _added_mass, 3e-3, 0.3, 3.0),
    "structural_mode": HiddenEffect("inertia", _structural_mode, 3e-3, 0.2, 2.0),
    "load_cell_stiffness_error": HiddenEffect("scale", _load_cell_stiffness_error, 2e-3, 0.1, 0.4),
    "tissue_motion": HiddenEffect("body motion", _tissue_motion, 1e-6, 1e-4, 2e-3),
    "stiffness_step": HiddenEffect("time-varying", _stiffness_step, 1e-3, 0.2, 0.8),
    "stiffness_ramp": HiddenEffect("time-varying", _stiffness_ramp, 1e-3, 0.2, 0.8),
}
"""Effects of the library that lie in the mechanics, by name: those that a diagnosis tries."""

ONLY_BY_NAME: dict[str, HiddenEffect] = {
    "poroelastic_relaxation": HiddenEffect("relaxation", _poroelastic_relaxation, 3e-3, 0.5, 10.0),
}
"""Those that a diagnosis tries only where it is asked to, and that no series hides by itself."""
