"""What is said of a record, by the library and where asked by the one before, beside the truth.

Contents: one answer, the marks of a record, diagnosing it.

A diagnosis works in one process here, so that its processor time is that of the process.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.laws.cases import Case, MadeCase, make_case
from benchmarks.laws.library import take_library_before
from tissue_probe.challenge.grading import NAMING, NO_DIAGNOSIS
from tissue_probe.challenge.instrument import FORCE_NOISE
from tissue_probe.challenge.simulator import PINK_NOISE
from tissue_probe.diagnosis.diagnosis import Diagnosis, diagnose
from tissue_probe.diagnosis.evidence.adequacy import leaves_only_noise
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.other_runs import carry_model
from tissue_probe.diagnosis.sharing import among
from tissue_probe.physics import machine_code
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS, Effect

#: A set of so many effects still helps: each can be tried.
SMALL = 3
#: Of a criterion (BIC), which is twice a logarithm of odds: above it, very strong evidence (Kass
#: and Raftery, J. American Statistical Association 90 (1995), 773).
STRONG = 10.0


@dataclass(frozen=True)
class Said:
    """An answer.

    Attributes
    ----------
    verdict : str
        As said; "no diagnosis" where there is none.
    effects, tied, unseen : tuple of str
        What would be added, what cannot be told apart, what the record could not have shown.
    seconds : float
        Processor time, models loaded [s].
    """

    verdict: str
    effects: tuple[str, ...] = ()
    tied: tuple[str, ...] = ()
    unseen: tuple[str, ...] = ()
    seconds: float = 0.0


@dataclass(frozen=True)
class LawOutcome:
    """A record, and what is said of it.

    Attributes
    ----------
    case : Case
        What was hidden.
    ratio : float
        What the best Kelvin-Voigt fit leaves of the law alone, in units of the noise.
    absorbed : bool
        Whether that fit absorbs the law.
    said : Said
        By the library.
    before : Said or None
        By the library before; None where it is not asked.
    second : float or None
        Error of the last model on the second recording over the noise; None but where it has all
        that was hidden and nothing else.
    by_name : float or None
        How much larger the criterion (BIC) of the model with all that was hidden is, fitted by
        name, than that of the last model; None where these are the same, or it cannot be fitted.
    explains_by_name : bool or None
        Whether that model leaves noise only, as the truth would; None as before.
    """

    case: Case
    ratio: float
    absorbed: bool
    said: Said
    before: Said | None = None
    second: float | None = None
    by_name: float | None = None
    explains_by_name: bool | None = None

    @property
    def is_right(self) -> bool:
        """Whether exactly what was hidden would be added, by a verdict that names effects."""
        return self.said.verdict in NAMING and set(self.said.effects) == set(self.case.hidden)

    @property
    def is_alone(self) -> bool:
        """Whether the law is named alone: nothing else would do as well."""
        return self.is_right and self.said.verdict == "missing"

    @property
    def is_among(self) -> bool:
        """Whether the law is named alone, or in a small set or one of its family."""
        told = {*self.said.effects, *self.said.tied}
        hidden, tied = set(self.case.hidden), self.said.tied
        families = {EFFECTS[name].family for name in tied}
        small = len(tied) <= SMALL or len(families) == 1
        sure = set(self.said.effects) - set(tied)
        return self.said.verdict in NAMING and sure <= hidden <= told and small

    @property
    def cause(self) -> str:
        """Why the law is not named first: by the criterion of the model that has it.

        A search failed if the truth explains more than the last model, or was not found by name.
        """
        if self.is_right:
            return ""
        if self.by_name is None or not self.explains_by_name:
            return "search, by name too"
        if self.by_name < -STRONG:
            return "search"
        return "not to be told" if self.by_name <= STRONG else "another explains more"


def ask(case: Case) -> LawOutcome:
    """Make a record, and diagnose it."""
    made = make_case(case)
    instrument = Instrument() if case.rig == "tolerant" else Instrument().exact()
    with among(1):
        if case.is_timed:
            before, _ = _say_timed(made.first, instrument, take_library_before())
            said, _ = _say_timed(made.first, instrument, EFFECTS)
            return LawOutcome(case, made.ratio, made.absorbed, said, before)
        said, found = _say(made.first, instrument, EFFECTS)
        outcome = LawOutcome(case, made.ratio, made.absorbed, said)
        if found is None or case.part != "law":
            return outcome
        if set(found.effects) == set(case.hidden):
            second = _carry(found, made, instrument, case.rig == "tolerant")
            return LawOutcome(case, made.ratio, made.absorbed, said, second=second)
        by_name = _by_name(found, case, made.first, instrument)
        return LawOutcome(case, made.ratio, made.absorbed, said, None, None, *by_name)


def _say(
    measured: Measurement, instrument: Instrument, library: Mapping[str, Effect], **asked: Any
) -> tuple[Said, Diagnosis | None]:
    # A measurement of its own: one keeps much that is computed of it.
    mine, begun = replace(measured), time.process_time()
    try:
        found = diagnose(Composition(), [mine], instrument, library, **asked)
    except ValueError:
        return Said(NO_DIAGNOSIS, seconds=time.process_time() - begun), None
    seconds = time.process_time() - begun
    said = (found.effects, found.indistinguishable, found.unseen)
    return Said(found.verdict, *said, round(seconds, 2)), found


def _say_timed(
    measured: Measurement, instrument: Instrument, library: Mapping[str, Effect]
) -> tuple[Said, Diagnosis | None]:
    """Diagnose; once more if models had to be compiled or loaded."""
    while True:
        loaded = machine_code.count_loaded()
        said = _say(measured, instrument, library)
        if machine_code.count_loaded() == loaded:
            return said


def _carry(found: Diagnosis, made: MadeCase, instrument: Instrument, tolerant: bool) -> float:
    final = found.ladder.final
    moved = carry_model(final.composition, final.named(), [made.second], instrument)
    if moved is None:
        return float("inf")
    noise = (FORCE_NOISE, PINK_NOISE if tolerant else 0.0, moved.rounding)
    return float(moved.rmse / np.linalg.norm(noise))


def _by_name(
    found: Diagnosis, case: Case, measured: Measurement, instrument: Instrument
) -> tuple[float | None, bool | None]:
    _, named = _say(measured, instrument, EFFECTS, wanted=case.hidden)
    if named is None:
        return None, None
    final = named.ladder.final
    return round(final.bic - found.ladder.final.bic, 1), leaves_only_noise(final)
