"""How the filters fare on a rig that is off within its tolerances: `live_loop`.

Contents: rejections of clean tissue, intervals that hold, the time of a sample.

Records are the challenge's, clean, on its tolerant rig; the filters have their default settings,
and the same with all constants taken as exact. Seeds from ``FIRST`` on were not looked at while
the filters were made.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np
from rich.table import Table

from benchmarks.estimators_speed import kernel_time
from tissue_probe.challenge import Challenge, make_challenge
from tissue_probe.estimation import Estimator, EstimatorSettings
from tissue_probe.signals import SampleBlock, Status, TissueEstimates

FIRST = 8000
EXCITATIONS = ("sine10", "chirp60")
FILTERS = ("robust_ekf", "ekf", "afekf", "ukf", "afukf")
#: Standard deviations that are to hold 95 % of the errors.
WITHIN = 2.0


@dataclass(frozen=True)
class Mark:
    """What one filter got on the records of one excitation.

    Attributes
    ----------
    filter, excitation : str
        Which.
    records : int
        How many.
    rejected, rejected_exact : int
        Records whose model was rejected at any sample; the same with constants taken as exact.
    stiffness_held, damping_held : int
        Last estimates within ``WITHIN`` stated standard deviations of the truth.
    stiffness_held_exact, damping_held_exact : int
        The same with constants taken as exact.
    times : float
        Time of a sample over that with constants taken as exact.
    """

    filter: str
    excitation: str
    records: int
    rejected: int
    rejected_exact: int
    stiffness_held: int
    stiffness_held_exact: int
    damping_held: int
    damping_held_exact: int
    times: float


def measure(seeds: int) -> list[Mark]:
    """Mark every filter on as many records of each excitation."""
    marks = []
    for excitation in EXCITATIONS:
        made = [make_challenge(FIRST + seed, (), excitation, "tolerant") for seed in range(seeds)]
        marks += [_marked(name, excitation, made) for name in FILTERS]
    return marks


def kept(marks: Sequence[Mark]) -> list[dict[str, object]]:
    """Return the marks as JSON keeps them."""
    return [asdict(mark) for mark in marks]


def table(marks: Sequence[Mark]) -> Table:
    """Return the marks as a table."""
    found = Table(title="Clean tissue on the tolerant rig; in brackets: constants taken as exact")
    for name in ("filter", "record", "rejected", "k in 2 sd", "beta in 2 sd", "time, ratio"):
        found.add_column(name)
    for mark in marks:
        found.add_row(
            mark.filter,
            mark.excitation,
            f"{mark.rejected} ({mark.rejected_exact}) of {mark.records}",
            f"{mark.stiffness_held} ({mark.stiffness_held_exact})",
            f"{mark.damping_held} ({mark.damping_held_exact})",
            f"{mark.times:.2f}",
        )
    return found


def _marked(name: str, excitation: str, made: Sequence[Challenge]) -> Mark:
    tolerant, exact = EstimatorSettings().tolerant(), EstimatorSettings()
    counts = {key: np.zeros(3, int) for key in (tolerant, exact)}
    for challenge in made:
        for settings in counts:
            counts[settings] += _judged(challenge, _estimated(name, settings, challenge))
    position, force = _channels(made[0])
    times = [kernel_time(name, position, force, settings) for settings in counts]
    (rejected, k, beta), (rejected_exact, k_exact, beta_exact) = (
        map(int, each) for each in counts.values()
    )
    return Mark(
        name, excitation, len(made),
        rejected, rejected_exact, k, k_exact, beta, beta_exact, times[0] / times[1],
    )  # fmt: skip


def _channels(challenge: Challenge) -> tuple[np.ndarray, np.ndarray]:
    recording = challenge.recording
    return np.asarray(recording.position), np.asarray(recording.force)


def _estimated(name: str, settings: EstimatorSettings, challenge: Challenge) -> TissueEstimates:
    position, force = _channels(challenge)
    block = SampleBlock(
        0, 0, challenge.recording.sample_period, position, force, np.full(position.size, np.nan)
    )
    return Estimator(name, settings).process(block)


def _judged(challenge: Challenge, found: TissueEstimates) -> np.ndarray:
    """Return whether the model was rejected, and whether k and beta are where they are said."""
    tissue = challenge.answer.tissue
    k, beta = found.stiffness[-1] - tissue["stiffness"], found.damping[-1] - tissue["damping"]
    return np.array(
        [
            bool(np.any(found.status == Status.MODEL_REJECTED)),
            abs(k) <= WITHIN * found.stiffness_variance[-1] ** 0.5,
            abs(beta) <= WITHIN * found.damping_variance[-1] ** 0.5,
        ],
        dtype=int,
    )
