"""The verdict of a diagnosis in words, and what to record or to calibrate next.

What belongs here: sentences. What does not: the answer for programs (``diagnosis.answer``).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from tissue_probe.analysis.result_table import probability

if TYPE_CHECKING:
    from tissue_probe.diagnosis.advice.separation import Suggestion
    from tissue_probe.diagnosis.diagnosis import Diagnosis
    from tissue_probe.diagnosis.evidence.conclusion import Ladder

#: Said of samples that the converter spoilt.
LEFT_OUT = "The samples concerned were left out."
#: Units of an excitation's settings.
UNITS = {"frequency": " Hz", "start": " Hz", "stop": " Hz", "spacing": " Hz"}


def told(diagnosis: Diagnosis) -> list[str]:
    """Say the verdict, and the command line of the next experiment: a line that can be pasted."""
    said = verdict(diagnosis)
    if diagnosis.command:
        said += ["The next experiment's command line:", diagnosis.command.line]
        said += [f"- {note}" for note in diagnosis.command.notes]
    return said


def verdict(diagnosis: Diagnosis) -> list[str]:
    """Say the verdict in words, a sentence or more each."""
    said = {
        "adequate": _adequate,
        "missing": _missing,
        "ambiguous": _ambiguous,
        "unexplained": _unexplained,
    }[diagnosis.verdict](diagnosis)
    said += _caveats(diagnosis)
    if diagnosis.suggestion:
        said += _advice(diagnosis.suggestion)
    return said


def _advice(suggestion: Suggestion) -> list[str]:
    """Say what to record or to calibrate next."""
    said = []
    if suggestion.excitation:
        told = ", ".join(f"{name} {value}" for name, value in settings(suggestion).items())
        said.append(f"Next experiment: {told}.")
        if math.isfinite(suggestion.separation):
            said.append(
                f"In it the wrong one would leave {suggestion.separation:.3g} times the noise."
            )
    if suggestion.shows:
        said.append(f"It would show {', '.join(suggestion.shows)} if there.")
    if suggestion.calibration:
        what = "show others" if suggestion.shows else "tell"
        said.append(f"Calibration that would {what}: {suggestion.calibration}.")
    return said


def settings(suggestion: Suggestion) -> dict[str, str]:
    """Return the settings of a suggested experiment with their units, by name.

    The amplitude is the coil's way; the volts that it takes are in ``Diagnosis.command``.
    """
    told = {
        name: f"{value}{UNITS.get(name, '')}"
        for name, value in suggestion.excitation.items()
        if name not in ("amplitude", "duration")
    }
    amplitude = 1e3 * float(str(suggestion.excitation["amplitude"]))
    return {
        **told,
        "amplitude": f"{amplitude:g} mm at the coil",
        "preload": f"{1e3 * suggestion.preload:g} mm",
        "duration": f"{suggestion.duration:g} s from rest",
    }


def _adequate(diagnosis: Diagnosis) -> list[str]:
    final = diagnosis.ladder.final
    told = f"{final.rmse / final.noise:.2f}"
    said = (
        "Adequate: nothing is missing that this recording could show; the error is "
        f"{told} times the noise"
    )
    if (counted := f"{final.ratio:.2f}") != told:
        said += f", {counted} times where {final.counted_too} counts as noise"
    return [f"{said}.", *_unseen(diagnosis)]


def _unseen(diagnosis: Diagnosis) -> list[str]:
    if not diagnosis.unseen:
        return []
    return [f"This excitation could not have shown: {', '.join(diagnosis.unseen)}."]


def _missing(diagnosis: Diagnosis) -> list[str]:
    final = diagnosis.ladder.final
    told = _fall(diagnosis)
    if not diagnosis.ladder.steps:
        told = (
            f"{LEFT_OUT} On the others the model is adequate: its error is "
            f"{final.rmse / final.noise:.2f} times the noise."
        )
    named = ", ".join(diagnosis.effects)
    return [f"Missing: {named}{_sure(diagnosis)}. {told}", *_unseen(diagnosis)]


def _sure(diagnosis: Diagnosis) -> str:
    """Say how probable the last model is, where that was asked."""
    ladder = diagnosis.ladder
    if ladder.asked or not ladder.steps:
        return ""
    told = ladder.posterior
    return f" (probability {probability((1.0 - told.unknown) * told.probabilities[0])})"


def _ambiguous(diagnosis: Diagnosis) -> list[str]:
    ladder = diagnosis.ladder
    said = _agreed(ladder)
    if models := _open(ladder):
        said += f"One of {', '.join(models)}: this recording cannot tell which. "
    else:
        left = ladder.final.ratio
        said += (
            f"Nearest: {', '.join(diagnosis.effects)}, which leaves {left:.2f} times the noise. "
        )
    return [said + _fall(diagnosis), *_unseen(diagnosis)]


def _agreed(ladder: Ladder) -> str:
    """Say what all probable models have: effects, then the family of which no form is sure."""
    told = ladder.posterior
    sure = [f"{name} (probability {probability(told.effect(name))})" for name in _common(ladder)]
    if ladder.family:
        likely = probability(told.families[ladder.family])
        sure.append(f"{ladder.family} (probability {likely}); its form is not settled")
    return f"Missing: {', and '.join(sure)}. " if sure else ""


def _common(ladder: Ladder) -> list[str]:
    """Name the effects that all of several probable models have."""
    first = ladder.alternatives[0] if ladder.alternatives else ()
    return [name for name in first if all(name in each for each in ladder.alternatives)]


def _open(ladder: Ladder) -> list[str]:
    """Name the rest of each probable model, with the model's probability."""
    common, models = _common(ladder), []
    for names, likely in zip(ladder.alternatives, ladder.posterior.probabilities, strict=False):
        rest = [name for name in names if name not in common]
        models.append(f"{' + '.join(rest) or 'nothing more'} ({probability(likely)})")
    return models


def _unexplained(diagnosis: Diagnosis) -> list[str]:
    if diagnosis.fails_elsewhere:
        names = " and ".join(diagnosis.effects)
        model = f"the model with {names}" if names else "the model"
        told = f"Unexplained: {model} explains this recording, and not the second one."
        return [f"{told} {_fall(diagnosis)}" if names else told, *_unseen(diagnosis)]
    said = "Unexplained: no effect of the library brings the error down to the noise. "
    if diagnosis.ladder.harmonic is not None:
        said = (
            f"Unexplained: a line at {diagnosis.ladder.harmonic:.4g} Hz, a multiple of the drive's "
            "frequency, explains more than any effect of the library; whatever is not linear "
            "leaves such lines. Drive at several frequencies to tell, as by a multisine. "
        )
    if diagnosis.ladder.asked:
        said = (
            f"Unexplained: with {', '.join(diagnosis.effects)} more is left than noise; other "
            f"effects were not tried. {_fall(diagnosis)}"
        )
    else:
        said += _nearest(diagnosis)
        if diagnosis.ladder.steps:
            unknown = probability(diagnosis.ladder.posterior.unknown)
            said += f" The probability that no model of the library is right is {unknown}."
    return [said.strip()]


def _nearest(diagnosis: Diagnosis) -> str:
    """Say which effects come nearest where none explains all, if they help at all."""
    ladder, names = diagnosis.ladder, ", ".join(diagnosis.effects)
    if not ladder.steps:
        return f"In the samples: {names}. {LEFT_OUT}" if diagnosis.spoilt else ""
    if diagnosis.heldout(ladder.final) <= diagnosis.heldout(ladder.base):
        return f"Nearest: {names}. {_fall(diagnosis)}"
    # Not all of the ranking is tried on a second recording.
    tried = [
        fit
        for fit in ladder.ranking
        if not diagnosis.validated or fit.composition.names in diagnosis.validated
    ]
    if any(diagnosis.heldout(fit) < diagnosis.heldout(ladder.base) for fit in tried):
        return f"What fits best, {names}, raises the error on held-out data. {_fall(diagnosis)}"
    return f"No effect lowers the error on held-out data. With {names}: {_fall(diagnosis)}"


def _caveats(diagnosis: Diagnosis) -> list[str]:
    """Say what speaks against trusting the last model."""
    said = []
    final = diagnosis.ladder.final
    if not final.converged:
        said.append(
            "But the fit of the last model did not settle: take its values, its error and with "
            "them this verdict for a guess."
        )
    return said + _beyond(diagnosis)


def _beyond(diagnosis: Diagnosis) -> list[str]:
    """Say how the last model fares on a second recording, where that is not as on the first."""
    final = diagnosis.ladder.final
    error = final.output.tell(diagnosis.heldout(final))
    noise = final.output.tell(diagnosis.validation_noise)
    if not diagnosis.carries_over:
        more = "" if diagnosis.ladder.asked else ", and no effect of the library explains both"
        return [
            f"But on the second recording the error stays at {error}, where the noise is {noise}: "
            "the model does not carry over. Either the specimen, the site or the contact is "
            f"another one there, or more is missing than the first recording shows{more}; record "
            "again, or fit both together."
        ]
    if not diagnosis.reaches:
        expected = final.output.tell(diagnosis.uncertainty)
        return [
            f"On the second recording the error is {error}, where the noise is {noise}. The first "
            f"tells some values so roughly that {expected} would have been no surprise: fit both "
            "together, to know the values better."
        ]
    return []


def _fall(diagnosis: Diagnosis) -> str:
    base, final = diagnosis.ladder.base, diagnosis.ladder.final
    before, after, noise = (
        base.output.tell(error)
        for error in (diagnosis.heldout(base), diagnosis.heldout(final), base.noise)
    )
    return f"The held-out error goes from {before} to {after}; the noise is {noise}."
