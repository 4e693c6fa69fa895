"""Recordings with a hidden effect, and what was hidden.

Contents: drawing a specimen, hiding effects in it, measuring it twice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from tissue_probe.challenge.case import Case
from tissue_probe.challenge.change import Change, HiddenEffect, log_uniform
from tissue_probe.challenge.coil import Coil
from tissue_probe.challenge.instrument import (
    CHALLENGE_RATE,
    FORCE_NOISE,
    InstrumentErrors,
    pink_noise,
)
from tissue_probe.challenge.instrumental import INSTRUMENTAL, SPOILING_EFFECTS
from tissue_probe.challenge.measured_motion import Measured
from tissue_probe.challenge.mechanical import MECHANICAL, ONLY_BY_NAME
from tissue_probe.challenge.outside import OUTSIDE
from tissue_probe.challenge.specimen import Specimen
from tissue_probe.challenge.strength import Hidden, hide
from tissue_probe.challenge.tolerances import Tolerances
from tissue_probe.challenge.trajectory import DURATIONS, MULTISINE_LINES, Kind, Trajectory
from tissue_probe.errors import ParameterError
from tissue_probe.signals import FloatArray

LIBRARY: dict[str, HiddenEffect] = {**MECHANICAL, **INSTRUMENTAL}
"""Effects that a diagnosis should name."""

SIMULATED_EFFECTS: dict[str, HiddenEffect] = {
    **LIBRARY,
    **ONLY_BY_NAME,
    **OUTSIDE,
    **SPOILING_EFFECTS,
}
"""Everything that can be hidden, by name."""

Rig = Literal["exact", "tolerant"]

Excitation = Kind | Measured

PINK_NOISE = 1e-3  # N rms
WEAKEST, STRONGEST = 1.4, 25.0
WEAKEST_OF_TWO = 2.0


@dataclass(frozen=True)
class SimulatedRecord:
    """What the probe measured, 2 kHz; time [s], position [m], force [N], sample period [s]."""

    time: FloatArray
    position: FloatArray
    force: FloatArray
    sample_period: float = 1.0 / CHALLENGE_RATE


@dataclass(frozen=True)
class HiddenTruth:
    """What was hidden.

    Attributes
    ----------
    effects : tuple of str
        Names; none for a clean recording.
    families : tuple of str
        Of the effects.
    parameters : dict
        For each effect what it set, SI units.
    strengths : dict
        How strong each effect was made, in the measure of its table.
    ratios : dict
        For each effect alone: rms that the best Kelvin-Voigt fit leaves, in units of the noise.
    shown : dict
        The same, where the fit may also move the rig within its tolerances.
    targets : dict
        The ratios asked for.
    ratio : float
        The same of all effects together.
    absorbed : tuple of str
        Effects that a Kelvin-Voigt model absorbs under this excitation, at a typical strength.
    tissue, rig, excitation, second_excitation : dict
        Numbers without the effects; ``rig`` holds the true constants, not the nominal ones. Of an
        excitation that was measured its source, too, and how it starts.
    seed : int
        Makes the same challenge again.
    """

    effects: tuple[str, ...]
    families: tuple[str, ...]
    parameters: dict[str, dict[str, Any]]
    strengths: dict[str, float]
    targets: dict[str, float]
    ratios: dict[str, float]
    shown: dict[str, float]
    ratio: float
    absorbed: tuple[str, ...]
    tissue: dict[str, float]
    rig: dict[str, Any]
    excitation: dict[str, Any]
    second_excitation: dict[str, Any]
    seed: int


@dataclass(frozen=True)
class Challenge:
    """A recording, a second one of the same specimen with another trajectory, and the answer."""

    recording: SimulatedRecord
    second: SimulatedRecord
    answer: HiddenTruth


def make_challenge(
    seed: int,
    effects: Sequence[str] = ("cubic_stiffening",),
    excitation: Excitation = "chirp60",
    rig: Rig = "exact",
    preload: float | None = None,
    coil: Coil | None = None,
    leaves: float | None = None,
) -> Challenge:
    """Simulate a recording of a random tissue with hidden effects.

    Stiffness is drawn from 150 to 3000 N/m, damping from 0.5 to 15 N s/m, the amplitude of the coil
    from 0.8 to 1.2 mm; each effect is made so strong that the best Kelvin-Voigt fit leaves 1.4 to
    25 times the noise (2 to 25 with each of two), as far as it can.

    Parameters
    ----------
    seed : int
        The same arguments give the same challenge.
    effects : sequence of str
        Names in ``SIMULATED_EFFECTS``; none for a clean recording.
    excitation : str or Measured
        One of ``DURATIONS``; or a motion that was measured, of which amplitude, preload and the
        coil's faults are kept.
    rig : {"exact", "tolerant"}
        Whether the rig is the nominal one, or off within its tolerances.
    preload : float, optional
        Mean displacement of the coil [m]; by default none or, as often, 1 to 3 mm, or what was
        measured. Effects that show only where the force comes near zero draw their own.
    coil : Coil, optional
        Faults of the coil; drawn by default. A motion that was measured has none added.
    leaves : float, optional
        The residual that the best Kelvin-Voigt fit leaves of each effect alone, in units of the
        noise, larger than 1, as far as the effect can; drawn by default. All else stays the same.

    Raises
    ------
    ValueError
        If a name is not known, one effect is given twice, or an effect is to leave the noise only.
    """
    _check(effects, excitation, rig)
    if leaves is not None and not leaves > 1.0:
        raise ParameterError(f"an effect leaves more than the noise: above 1, not {leaves:g}")
    random = np.random.default_rng(seed)
    coil = Coil.draw(random.spawn(1)[0]) if coil is None else coil
    pressed = random.uniform(1e-3, 3e-3) if random.random() < 0.5 else 0.0
    if isinstance(excitation, Measured):
        pressed = excitation.preload
    first, other = _trajectories(random, excitation, coil)
    tolerances = Tolerances() if rig == "tolerant" else None
    clean = Case(*_rig_and_tissue(random, tolerances), first)
    clean = clean.press_in(pressed if preload is None else preload)
    case, hidden = _hide(effects, clean, random, tolerances, leaves)
    second = replace(_phases_anew(case, random), trajectory=other)
    second = second.press_in(case.trajectory.preload)
    answer = HiddenTruth(
        effects=tuple(effects),
        families=tuple(SIMULATED_EFFECTS[name].family for name in effects),
        parameters={name: _parameters(hidden[name].change) for name in effects},
        strengths={name: hidden[name].strength for name in effects},
        targets={name: hidden[name].target for name in effects},
        ratios={name: hidden[name].ratio for name in effects},
        shown={name: hidden[name].shown for name in effects},
        ratio=case.ratio(clean.specimen),
        absorbed=tuple(name for name in effects if hidden[name].absorbed),
        tissue={"stiffness": clean.specimen.stiffness, "damping": clean.specimen.damping},
        rig=_rig(clean, rig),
        excitation=_excitation(case.trajectory),
        second_excitation=_excitation(second.trajectory),
        seed=seed,
    )
    return Challenge(_measure(case, random), _measure(second, random), answer)


def _check(effects: Sequence[str], excitation: Excitation, rig: str) -> None:
    if unknown := [name for name in effects if name not in SIMULATED_EFFECTS]:
        raise ParameterError(
            f"there is no effect {unknown[0]!r}; there are {', '.join(SIMULATED_EFFECTS)}"
        )
    if len(set(effects)) < len(effects):
        raise ParameterError(f"{', '.join(effects)}: an effect can be hidden once only")
    if not isinstance(excitation, Measured) and excitation not in DURATIONS:
        raise ParameterError(
            f"there is no excitation {excitation!r}; there are {', '.join(DURATIONS)}"
        )
    if rig not in ("exact", "tolerant"):
        raise ParameterError(f"there is no rig {rig!r}; there are exact, tolerant")


def _rig_and_tissue(
    random: np.random.Generator, tolerances: Tolerances | None
) -> tuple[Specimen, InstrumentErrors]:
    tissue = Specimen(
        stiffness=log_uniform(random, 150.0, 3000.0), damping=log_uniform(random, 0.5, 15.0)
    )
    deviations = random.standard_normal(len(Tolerances._fields))
    if tolerances is None:
        return tissue, InstrumentErrors()
    specimen, zero = tolerances.draw_rig(tissue, deviations)
    return specimen, InstrumentErrors(contact_zero=zero, pink_noise=PINK_NOISE)


def _trajectories(
    random: np.random.Generator, excitation: Excitation, coil: Coil
) -> tuple[Trajectory, Trajectory]:
    """Return the motions of both recordings; the second is broadband, and not the first's."""
    if isinstance(excitation, Measured):
        other = _trajectory(random, "msine60", excitation.duration, coil)
        return Trajectory.follow_motion(excitation), replace(other, amplitude=excitation.amplitude)
    kinds = (excitation, "chirp60" if excitation == "msine60" else "msine60")
    first, other = (_trajectory(random, kind, DURATIONS[excitation], coil) for kind in kinds)
    return first, other


def _trajectory(random: np.random.Generator, kind: str, duration: float, coil: Coil) -> Trajectory:
    phases = tuple(random.uniform(0.0, 2.0 * np.pi, MULTISINE_LINES).tolist())
    return Trajectory(kind, random.uniform(0.8e-3, 1.2e-3), duration, phases=phases, coil=coil)


def _hide(
    effects: Sequence[str],
    clean: Case,
    random: np.random.Generator,
    tolerances: Tolerances | None,
    leaves: float | None,
) -> tuple[Case, dict[str, Hidden]]:
    """Hide the effects, each scaled alone; those that need a preload of their own come first."""
    case, hidden = clean, {}
    weakest = WEAKEST if len(effects) < 2 else WEAKEST_OF_TWO
    for name in sorted(effects, key=lambda name: not SIMULATED_EFFECTS[name].sets_preload):
        target, seed = log_uniform(random, weakest, STRONGEST), int(random.integers(2**32))
        target = target if leaves is None else leaves
        alone = clean.press_in(case.trajectory.preload)
        hidden[name] = hide(SIMULATED_EFFECTS[name], alone, target, seed, tolerances)
        case = case.apply_change(hidden[name].change)
    return case, hidden


def _phases_anew(case: Case, random: np.random.Generator) -> Case:
    """Return the case at another time: hum and motion of the body are elsewhere in their cycle.

    The tissue remembers how deep it was pressed, and how far it was worked.
    """
    surface, hum = random.uniform(0.0, 2.0 * np.pi, 2)
    way = np.abs(np.diff(case.trajectory.sample_motion(CHALLENGE_RATE)[0])).sum()
    return replace(
        case,
        specimen=case.specimen._replace(
            surface_phase=surface,
            damage_reached=case.situation.depth,
            worked_before=float(way),
        ),
        instrument=replace(case.instrument, hum_phase=hum),
    )


def _measure(case: Case, random: np.random.Generator) -> SimulatedRecord:
    count = case.samples
    noise = FORCE_NOISE * random.standard_normal(count)
    noise += case.instrument.pink_noise * pink_noise(count, random)
    position, force = case.measure(noise)
    return SimulatedRecord(np.arange(count) / CHALLENGE_RATE, position, force)


def _parameters(change: Change) -> dict[str, Any]:
    return {**change.specimen, **change.instrument}


def _rig(case: Case, rig: str) -> dict[str, Any]:
    specimen = case.specimen
    return {
        "name": rig,
        "tip_mass": specimen.tip_mass,
        "load_cell_stiffness": specimen.load_cell_stiffness,
        "load_cell_damping": specimen.load_cell_damping,
        "contact_zero": case.instrument.contact_zero,
    }


def _excitation(trajectory: Trajectory) -> dict[str, Any]:
    told = {
        "kind": trajectory.kind,
        "amplitude": trajectory.amplitude,
        "preload": trajectory.preload,
        "duration": trajectory.duration,
        "coil": trajectory.coil._asdict(),
    }
    if trajectory.measured is not None:
        told["source"] = trajectory.measured.source
        told["starts"] = "at-rest" if trajectory.from_rest else "moving"
    return told
