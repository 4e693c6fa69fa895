"""Which records there are: fixed names and seeds, so that each is the same every time.

Contents: the list, and making a record by its name.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import partial
from itertools import count, cycle
from typing import Any

import numpy as np

from benchmarks.diagnosis import is_right as is_right_for
from benchmarks.diagnosis import two_of
from benchmarks.golden.experiments import EXPERIMENTS, Experiment, experiment
from benchmarks.protocols.catalogue import PROTOCOLS
from benchmarks.protocols.deal import deal
from benchmarks.ruler.dealt import Record
from benchmarks.ruler.marks import NAMING, is_right
from tissue_probe.challenge.grading import GradedDiagnosis
from tissue_probe.challenge.instrument import FORCE_NOISE
from tissue_probe.challenge.outside import OUTSIDE
from tissue_probe.challenge.simulator import LIBRARY, SimulatedRecord, make_challenge
from tissue_probe.challenge.trajectory import DURATIONS

Answer = Mapping[str, Any]
#: Of the challenges and protocols: no test has them, nor do the larger sets at their default seeds.
FIRST_SEED = 600_000
#: Records of each protocol with something hidden; one more is clean.
HIDDEN = 2
RIGS = ("exact", "tolerant")
#: Challenges with nothing hidden, and with two effects.
CLEAN, PAIRS = 5, 10
PAIR = ("two", "effects")
#: A pair that does not show is drawn anew, from seeds that no other pair has.
SEEDS_OF_A_PAIR = 1000
NONE = "none"
#: A value is right within this share of the truth: ten times what the noise leaves unknown of it.
CLOSE = 0.05
#: A law carries over to a second record if its error there is below this many times the noise.
CARRIES = 1.5


@dataclass(frozen=True)
class Asked:
    """A record, how it is asked about, and which answers are right.

    Attributes
    ----------
    name : str
        Of the record: its set, what makes it again, and what is hidden.
    first, second : Record
        To be diagnosed, and to validate, if there is one.
    arguments : mapping
        Of ``tp.diagnose``.
    right : callable
        Whether an answer for programs is.
    """

    name: str
    first: Record
    second: Record | None
    arguments: Mapping[str, Any]
    right: Callable[[Answer], bool]


def makers() -> list[Callable[[], Asked]]:
    """Return what makes each record; made where it is asked about, since some take seconds."""
    return [*_protocols(), *(partial(_experiment, name) for name in EXPERIMENTS), *_challenges()]


def _protocols() -> Iterator[Callable[[], Asked]]:
    for number, name in enumerate(PROTOCOLS):
        first = FIRST_SEED + HIDDEN * number
        yield from (partial(_protocol, name, first + more, True) for more in range(HIDDEN))
        if PROTOCOLS[name].clean:
            yield partial(_protocol, name, first, False)


def _protocol(protocol: str, seed: int, hide: bool) -> Asked:
    dealt = deal(protocol, seed, hide)
    name = f"protocol {protocol} {seed} {dealt.truth.hidden or NONE}"
    right = partial(is_right, truth=dealt.truth)
    return Asked(name, dealt.first, dealt.second, dealt.arguments, right)


def _experiment(name: str) -> Asked:
    made = experiment(name)
    title = f"experiment {name}"
    return Asked(title, made.first, made.second, made.arguments, partial(_answered, made))


def _answered(made: Experiment, answer: Answer) -> bool:
    """Whether a right set of effects is named, with right values, and the law carries over."""
    effects = frozenset(answer["effects"])
    verdict = answer["verdict"] in (NAMING if effects else ("adequate",))
    values = {name: each["value"] for name, each in answer["ladder"][-1]["parameters"].items()}
    close = all(
        name in values and abs(values[name] - true) <= CLOSE * abs(true)
        for name, true in made.values.items()
    )
    if made.second is not None:
        error = answer["rmse"]["heldout"]["final"]
        close &= error is not None and error <= CARRIES * made.second.noise
    return close and (not made.right or (verdict and effects in made.right))


def _challenges() -> Iterator[Callable[[], Asked]]:
    """Yield each effect of the challenge alone, some clean ones, and pairs."""
    hidden = [(name,) for name, each in (LIBRARY | OUTSIDE).items() if not each.beside]
    hidden += [()] * CLEAN + [PAIR] * PAIRS
    # Of five excitations and two rigs: each combination comes once in ten.
    settings = zip(cycle(DURATIONS), cycle(RIGS), strict=False)
    for number, (effects, (excitation, rig)) in enumerate(zip(hidden, settings, strict=False)):
        yield partial(_challenge, FIRST_SEED + number, effects, excitation, rig)


def _challenge(seed: int, effects: tuple[str, ...], excitation: str, rig: str) -> Asked:
    if effects == PAIR:
        random = np.random.default_rng(seed)
        made = two_of(random, count(seed, SEEDS_OF_A_PAIR), excitation, rig)
    else:
        made = make_challenge(seed, effects, excitation, rig)
    sealed = made.answer
    name = f"challenge {excitation} {rig} {seed} {'+'.join(sealed.effects) or NONE}"
    starts = {} if excitation == "sine10ss" else {"starts": "at-rest"}
    arguments = {"rig": "compliant_probe", "known_rig": rig == "exact", **starts}
    return Asked(name, _record(made.recording), None, arguments, partial(_marked, asdict(sealed)))


def _marked(sealed: Mapping[str, Any], answer: Answer) -> bool:
    return is_right_for(sealed, GradedDiagnosis.parse(answer))


def _record(measured: SimulatedRecord) -> Record:
    time = measured.sample_period * np.arange(measured.position.size)
    return Record(time, measured.position, measured.force, FORCE_NOISE)
