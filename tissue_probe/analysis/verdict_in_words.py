"""The verdict of a diagnosis in words, and the next recording or calibration.

Contents: sentences.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from tissue_probe.analysis import fit_shown, shape_in_words
from tissue_probe.analysis.result_table import probability
from tissue_probe.diagnosis.answer import correlations, says
from tissue_probe.physics.rigs.constants import CONTACT_POSITION
from tissue_probe.quantities import SIDE, engineering

if TYPE_CHECKING:
    from tissue_probe.diagnosis.advice.separation import Suggestion
    from tissue_probe.diagnosis.diagnosis import Diagnosis
    from tissue_probe.diagnosis.evidence.conclusion import Ladder
    from tissue_probe.diagnosis.fitting.fit import Fit
    from tissue_probe.physics.rigs import Rig

#: Said of samples that the converter spoilt.
LEFT_OUT = "The samples concerned were left out."
#: Units of an excitation's settings.
EXCITATION_UNITS = {"frequency": " Hz", "start": " Hz", "stop": " Hz", "spacing": " Hz"}


def describe_diagnosis(diagnosis: Diagnosis) -> list[str]:
    """Say the whole answer, the values of the last model and the next command line in it."""
    values_of = diagnosis.ladder.base if _names_nothing(diagnosis) else diagnosis.ladder.final
    said = [*_describe_verdict(diagnosis), *_values(values_of), *_of_others(diagnosis.ladder)]
    said += _rest(diagnosis)
    if diagnosis.command:
        said += ["The next experiment's command line:", diagnosis.command.line]
        said += [f"- {note}" for note in diagnosis.command.notes]
    return said


def verdict(diagnosis: Diagnosis) -> list[str]:
    """Say the answer in words, a sentence or more each: without values, and without a command."""
    return [*_describe_verdict(diagnosis), *_rest(diagnosis)]


def _describe_verdict(diagnosis: Diagnosis) -> list[str]:
    """Tell the verdict, and the meaning of the values of each effect."""
    said = {
        "adequate": _adequate,
        "missing": _describe_missing,
        "ambiguous": _ambiguous,
        "unexplained": _describe_unexplained,
    }[diagnosis.verdict](diagnosis)
    if _names_nothing(diagnosis):
        return said
    return [*said, *(f"{name}: {meaning}." for name, meaning in says(diagnosis.ladder).items())]


def _names_nothing(diagnosis: Diagnosis) -> bool:
    """Whether no effect is named, since any would stand for another: depth and time are one."""
    one_way = any(finding.name == "one_way" for finding in diagnosis.findings)
    return one_way and diagnosis.verdict == "unexplained" and not diagnosis.ladder.asked


def _values(final: Fit) -> list[str]:
    """Tell the values of a model, a line each."""
    told = [f"Values of {fit_shown.title(final)}, 95 % intervals:", *fit_shown.lines(final)]
    return [*told, *filter(None, [fit_shown.exhaustion([final])])]


def _of_others(ladder: Ladder) -> list[str]:
    """Say how the values of the other probable models are had, where there are several."""
    if len(ladder.alternatives) < 2:
        return []
    other = " and ".join(ladder.alternatives[1])
    return [f"The values of another of them: `add` of improve, such as {other}."]


def _rest(diagnosis: Diagnosis) -> list[str]:
    """State the errors, the effects that could not be seen, and the next step."""
    said = [*_errors(diagnosis), *_caveats(diagnosis)]
    said += [*_not_apart(diagnosis.ladder.final), *_unseen(diagnosis)]
    if diagnosis.suggestion:
        said += _advice(diagnosis.suggestion, diagnosis.ladder.final.composition.rig)
    if not diagnosis.validated and diagnosis.verdict in ("adequate", "missing"):
        said.append(RECORD_SECOND)
    return said


def _errors(diagnosis: Diagnosis) -> list[str]:
    """Say how the errors fall from the base to the last model, beside the noise."""
    base, final = diagnosis.ladder.base, diagnosis.ladder.final
    tell, second = final.output.tell, bool(diagnosis.validated)

    def fall(error: Callable[[Fit], float]) -> str:
        before = "" if final is base else f"{tell(error(base))} -> "
        return f"{before}{tell(error(final))}"

    named = [
        f"fitted {fall(lambda fit: fit.rmse)}",
        f"held-out parts {fall(lambda fit: fit.heldout_rmse)}",
        *([f"second recording {fall(diagnosis.heldout)}"] if second else []),
    ]
    other = f" (second recording {tell(diagnosis.validation_noise)})" if second else ""
    return [f"Errors, rms: {', '.join(named)}; noise {tell(final.noise)}{other}."]


def _not_apart(final: Fit) -> list[str]:
    """Say which values the recording does not tell from one another."""
    named, deviations = final.named(), final.deviations()
    known = [name for name in final.names if deviations[name] > 0.0]
    together = np.abs(np.array(correlations(final)))
    lost = [n for n, each in enumerate(known) if SIDE * deviations[each] > abs(named[each])]
    pairs = [
        f"{known[one]} and {known[other]}"
        for one, other in combinations(lost, 2)
        if together[one, other] > AS_ONE
    ]
    if not pairs:
        return []
    told = ", ".join(pairs)
    return [f"This recording does not tell apart {told}: one makes up for the other."]


def _advice(suggestion: Suggestion, rig: Rig) -> list[str]:
    """Name the next recording or calibration."""
    said = []
    if suggestion.excitation:
        said.append(f"Next experiment: {_motion(suggestion, rig)}.")
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


#: Correlation from which on two values are known together only: either is known more than twenty
#: times as well where the other is stated.
AS_ONE = 0.999
#: Said where one recording alone was explained.
RECORD_SECOND = (
    "Next recording: the same specimen, moved otherwise (deeper, faster, or held); given as "
    "`validate` it tells whether the model carries over."
)
#: Said where nothing explains a record whose position was taken to be zero at the touch.
ZERO_AT_TOUCH = (
    "The tip was taken to touch near the position's zero. If both were set to zero in contact, or "
    "before the touch, say where it touches: `constant` contact_position=-0.002+-0.001 (m)."
)
#: Said in the place of the nearest effects.
NONE_NAMED = (
    "None is named: the tip goes one way all the time, so that one that acts in time can stand for "
    "one that acts with the depth, and the reverse. Unload the tissue as well, or hold."
)
#: How each excitation is called, by its settings.
EXCITATION_WORDS = {
    "sine": "a sine of {frequency:.3g} Hz",
    "multisine": "sines from {start:.3g} to {stop:.3g} Hz at once, {spacing:.3g} Hz apart",
    "chirp": "a sweep from {start:.3g} to {stop:.3g} Hz within {duration:.3g} s",
}


def _motion(suggestion: Suggestion, rig: Rig) -> str:
    """Describe the motion of a suggested experiment to whom it makes: where, how far, how long."""
    way = float(str(suggestion.excitation["amplitude"]))
    kind = EXCITATION_WORDS[str(suggestion.excitation["kind"])].format_map(suggestion.excitation)
    about = f"a mean depth of {engineering(suggestion.preload, 'm')}" if suggestion.preload else (
        "the place of first touch"
    )  # fmt: skip
    return (
        f"{kind}, {engineering(way, 'm')} to either side of {about} {_mover(rig)}, for "
        f"{suggestion.duration:.3g} s from rest"
    )


def _mover(rig: Rig) -> str:
    return "at the tip" if rig.tip_is_position else "at the coil"


def settings(suggestion: Suggestion, rig: Rig) -> dict[str, str]:
    """Return the settings of a suggested experiment with their units, by name.

    The amplitude is that of the input; the volts that a coil takes for it are in
    ``Diagnosis.command``.
    """
    told = {
        name: f"{value}{EXCITATION_UNITS.get(name, '')}"
        for name, value in suggestion.excitation.items()
        if name not in ("amplitude", "duration")
    }
    amplitude = 1e3 * float(str(suggestion.excitation["amplitude"]))
    return {
        **told,
        "amplitude": f"{amplitude:g} mm {_mover(rig)}",
        "preload": f"{1e3 * suggestion.preload:g} mm",
        "duration": f"{suggestion.duration:g} s from rest",
    }


def _adequate(diagnosis: Diagnosis) -> list[str]:
    left = fit_shown.over_noise(diagnosis.ladder.final)
    said = f"Adequate: nothing is missing that this recording could show; the error is {left}"
    return [f"{said}."]


def _unseen(diagnosis: Diagnosis) -> list[str]:
    if not diagnosis.unseen:
        return []
    return [f"This excitation could not have shown: {', '.join(diagnosis.unseen)}."]


def _describe_missing(diagnosis: Diagnosis) -> list[str]:
    final = diagnosis.ladder.final
    named = ", ".join((*diagnosis.spoilt, *_sure(diagnosis.ladder)))
    if diagnosis.ladder.asked:
        left = fit_shown.over_noise(final)
        return [
            f"Explained: with {named}, as asked for, the error is {left}; others were not tried."
        ]
    if diagnosis.ladder.steps:
        return [f"Missing: {named}."]
    return [
        f"Missing: {named}. {LEFT_OUT} On the others the model is adequate: its error is "
        f"{fit_shown.over_noise(final)}."
    ]


def _sure(ladder: Ladder) -> list[str]:
    """Name the effects of the last model, each as probable as the table beside has it."""
    if ladder.asked:
        return list(ladder.effects)
    likely = {name: probability(ladder.posterior.effect(name)) for name in ladder.effects}
    return [f"{name} (probability {each})" for name, each in likely.items()]


def _ambiguous(diagnosis: Diagnosis) -> list[str]:
    ladder = diagnosis.ladder
    said = _name_agreed(ladder)
    if models := _open(ladder):
        said += f"One of {', '.join(models)}: this recording cannot tell which. "
    else:
        left = fit_shown.over_noise(ladder.final)
        said += f"Nearest: {', '.join(diagnosis.effects)}, which leaves {left}."
    return [said.strip()]


def _name_agreed(ladder: Ladder) -> str:
    """Name the parts of all probable models: effects, then the family of which no form is sure."""
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
        # Of one effect alone it is that of the table beside.
        known = (1.0 - ladder.posterior.unknown) * likely
        told = ladder.posterior.effect(rest[0]) if len(rest) == 1 else known
        models.append(f"{' + '.join(rest) or 'nothing more'} ({probability(told)})")
    return models


def _describe_unexplained(diagnosis: Diagnosis) -> list[str]:
    if diagnosis.fails_elsewhere:
        names = " and ".join(diagnosis.effects)
        model = f"the model with {names}" if names else "the model"
        return [f"Unexplained: {model} explains this recording, and not the second one."]
    said = "Unexplained: no effect of the library brings the error down to the noise. "
    if diagnosis.ladder.harmonic is not None:
        said = (
            f"Unexplained: a line at {diagnosis.ladder.harmonic:.4g} Hz, a multiple of the drive's "
            "frequency, explains more than any effect of the library; any nonlinear cause "
            "leaves such lines. Drive at several frequencies to tell, as by a multisine. "
        )
    if diagnosis.ladder.asked:
        said = (
            f"Unexplained: with {', '.join(diagnosis.effects)} more is left than noise; other "
            "effects were not tried."
        )
    else:
        said += _nearest(diagnosis)
        said += _of_zero(diagnosis.ladder.final)
        if diagnosis.ladder.steps:
            unknown = probability(diagnosis.ladder.posterior.unknown)
            said += (
                f" The probability that no model of the library is right is {unknown}; those of "
                "the effects say which of them help most, and not that one is right."
            )
    return [said.strip(), *shape_in_words.describe_shape(diagnosis.shape)]


def _of_zero(final: Fit) -> str:
    """Ask where the tip touches, where the model has it touch within its travel of zero."""
    touch = final.named().get(CONTACT_POSITION.name, math.inf)
    near = abs(touch) < max(float(each.position.max()) for each in final.measurements)
    return f" {ZERO_AT_TOUCH}" if near and final.composition.rig.tip_is_position else ""


def _nearest(diagnosis: Diagnosis) -> str:
    """Say which effects come nearest where none explains all, if they help at all."""
    if _names_nothing(diagnosis):
        return NONE_NAMED
    ladder, names = diagnosis.ladder, ", ".join(diagnosis.effects)
    if not ladder.steps:
        return f"In the samples: {names}. {LEFT_OUT}" if diagnosis.spoilt else ""
    if diagnosis.heldout(ladder.final) <= diagnosis.heldout(ladder.base):
        return f"Nearest: {names}."
    # Not all of the ranking is tried on a second recording.
    tried = [
        fit
        for fit in ladder.ranking
        if not diagnosis.validated or fit.composition.names in diagnosis.validated
    ]
    if any(diagnosis.heldout(fit) < diagnosis.heldout(ladder.base) for fit in tried):
        return f"{names}, which fits best, raises the error on held-out data."
    return f"No effect lowers the error on held-out data, {names} neither, which fits best."


def _caveats(diagnosis: Diagnosis) -> list[str]:
    """Give the reasons against trusting the last model."""
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
            "the model does not carry over. Either the specimen, the site, the contact, the start "
            "or a zero is another one there, or more is missing than the first recording shows"
            f"{more}; record again, or fit both together."
        ]
    if not diagnosis.reaches:
        expected = final.output.tell(diagnosis.uncertainty)
        return [
            f"On the second recording the error is {error}, where the noise is {noise}. The first "
            f"tells some values so roughly that {expected} would have been no surprise: fit both "
            "together, to know the values better."
        ]
    return []
