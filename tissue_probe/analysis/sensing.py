"""A robot's force sensor in free air: reading, identifying, telling."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tissue_probe import arguments as take
from tissue_probe.likeness import Alike
from tissue_probe.recording.bags.bag import Bag, by_log_time
from tissue_probe.recording.bags.decoding import Decoder
from tissue_probe.recording.bags.open_bag import is_bag, open_bag
from tissue_probe.recording.columns.in_memory import columns_in_memory
from tissue_probe.recording.columns.open_columns import open_columns
from tissue_probe.recording.columns.source import Columns
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.tables.quantity_columns import read_quantities
from tissue_probe.recording.units import FORCE_UNITS, POSITION_UNITS, TIME_UNITS
from tissue_probe.sensor import compensation
from tissue_probe.sensor.free_air import WRENCH_AXES, WRENCH_UNITS, FreeAir
from tissue_probe.sensor.identify import Identified, identify
from tissue_probe.sensor.sensor_tracks import Track, stretches
from tissue_probe.signals import NANOSECONDS

PLACE_COLUMNS, TURN = ("x", "y", "z"), ("qx", "qy", "qz", "qw")
POSE, WRENCH, JOINTS = "PoseStamped", "WrenchStamped", "JointState"


@dataclass(frozen=True, eq=False, repr=False)
class SensorResult(Alike):
    """A force sensor where nothing is touched.

    Attributes
    ----------
    found : Identified
        Verdict, numbers with their errors, missing effects and poses.
    model : Compensation
        The model, which the node `sensor` reads.
    name : str
        Of the source.
    """

    found: Identified
    model: compensation.Compensation
    name: str

    @property
    def verdict(self) -> str:
        """``adequate``, ``missing`` or ``cannot tell``."""
        return self.found.verdict

    @property
    def text(self) -> str:
        """The answer in words."""
        found = self.found
        lines = [f"{self.name}: {_VERDICTS[found.verdict]}"]
        lines += [f"Missing: {sentence}." for sentence in found.missing_effects]
        lines += [f"To tell the rest: {sentence}." for sentence in found.missing_poses]
        for number in found.numbers:
            mark = "" if number.told else "   (not told)"
            value = f"{number.value:.6g} ± {number.deviation:.2g}"
            lines.append(f"  {number.name:<11} {value} {number.unit}{mark}")
        for axis, name in enumerate(WRENCH_AXES):
            lines.append(f"  {'noise_' + name:<11} {found.noise[axis]:.3g} {WRENCH_UNITS[axis]}")
        if found.cable:
            told = f"{found.cable.joints} joints" if found.cable.joints else "the pose"
            lines.append(f"  A cable is part of it, as a function of {told}.")
        lines += [f"One function: {sentence}." for sentence in found.one_function]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return self.text

    def to_dict(self) -> dict[str, Any]:
        """Return the answer in plain types, in SI units."""
        found = self.found
        return {
            "verdict": found.verdict,
            "numbers": {
                number.name: {
                    "value": number.value,
                    "deviation": number.deviation,
                    "unit": number.unit,
                    "told": number.told,
                }
                for number in found.numbers
            },
            "noise": dict(zip(WRENCH_AXES, found.noise.tolist(), strict=True)),
            "cable": found.cable is not None,
            "missing_effects": found.missing_effects,
            "missing_poses": found.missing_poses,
            "one_function": found.one_function,
        }

    @take.checks(path=take.path)
    def save(self, path: str | Path) -> None:
        """Write the model in YAML, which the node `sensor` reads."""
        compensation.save(path, self.model)


_VERDICTS = {
    "adequate": "adequate: the wrench is explained to its noise, and every number is told",
    "missing": "missing: something else is in the wrench",
    "cannot tell": "cannot tell: these poses tell too little",
}


@take.checks(
    pose=take.optional(take.text),
    wrench=take.optional(take.text),
    joints=take.several(take.text, "names of joints"),
)
def identify_sensor(
    source: Any,
    *,
    pose: str | None = None,
    wrench: str | None = None,
    joints: Sequence[str] = (),
) -> SensorResult:
    """Identify a robot's force sensor from poses and wrenches in free air.

    Parameters
    ----------
    source : path, data frame or mapping of arrays
        A bag with a ``PoseStamped`` and a ``WrenchStamped``, or a table with the columns t, x, y,
        z, qx, qy, qz, qw, fx, fy, fz, tx, ty, tz (SI, or with a unit: ``x_mm``, ``t [ms]``). The
        pose is that of the sensor's own frame, in a base whose z is up.
    pose, wrench : str, optional
        Topics in a bag that has several.
    joints : sequence of str
        Joints along which a cable runs, three at most: columns of a table [rad], or names in a
        bag's ``JointState``. With none the cable is taken for a function of the pose.

    Returns
    -------
    SensorResult

    Raises
    ------
    TissueProbeError
        If the samples are of no use; says why, and the remedy.
    """
    path = Path(source) if isinstance(source, str | Path) else None
    if path is not None and is_bag(path):
        name = str(path)
        tracks = _of_bag(open_bag(path), path, pose, wrench, joints)
    else:
        columns = open_columns(path) if path is not None else columns_in_memory(source, "table")
        name = str(path) if path is not None else "table"
        tracks = _of_table(columns, joints)
    origin = int(min(track.stamps[0] for track in tracks if track is not None))
    runs = stretches(*tracks, origin)
    return tell_sensor(identify(runs), runs, origin, name)


def tell_sensor(found: Identified, runs: list[FreeAir], origin: int, name: str) -> SensorResult:
    """Return the result of an identification."""
    return SensorResult(found, compensation.compensation(found, runs, origin), name)


def _of_table(columns: Columns, joints: Sequence[str]) -> tuple[Track, Track, Track | None]:
    units: dict[str, Mapping[str, float]] = {"t": TIME_UNITS}
    units |= dict.fromkeys(PLACE_COLUMNS, POSITION_UNITS) | dict.fromkeys(
        WRENCH_AXES[:3], FORCE_UNITS
    )
    units |= {name: {} for name in (*TURN, *WRENCH_AXES[3:], *joints)}
    read = read_quantities(columns, units, tuple(units), any_case=False)
    if not np.isfinite(read["t"]).all():
        raise RecordingError(f"{columns.path}: a time t is missing; give every sample its own")
    stamps = np.round(read["t"] * NANOSECONDS).astype(np.int64)

    def track(names: Sequence[str]) -> Track:
        return Track(stamps, np.stack([read[name] for name in names], axis=1))

    return track((*PLACE_COLUMNS, *TURN)), track(WRENCH_AXES), track(joints) if joints else None


def _of_bag(
    bag: Bag, path: Path, pose: str | None, wrench: str | None, joints: Sequence[str]
) -> tuple[Track, Track, Track | None]:
    return (
        _track(bag, path, _topic(bag, path, POSE, pose, "pose"), _pose),
        _track(bag, path, _topic(bag, path, WRENCH, wrench, "wrench"), _wrench),
        _track_of_joints(bag, path, joints) if joints else None,
    )


def _track_of_joints(bag: Bag, path: Path, joints: Sequence[str]) -> Track:
    name = _topic(bag, path, JOINTS, None, "joints")

    def angles(message: Any) -> Fields | None:
        places = {name: place for place, name in enumerate(message.name)}
        if not set(joints) <= set(places):
            return None  # other nodes tell of other joints on the same topic
        if len(message.position) < len(places):
            raise RecordingError(f"{path}: {name} has a joint without a position; record them all")
        return tuple(float(message.position[places[joint]]) for joint in joints)

    return _track(bag, path, name, angles, f" of {', '.join(joints)}")


def _topic(bag: Bag, path: Path, kind: str, name: str | None, parameter: str) -> str:
    there = [topic.name for topic in bag.topics if topic.typename.endswith(f"/{kind}")]
    if name is not None:
        if name not in there:
            raise RecordingError(f"{path} has no {kind} on {name}; it has {there or 'none'}")
        return name
    if len(there) != 1:
        raise RecordingError(
            f"{path} has {len(there)} topics of {kind} ({', '.join(there) or 'none'}): "
            + (f"state `{parameter}`" if there else "record pose and wrench")
        )
    return there[0]


Fields = tuple[float, ...]


def _track(
    bag: Bag, path: Path, name: str, values: Callable[[Any], Fields | None], of_what: str = ""
) -> Track:
    decoder = Decoder(next(topic for topic in bag.topics if topic.name == name), path)
    stamps, rows = [], []

    def take_row(message: Any) -> None:
        row = values(message)
        if row is not None:
            stamp = message.header.stamp
            stamps.append(int(stamp.sec) * NANOSECONDS + int(stamp.nanosec))
            rows.append(row)

    for _ in decoder.decode(by_log_time(bag, [name], lambda share: None), take_row):
        pass
    if not rows:
        raise RecordingError(f"{path}: on {name} there is no message{of_what}")
    return Track(np.array(stamps, dtype=np.int64), np.array(rows, dtype=np.float64))


def _pose(message: Any) -> Fields:
    p, q = message.pose.position, message.pose.orientation
    return (p.x, p.y, p.z, q.x, q.y, q.z, q.w)


def _wrench(message: Any) -> Fields:
    f, t = message.wrench.force, message.wrench.torque
    return (f.x, f.y, f.z, t.x, t.y, t.z)
