"""How far the diagnosis can be trusted: sealed challenges of seeds that no test uses.

Contents: dealing the challenges, diagnosing them, marking the diagnoses.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from itertools import count as count_from
from itertools import cycle
from typing import Any

import numpy as np

from benchmarks import sparse_regression
from benchmarks.ruler.probabilities import Stated, stated
from tissue_probe.challenge import simulator
from tissue_probe.challenge.grading import Grade, GradedDiagnosis, HiddenKind, grade, kind_of
from tissue_probe.challenge.instrument import FORCE_NOISE
from tissue_probe.challenge.series import all_show, deal
from tissue_probe.challenge.simulator import PINK_NOISE, Challenge, Rig, make_challenge
from tissue_probe.challenge.trajectory import DURATIONS
from tissue_probe.diagnosis import diagnosis
from tissue_probe.diagnosis.answer import answer
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.other_runs import carry_model
from tissue_probe.physics import machine_code
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS

#: Seeds of the tests are smaller, but for a dozen from 1.5 million on.
FIRST_SEED = 500_000
#: Recordings of one hidden effect in each cell, of each excitation on each rig: so many that every
#: effect comes at least once.
COUNT = 6
#: What may be hidden: one effect, one outside the library, none, two.
HIDDEN = ("one", "outside", "none", "two")
#: To as many of these, or a part of as many, on each rig there is one of each other kind.
TO_ANOTHER = 3


@dataclass
class Battery:
    """What was hidden on one rig, and what was said of it, by the recordings' seeds.

    Attributes
    ----------
    answers : dict
        Fields of each ``HiddenTruth``.
    diagnoses, regressions : dict
        Of the suite, and of sparse regression.
    heldout, left_out : list of float
        Error over the rms of the noise [-], an encoder's rounding counted as such, where exactly
        what was hidden was added: on the second recording, and on eighths of the first, each
        predicted by a fit to the others.
    seconds : dict of float to list of float
        Time of each diagnosis, kernels compiled, by the length of the recording [s].
    stated : list of Stated
        What was stated with which probability; not of what Kelvin-Voigt absorbs, which none tells.
    """

    answers: dict[str, dict[str, Any]] = field(default_factory=dict)
    diagnoses: dict[str, GradedDiagnosis] = field(default_factory=dict)
    regressions: dict[str, GradedDiagnosis] = field(default_factory=dict)
    heldout: list[float] = field(default_factory=list)
    left_out: list[float] = field(default_factory=list)
    seconds: dict[float, list[float]] = field(default_factory=dict)
    stated: list[Stated] = field(default_factory=list)

    def marks(self) -> tuple[Grade, Grade]:
        """Return the marks of the suite, and of sparse regression."""
        return grade(self.answers, self.diagnoses), grade(self.answers, self.regressions)


def measure(
    count: int,
    first_seed: int,
    rigs: Sequence[str],
    excitations: Sequence[str],
    hidden: Sequence[str] = HIDDEN,
    say: Callable[[str], None] = print,
) -> dict[str, Battery]:
    """Return a battery for each rig.

    Parameters
    ----------
    count : int
        Recordings of one hidden effect for each excitation; a third as many of each other kind.
    first_seed : int
        Of the first challenge; each further one has a larger one.
    rigs, excitations : sequences of str
        Names that ``make_challenge`` knows.
    hidden : sequence of str
        What is hidden: some of ``HIDDEN``.
    say : callable
        Told of each miss as it is met: seed, excitation, rig, preload, what was hidden (alone: rms
        left by Kelvin-Voigt over the noise); verdict, effects added, [the indistinguishable],
        residual over noise of the base and each step, the first of the ranking with theirs.
    """
    say(f"diagnosis: challenges from seed {first_seed} on; told are those not marked as right")
    batteries = {rig: Battery() for rig in rigs}
    for rig, challenge in challenges(count, first_seed, rigs, excitations, hidden):
        take(batteries[rig], challenge, say)
    return batteries


def challenges(
    count: int,
    first_seed: int,
    rigs: Sequence[str],
    excitations: Sequence[str],
    hidden: Sequence[str] = HIDDEN,
) -> Iterator[tuple[str, Challenge]]:
    """Yield rigs and challenges; single effects are dealt so that each comes equally often."""
    random, seeds = np.random.default_rng(first_seed), count_from(first_seed)
    for rig in rigs:
        singles = count * len(excitations) if "one" in hidden else 0
        others = -(-count * len(excitations) // TO_ANOTHER)
        dealt = zip(deal("one", singles, random), cycle(excitations), strict=False)
        for effects, excitation in dealt:
            yield rig, make_challenge(next(seeds), effects, excitation, rig)
        dealt = zip(deal("outside", others, random), cycle(excitations), strict=False)
        for outside, excitation in dealt:
            if "outside" in hidden:
                yield rig, make_challenge(next(seeds), outside, excitation, rig)
            if "none" in hidden:
                yield rig, make_challenge(next(seeds), (), excitation, rig)
            if "two" in hidden:
                yield rig, two_of(random, seeds, excitation, rig)


def two_of(
    random: np.random.Generator, seeds: Iterator[int], excitation: simulator.Kind, rig: Rig
) -> Challenge:
    """Hide two effects of which each would show alone, drawn anew until they do."""
    while True:
        (effects,) = deal("two", 1, random)
        challenge = make_challenge(next(seeds), effects, excitation, rig)
        if all_show(challenge.answer):
            return challenge


def take(battery: Battery, challenge: Challenge, say: Callable[[str], None]) -> None:
    """Diagnose a challenge, and note what was said."""
    sealed = challenge.answer
    name, excitation = str(sealed.seed), sealed.excitation["kind"]
    tolerant = sealed.rig["name"] == "tolerant"
    instrument = Instrument() if tolerant else Instrument().exact()
    battery.answers[name] = asdict(sealed)
    battery.regressions[name] = sparse_regression.diagnose(challenge.recording)
    measured = _measurement(challenge.recording, at_rest=excitation != "sine10ss")
    try:
        found = _diagnose(measured, instrument)
    except ValueError as error:
        say(f"{_told(sealed)}: no diagnosis: {error}")
        return
    told = answer(found).model_dump()
    battery.diagnoses[name] = GradedDiagnosis.parse(told)
    if not sealed.absorbed:
        battery.stated.append(_stated(told, sealed.effects))
    battery.seconds.setdefault(DURATIONS[excitation], []).append(found.seconds)
    if sealed.effects and set(found.effects) == set(sealed.effects):
        final = found.ladder.final
        second = _measurement(challenge.second, at_rest=True)
        noise = (FORCE_NOISE, PINK_NOISE if tolerant else 0.0)
        battery.left_out.append(final.heldout_rmse / np.linalg.norm([*noise, final.rounding]))
        moved = carry_model(final.composition, final.named(), [second], instrument)
        rmse, rounding = (moved.rmse, moved.rounding) if moved else (np.inf, 0.0)
        battery.heldout.append(rmse / np.linalg.norm([*noise, rounding]))
    if not is_right(battery.answers[name], battery.diagnoses[name]):
        say(f"{_told(sealed)}: {_said(found)}")


def _stated(told: Mapping[str, Any], hidden: Sequence[str]) -> Stated:
    """Return what is stated of a challenge; of what is outside the library nothing is right."""
    known = [EFFECTS[name] for name in hidden if name in EFFECTS]
    models = [hidden] if known and len(known) == len(hidden) else []
    return stated(told, models, {each.family for each in known})


def _measurement(record: simulator.SimulatedRecord, at_rest: bool) -> Measurement:
    return Measurement(record.position, record.force, record.sample_period, at_rest)


def _diagnose(measured: Measurement, instrument: Instrument) -> diagnosis.Diagnosis:
    """Diagnose a measurement; once more if kernels had to be compiled or loaded."""
    while True:
        loaded = machine_code.count_loaded()
        found = diagnosis.diagnose(Composition(), [measured], instrument, EFFECTS)
        if machine_code.count_loaded() == loaded:
            return found


def is_right(sealed: Mapping[str, Any], said: GradedDiagnosis) -> bool:
    """Whether it counts as right for what was hidden, by the strictest mark."""
    marks = grade({"": sealed}, {"": said})
    if kind_of(sealed) == HiddenKind.none:
        return marks.false_alarms.right == 0
    strictest = (marks.first, marks.absorbed, marks.two, marks.unexplained)
    return all(count.right == count.total for count in strictest)


def _told(sealed: simulator.HiddenTruth) -> str:
    """Return what makes the challenge again, and how strong the hidden effects are."""
    hidden = " + ".join(f"{name} ({ratio:.1f})" for name, ratio in sealed.ratios.items())
    kind, preload = sealed.excitation["kind"], 1e3 * sealed.excitation["preload"]
    rig = sealed.rig["name"]
    return f"{sealed.seed} {kind} {rig}, preload {preload:.1f} mm, {hidden or 'none'}"


def _said(found: diagnosis.Diagnosis) -> str:
    """Return the verdict, and what each of its models leaves in units of the noise."""
    ladder = found.ladder
    ratios = " > ".join(f"{fit.ratio:.3f}" for fit in (ladder.base, *ladder.steps))
    ranking = ", ".join(
        f"{fit.composition.names[-1]} {fit.ratio:.3f}" for fit in ladder.ranking[:3]
    )
    added, tied = "+".join(found.effects), "/".join(found.indistinguishable)
    return f"{found.verdict} {added} [{tied}] {ratios}; ranking {ranking}"
