"""What was found at each site, kept in a file for a mapper that is started again.

Contents: the file.

The file is text, one JSON object a line, and only grows while a scan goes on: a line that was cut
off costs that line. The last line of a dwell counts.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tissue_probe.mapping.fusion import Dwell, Estimate, Judged
from tissue_probe.signals import Leaving, PalpationSite, Phase, sound_normal


class SiteResults:
    """A file of dwells that have ended, each known by when its announcement was sent.

    A dwell that is announced once more, by a replay for one, was sent at another time: so results
    are never taken for those of another run.

    Parameters
    ----------
    path : Path
        Its folder is made by ``begin``.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def read_stored(self) -> dict[int, Dwell]:
        """Return the dwells in the file, in their order, by when each was announced [ns].

        Lines that are not understood are left out. OSError if the file cannot be read.
        """
        if not self._path.exists():
            return {}
        found: dict[int, Dwell] = {}
        with self._path.open(errors="replace") as lines:
            for line in lines:
                try:
                    announced, dwell = _dwell(json.loads(line))
                except (ValueError, TypeError, KeyError):
                    continue
                # Who joined late heard of the dwell, and of nothing that was found in it.
                if dwell.last() or announced not in found:
                    found[announced] = dwell
        return found

    def begin(self, dwells: Mapping[int, Dwell]) -> None:
        """Write a new file with these dwells alone; OSError if it cannot be written."""
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with self._path.open("w") as file:
            file.writelines(_line(announced, dwell) for announced, dwell in dwells.items())

    def keep(self, announced: int, dwell: Dwell) -> None:
        """Add a dwell that has ended; OSError if the file cannot be written."""
        with self._path.open("a") as file:
            file.write(_line(announced, dwell))


def _line(announced: int, dwell: Dwell) -> str:
    site = dwell.site
    content = {
        "announced": announced,
        "begin": site.stamp,
        "end": dwell.until,
        "site": site.site,
        "position": site.position,
        "normal": site.normal,
        "leaving": dwell.leaving,
        "found": {name: [each.status, *each.estimate] for name, each in dwell.last().items()},
    }
    return json.dumps(content) + "\n"


def _dwell(content: dict[str, Any]) -> tuple[int, Dwell]:
    x, y, z = map(float, content["position"])
    across, along, up = map(float, content["normal"])
    normal = sound_normal((across, along, up))
    begin, number = int(content["begin"]), int(content["site"])
    site = PalpationSite(begin, number, (x, y, z), Phase.DWELL, normal=normal)
    dwell = Dwell(site)
    dwell.end_at(int(content["end"]))
    dwell.leaving = Leaving(content["leaving"])
    for name, (status, stamp, *values) in content["found"].items():
        dwell.take(str(name), Judged(int(status), Estimate(int(stamp), *map(float, values))))
    return int(content["announced"]), dwell
