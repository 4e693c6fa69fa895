"""Whether an identification settles on the hidden effect, after at most two further records.

The records are of the specimens of `streams`. The first is a sine of 10 Hz, as the driver has it by
default; the code that the node asks chooses the others. Each effect is made so strong that it shows
under a multisine.

An effect counts as one that an excitation can tell if the best Kelvin-Voigt fit within the rig's
tolerances leaves enough of it under the first motion or under one of those that may be chosen.

Contents: the records of a specimen, an identification of it, the table.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np
from rich.table import Table

from benchmarks.live_loop.streams import ALONE, draw_rig, measure_case, rise_from_rest
from tissue_probe.analysis.monitor_worker import answer_records
from tissue_probe.challenge.case import Case
from tissue_probe.challenge.change import log_uniform
from tissue_probe.challenge.instrument import CHALLENGE_RATE
from tissue_probe.challenge.record import follow
from tissue_probe.challenge.simulator import LIBRARY
from tissue_probe.challenge.strength import SEARCH_RATE, hide
from tissue_probe.challenge.tolerances import Tolerances
from tissue_probe.challenge.trajectory import Trajectory
from tissue_probe.errors import TissueProbeError
from tissue_probe.excitation import parse_excitation
from tissue_probe.monitoring.experiments import ExcitationBounds
from tissue_probe.monitoring.identification import (
    LiveRecord,
    RecordsVerdict,
    ask_about_records,
    find_end,
)
from tissue_probe.monitoring.settings import MonitorSettings
from tissue_probe.monitoring.tested_model import TestedModel, load_tested_model
from tissue_probe.physics.effects import EFFECTS

#: Seeds of no test, and of nothing that was tuned by them.
FIRST_SEED = 64_000
#: The first record: the driver's usual excitation, and how long it is [s].
FIRST: dict[str, object] = {"kind": "sine", "amplitude": 0.85, "frequency": 10.0}
FIRST_SECONDS = 4.0
#: Way of the coil for a volt [m/V], about that of the simulated probe.
GAIN = 1e-3
#: The driver's own limits: volts, hertz, newtons, metres.
BOUNDS = ExcitationBounds(5.0, 0.01, 100.0, 8.0, 6e-3)
PROBABILITY, MOST_RECORDS = 0.95, 3
#: Residual over noise from which an effect can be told, the rig's tolerances taken into account.
SHOWN = 1.4
#: Residual over noise that an effect is to leave under the multisine.
WEAKEST, STRONGEST = 2.0, 10.0
#: The multisine that effects are scaled by.
BROAD: dict[str, object] = {
    "kind": "multisine",
    "amplitude": 1.0,
    "start": 1.0,
    "stop": 60.0,
    "spacing": 1.0,
}
SWEEP: dict[str, object] = {
    "kind": "chirp",
    "amplitude": 1.0,
    "start": 1.0,
    "stop": 60.0,
    "duration": 4.0,
}


@dataclass(frozen=True)
class Outcome:
    """How an identification ended.

    Attributes
    ----------
    effect : str
        What was hidden; empty if nothing.
    seed : int
        Of the specimen.
    shown : float
        Most that the effect leaves over the noise under a motion that may be chosen.
    records : int
        How many were made.
    verdicts : tuple of str
        After each record.
    found : tuple of str
        Effects that are rather missing than not.
    settled, right : bool
        Whether the answer is settled; whether it names the effect and no other.
    seconds : float
        Processor time of all diagnoses [s].
    end : str
        How it ended.
    """

    effect: str
    seed: int
    shown: float
    records: int
    verdicts: tuple[str, ...]
    found: tuple[str, ...]
    settled: bool
    right: bool
    seconds: float
    end: str


def measure(count: int, effects: Sequence[str] = (*ALONE, "")) -> list[Outcome]:
    """Identify ``count`` specimens of each effect, and as many without one."""
    model = load_tested_model(MonitorSettings())
    outcomes = []
    for number in range(count):
        for effect in effects:
            place = [*LIBRARY, ""].index(effect)
            outcomes.append(_identify(model, effect, FIRST_SEED + 100 * number + place))
    return outcomes


def _identify(model: TestedModel, effect: str, seed: int) -> Outcome:
    random = np.random.default_rng(seed)
    case, shown = _specimen(effect, random)
    records = [_record(case, FIRST, FIRST_SECONDS, random)]
    verdicts: list[RecordsVerdict] = []
    begun = time.process_time()
    while True:
        asked = ask_about_records(model, records, BOUNDS, PROBABILITY)
        try:
            verdicts.append(answer_records(asked))
        except TissueProbeError as error:
            end = str(error)
            break
        if end := find_end(verdicts[-1], PROBABILITY, len(records), MOST_RECORDS):
            break
        last = verdicts[-1]
        records.append(_record(case, last.excitation, last.duration, random))
    found = tuple(name for name, likely in verdicts[-1].effects if likely > 0.5) if verdicts else ()
    settled = bool(verdicts) and verdicts[-1].is_settled(PROBABILITY)
    return Outcome(
        effect, seed, shown, len(records), tuple(each.verdict for each in verdicts), found,
        settled, found == ((effect,) if effect else ()), time.process_time() - begun, end,
    )  # fmt: skip


def _specimen(effect: str, random: np.random.Generator) -> tuple[Case, float]:
    """Return a specimen with an effect, and the most that it shows under any motion."""
    rig, instrument = draw_rig(random)
    pressed = random.uniform(1e-3, 3e-3) if random.random() < 0.5 else 0.0
    clean = Case(rig, instrument, _motion(BROAD, 2.0, pressed)).press_in(pressed)
    if not effect:
        return clean, 1.0
    target, tolerances = log_uniform(random, WEAKEST, STRONGEST), Tolerances()
    hidden = hide(LIBRARY[effect], clean, target, int(random.integers(2**32)), tolerances)
    case = clean.apply_change(hidden.change)
    preload = case.trajectory.preload
    shown = max(
        _move(case, _motion(each, seconds, preload)).ratio(rig, SEARCH_RATE, tolerances)
        for each, seconds in ((FIRST, FIRST_SECONDS), (BROAD, 2.0), (SWEEP, 4.0))
    )
    return case, shown


def _motion(excitation: Mapping[str, object], seconds: float, preload: float) -> Trajectory:
    """Return the coil's motion under an excitation, from rest."""
    since = np.arange(round(seconds * CHALLENGE_RATE)) / CHALLENGE_RATE
    moved = preload + GAIN * rise_from_rest(since) * parse_excitation(dict(excitation))(since)
    return Trajectory.follow_motion(follow(since, moved, str(excitation["kind"]), True))


def _move(case: Case, motion: Trajectory) -> Case:
    """Return the specimen under another motion; what it remembers is kept."""
    known = case.specimen._replace(damage_reached=case.situation.depth)
    return replace(case, specimen=known, trajectory=motion).press_in(motion.preload)


def _record(
    case: Case, excitation: Mapping[str, object], seconds: float, random: np.random.Generator
) -> LiveRecord:
    moved = _move(case, _motion(excitation, seconds, case.trajectory.preload))
    position, force = measure_case(moved, random)
    command = parse_excitation(dict(excitation))(np.arange(moved.samples) / CHALLENGE_RATE)
    return LiveRecord(position, force, command, 1.0 / CHALLENGE_RATE, excitation)


def kept(outcomes: Sequence[Outcome]) -> list[dict[str, object]]:
    """Return the outcomes as JSON holds them."""
    return [asdict(each) for each in outcomes]


def table(outcomes: Sequence[Outcome]) -> Table:
    """Return how many identifications settled, and on what."""
    told = [each for each in outcomes if each.effect and each.shown >= SHOWN]
    rows = {
        "an effect that an excitation can tell": told,
        "an effect that none can tell": [e for e in outcomes if e.effect and e.shown < SHOWN],
        "none": [each for each in outcomes if not each.effect],
    }
    found = Table("hidden", "count", "settled and right", "right family", "settled, wrong",
                  "not settled", title="Identify: after at most two further records")  # fmt: skip
    for name, of in rows.items():
        right = [each for each in of if each.settled and each.right]
        wrong = [each for each in of if each.settled and not each.right]
        rest = [each.effect or "none" for each in of if not each.settled]
        false = ", ".join(f"{e.effect or 'none'}: {' + '.join(e.found) or 'none'}" for e in wrong)
        family = [each for each in of if each.settled and _families(each.found) == _hidden(each)]
        found.add_row(name, str(len(of)), str(len(right)), str(len(family)), false, ", ".join(rest))
    spent = [each.seconds for each in outcomes]
    made = np.mean([each.records for each in outcomes])
    found.caption = (
        f"{np.mean(spent):.1f} s of processor an identification, {max(spent):.1f} s at the most; "
        f"{made:.2f} records each"
    )
    return found


def _families(names: Sequence[str]) -> list[str]:
    return sorted(EFFECTS[name].family for name in names)


def _hidden(outcome: Outcome) -> list[str]:
    return _families([outcome.effect] if outcome.effect else [])
