"""The process that listens to ROS for the pages: twenty messages a second at any traffic.

Contents: its loop, and the contents of a message.
"""

from __future__ import annotations

import json
import math
import os
import select
import time
from typing import Any

import numpy as np

from tissue_probe.signals import NANOSECONDS
from tissue_probe.workbench.messages import pack_message
from tissue_probe.workbench.page_messages import LiveMessage, MapMessage
from tissue_probe.workbench.worker import DONE, FRAME, WORK_TOLD

#: A map, which must reach every page, unlike samples of a moment ago.
MAP_KIND = b"m"
#: Time between two messages [s]: more often the eye sees no difference.
MESSAGE_PERIOD = 0.05
#: Of the columns of a row of estimates, those that pages draw.
DRAWN_COLUMNS = (
    "stiffness",
    "damping",
    "stiffness_variance",
    "damping_variance",
    "predicted_force",
    "innovation",
    "normalized_innovation_squared",
)
#: The pages' names of the fields of the surface's cloud.
LAYERS = {"mean": "stiffness", "sd": "stiffness_stddev", "probability": "probability"}


def main() -> None:
    """Listen until standard input ends; obey the commands that come through it."""
    from tissue_probe.nodes.watch import Watch

    answer = os.dup(1)
    os.dup2(2, 1)
    watch = Watch()
    told_map = watch.map
    try:
        while True:
            time.sleep(MESSAGE_PERIOD)
            watch.hear()
            head, arrays = _take_messages(watch)
            _write(answer, WORK_TOLD, pack_message({"live": head}, arrays))
            if watch.map is not told_map:
                told_map = watch.map
                _write(answer, MAP_KIND, _map(watch.map))
            for line in _commands():
                if line is None:
                    return
                _write(answer, DONE, json.dumps(_obey_command(watch, line)).encode())
    except BrokenPipeError:
        pass
    finally:
        watch.close()


def _take_messages(watch: Any) -> tuple[LiveMessage, dict[str, Any]]:
    """Take away the messages heard since the last time."""
    from tissue_probe.nodes.watch import PLACES

    blocks, watch.blocks = watch.blocks, []
    estimates, watch.estimates = watch.estimates, {}
    arrays: dict[str, Any] = {}
    if blocks:
        times = [b.stamp / NANOSECONDS + np.arange(len(b)) * b.sample_period for b in blocks]
        arrays["time"] = np.concatenate(times)
        for name in ("position", "force"):
            arrays[name] = np.concatenate([getattr(b, name) for b in blocks]).astype(np.float32)
    for name, rows in estimates.items():
        table = np.array(rows, dtype=np.float64)
        arrays[f"{name}.time"] = table[:, 0] / NANOSECONDS
        arrays[f"{name}.status"] = table[:, 1].astype(np.float32)
        for value in DRAWN_COLUMNS:
            arrays[f"{name}.{value}"] = table[:, PLACES[value]].astype(np.float32)
    head: LiveMessage = {
        "estimators": list(estimates),
        "fault": watch.fault,
        "state": watch.state,
        "verdict": watch.verdict or None,
        "health": [(name, *told) for name, told in sorted(watch.health.items())],
    }
    return head, arrays


def _map(found: Any) -> bytes:
    """Return the message of a map, as pages draw that of a recording (``map_messages``)."""
    told = [f"background {found.background:.1f} N/m"] if math.isfinite(found.background) else []
    head: MapMessage = {
        "text": "\n".join([*told, *found.notes]),
        "sites": found.sites,
        "inclusions": found.inclusions,
    }
    return pack_message({"live_map": head}, {} if found.surface is None else _raster(found.surface))


def _raster(points: Any) -> dict[str, Any]:
    """Return points of a surface as layers over their places; NaN where there is no point."""
    axes = {name: np.unique(points[name]) for name in "xy"}
    row, column = (np.searchsorted(axes[name], points[name]) for name in "yx")
    layers = {}
    for name, field in LAYERS.items():
        layer = np.full((axes["y"].size, axes["x"].size), np.nan, np.float32)
        layer[row, column] = points[field]
        layers[name] = layer.ravel()
    return {**{name: axis.astype(np.float64) for name, axis in axes.items()}, **layers}


def _commands() -> list[dict[str, Any] | None]:
    """Return the commands by now; None where no more will come."""
    if not select.select([0], [], [], 0)[0]:
        return []
    # A line is written at once, and shorter than a pipe takes at once.
    text = os.read(0, 2**16)
    return [json.loads(line) for line in text.splitlines()] if text else [None]


def _obey_command(watch: Any, asked: dict[str, Any]) -> dict[str, Any]:
    from tissue_probe.nodes.watch import CommandError

    try:
        said = watch.command(asked["command"], asked["given"])
    except CommandError as error:
        return {"number": asked["number"], "refused": str(error)}
    return {"number": asked["number"], "ok": said}


def _write(descriptor: int, kind: bytes, data: bytes) -> None:
    view = memoryview(FRAME.pack(kind, len(data)) + data)
    while view:
        view = view[os.write(descriptor, view) :]


if __name__ == "__main__":
    main()
