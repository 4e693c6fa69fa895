"""Measurements and instrument as a model is fitted to them: the order of all that comes before.

What belongs here: that order. What does not: its steps (``cleaning``, ``input_course``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tissue_probe.diagnosis.cleaning import cleaned, from_touch, with_any_touch
from tissue_probe.diagnosis.input_course import with_input
from tissue_probe.diagnosis.inspection.finding import Finding
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.physics.composition import Composition


def prepared(
    composition: Composition,
    measurements: Sequence[Measurement],
    instrument: Instrument,
    begin_at: Mapping[str, float] | None = None,
) -> tuple[list[Measurement], Instrument, list[Finding]]:
    """Inspect measurements; return them, and the instrument, as a model is fitted to them.

    Without spoilt samples, from the touch on, and with the course of the input between samples.

    Raises
    ------
    MeasurementError
        If any samples are such that a fit would be worthless.
    """
    clean, findings = cleaned(measurements)
    clean, instrument, touched = from_touch(clean, instrument)
    instrument = with_any_touch(clean, instrument)
    clean, held = with_input(composition, clean, instrument, begin_at)
    return clean, instrument, [*findings, *touched, *held]
