"""Whether somebody is told where a filter is sure of an estimate that is wrong.

A delay, a heavier tip or a relaxation may pass for tissue: the innovations stay white, and
`robust_ekf` calls stiffness and damping converged while one of them is off by more than 5 %.
Counted are streams, those of `streams`, on which it does so by the cause alone: without the cause,
on the same rig with the same noise, both are within 5 %.

The monitor is to reject a window in time; or the diagnosis that its node makes on request is to
name the cause, or to list it under `unseen` with what would show it.

Contents: causes, what is told of each stream, the table.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import count, islice

import numpy as np
from rich.table import Table

from benchmarks.live_loop.monitor import IN_TIME, diagnose_last, name_likely
from benchmarks.live_loop.streams import cut_into_blocks, draw_rig, measure_case, move_coil
from tissue_probe.challenge.case import Case
from tissue_probe.challenge.change import Change, log_uniform
from tissue_probe.challenge.instrument import CHALLENGE_RATE
from tissue_probe.challenge.specimen import Specimen
from tissue_probe.challenge.trajectory import Trajectory
from tissue_probe.estimation import Estimator, EstimatorSettings
from tissue_probe.monitoring.monitor import Monitor
from tissue_probe.monitoring.settings import MonitorSettings
from tissue_probe.signals import FloatArray, SampleBlock, Status

#: Seeds of no test, and of nothing that the test was made with.
FIRST_SEED = 65_000
FILTER = "robust_ekf"
#: Error from which an estimate is wrong, over the truth.
WRONG = 0.05
#: Streams of each cause that are counted, and specimens tried for them.
COUNTED, TRIED = 12, 400
CAUSES = ("channel_delay", "added_mass", "standard_linear_solid")


@dataclass(frozen=True)
class Outcome:
    """What was told of one stream.

    Attributes
    ----------
    cause : str
        What makes the estimate wrong.
    seed : int
        Of the stream.
    motion : str
        ``sine`` or ``sweep``.
    error : float
        The larger of those of stiffness and damping, over the truth.
    told : float
        Time of samples until a window was rejected [s]; NaN if none was in time.
    verdict : str
        Of the diagnosis, which is made where no window was rejected; else empty.
    named, unseen : tuple of str
        Effects that it holds for missing, and those that these samples could not have shown.
    experiment : str
        What it says would show more.
    """

    cause: str
    seed: int
    motion: str
    error: float
    told: float
    verdict: str = ""
    named: tuple[str, ...] = ()
    unseen: tuple[str, ...] = ()
    experiment: str = ""

    @property
    def is_shown(self) -> bool:
        """Whether somebody who asks hears of the cause."""
        listed = self.cause in self.unseen and bool(self.experiment)
        return listed or self.cause in self.named


def measure() -> list[Outcome]:
    """Mark ``COUNTED`` streams of each cause."""
    return [each for cause in CAUSES for each in islice(_streams(cause), COUNTED)]


def _streams(cause: str) -> Iterator[Outcome]:
    """Mark streams of a cause on which the filter is sure of a wrong estimate."""
    place = CAUSES.index(cause)
    for number in islice(count(), TRIED):
        seed, motion = FIRST_SEED + TRIED * place + number, ("sine", "sweep")[number % 2]
        random = np.random.default_rng(seed)
        rig, instrument = draw_rig(random)
        coil = Trajectory.follow_motion(move_coil(motion, seed, IN_TIME))
        clean = Case(rig, instrument, coil).press_in(coil.preload)
        case = clean.apply_change(_change(cause, rig, random))
        noise = int(random.integers(2**32))
        blocks = list(cut_into_blocks(*measure_case(case, np.random.default_rng(noise))))
        error = _sure_error(blocks, rig)
        if error is None or error <= WRONG:
            continue
        right = cut_into_blocks(*measure_case(clean, np.random.default_rng(noise)))
        without = _sure_error(list(right), rig)
        if without is not None and without <= WRONG:
            yield _marked(Outcome(cause, seed, motion, error, np.nan), blocks)


def _change(cause: str, rig: Specimen, random: np.random.Generator) -> Change:
    if cause == "channel_delay":
        return Change(instrument={"delay": 0.5e-3})
    if cause == "added_mass":
        return Change({"tip_mass": 1.05 * rig.tip_mass})
    time = log_uniform(random, 0.01, 0.3)
    return Change({"branch_stiffness": (0.1 * rig.stiffness,), "branch_rate": (1.0 / time,)})


def _sure_error(blocks: Sequence[SampleBlock], truth: Specimen) -> float | None:
    """Return the error of the last estimate over the truth; None where it is not converged."""
    whole = SampleBlock(
        blocks[0].stamp, 0, blocks[0].sample_period,
        *(_join(blocks, name) for name in ("position", "force", "command")),
    )  # fmt: skip
    last = Estimator(FILTER, EstimatorSettings()).process(whole)[-1:]
    if last.status[0] != Status.CONVERGED:
        return None
    wrong = last.stiffness[0] / truth.stiffness, last.damping[0] / truth.damping
    return float(np.max(np.abs(np.array(wrong) - 1.0)))


def _join(blocks: Sequence[SampleBlock], name: str) -> FloatArray:
    return np.concatenate([getattr(each, name) for each in blocks])


def _marked(found: Outcome, blocks: Sequence[SampleBlock]) -> Outcome:
    monitor = Monitor(MonitorSettings())
    for block in blocks:
        tested = monitor.take(block)
        if tested is not None and tested.rejected:
            told = (block.sequence + len(block)) / CHALLENGE_RATE
            return Outcome(found.cause, found.seed, found.motion, found.error, told)
    verdict = diagnose_last(monitor)
    return Outcome(
        found.cause, found.seed, found.motion, found.error, np.nan,
        verdict.verdict, name_likely(verdict), verdict.unseen, verdict.experiment,
    )  # fmt: skip


def kept(outcomes: Sequence[Outcome]) -> list[dict[str, object]]:
    """Return the outcomes as JSON holds them."""
    known = (asdict(each) for each in outcomes)
    return [{**each, "told": None if np.isnan(each["told"]) else each["told"]} for each in known]


def table(outcomes: Sequence[Outcome]) -> Table:
    """Return of how many wrong estimates somebody is told, and how."""
    found = Table(
        "cause", "estimates", f"told in {IN_TIME:g} s", "named or unseen, on request", "neither",
        title=f"Estimates of {FILTER} that are converged, and wrong by more than {WRONG:.0%}",
    )  # fmt: skip
    for cause in CAUSES:
        of = [each for each in outcomes if each.cause == cause]
        silent = [each for each in of if np.isnan(each.told)]
        missed = [
            f"{e.motion} {e.seed} ({e.error:.0%}): {e.verdict}, {' + '.join(e.named) or 'none'}"
            for e in silent
            if not e.is_shown
        ]
        found.add_row(
            cause, str(len(of)), str(len(of) - len(silent)), str(len(silent) - len(missed)),
            "; ".join(missed),
        )  # fmt: skip
    return found
