"""Recordings of simulated tissue with hidden effects, as measurements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from tissue_probe import arguments as take
from tissue_probe.analysis.measurements import Measurements, read
from tissue_probe.challenge.simulator import HiddenTruth, SimulatedRecord
from tissue_probe.challenge.simulator import make_challenge as make
from tissue_probe.challenge.trajectory import Kind
from tissue_probe.likeness import Alike


@dataclass(frozen=True, eq=False)
class ChallengeResult(Alike):
    """Two recordings of one specimen, and the effects hidden in it.

    Attributes
    ----------
    first, second : Measurements
        With another motion of the coil each.
    answer : Answer
        The hidden effects and their sizes.
    """

    first: Measurements
    second: Measurements
    answer: HiddenTruth


@take.checks(
    seed=take.whole(),
    effects=take.several(take.text, "names of effects"),
    excitation=take.choice(*get_args(Kind)),
    rig=take.choice("exact", "tolerant"),
)
def make_challenge(
    seed: int,
    effects: Sequence[str] = (),
    excitation: Kind = "chirp60",
    rig: Literal["exact", "tolerant"] = "exact",
) -> ChallengeResult:
    """Hide effects in a simulated specimen, and measure it twice.

    The simulator shares no code with the models that are fitted.

    Parameters
    ----------
    seed : int
        The same arguments give the same challenge.
    effects : sequence of str
        Names of effects to hide; none for a clean recording.
    excitation : str
        ``sine10``, ``sine10ss``, ``stepped30``, ``chirp60`` or ``msine60``.
    rig : {"exact", "tolerant"}
        Whether the rig is the nominal one, or off within its tolerances.

    Raises
    ------
    ParameterError
        If there is no such effect, excitation or rig.
    """
    made = make(seed, tuple(effects), excitation, rig)
    return ChallengeResult(_measurements(made.recording), _measurements(made.second), made.answer)


def _measurements(taken: SimulatedRecord) -> Measurements:
    columns = {"t": taken.time, "u": taken.position, "F": taken.force}
    return read(columns, force_polarity="compression")
