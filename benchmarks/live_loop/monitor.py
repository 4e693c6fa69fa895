"""Whether the monitor's test tells hidden effects in time, and is silent on tissue without any.

The streams are made by the challenge's simulator, which shares no code with the models under test,
on its tolerant rig (constants off within their tolerances, 1/f noise); every second one is a sine
of 10 Hz, the others sweep from 1 to 60 Hz and back. They are played through the numerics of the
node, faster than in real time.

Contents: streams, what is told of them, the tables.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import islice

import numpy as np
from rich.table import Table

from tissue_probe.challenge.case import Case
from tissue_probe.challenge.instrument import (
    CHALLENGE_RATE,
    FORCE_NOISE,
    InstrumentErrors,
    pink_noise,
)
from tissue_probe.challenge.measured import Measured
from tissue_probe.challenge.record import follow
from tissue_probe.challenge.simulator import LIBRARY, PINK_NOISE, make_challenge
from tissue_probe.challenge.specimen import Specimen
from tissue_probe.challenge.tolerances import Tolerances
from tissue_probe.challenge.trajectory import Trajectory
from tissue_probe.monitoring.monitor import Monitor
from tissue_probe.monitoring.settings import MonitorSettings
from tissue_probe.signals import FloatArray, SampleBlock

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
#: Samples to a block, as the driver publishes them.
BLOCK = 10


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
    """

    effect: str
    seed: int
    motion: str
    shown: float
    windows: int
    rejected: int
    told: float
    seconds: float


def measure(count: int) -> list[Outcome]:
    """Mark ``STRENGTHS`` streams of each effect, and ``count`` minutes without one."""
    settings = MonitorSettings()
    return [*_hidden(settings), *(_clean(settings, number) for number in range(PIECES * count))]


def _hidden(settings: MonitorSettings) -> Iterator[Outcome]:
    for place, effect in enumerate(LIBRARY):
        seeds = range(FIRST_SEED + TRIED * place, FIRST_SEED + TRIED * (place + 1))
        marked = (_of_effect(settings, effect, seed) for seed in seeds)
        yield from islice((each for each in marked if each.shown >= SHOWN), STRENGTHS)


def _of_effect(settings: MonitorSettings, effect: str, seed: int) -> Outcome:
    motion = ("sine", "sweep")[seed % 2]
    made = make_challenge(seed, (effect,), _motion(motion, seed, IN_TIME), "tolerant")
    shown = made.answer.shown[effect]
    taken = made.recording
    return _marked(settings, taken.position, taken.force, (effect, seed, motion, shown))


def _clean(settings: MonitorSettings, number: int) -> Outcome:
    """Mark tissue without any effect."""
    seed, motion = CLEAN_SEED - number, ("sine", "sweep")[number % 2]
    random = np.random.default_rng(seed)
    tissue = Specimen(
        stiffness=float(np.exp(random.uniform(np.log(150.0), np.log(3000.0)))),
        damping=float(np.exp(random.uniform(np.log(0.5), np.log(15.0)))),
    )
    rig, zero = Tolerances().draw_rig(tissue, random.standard_normal(len(Tolerances._fields)))
    instrument = InstrumentErrors(contact_zero=zero, pink_noise=PINK_NOISE)
    coil = Trajectory.follow_motion(_motion(motion, seed, PIECE))
    case = Case(rig, instrument, coil).press_in(coil.preload)
    noise = FORCE_NOISE * random.standard_normal(case.samples)
    noise += PINK_NOISE * pink_noise(case.samples, random)
    return _marked(settings, *case.measure(noise, COARSE), ("", seed, motion, 1.0))


def _motion(kind: str, seed: int, seconds: float) -> Measured:
    """Return a motion of the coil that begins at rest, pressed in or not."""
    random = np.random.default_rng(seed)
    since = np.arange(round(seconds * CHALLENGE_RATE)) / CHALLENGE_RATE
    frequency = np.full(since.size, 10.0)
    if kind == "sweep":  # up and down in 8 s
        frequency = 1.0 + 59.0 * (1.0 - np.abs(1.0 - since % 8.0 / 4.0))
    rise = np.clip(since / 0.05, 0.0, 1.0)
    rise = rise**3 * (10.0 - 15.0 * rise + 6.0 * rise**2)
    angle = 2.0 * np.pi * np.cumsum(frequency) / CHALLENGE_RATE
    preload = random.uniform(1e-3, 3e-3) if random.random() < 0.5 else 0.0
    moved = preload + random.uniform(0.8e-3, 1.2e-3) * rise * np.sin(angle)
    return follow(since, moved, kind, True)


def _marked(
    settings: MonitorSettings,
    position: FloatArray,
    force: FloatArray,
    of: tuple[str, int, str, float],
) -> Outcome:
    monitor, told, windows, rejected, spent = Monitor(settings), np.nan, 0, 0, 0.0
    unknown = np.full(BLOCK, np.nan)
    for first in range(0, force.size - BLOCK + 1, BLOCK):
        here = slice(first, first + BLOCK)
        stamp = round(1e9 * first / CHALLENGE_RATE)
        block = SampleBlock(
            stamp, first, 1.0 / CHALLENGE_RATE, position[here], force[here], unknown
        )
        begun = time.process_time()
        tested = monitor.take(block)
        if tested is None:
            continue
        spent += time.process_time() - begun
        windows += 1
        rejected += tested.rejected
        if tested.rejected and np.isnan(told):
            told = (first + BLOCK) / CHALLENGE_RATE
    return Outcome(*of, windows, rejected, float(told), spent / max(windows, 1))


def kept(outcomes: Sequence[Outcome]) -> list[dict[str, object]]:
    """Return the outcomes as JSON holds them."""
    known = (asdict(each) for each in outcomes)
    return [{**each, "told": None if np.isnan(each["told"]) else each["told"]} for each in known]


def table(outcomes: Sequence[Outcome]) -> Table:
    """Return what was told, and what was told in vain."""
    hidden = [each for each in outcomes if each.effect]
    clean = [each for each in outcomes if not each.effect]
    found = Table("streams", "count", "told", "missed or in vain", title="The monitor's test")
    for motion in ("sine", "sweep"):
        of = [each for each in hidden if each.motion == motion]
        missed = [f"{e.effect} ({e.shown:.1f})" for e in of if not e.rejected]
        told = len(of) - len(missed)
        found.add_row(f"an effect, {motion}", str(len(of)), str(told), ", ".join(missed))
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
