"""Whether fitted values are possible for the measurements: contact, softness, units.

Contents: faults of the measurements that only a fit of the base model shows.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tissue_probe.diagnosis.evidence.adequacy import leaves_only_noise
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.inspection.finding import Finding
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.ranking.other_runs import of_specimen
from tissue_probe.physics.rigs import name_rigs
from tissue_probe.quantities import FORCE, SIDE

#: Values that are fitted of every tissue.
TISSUE_VALUES = ("stiffness", "damping")
#: Share of the force's rms that no model leaves whose units are right, and where it is much.
ALL, MUCH = 1.0, 0.5
#: Standard deviations within which a fitted value is as good as 0.
ZERO_DEVIATIONS = 3.0
#: Share of the force's changes (rms) that is at most the tissue's where nothing is touched.
NOTHING_TOUCHED = 0.1
#: Tissues whose force is that of stiffness and damping.
PLAIN_TISSUES = ("kelvin_voigt", "maxwell")
#: Stiffness of no soft tissue [N/m]; and of none that a probe's load cell can feel, in multiples of
#: its own: the tip then hardly moves.
STIFFEST, BEYOND_CELL = 1e5, 5.0
#: Rigs whose position is that of the tip.
RIGS_LED = name_rigs(lambda rig: rig.tip_is_position)

HELD_OUT = (
    "One part of the record alone tells {}: no error on a part that is left out tests that. Give "
    "another recording of the same specimen to test the model on (`validate`)."
)


def check_fit(base: Fit, final: Fit) -> Iterator[Finding]:
    """Yield ``suspicious_units``, and ``not_followed``, ``no_tissue`` or ``no_contact``.

    Each where a fit shows it.

    Parameters
    ----------
    base : Fit
        The model asked about.
    final : Fit
        The best that came of it: where that explains everything, the units are right; and a
        stiffness is suspicious only if it is so in both.
    """
    if _loses(base) and not leaves_only_noise(final):
        yield Finding(
            "not_followed",
            "The model cannot follow the force at all: its error of "
            f"{FORCE.tell(base.rmse)} is {100 * base.rmse / _size(base):.3g} % of the force's rms. "
            "Check the units of position and force (`position_unit`, `force_unit`), their "
            "polarity, whether both belong together in time, and the rig's constants.",
        )
    elif _measure_force_slope(base) > BEYOND_CELL * _cell(base) and not leaves_only_noise(final):
        yield Finding(
            "suspicious_units",
            f"Force over position is {_measure_force_slope(base):.3g} N/m, and the load cell's "
            f"spring, through which it is felt, has {_cell(base):.4g} N/m: check the units "
            "(`position_unit`, `force_unit`), or state the spring (`constant` "
            "load_cell_stiffness).",
        )
    elif _is_too_stiff(base) and _is_too_stiff(final):
        yield Finding("no_tissue", _no_tissue(final))
    elif _touches_nothing(base):
        yield Finding("no_contact", _no_contact(base))


def check_held_out(final: Fit, instrument: Instrument) -> Iterator[Finding]:
    """Yield ``held_out`` where no part that is left out tests some of the specimen's values."""
    specimen = of_specimen(final.composition, instrument)
    if alone := [name for name in final.alone if name in specimen]:
        yield Finding("held_out", HELD_OUT.format(" and ".join(alone)))


def _size(fit: Fit) -> float:
    return fit.output.size(np.concatenate([m.output_values for m in fit.measurements]))


def _loses(fit: Fit) -> bool:
    """Whether a model leaves all of a measured force, or much of it and knows no tissue.

    A position that a force drives wanders where nothing holds it: that may be as far off.
    """
    if fit.output is not FORCE:
        return False
    values, deviations = fit.named(), fit.deviations()
    guessed = all(deviations[name] > abs(values[name]) for name in TISSUE_VALUES)
    return fit.rmse > (MUCH if guessed else ALL) * _size(fit)


def _is_too_stiff(fit: Fit) -> bool:
    """Whether a fitted stiffness, not one that is held, is known to be that of no soft tissue.

    The spring of a Maxwell fluid may be as stiff as it likes: the damper in series with it gives
    way.
    """
    stiffness, deviation = fit.named()["stiffness"], fit.deviations()["stiffness"]
    if not deviation > 0.0 or fit.composition.tissue == "maxwell":
        return False
    if stiffness > BEYOND_CELL * _cell(fit):
        return True
    return stiffness > max(STIFFEST, ZERO_DEVIATIONS * deviation)


def _measure_force_slope(fit: Fit) -> float:
    """Return the rms of the force's changes over that of the position's [N/m].

    Through a spring it is no more than that of the spring, if no mass is in resonance with it.
    """
    return float(max(np.std(m.force) / np.std(m.position) for m in fit.measurements))


def _cell(fit: Fit) -> float:
    """Stiffness of the load cell [N/m]; infinite where the rig has no spring."""
    return fit.named().get("load_cell_stiffness", np.inf)


def _no_tissue(fit: Fit) -> str:
    stiffness, cell = fit.named()["stiffness"], _cell(fit)
    if np.isfinite(cell):
        return (
            f"No soft tissue: a stiffness of {stiffness:.3g} N/m is {stiffness / cell:.3g} times "
            f"the load cell's {cell:.4g} N/m, so that the tip hardly moves and nothing is told of "
            "the specimen. Look whether it presses on a rigid stop; check the units "
            "(`position_unit`, `force_unit`), the load cell (`constant` load_cell_stiffness), and "
            f"whether the position is that of the tip (`rig` {RIGS_LED})."
        )
    return (
        f"No soft tissue: a stiffness of {stiffness:.3g} N/m is suspicious. Check the units "
        "(`position_unit`, `force_unit`) and the polarity (`force_polarity`), look whether the "
        "tip presses on a rigid stop, and whether the rig is the right one (`rig`); a stiffness "
        "that is known is held by `constant` stiffness=VALUE."
    )


def _touches_nothing(fit: Fit) -> bool:
    """Whether stiffness and damping are as good as 0, and known to be small.

    A mass that is not known may hide a stiffness under a sine: then the deviation is large.
    """
    values, deviations = fit.named(), fit.deviations()
    if fit.composition.effects or fit.composition.tissue not in PLAIN_TISSUES:
        return False
    if not all(deviations[name] > 0.0 for name in TISSUE_VALUES):  # held: it is known
        return False
    moved = list(zip(fit.tip, fit.measurements, strict=True))
    swing = max(float(np.std(tip)) for tip, _ in moved)
    speed = max(float(np.std(np.gradient(tip, m.sample_period))) for tip, m in moved)
    force = max(float(np.std(m.force)) for _, m in moved)
    found = np.array([abs(values[name]) for name in TISSUE_VALUES])
    doubt = ZERO_DEVIATIONS * np.array([deviations[name] for name in TISSUE_VALUES])
    reach = np.array([swing, speed])
    none = (found < doubt).all() or (found * reach).sum() < fit.noise
    return bool(none and ((found + doubt) * reach).sum() < NOTHING_TOUCHED * force)


def _no_contact(fit: Fit) -> str:
    values, deviations = fit.named(), fit.deviations()
    k, beta = (
        f"{name} {values[name]:.3g} +- {SIDE * deviations[name]:.2g} {unit}"
        for name, unit in zip(TISSUE_VALUES, ("N/m", "N s/m"), strict=True)
    )
    return (
        f"No contact: the tip seems to touch nothing, {k} and {beta} are nothing beside the force "
        "that moves the tip. Bring the tip into the tissue and record again; nothing of a tissue "
        "can be told from this."
    )
