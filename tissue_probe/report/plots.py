"""The report's plots, as plain data for the page's script (``report.js``).

Contents: numbers and names, in the units that are shown.
"""

from __future__ import annotations

from base64 import b64encode
from typing import Any

import numpy as np

from tissue_probe.diagnosis.residuals.localise import Localisation, Profile
from tissue_probe.quantities import Quantity, scale_value
from tissue_probe.report.contents import Report, ReportSignals
from tissue_probe.signals import FloatArray

SAMPLES_IN_BIN = 8  # samples in a bin, from which on its error is shown


def unit_of(report: Report) -> tuple[float, str]:
    """Return the divisor of errors, and their unit, so that the base model's reads easily."""
    return scale_value(report.steps[0].training_rmse, report.output.unit)


def ladder(report: Report) -> list[dict[str, Any]]:
    """Return for each step the lengths of its bars, in per cent of the widest, by logarithm."""
    errors = [(step.training_rmse, step.heldout_rmse) for step in report.steps]
    known = np.array([*errors, (report.noise_floor,) * 2])
    known = known[np.isfinite(known) & (known > 0.0)]
    low, high = np.log(0.7 * known.min()), np.log(known.max())

    def length(error: float) -> float:
        if not error > 0.0:
            return 0.0
        return round(float(100.0 * (np.log(error) - low) / (high - low or 1.0)), 2)

    floor = length(report.noise_floor)
    return [
        {"fitted": length(fitted), "heldout": length(heldout), "floor": floor}
        for fitted, heldout in errors
    ]


def signals(drawn: ReportSignals, noise: float, output: Quantity) -> dict[str, Any]:
    """Return measured and predicted signal, from which the page takes the errors."""
    span = float(np.ptp(drawn.measured)) if drawn.measured.size else 0.0
    factor, unit = scale_value(span, output.unit)
    small, small_unit = scale_value(noise, output.unit)
    one = np.array_equal(drawn.base, drawn.final)
    models = {"model": drawn.final}
    if not one:
        models = {"base model": drawn.base, "last model": drawn.final}
    return {
        "kind": "signals",
        "name": output.name,
        "unit": unit,
        "per": factor / small,
        "error_unit": small_unit,
        "noise": noise / small,
        "time": pack_values(drawn.time),
        "measured": pack_values(drawn.measured / factor),
        "models": {name: pack_values(values / factor) for name, values in models.items()},
    }


def where(drawn: ReportSignals, noise: float) -> list[dict[str, Any]]:
    """Return the rms error over the noise, by each quantity, and where it stands out."""
    named = {"base model": drawn.base_localisation, "last model": drawn.final_localisation}
    kept = {name: each for name, each in named.items() if each is not None}
    if len(kept) == 1 and np.array_equal(drawn.base, drawn.final):
        kept = {"model": next(iter(kept.values()))}
    shown = next(iter(kept.values()))
    return [_profile(kept, place, noise) for place in range(len(shown.profiles))]


def _profile(of: dict[str, Localisation], place: int, noise: float) -> dict[str, Any]:
    first = next(iter(of.values())).profiles[place]
    here = first.here
    return {
        "kind": "profile",
        "quantity": first.quantity,
        "unit": first.unit,
        "labels": list(first.labels or ()),
        "edges": [float(f"{edge:.6g}") for edge in first.edges],
        "logarithmic": first.quantity == "frequency",
        "here": [here.begin, here.end] if here else None,
        "models": {name: _ratio(each.profiles[place], noise) for name, each in of.items()},
    }


def _ratio(profile: Profile, noise: float) -> list[float | None]:
    ratio = np.sqrt(np.where(profile.expected < SAMPLES_IN_BIN * noise**2, np.nan, profile.excess))
    return [float(f"{each:.4g}") if np.isfinite(each) else None for each in ratio]


def pack_values(values: FloatArray) -> str:
    """Return numbers in single precision, more than any load cell has, as base64."""
    return b64encode(np.asarray(values, dtype="<f4").tobytes()).decode("ascii")
