"""Whether the monitor's test tells hidden effects in time, and is silent on tissue without any.

The streams are those of `streams`; every second one is a sine of 10 Hz, the others sweep from 1 to
60 Hz and back. They are played through the numerics of the node, faster than in real time. What is
told is diagnosed, on the samples that the node would have.

Contents: streams, what is told of them, the tables.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import islice

import numpy as np
from rich.table import Table

from benchmarks.live_loop.streams import ALONE, cut_into_blocks, draw_rig, measure_case, move_coil
from tissue_probe.analysis.monitor_worker import answer_question
from tissue_probe.challenge.case import Case
from tissue_probe.challenge.instrument import CHALLENGE_RATE
from tissue_probe.challenge.simulator import LIBRARY, make_challenge
from tissue_probe.challenge.trajectory import Trajectory
from tissue_probe.monitoring.monitor import Monitor
from tissue_probe.monitoring.question import MonitorAnswer, question
from tissue_probe.monitoring.settings import MonitorSettings
from tissue_probe.signals import FloatArray

#: Seeds of no test, and of nothing that the test was made with; of clean tissue, downwards.
FIRST_SEED, CLEAN_SEED = 63_000, 60_499
#: Samples within which an effect is to be told [s].
IN_TIME = 3.0
#: Strengths of each effect, each with a specimen of its own.
STRENGTHS = 3
#: Residual over noise from which an effect must be told, the rig's tolerances taken into account.
SHOWN = 1.4
#: Specimens tried for each effect until it shows at that many strengths.
TRIED = 12
#: Steps a second of the simulation of minutes without an effect [Hz]: without switches it is exact.
COARSE = 8_000
#: A minute is that many specimens, each for so long [s].
PIECES, PIECE = 3, 20.0


@dataclass(frozen=True)
class Outcome:
    """What the test said of one stream.

    Attributes
    ----------
    effect : str
        What was hidden; empty if nothing.
    seed : int
        Of the stream.
    motion : str
        ``sine`` or ``sweep``.
    shown : float
        Residual over noise that the effect leaves beyond the rig's tolerances.
    windows, rejected : int
        How many were tested, and how many of them rejected.
    told : float
        Time of samples until the first window was rejected [s]; NaN if none was.
    seconds : float
        Processor time of a window [s].
    verdict : str
        Of the diagnosis of what was told; empty where nothing was.
    named : tuple of str
        Effects that it holds for missing.
    """

    effect: str
    seed: int
    motion: str
    shown: float
    windows: int
    rejected: int
    told: float
    seconds: float
    verdict: str
    named: tuple[str, ...]

    @property
    def is_right(self) -> bool:
        """Whether the verdict names the effect alone, or is ambiguous and has it in its set."""
        if self.verdict == "ambiguous":
            return self.effect in self.named
        return self.verdict == "missing" and self.named == (self.effect,)


def measure(count: int) -> list[Outcome]:
    """Mark ``STRENGTHS`` streams of each effect, and ``count`` minutes without one."""
    settings = MonitorSettings()
    return [*_hidden(settings), *(_clean(settings, number) for number in range(PIECES * count))]


def _hidden(settings: MonitorSettings) -> Iterator[Outcome]:
    for effect in ALONE:
        place = [*LIBRARY].index(effect)
        seeds = range(FIRST_SEED + TRIED * place, FIRST_SEED + TRIED * (place + 1))
        marked = (_of_effect(settings, effect, seed) for seed in seeds)
        yield from islice((each for each in marked if each.shown >= SHOWN), STRENGTHS)


def _of_effect(settings: MonitorSettings, effect: str, seed: int) -> Outcome:
    motion = ("sine", "sweep")[seed % 2]
    made = make_challenge(seed, (effect,), move_coil(motion, seed, IN_TIME), "tolerant")
    shown = made.answer.shown[effect]
    taken = made.recording
    return _marked(settings, taken.position, taken.force, (effect, seed, motion, shown))


def _clean(settings: MonitorSettings, number: int) -> Outcome:
    """Mark tissue without any effect."""
    seed, motion = CLEAN_SEED - number, ("sine", "sweep")[number % 2]
    random = np.random.default_rng(seed)
    coil = Trajectory.follow_motion(move_coil(motion, seed, PIECE))
    case = Case(*draw_rig(random), coil).press_in(coil.preload)
    return _marked(settings, *measure_case(case, random, COARSE), ("", seed, motion, 1.0))


def _marked(
    settings: MonitorSettings,
    position: FloatArray,
    force: FloatArray,
    of: tuple[str, int, str, float],
) -> Outcome:
    monitor, told, windows, rejected, spent = Monitor(settings), np.nan, 0, 0, 0.0
    for block in cut_into_blocks(position, force):
        begun = time.process_time()
        tested = monitor.take(block)
        if tested is None:
            continue
        spent += time.process_time() - begun
        windows += 1
        rejected += tested.rejected
        if tested.rejected and np.isnan(told):
            told = (block.sequence + len(block)) / CHALLENGE_RATE
    verdict = diagnose_last(monitor) if of[0] and rejected else None
    return Outcome(
        *of, windows, rejected, float(told), spent / max(windows, 1),
        verdict.verdict if verdict else "", name_likely(verdict) if verdict else (),
    )  # fmt: skip


def diagnose_last(monitor: Monitor) -> MonitorAnswer:
    """Diagnose the last samples that a monitor has, as its node does on request."""
    block = monitor.last()
    assert block is not None, "the stream is longer than a window"
    return answer_question(question(monitor.model, block))


def name_likely(verdict: MonitorAnswer) -> tuple[str, ...]:
    """Name the effects that a verdict holds for missing.

    Where it is ambiguous these are all that it tells, else those that are rather missing than not.
    """
    ambiguous = verdict.verdict == "ambiguous"
    return tuple(name for name, likely in verdict.effects if ambiguous or likely > 0.5)


def kept(outcomes: Sequence[Outcome]) -> list[dict[str, object]]:
    """Return the outcomes as JSON holds them."""
    known = (asdict(each) for each in outcomes)
    return [{**each, "told": None if np.isnan(each["told"]) else each["told"]} for each in known]


def table(outcomes: Sequence[Outcome]) -> Table:
    """Return what was told, and what was told in vain."""
    hidden = [each for each in outcomes if each.effect]
    clean = [each for each in outcomes if not each.effect]
    found = Table(
        "streams", "count", "told", "missed or in vain", "verdict right", "not right",
        title="The monitor's test",
    )  # fmt: skip
    for motion in ("sine", "sweep"):
        of = [each for each in hidden if each.motion == motion]
        missed = [f"{e.effect} ({e.shown:.1f})" for e in of if not e.rejected]
        told = len(of) - len(missed)
        marked = [each for each in of if each.rejected]
        wrong = [_describe_wrong(each) for each in marked if not each.is_right]
        found.add_row(
            f"an effect, {motion}", str(len(of)), str(told), ", ".join(missed),
            f"{told - len(wrong)} of {told}", "; ".join(wrong),
        )  # fmt: skip
        of = [each for each in clean if each.motion == motion]
        vain = [f"{each.rejected} of seed {each.seed}" for each in of if each.rejected]
        found.add_row(
            f"{PIECE:g} s without, {motion}", str(len(of)), str(len(vain)), ", ".join(vain)
        )
    windows = sum(each.windows for each in outcomes)
    spent = sum(each.windows * each.seconds for each in outcomes) / max(windows, 1)
    step = MonitorSettings().step
    found.caption = (
        f"{windows} windows, {1e3 * spent:.1f} ms of processor each, {spent / step:.3f} core"
    )
    return found


def _describe_wrong(outcome: Outcome) -> str:
    named = " + ".join(outcome.named) or "none"
    return f"{outcome.effect} ({outcome.seed}): {outcome.verdict}, {named}"
