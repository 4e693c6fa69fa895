"""Stiffness and damping under any robot's tip, from a recording in which it presses.

Contents: the question that is put to the diagnosis' fit, what of its answer is told, the result.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.ndimage import binary_dilation

from tissue_probe import arguments as take
from tissue_probe.alike import Alike
from tissue_probe.analysis.measurements import Source, measurements_of
from tissue_probe.analysis.question import constant, question
from tissue_probe.contact.contact import VERDICTS, Contact, Number, Verdict
from tissue_probe.diagnosis.evidence.adequacy import leaves_only_noise
from tissue_probe.diagnosis.evidence.posterior import RIVAL
from tissue_probe.diagnosis.fitting.corners import without_corners
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.problem import CONTACT_NAME
from tissue_probe.diagnosis.left_out import left_out
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.prepared import prepare_question
from tissue_probe.diagnosis.ranking.candidates import fit_base, refit
from tissue_probe.errors import MeasurementError, ParameterError
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.kinds import LONGEST_DELAY, MOST_EARLY
from tissue_probe.physics.rigs import RIGS
from tissue_probe.quantities import SIDE
from tissue_probe.sensor.compensation import load_file
from tissue_probe.signals import BoolArray, FloatArray

#: The numbers that are asked for, with their units.
UNITS = {"stiffness": "N/m", "damping": "N s/m"}
ASKED = tuple(UNITS)
DELAY, DRIFT, MASS = "channel_delay", "force_drift", "tip_mass"
#: Of two values the error of one is mostly that of the other if these go together by more: half of
#: the variance.
MOSTLY = math.sqrt(0.5)
#: Out of contact in more of the samples than this, the rest is no motion any more.
MOST_LOST = 0.5
#: Shares of the travel at which the search for a touch begins: cost has a valley about each.
TOUCHES = np.arange(0.1, 0.95, 0.1)
#: In the air the force does not go with the position: by no more than so many deviations, and these
#: are less than this share of the tissue's stiffness. A tissue that is softer there is told apart.
CERTAIN, SOFTER = 3.0, 0.25
MAY_LEAVE = (
    "Below {:.4g} mm the tip may be out of contact, or the tissue softer: press deeper, or let "
    "`tissue_probe diagnose` tell."
)
#: Share of the power of a motion outside the frequencies that are told, at either end.
OUTSIDE = 0.025

Uncertain = float | tuple[float, float]
"""A value, or a value with its standard deviation [SI]."""

#: What tells two values apart that this motion does not.
TELLS = {
    MASS: "state `constants` tip_mass with its error (weigh the tool, or give the file of "
    "`tissue_probe sensor` as `sensor`), or move at several frequencies, the fastest at least "
    "twice the slowest",
    DELAY: "state `delay` with its error, or give the file of `tissue_probe sensor` as `sensor`; "
    "motion hardly tells it",
    DRIFT: "move to and fro for several cycles, or state `drift` with its error",
    CONTACT_NAME: "state `constants` contact_position with a smaller error, or leave it out",
}


@dataclass(frozen=True, eq=False, repr=False)
class ContactResult(Alike):
    """A contact that a robot felt.

    Attributes
    ----------
    contact : Contact
        Stiffness and damping with their errors, and where they held.
    fit : Fit
        The model with all its values.
    to_tell : tuple of str
        What would tell the numbers that are not told, in sentences.
    notes : tuple of str
        How the samples were read, their faults, and what was left out.
    """

    contact: Contact
    fit: Fit
    to_tell: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def verdict(self) -> Verdict:
        """``adequate``, ``missing`` or ``cannot tell``."""
        return self.contact.verdict

    @property
    def text(self) -> str:
        """The answer in words."""
        lines = [VERDICTS[self.verdict]]
        if self.verdict == "missing":
            lines.append("`tissue_probe diagnose` says what it is.")
        lines += [f"To tell the rest: {sentence}." for sentence in self.to_tell]
        deviations = self.fit.deviations()
        for entry in self.fit.entries:
            number = Number(self.fit.named()[entry.name], deviations[entry.name])
            if number.deviation > 0.0:
                mark = "" if number.told or entry.name not in ASKED else "   (not told)"
                lines.append(f"  {entry.name:<16} {number.text(entry.unit)}{mark}")
        lines += [f"  {line}" for line in self.contact.notes[1:]]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return self.text

    def to_dict(self) -> dict[str, Any]:
        """Return the answer in plain types, in SI units."""
        contact, named, deviations = self.contact, self.fit.named(), self.fit.deviations()
        return {
            "verdict": contact.verdict,
            "values": {
                entry.name: {
                    "value": named[entry.name],
                    "deviation": deviations[entry.name],
                    "unit": entry.unit,
                }
                for entry in self.fit.entries
            },
            "told": [name for name in ASKED if getattr(contact, name).told],
            "to_tell": list(self.to_tell),
            "error": contact.error,
            "error_over_noise": contact.error_over_noise,
            "positions": [contact.lowest, contact.highest],
            "fastest": contact.fastest,
            "frequencies": [contact.slow, contact.fast],
            "notes": list(self.notes),
        }

    @take.checks(path=take.path)
    def save(self, path: str | Path) -> None:
        """Write the contact in YAML, which admittance and MuJoCo's contact are made of."""
        Path(path).write_text(self.contact.text(), encoding="utf-8")


@take.checks(
    delay=take.optional(constant),
    drift=take.optional(constant),
    sensor=take.optional(take.path),
    constants=take.optional(take.by_name(constant, "numbers")),
)
def identify_contact(
    measured: Source | Sequence[Source],
    *,
    delay: Uncertain | None = None,
    drift: Uncertain | None = None,
    sensor: str | Path | None = None,
    constants: Mapping[str, Uncertain] | None = None,
) -> ContactResult:
    """Identify stiffness and damping under a robot's tip that presses to and fro.

    The position is that of the tip; the force's zero is free, of each recording. Fitted is
    F(t) = k (u - c) + beta u' + m u'' at t - tau, beside the zero, by the diagnosis' generalised
    least squares, with the noise of the position.

    Parameters
    ----------
    measured : Measurements, path, data frame, mapping of arrays, or a sequence of these
        Recordings of pressing on one tissue.
    delay : float or (float, float), optional
        Of the force after the position, and its standard deviation [s]; free where it is not
        stated.
    drift : float or (float, float), optional
        How fast the force's zero moves [N/s], and its standard deviation; free where it is not
        stated.
    sensor : path, optional
        A file of ``tissue_probe sensor``: it states delay, drift and the mass on the sensor, which
        the others overrule.
    constants : mapping, optional
        ``tip_mass``, mass between sensor and tissue [kg], free where it is not stated;
        ``contact_position``, where the tip touches [m]: the force's zero is taken to be right
        then; ``flicker_noise`` [N]. A value, or a value and its standard deviation.

    Raises
    ------
    TissueProbeError
        If the samples are of no use; says why, and the remedy.
    """
    known = _known(delay, drift, sensor, constants or {})
    asked = {name: given for name, given in known.items() if name not in (DELAY, DRIFT)}
    put = question(rig="rigid_probe", constants=asked)
    # A free place of touch would be one with a free zero of the force.
    composition = _composition(free_zero=CONTACT_NAME not in known)
    rig = dict(put.instrument.constants or {})
    instrument = replace(put.instrument, constants={**rig, **_of_effects(known)})
    found = put.segments(measurements_of(measured))
    taken = [each.measurement(composition.output) for each in found]
    ready = prepare_question(composition, taken, instrument)
    findings = list(ready.findings)
    fit = _fit(composition, ready.measurements, instrument)
    lost: list[str] = []
    if not leaves_only_noise(fit):
        fit, lost = _in_contact(fit, instrument)
    findings += left_out(ready.measurements, fit, instrument)
    notes = [*put.notes, *(each.sentence for each in findings), *lost, *_mostly_others(fit)]
    to_tell = tuple(_to_tell(fit))
    return ContactResult(_contact(fit, to_tell), fit, to_tell, tuple(dict.fromkeys(notes)))


def _known(
    delay: Uncertain | None,
    drift: Uncertain | None,
    sensor: str | Path | None,
    constants: Mapping[str, Uncertain],
) -> dict[str, Uncertain]:
    """Return all that is known before, by name."""
    given = {**(_of_sensor(sensor) if sensor else {}), **constants}
    given |= {name: each for name, each in ((DELAY, delay), (DRIFT, drift)) if each is not None}
    if CONTACT_NAME in constants:
        given.pop(DRIFT, None)
        if drift is not None:
            raise ParameterError("`drift`: contact_position says that the force's zero is right")
    return given


def _of_sensor(path: str | Path) -> dict[str, Uncertain]:
    """Return what a model of the force sensor knows, with the standard deviations."""
    found = load_file(path)
    # The file's axes are those of the sensor: along any the drift is no faster than in all.
    drift = np.sqrt(np.sum(found.rate[:3] ** 2) + np.max(found.drift_covariance[:3, 1, 1]))
    known = {
        DELAY: (found.delay, found.delay_deviation),
        MASS: found.mass,
        DRIFT: (0.0, float(drift)),
    }
    return {name: each for name, each in known.items() if math.isfinite(each[1])}


def _of_effects(known: Mapping[str, Uncertain]) -> dict[str, tuple[float, float]]:
    """Return delay and drift with their deviations, as far as they are known."""
    found = {}
    for name, called in ((DELAY, "delay"), (DRIFT, "drift")):
        if name in known:
            given = known[name]
            value, deviation = given if isinstance(given, tuple) else (given, 0.0)
            if deviation < 0.0:
                raise ParameterError(f"`{called}`: its standard deviation is below 0")
            found[name] = (value, deviation)
    late = found.get(DELAY, (0.0, 0.0))[0]
    if not -MOST_EARLY <= late <= LONGEST_DELAY:
        raise ParameterError(
            f"`delay` is {late:g} s; give {-MOST_EARLY:g} to {LONGEST_DELAY:g} s, and take the "
            "rest off the times of the force"
        )
    return found


def _composition(free_zero: bool) -> Composition:
    from tissue_probe.physics.effects import EFFECTS

    names = (DELAY, DRIFT) if free_zero else (DELAY,)
    return Composition(RIGS["rigid_probe"], effects=tuple(EFFECTS[name] for name in names))


def _fit(
    composition: Composition, measurements: Sequence[Measurement], instrument: Instrument
) -> Fit:
    fit = fit_base(composition, measurements, instrument)
    kept = without_corners(fit)
    return fit_base(composition, kept, instrument) if kept else fit


def _in_contact(fit: Fit, instrument: Instrument) -> tuple[Fit, list[str]]:
    """Fit again without the samples in which the tip is out of contact, if that explains more.

    Raises
    ------
    MeasurementError
        If these are most of the samples.
    """
    from tissue_probe.physics.effects import EFFECTS

    low = min(float(each.position.min()) for each in fit.measurements)
    travel = max(float(each.position.max()) for each in fit.measurements) - low
    free = {**(instrument.constants or {}), CONTACT_NAME: (low, travel)}
    anywhere = replace(instrument, constants=free)
    lossy = fit.composition.plus(EFFECTS["contact_loss"])
    # From a touch below all of the motion no slope leads to one within it.
    tried = [
        refit(fit, lossy, anywhere, held={CONTACT_NAME: low + share * travel}) for share in TOUCHES
    ]
    best = min((each for each in tried if each), key=lambda each: each.cost, default=None)
    found = refit(best, lossy, anywhere) if best else None
    # By the residual alone: strained constants are no loss of contact.
    if found is None or sum(fit.misfits) - sum(found.misfits) < 2.0 * RIVAL:
        return fit, []
    touch = found.named()[CONTACT_NAME] + SIDE * found.deviations()[CONTACT_NAME]
    late = max(found.named()[DELAY], 0.0)
    away = [_out_of_contact(each, touch, late) for each in found.measurements]
    slope, doubt = _slope_in_air(found, touch)
    if not abs(slope) < CERTAIN * doubt < SOFTER * found.named()["stiffness"]:
        return fit, [MAY_LEAVE.format(1e3 * touch)]
    share = sum(int(np.sum(each)) for each in away) / sum(each.size for each in away)
    kept = fit.without(away, MOST_LOST)
    if kept is None:
        raise MeasurementError(
            f"the tip is out of contact in {100 * share:.3g} % of the samples, where the position "
            f"is below {1e3 * touch:.4g} mm: press deeper, so that it stays in the tissue"
        )
    told = (
        f"The tip is out of contact in {100 * share:.3g} % of the samples, where the position is "
        f"below {1e3 * touch:.4g} mm: left out."
    )
    return _fit(fit.composition, kept, instrument), [told]


def _out_of_contact(measurement: Measurement, touch: float, late: float) -> BoolArray:
    """Return the samples whose force comes from a position below the touch."""
    away = measurement.position < touch
    reach = math.ceil(late / measurement.sample_period) + 1
    return np.asarray(binary_dilation(away, iterations=reach), dtype=bool)


def _slope_in_air(fit: Fit, touch: float) -> tuple[float, float]:
    """Return how the force left over goes with the position below a touch, and its doubt [N/m]."""
    normal, right = np.zeros((3, 3)), np.zeros(3)
    for measurement, left in zip(fit.measurements, fit.residuals, strict=True):
        speed = np.gradient(measurement.position, measurement.times)
        inside = (measurement.position < touch) & measurement.counted
        columns = np.stack([np.ones_like(speed), measurement.position, speed], axis=1)[inside]
        columns /= measurement.noise.own
        normal += columns.T @ columns
        right += columns.T @ left[inside] / measurement.noise.own
    inverse = np.linalg.pinv(normal, hermitian=True)
    return float((inverse @ right)[1]), float(np.sqrt(inverse[1, 1]))


def _contact(fit: Fit, to_tell: Sequence[str]) -> Contact:
    """Return the numbers of a fit, and the range in which they held."""
    named, deviations = fit.named(), fit.deviations()
    verdict: Verdict = "adequate" if leaves_only_noise(fit) else "missing"
    if to_tell:
        verdict = "cannot tell"
    lowest, highest, fastest, slow, fast = _range(fit.measurements)
    stiffness, damping, mass, delay = (
        Number(named[name], deviations[name]) for name in (*ASKED, MASS, DELAY)
    )
    return Contact(
        verdict=verdict,
        stiffness=stiffness,
        damping=damping,
        tip_mass=mass,
        delay=delay,
        error=fit.rmse,
        error_over_noise=fit.ratio,
        lowest=lowest,
        highest=highest,
        fastest=fastest,
        slow=slow,
        fast=fast,
    )


def _range(measurements: Sequence[Measurement]) -> tuple[float, float, float, float, float]:
    """Return lowest and highest position [m], largest speed [m/s], and frequencies [Hz]."""
    used = [each.position[each.used] for each in measurements]
    moved = [each.on_grid(each.position) for each in measurements]
    speeds = [
        np.max(np.abs(np.gradient(each, m.sample_period)))
        for each, m in zip(moved, measurements, strict=True)
    ]
    longest = max(measurements, key=lambda each: each.position.size)
    slow, fast = _frequencies(longest.on_grid(longest.position), longest.sample_period)
    lowest, highest = (float(of(np.concatenate(used))) for of in (np.min, np.max))
    return lowest, highest, float(max(speeds)), slow, fast


def _frequencies(position: FloatArray, sample_period: float) -> tuple[float, float]:
    """Return the frequencies between which 95 % of a motion's power lies [Hz]."""
    power = np.abs(np.fft.rfft((position - position.mean()) * np.hanning(position.size))) ** 2
    share = np.cumsum(power) / np.sum(power)
    of = np.fft.rfftfreq(position.size, sample_period)
    slow, fast = (of[int(np.searchsorted(share, each))] for each in (OUTSIDE, 1.0 - OUTSIDE))
    return float(slow), float(fast)


def _to_tell(fit: Fit) -> Iterator[str]:
    """Yield what would tell stiffness and damping, of those that are not told."""
    for name in ASKED:
        number = Number(fit.named()[name], fit.deviations()[name])
        if number.told:
            continue
        other, together = _partner(fit, name)
        if abs(together) > MOSTLY:
            yield (
                f"{name} and {other} are hardly told apart by this motion (correlation "
                f"{together:.2f}): {TELLS[other]}"
            )
        else:
            yield (
                f"{name} is hidden by the noise ({number.text(UNITS[name])}): "
                "move farther or faster, or record longer"
            )


def _mostly_others(fit: Fit) -> Iterator[str]:
    """Yield which error makes most of that of a number that is told."""
    for name in ASKED:
        other, together = _partner(fit, name)
        if abs(together) > MOSTLY and Number(fit.named()[name], fit.deviations()[name]).told:
            yield (
                f"Most of the error of {name} is that of {other} (correlation {together:.2f}): "
                f"with a smaller one {name} is known better."
            )


def _partner(fit: Fit, name: str) -> tuple[str, float]:
    """Return which other value goes with one most, and their correlation."""
    names, covariance = list(fit.names), fit.covariance
    others = [each for each in TELLS if each in names and fit.deviations()[each] > 0.0]
    own = names.index(name)

    def together(other: str) -> float:
        place = names.index(other)
        size = math.sqrt(covariance[own, own] * covariance[place, place])
        return float(covariance[own, place] / size) if size > 0.0 else 0.0

    found = {each: together(each) for each in others}
    most = max(found, key=lambda each: abs(found[each]), default="")
    return most, found.get(most, 0.0)
