"""Lines at multiples of a sine that drives: anything nonlinear leaves them.

Contents: the sine's frequency, and whether a model hums at a multiple of it.
"""

from __future__ import annotations

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.residuals.drive import dominant_period, drive_of

#: How far a drive's strongest frequency may be from that of its repetition: it is a sine.
SINE_WITHIN = 0.1
#: Two frequencies within this share are the same.
SAME_FREQUENCY = 2e-3
#: The value of a model that hums.
LINE_FREQUENCY_NAME = "hum_frequency"


def is_multiple(fit: Fit) -> bool:
    """Whether a model hums at a multiple of a sine that drives."""
    frequency = fit.named().get(LINE_FREQUENCY_NAME)
    sine = sine_of(fit.measurements[0]) if frequency else None
    if frequency is None or sine is None:
        return False
    order = round(frequency / sine)
    return order > 1 and abs(frequency / (order * sine) - 1.0) < SAME_FREQUENCY


def sine_of(measurement: Measurement) -> float | None:
    """Return the frequency of the drive [Hz] if it is a sine."""
    driven, period = measurement.input_values, measurement.sample_period
    repetition = drive_of(driven, period).repetition
    if repetition is None:
        return None
    same = abs(dominant_period(driven, period) * repetition - 1.0) < SINE_WITHIN
    return repetition if same else None
