"""Marks for diagnoses of recordings with hidden effects.

Contents: what counts as right, and the counts.

A diagnosis *names* an effect if its verdict is ``missing`` or ``ambiguous``; it then claims that
the first of its ranking, or one of those it declares indistinguishable, is there. ``adequate`` and
``unexplained`` name none, whatever their ranking. A recording without a diagnosis is a miss.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from tissue_probe.challenge.instrumental import SPOILING_EFFECTS
from tissue_probe.challenge.outside import OUTSIDE
from tissue_probe.challenge.simulator import LIBRARY, SIMULATED_EFFECTS

NO_DIAGNOSIS = "no diagnosis"
NAMING = ("missing", "ambiguous")


class HiddenKind(str, Enum):
    """What was hidden."""

    one = "one effect"
    absorbed = "one effect that Kelvin-Voigt absorbs"
    two = "two effects"
    none = "none"
    outside = "outside the library"
    spoilt = "spoilt by the converter"


@dataclass(frozen=True)
class GradedDiagnosis:
    """What a diagnosis says, as far as it is marked.

    Attributes
    ----------
    verdict : str
        ``adequate``, ``missing``, ``ambiguous``, ``unexplained``, or ``no diagnosis``.
    ranking : tuple of str
        Effects, best first.
    indistinguishable : frozenset of str
        Effects declared not to be told apart.
    effects : tuple of str
        Effects it would add, in order.
    unseen : frozenset of str
        Effects of which it says that the recording could not have shown them.
    """

    verdict: str
    ranking: tuple[str, ...] = ()
    indistinguishable: frozenset[str] = frozenset()
    effects: tuple[str, ...] = ()
    unseen: frozenset[str] = frozenset()

    @classmethod
    def parse(cls, told: Mapping[str, Any]) -> GradedDiagnosis:
        """Take what is marked from the JSON of ``tissue_probe diagnose``.

        Raises
        ------
        ValueError
            If an entry is missing or of another kind.
        """
        try:
            return cls(
                str(told["verdict"]),
                tuple(str(entry["effect"]) for entry in told["ranking"]),
                frozenset(map(str, told["indistinguishable"])),
                tuple(map(str, told["effects"])),
                frozenset(map(str, told["unseen"])),
            )
        except (KeyError, TypeError) as error:
            raise ValueError(
                f"a diagnosis has verdict, ranking, indistinguishable, effects, unseen: {error}"
            ) from error

    @property
    def named(self) -> str:
        """The effect it names first; its verdict where it names none."""
        if self.verdict in NAMING and self.ranking:
            return self.ranking[0]
        return self.verdict

    @property
    def claimed(self) -> frozenset[str]:
        """The effects of which it claims that one is there; none where it names none."""
        if self.named == self.verdict:
            return frozenset()
        return self.indistinguishable | {self.named}

    def declares(self, effect: str) -> bool:
        """Whether it leaves room for an effect: claimed, or adequate as far as could be seen."""
        return effect in self.claimed or (self.verdict == "adequate" and effect in self.unseen)

    @property
    def says(self) -> frozenset[str]:
        """Everything it could call a spoilt recording by."""
        return frozenset({self.verdict, *self.ranking[:1], *self.effects[:1]})


@dataclass
class Count:
    """How many of how many."""

    right: int = 0
    total: int = 0

    def add(self, right: bool) -> None:
        """Count one more."""
        self.right += right
        self.total += 1

    @property
    def share(self) -> float | None:
        """Share that is right [-]; None of none."""
        return self.right / self.total if self.total else None


@dataclass
class Grade:
    """Marks of a series; each a ``Count``.

    Attributes
    ----------
    first : Count
        One hidden effect that shows: ranked first.
    declared : Count
        The same: ranked first, in the declared indistinguishable set, or ``adequate`` with the
        effect listed as one that the recording could not have shown.
    first_three, first_three_named : Count
        The same: among the first three of the ranking, and named or, where the verdict is
        ``adequate``, listed as one that the recording could not have shown; of these the named.
    family : Count
        The same: an effect of its family ranked first.
    covered : Count
        Of the diagnoses of these that name effects: those whose claim holds the hidden one.
    claimed : list of int
        How many effects each of these claims, the first included.
    absorbed : Count
        An effect that Kelvin-Voigt absorbs: ``adequate``, or the effect claimed or listed as
        indistinguishable.
    false_alarms : Count
        None hidden: verdict other than ``adequate``. Counted are the alarms.
    two : Count
        Two hidden: the first two of ``effects`` are these.
    two_declared : Count
        Two hidden: one of them is among the first two of ``effects``, and the other too, or it is
        listed as indistinguishable or as one that the recording could not have shown.
    one_of_two : Count
        Two hidden: at least one of them among the first two of ``effects``.
    unexplained : Count
        Outside the library: verdict ``unexplained``.
    spoilt : Count
        Converter at fault: told by name as verdict, first of the ranking or first effect.
    undiagnosed : list of str
        Recordings without a diagnosis; each is counted as wrong above (none hidden: as an alarm).
    confusion : dict
        By what was hidden (two joined by ``+``) how often each was named first, misses included.
    """

    first: Count = field(default_factory=Count)
    declared: Count = field(default_factory=Count)
    first_three: Count = field(default_factory=Count)
    first_three_named: Count = field(default_factory=Count)
    family: Count = field(default_factory=Count)
    covered: Count = field(default_factory=Count)
    claimed: list[int] = field(default_factory=list)
    absorbed: Count = field(default_factory=Count)
    false_alarms: Count = field(default_factory=Count)
    two: Count = field(default_factory=Count)
    two_declared: Count = field(default_factory=Count)
    one_of_two: Count = field(default_factory=Count)
    unexplained: Count = field(default_factory=Count)
    spoilt: Count = field(default_factory=Count)
    undiagnosed: list[str] = field(default_factory=list)
    confusion: dict[str, Counter[str]] = field(default_factory=dict)

    @property
    def mean_claimed(self) -> float | None:
        """Mean size of a claim [effects]; None if nothing was claimed."""
        return sum(self.claimed) / len(self.claimed) if self.claimed else None


def grade(
    answers: Mapping[str, Mapping[str, Any]], diagnoses: Mapping[str, GradedDiagnosis]
) -> Grade:
    """Mark diagnoses by the answers, both by the recordings' names.

    Parameters
    ----------
    answers : mapping
        Fields of each ``HiddenTruth``, as ``read_answers`` returns them.
    diagnoses : mapping
        One for each recording; those of other names are ignored.
    """
    marks = Grade()
    for name, answer in answers.items():
        diagnosis = diagnoses.get(name, GradedDiagnosis(NO_DIAGNOSIS))
        if name not in diagnoses:
            marks.undiagnosed.append(name)
        hidden = " + ".join(answer["effects"]) or "none"
        marks.confusion.setdefault(hidden, Counter())[diagnosis.named] += 1
        _MARKERS[kind_of(answer)](marks, answer["effects"], diagnosis)
    return marks


def kind_of(answer: Mapping[str, Any]) -> HiddenKind:
    """Return what kind of challenge an answer belongs to."""
    effects = answer["effects"]
    if len(effects) != 1:
        return HiddenKind.two if effects else HiddenKind.none
    if answer["absorbed"]:
        return HiddenKind.absorbed
    if effects[0] in OUTSIDE:
        return HiddenKind.outside
    return HiddenKind.spoilt if effects[0] in SPOILING_EFFECTS else HiddenKind.one


def _mark_one(marks: Grade, effects: list[str], diagnosis: GradedDiagnosis) -> None:
    (hidden,) = effects
    named = diagnosis.named in LIBRARY
    marks.first.add(diagnosis.named == hidden)
    marks.declared.add(diagnosis.declares(hidden))
    among, claims = hidden in diagnosis.ranking[:3], bool(diagnosis.claimed)
    marks.first_three.add(among and (claims or diagnosis.declares(hidden)))
    marks.first_three_named.add(among and claims)
    marks.family.add(
        named and SIMULATED_EFFECTS[diagnosis.named].family == SIMULATED_EFFECTS[hidden].family
    )
    if diagnosis.claimed:
        marks.covered.add(hidden in diagnosis.claimed)
        marks.claimed.append(len(diagnosis.claimed))


def _mark_absorbed(marks: Grade, effects: list[str], diagnosis: GradedDiagnosis) -> None:
    told = diagnosis.claimed | diagnosis.indistinguishable
    marks.absorbed.add(diagnosis.verdict == "adequate" or effects[0] in told)


def _mark_two(marks: Grade, effects: list[str], diagnosis: GradedDiagnosis) -> None:
    found = set(diagnosis.effects[:2]) & set(effects)
    marks.two.add(len(found) == 2)
    told = found | diagnosis.indistinguishable | diagnosis.unseen
    marks.two_declared.add(bool(found) and set(effects) <= told)
    marks.one_of_two.add(len(found) >= 1)


def _mark_none(marks: Grade, _: list[str], diagnosis: GradedDiagnosis) -> None:
    marks.false_alarms.add(diagnosis.verdict != "adequate")


def _mark_outside(marks: Grade, _: list[str], diagnosis: GradedDiagnosis) -> None:
    marks.unexplained.add(diagnosis.verdict == "unexplained")


def _mark_spoilt(marks: Grade, effects: list[str], diagnosis: GradedDiagnosis) -> None:
    marks.spoilt.add(effects[0] in diagnosis.says)


_MARKERS = {
    HiddenKind.one: _mark_one,
    HiddenKind.absorbed: _mark_absorbed,
    HiddenKind.two: _mark_two,
    HiddenKind.none: _mark_none,
    HiddenKind.outside: _mark_outside,
    HiddenKind.spoilt: _mark_spoilt,
}
