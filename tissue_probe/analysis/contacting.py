"""Stiffness and damping under any robot's tip, from a recording in which it presses.

Contents: the question that is put to the diagnosis' fit, the range of the motion, the result.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from tissue_probe import arguments as take
from tissue_probe.analysis.contact_lost import in_contact
from tissue_probe.analysis.contact_told import (
    ASKED_NUMBERS,
    DELAY_NAME,
    DRIFT_NAME,
    MASS_NAME,
    errors_of_others,
    to_tell,
)
from tissue_probe.analysis.measurements import Source, measurements_of
from tissue_probe.analysis.question import constant, question
from tissue_probe.contact.contact import VERDICTS, Contact, ContactNumber, Verdict
from tissue_probe.diagnosis.evidence.adequacy import leaves_only_noise
from tissue_probe.diagnosis.fitting.corners import without_corners
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.problem import CONTACT_NAME
from tissue_probe.diagnosis.left_out_samples import report_left_out
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.preparation import prepare_question
from tissue_probe.diagnosis.ranking.candidates import fit_base
from tissue_probe.errors import ParameterError
from tissue_probe.likeness import Alike
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.kinds import LONGEST_DELAY, MOST_EARLY
from tissue_probe.physics.rigs import RIGID_PROBE
from tissue_probe.sensor.compensation import load_file
from tissue_probe.signals import FloatArray

#: Share of the power of a motion outside the frequencies that are told, at either end.
POWER_OUTSIDE = 0.025

Uncertain = float | tuple[float, float]
"""A value, or a value with its standard deviation [SI]."""


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
        Sentences that name the motion or the value by which the other numbers would be told.
    notes : tuple of str
        How the samples were read, their faults, and which samples were left out.
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
            lines.append("`tissue_probe diagnose` names the missing effect.")
        lines += [f"To tell the rest: {sentence}." for sentence in self.to_tell]
        deviations = self.fit.deviations()
        for entry in self.fit.entries:
            number = ContactNumber(self.fit.named()[entry.name], deviations[entry.name])
            if number.deviation > 0.0:
                mark = "" if number.told or entry.name not in ASKED_NUMBERS else "   (not told)"
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
            "told": [name for name in ASKED_NUMBERS if getattr(contact, name).told],
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
    asked = {name: given for name, given in known.items() if name not in (DELAY_NAME, DRIFT_NAME)}
    put = question(rig=RIGID_PROBE, constants=asked)
    # A free place of touch would be one with a free zero of the force.
    composition = _composition(free_zero=CONTACT_NAME not in known)
    rig = dict(put.instrument.constants or {})
    instrument = replace(put.instrument, constants={**rig, **_of_effects(known)})
    found = put.segments(measurements_of(measured))
    taken = [each.measurement(composition.output) for each in found]
    ready = prepare_question(composition, taken, instrument)
    fit = _fit(composition, ready.measurements, instrument)
    findings = [*ready.findings, *report_left_out(ready.measurements, fit, instrument)]
    kept, lost = (None, "") if leaves_only_noise(fit) else in_contact(fit, instrument)
    if kept is not None:
        fit = _fit(composition, kept, instrument)
    notes = [*put.notes, *(each.sentence for each in findings), lost, *errors_of_others(fit)]
    missing = tuple(to_tell(fit))
    return ContactResult(
        _contact(fit, missing), fit, missing, tuple(dict.fromkeys(filter(None, notes)))
    )


def _known(
    delay: Uncertain | None,
    drift: Uncertain | None,
    sensor: str | Path | None,
    constants: Mapping[str, Uncertain],
) -> dict[str, Uncertain]:
    """Return all that is known before, by name."""
    given = {**(_of_sensor(sensor) if sensor else {}), **constants}
    given |= {
        name: each for name, each in ((DELAY_NAME, delay), (DRIFT_NAME, drift)) if each is not None
    }
    if CONTACT_NAME in constants:
        given.pop(DRIFT_NAME, None)
        if drift is not None:
            raise ParameterError("`drift`: contact_position says that the force's zero is right")
    return given


def _of_sensor(path: str | Path) -> dict[str, Uncertain]:
    """Return mass, delay and drift of a sensor's model, each with its standard deviation."""
    found = load_file(path)
    # The file's axes are those of the sensor: along any the drift is no faster than in all.
    drift = np.sqrt(np.sum(found.rate[:3] ** 2) + np.max(found.drift_covariance[:3, 1, 1]))
    known = {
        DELAY_NAME: (found.delay, found.delay_deviation),
        MASS_NAME: found.mass,
        DRIFT_NAME: (0.0, float(drift)),
    }
    return {name: each for name, each in known.items() if math.isfinite(each[1])}


def _of_effects(known: Mapping[str, Uncertain]) -> dict[str, tuple[float, float]]:
    """Return delay and drift with their deviations, as far as they are known."""
    found = {}
    for name, called in ((DELAY_NAME, "delay"), (DRIFT_NAME, "drift")):
        if name in known:
            given = known[name]
            value, deviation = given if isinstance(given, tuple) else (given, 0.0)
            if deviation < 0.0:
                raise ParameterError(f"`{called}`: its standard deviation is below 0")
            found[name] = (value, deviation)
    late = found.get(DELAY_NAME, (0.0, 0.0))[0]
    if not -MOST_EARLY <= late <= LONGEST_DELAY:
        raise ParameterError(
            f"`delay` is {late:g} s; give {-MOST_EARLY:g} to {LONGEST_DELAY:g} s, and take the "
            "rest off the times of the force"
        )
    return found


def _composition(free_zero: bool) -> Composition:
    from tissue_probe.physics.effects import EFFECTS

    names = (DELAY_NAME, DRIFT_NAME) if free_zero else (DELAY_NAME,)
    return Composition(RIGID_PROBE, effects=tuple(EFFECTS[name] for name in names))


def _fit(
    composition: Composition, measurements: Sequence[Measurement], instrument: Instrument
) -> Fit:
    fit = fit_base(composition, measurements, instrument)
    kept = without_corners(fit)
    return fit_base(composition, kept, instrument) if kept else fit


def _contact(fit: Fit, missing: Sequence[str]) -> Contact:
    """Return the numbers of a fit, and the range in which they held."""
    named, deviations = fit.named(), fit.deviations()
    verdict: Verdict = "adequate" if leaves_only_noise(fit) else "missing"
    if missing:
        verdict = "cannot tell"
    lowest, highest, fastest, slow, fast = _range(fit.measurements)
    stiffness, damping, mass, delay = (
        ContactNumber(named[name], deviations[name])
        for name in (*ASKED_NUMBERS, MASS_NAME, DELAY_NAME)
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
    slow, fast = (
        of[int(np.searchsorted(share, each))] for each in (POWER_OUTSIDE, 1.0 - POWER_OUTSIDE)
    )
    return float(slow), float(fast)
