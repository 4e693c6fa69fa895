"""Whether samples are fit to be fitted: their faults, and the remedies.

Contents: the list of checks, their order, and the sentence of each.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tissue_probe.diagnosis.inspection.channel import InspectedChannel
from tissue_probe.diagnosis.inspection.finding import Finding
from tissue_probe.diagnosis.inspection.information import (
    ENOUGH_DEVIATION,
    FEWEST_IN_RESIDUAL,
    stiffness_deviation,
)
from tissue_probe.diagnosis.inspection.response_checks import check_response, check_size
from tissue_probe.diagnosis.inspection.sampling_checks import check_sampling, check_times
from tissue_probe.diagnosis.inspection.value_checks import check_values
from tissue_probe.errors import MeasurementError
from tissue_probe.quantities import POSITION, Quantity
from tissue_probe.signals import FloatArray, spans_of


@dataclass(frozen=True)
class Inspection:
    """The faults of samples, and how fine they are.

    Attributes
    ----------
    findings : tuple of Finding
        Fatal ones first.
    position_step, force_step : float or None
        Step in which the values come [m], [N]; None where they come in none.
    """

    findings: tuple[Finding, ...]
    position_step: float | None = None
    force_step: float | None = None

    @property
    def fatal(self) -> bool:
        """Whether a fit would be worthless."""
        return any(finding.fatal for finding in self.findings)

    @property
    def answer(self) -> str | None:
        """``adc_saturation`` or ``stuck_samples``, where the data have that fault."""
        names = [finding.name for finding in self.findings]
        return next((name for name in ("adc_saturation", "stuck_samples") if name in names), None)

    def __getitem__(self, name: str) -> Finding:
        """Return the finding of a name; KeyError if there is none."""
        for finding in self.findings:
            if finding.name == name:
                return finding
        raise KeyError(name)


def inspect(
    position: FloatArray,
    force: FloatArray,
    sample_period: float,
    time: FloatArray | None = None,
    times: float = 1.0,
    drives: Quantity = POSITION,
) -> Inspection:
    """Check samples before a model is fitted to them.

    Findings, by name: ``too_short``, ``missing_samples``, ``irregular_sampling``, ``gaps``,
    ``constant_position``, ``constant_force``, ``no_motion``, ``no_contact``, ``low_rate``,
    ``coarse_encoder``, ``adc_saturation``, ``stuck_samples``, ``spikes`` (of the force),
    ``position_spikes``, ``unsynchronised``, ``wrong_polarity``, ``suspicious_units``.

    Parameters
    ----------
    position : array, shape (n,)
        Displacement of the coil [m], positive into the tissue. NaN where not known.
    force : array, shape (n,)
        Load-cell force [N], positive in compression. NaN where not known.
    sample_period : float
        Time between two samples [s].
    time : array, shape (n,), optional
        When each sample was taken [s], where that is known.
    times : float
        How many times slower than usual the record is (``Scale.time``).
    drives : Quantity
        Which of the two drives the other one.

    Raises
    ------
    MeasurementError
        If the arrays are not one-dimensional and of one length, or the period is not positive.
    """
    position, force = (np.asarray(column, dtype=np.float64) for column in (position, force))
    if position.ndim != 1 or position.shape != force.shape:
        raise MeasurementError(
            f"position and force have shapes {position.shape} and {force.shape}; give one value of "
            "each a sample"
        )
    if not 0.0 < sample_period < float("inf"):
        raise MeasurementError(f"sample_period is {sample_period} s; it must be positive")
    known = np.isfinite(position) & np.isfinite(force)
    findings = list(_check_known(known, sample_period))
    if time is not None:
        findings += check_times(np.asarray(time, dtype=np.float64), sample_period)
    if np.count_nonzero(known) < FEWEST_IN_RESIDUAL:
        return Inspection(tuple(findings))
    u, f = (InspectedChannel(*named) for named in _bridge_missing(position, force, known))
    findings += _check_information(u, f, known, sample_period)
    if beyond := list(check_size(u, f)):
        return Inspection((*findings, *beyond))
    findings += check_sampling(u, f, sample_period)
    if not any(finding.name.startswith(("constant", "no_motion")) for finding in findings):
        findings += check_values(u, f, known)
        findings += check_response(u, f, sample_period, times, drives)
    findings.sort(key=lambda finding: not finding.fatal)
    return Inspection(tuple(findings), u.step or None, f.step or None)


def _check_known(known: np.ndarray, sample_period: float) -> Iterator[Finding]:
    count = int(np.count_nonzero(known))
    if count < FEWEST_IN_RESIDUAL:
        yield Finding("too_short", _too_short(count, sample_period, "nothing"), fatal=True)
    if missing := known.size - count:
        share = missing / known.size
        yield Finding(
            "missing_samples",
            f"{missing} of {known.size} samples have no number for position or force: cut them "
            "out, or find out why the recorder lost them.",
            fatal=bool(share > 0.1),
            spans=tuple(spans_of(~known)),
        )


def _check_information(
    position: InspectedChannel, force: InspectedChannel, known: np.ndarray, sample_period: float
) -> Iterator[Finding]:
    """Yield ``too_short`` where the samples of something that moves do not tell its stiffness."""
    deviation = stiffness_deviation(position.values, force.values, sample_period, known)
    if position.span > 0.0 and deviation > ENOUGH_DEVIATION:
        share = f"the stiffness to {100.0 * deviation:.0f} % of force over position only"
        said = share if np.isfinite(deviation) else "nothing"
        count = int(np.count_nonzero(known))
        yield Finding("too_short", _too_short(count, sample_period, said), fatal=True)


def _too_short(count: int, sample_period: float, told: str) -> str:
    return (
        f"The recording has {count} samples in {count * sample_period:.3g} s, which tell {told}: "
        "record for longer, or more samples a second."
    )


def _bridge_missing(
    position: FloatArray, force: FloatArray, known: np.ndarray
) -> Iterator[tuple[str, FloatArray]]:
    """Bridge missing samples by straight lines, so that only known values decide."""
    number = np.arange(known.size)
    for name, column in (("position", position), ("force", force)):
        if known.all():
            yield name, column
        else:
            yield name, np.interp(number, number[known], column[known])
