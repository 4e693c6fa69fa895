"""The samples that pages draw, made few enough on this side: as arrays by name.

Contents: which samples, over which axis, brushed how.

All is computed in one thread beside the server's own, so that a page that asks for much holds up
no other one.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import asdict
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from tissue_probe.analysis.comparing import ComparisonResult
from tissue_probe.analysis.error_view import ErrorView
from tissue_probe.signals import NANOSECONDS, spans_of
from tissue_probe.workbench.decimation import dots, lines
from tissue_probe.workbench.desk import Desk
from tissue_probe.workbench.page_messages import (
    BrushMessage,
    DotsMessage,
    LinesMessage,
    NoMessage,
    ProfileMessage,
    RegionMessage,
    SpectrumMessage,
    WhereMessage,
)
from tissue_probe.workbench.refusal import RequestRefused
from tissue_probe.workbench.request_declarations import Dots, Lines, LookRequest, Recorded

Arrays = dict[str, NDArray[Any]]
Spans = list[tuple[float, float]]
#: Views that are kept: rungs of a long ladder, on both recordings.
VIEWS_KEPT = 24
#: Rows of brushed samples that are told: more are narrower than a pixel each.
SPANS = 2000


class Pictures:
    """Draws the results on a desk."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        #: Each view, with the times of the samples that were not fitted.
        self._views: OrderedDict[tuple[int, str, int], tuple[ErrorView, Spans]] = OrderedDict()

    def draw_recording(self, asked: Recorded) -> tuple[NoMessage, Arrays]:
        """Return position and force of a recording as they were read, over the whole of it.

        Of several that lie in one file, it is the one that is named by ``part``.
        """
        measured, part = self._desk.file(asked.file).measured, asked.part
        if measured is None:
            raise RequestRefused("this recording is not read yet")
        if part >= len(measured.parts):
            raise RequestRefused(f"there are {len(measured.parts)} recordings in it")
        recording = measured.parts[part].recording
        signals = {"position": recording.position, "force": recording.force}
        numbers, drawn = lines(signals, 0, recording.position.size, asked.width)
        since = (recording.stamps - recording.stamps[0]) / NANOSECONDS
        time = np.interp(numbers, np.arange(since.size), since)
        return {}, {"time": time, **{n: each.astype(np.float32) for n, each in drawn.items()}}

    def lines(self, asked: Lines) -> tuple[LinesMessage, Arrays]:
        """Return measured, predicted and residual over a span of time.

        With ``values``, the model's prediction at those is drawn in place of the fit's; with
        ``effect``, the part of the residual that this effect alone explains stands beside.
        """
        view, unused = self._view_and_unused(asked)
        signals = {"measured": view.measured, "predicted": view.predicted,
                   "residual": view.residual}  # fmt: skip
        error: float | None = None
        if asked.values:
            predicted = self._compare_model(asked).predict(asked.values, asked.stretch)
            if not np.isfinite(predicted).all():
                raise RequestRefused("`values`: the model diverges there")
            signals |= {"predicted": predicted, "residual": view.measured - predicted}
            used = signals["residual"][view.used]
            error = float(np.sqrt(np.mean(used**2)))
        if asked.effect:
            signals["explained"] = self._explain_residual(asked.effect, asked)
        first, stop = _span(asked, view)
        numbers, drawn = lines(signals, first, stop, asked.width)
        found: Arrays = {"time": numbers * view.sample_period}
        found |= {name: each.astype(np.float32) for name, each in drawn.items()}
        told: LinesMessage = {
            "noise": view.noise,
            "unused": unused,
            "dense": numbers.size < stop - first,
            "end": view.measured.size * view.sample_period,
        }
        if error is not None:
            told["rmse"] = error
        return told, found

    def dots(self, asked: Dots) -> tuple[DotsMessage, Arrays]:
        """Return the residual over indentation, speed or phase; brushed samples apart."""
        view = self._view(asked)
        x, y = view.along(asked.axis), view.residual
        limits = (*_limits(x[view.used]), *_limits(y[view.used]))
        pixels = (asked.width, asked.height)
        found = dict(zip(("x", "y"), dots(x, y, limits, pixels), strict=True))
        if (chosen := self._select_brushed(view, asked)) is not None:
            marked = dots(x[chosen], y[chosen], limits, pixels)
            found |= dict(zip(("marked_x", "marked_y"), marked, strict=True))
        return {"limits": limits}, {name: each.astype(np.float32) for name, each in found.items()}

    def spectrum(self, asked: LookRequest) -> tuple[SpectrumMessage, Arrays]:
        """Return the density of the residual's power, that of noise, and of brushed samples."""
        view = self._view(asked)
        frequencies, density = view.spectrum()
        found = {"frequency": frequencies, "density": density}
        if (chosen := self._select_brushed(view, asked)) is not None and chosen.any():
            found["marked"] = view.spectrum(chosen)[1]
        white = 2.0 * view.sample_period * view.noise**2
        return {"white": white}, {n: each.astype(np.float32) for n, each in found.items()}

    def brush(self, asked: LookRequest) -> tuple[BrushMessage, Arrays]:
        """Return the times of the samples that a look along an axis means, and their error."""
        view = self._view(asked)
        chosen = self._select_brushed(view, asked)
        if chosen is None:
            return {"spans": [], "count": 0}, {}
        error = float(np.sqrt(np.mean(view.residual[chosen] ** 2))) if chosen.any() else 0.0
        spans = _spans(chosen, view.sample_period)
        return {"spans": spans, "count": int(chosen.sum()), "rmse": error}, {}

    def where(self, asked: LookRequest) -> tuple[WhereMessage, Arrays]:
        """Return where the model fails: a region of each axis, with the sentence on it."""
        found = self._view(asked).where
        regions: list[ProfileMessage] = [
            {
                "axis": profile.quantity,
                "unit": profile.unit,
                "told": profile.describe(),
                "here": None if profile.here is None else cast(RegionMessage, asdict(profile.here)),
                "foremost": profile is found.here,
            }
            for profile in found.profiles
        ]
        return {"regions": regions}, {}

    def _select_brushed(self, view: ErrorView, asked: LookRequest) -> NDArray[np.bool_] | None:
        brush = asked.brush
        return None if brush is None else view.between(brush.axis, brush.low, brush.high)

    def _explain_residual(self, effect: str, asked: LookRequest) -> NDArray[Any]:
        if self._desk.ranking is None:
            raise RequestRefused("nothing is ranked yet")
        if asked.source == "second":
            raise RequestRefused("an effect's curve is of the recording that is fitted")
        rung = self._desk.rung(asked.rung)
        return self._desk.ranking.explain_residual(rung, effect, asked.stretch)

    def _compare_model(self, asked: LookRequest) -> ComparisonResult:
        rung = self._desk.rung(asked.rung)
        if asked.source != "second":
            return rung.compared
        if rung.second is None:
            raise RequestRefused(rung.second_told or "there is no second recording")
        return rung.second

    def _view(self, asked: LookRequest) -> ErrorView:
        return self._view_and_unused(asked)[0]

    def _view_and_unused(self, asked: LookRequest) -> tuple[ErrorView, Spans]:
        key = (asked.rung, asked.source, asked.stretch)
        compared = self._compare_model(asked)
        if asked.stretch >= len(compared.sources):
            raise RequestRefused(f"there are {len(compared.sources)} stretches")
        if key not in self._views:
            view = compared.view(asked.stretch)
            self._views[key] = view, _spans(~view.used, view.sample_period)
        self._views.move_to_end(key)
        while len(self._views) > VIEWS_KEPT:
            self._views.popitem(last=False)
        return self._views[key]


def _span(asked: Lines, view: ErrorView) -> tuple[int, int]:
    """Return the samples of a span of time, with one more on either side, to draw lines to."""
    size, period = view.measured.size, view.sample_period
    begin = 0.0 if asked.begin is None else asked.begin / period
    end = size if asked.end is None else asked.end / period
    # Any time that a page names, however far away, is clipped to the samples.
    first = int(np.clip(np.floor(begin) - 1, 0, size - 2))
    return first, int(np.clip(np.ceil(end) + 2, first + 2, size))


def _spans(chosen: NDArray[np.bool_], period: float) -> Spans:
    found = [(first * period, stop * period) for first, stop in spans_of(chosen)]
    return found[:SPANS]


def _limits(values: NDArray[np.float64]) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    if high > low:
        return low, high
    return low - 1.0, high + 1.0
