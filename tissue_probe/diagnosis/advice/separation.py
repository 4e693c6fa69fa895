"""The experiment that would separate effects which this one cannot.

Contents: simulated experiments with fitted models, and calibrations that help where no excitation
does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from tissue_probe.diagnosis.advice.visibility import SEEN, visibilities
from tissue_probe.diagnosis.evidence.conclusion import name_differences
from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.problem import Problem
from tissue_probe.diagnosis.inspection.sampling_checks import PER_CYCLE
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import SETTLING_TIME, Measurement
from tissue_probe.diagnosis.observation.noise import Noise
from tissue_probe.diagnosis.ranking.candidates import refit
from tissue_probe.diagnosis.sharing import map_shared
from tissue_probe.physics.response import course, respond
from tissue_probe.quantities import FORCE

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect
    from tissue_probe.physics.scale import Scale

#: Experiments that a probe can make, from the shortest on: excitation, preload [m], duration [s].
PROBE_EXPERIMENTS: tuple[tuple[dict[str, object], float, float], ...] = (
    ({"kind": "sine", "frequency": 10.0}, 0.0, 2.0),
    ({"kind": "sine", "frequency": 10.0}, 2e-3, 2.0),
    ({"kind": "multisine", "start": 1.0, "stop": 60.0, "spacing": 1.0}, 0.0, 2.0),
    ({"kind": "multisine", "start": 1.0, "stop": 60.0, "spacing": 1.0}, 2e-3, 2.0),
    ({"kind": "chirp", "start": 1.0, "stop": 60.0, "duration": 4.0}, 0.0, 4.0),
    ({"kind": "chirp", "start": 1.0, "stop": 60.0, "duration": 4.0}, 2e-3, 4.0),
)
PROBE_AMPLITUDE = 1e-3
#: Values of an excitation that are rates per second.
RATE_SETTINGS = {"frequency", "start", "stop", "spacing"}
#: Of models that explain equally well, so many are held to be the right one, in their order.
RIVALS_COMPARED = 3
#: Residual over noise of the wrong models from which an experiment tells them from the right one,
#: and from which it needs no calibration besides.
TOLD, CLEARLY = 1.02, 1.1

#: Two values are others from so many standard deviations of their difference on: chance makes it of
#: one in 400.
DIFFERS = 3.0
#: Of a constant by which models differ: name, then value and effects of each of two.
STATED = "weigh or calibrate {0}, and state it: it is {1:.3g} with {2}, and {3:.3g} with {4}"

#: The calibration that shows an effect which hides within the rig's tolerances.
CALIBRATIONS = {
    "force_bias": "record the force in free air, and tare (tissue_probe calibrate)",
    "force_gain": "hang a known weight on the load cell",
    "load_cell_stiffness_error": "press the tip on a rigid stop: the force against the coil's way "
    "is the load cell's stiffness",
    "added_mass": "let the tip ring down in free air: its frequency gives its mass",
    "structural_mode": "let the tip ring down in free air: a second resonance shows as a beat",
    "force_drift": "record the force for a minute in free air, with nothing moving",
    "tissue_motion": "record the force with the tip on the tissue and the drive standing still",
    "mains_hum": "record the force with the drive standing still",
    "force_lag": "let the tip ring down in free air, and compare force with position",
    "channel_delay": "tap the tip on a rigid stop: force and position must break off together",
    "contact_loss": "touch off: go down slowly until the force rises, and set the zero there",
    "adhesion": "touch off and pull back slowly: the force at which the tip comes off",
    "adhesion_within_range": "touch off and pull back slowly: the force falls while the tip lifts",
}

#: The same where the tip follows the position exactly, and cannot ring.
LED_CALIBRATIONS = {
    **CALIBRATIONS,
    "load_cell_stiffness_error": "press the tip on a rigid stop: the force against the position "
    "is the load cell's stiffness",
    "added_mass": "weigh the parts that hang between load cell and tissue",
    "structural_mode": "move in free air, faster and faster: a resonance shows in the force",
    "force_lag": "press the tip on a steel spring: force and position must turn together",
}


@dataclass(frozen=True)
class Suggestion:
    """The next experiment or calibration.

    Attributes
    ----------
    excitation : mapping
        As the driver takes it (kind, frequencies), but for the amplitude, which is the coil's way
        [m]; empty where no excitation would help.
    preload : float
        Mean displacement of the coil [m].
    duration : float
        Time to record, from rest [s].
    separation : float
        Predicted residual of the wrong model over the noise; 1 tells nothing, NaN where there is
        no wrong one.
    shows : tuple of str
        Effects that could not be seen, and would be.
    calibration : str
        The calibration that would tell where no excitation does.
    """

    excitation: Mapping[str, object]
    preload: float
    duration: float
    separation: float
    shows: tuple[str, ...] = ()
    calibration: str = ""


@dataclass(frozen=True)
class PossibleExperiments:
    """The experiments that a drive can make, and how sure the answer is to be after them.

    Attributes
    ----------
    motions : tuple
        Of each its excitation, preload [m] and duration [s].
    amplitude : float
        The coil's way in all of them [m].
    probability : float
        Models are to be told apart until the best is so probable; 0 leaves that to the verdict.
    """

    motions: tuple[tuple[dict[str, object], float, float], ...] = PROBE_EXPERIMENTS
    amplitude: float = PROBE_AMPLITUDE
    probability: float = 0.0


#: Of a probe that stands anywhere.
ALL_EXPERIMENTS = PossibleExperiments()

#: Excitation, preload [m] and duration [s] of an experiment, and how it would come out.
_Made = tuple[dict[str, object], float, float, Measurement]
_Told = TypeVar("_Told")


def suggest(
    rivals: Sequence[Fit],
    instrument: Instrument,
    library: Mapping[str, Effect],
    unseen: Sequence[str] = (),
    possible: PossibleExperiments = ALL_EXPERIMENTS,
) -> Suggestion | None:
    """Choose the experiment under which rival models differ most, or unseen effects show.

    Parameters
    ----------
    rivals : sequence of Fit
        Models that explain the measurement equally well, the best first; or one alone.
    instrument : Instrument
        Constants of the rig with their tolerances.
    library : mapping of str to Effect
        All effects.
    unseen : sequence of str
        Effects that the measurement could not have shown.
    possible : PossibleExperiments
        Of which one is chosen.
    """
    if len(rivals) > 1:
        return _between(rivals, instrument, possible)
    return _choose_experiment(rivals[0], instrument, library, unseen, possible) if unseen else None


def _between(
    rivals: Sequence[Fit], instrument: Instrument, possible: PossibleExperiments
) -> Suggestion | None:
    """Choose the experiment that the wrong models could not follow if one of the first were right.

    Where each could follow the best, being faint, one of the others may be the missing one.
    """
    stated, known = (
        _constants(rivals, instrument),
        _calibrations(name_differences(rivals), instrument),
    )
    helps = "; ".join(filter(None, (stated, known)))
    if rivals[0].composition.input is FORCE:
        # The experiments are motions of a coil; which forces another drive can make is not known.
        return Suggestion({}, 0.0, 0.0, np.nan, calibration=helps) if helps else None
    apart, best = 0.0, None
    for right in rivals[:RIVALS_COMPARED]:
        wrong = [rival for rival in rivals[:RIVALS_COMPARED] if rival is not right]
        for made, left in _try_experiments(
            right, partial(_least_misfit, wrong, instrument), possible
        ):
            if left > apart:
                apart, best = left, made
        if apart >= TOLD:
            break
    if best is None:  # the samples come too slowly for any
        return Suggestion({}, 0.0, 0.0, np.nan, calibration=helps) if helps else None
    if apart < TOLD:
        return Suggestion({}, 0.0, 0.0, apart, calibration=helps or "calibrate the rig")
    excitation, preload, duration, _ = best
    helps = helps if apart < CLEARLY else stated
    return Suggestion(excitation, preload, duration, apart, (), helps)


def _constants(rivals: Sequence[Fit], instrument: Instrument) -> str:
    """Say which constants of the rig would tell, which nobody gave: rivals found others of them."""
    first, second, *_ = rivals
    told = []
    for name, (_, deviation) in (instrument.constants or {}).items():
        here, there = first.named()[name], second.named()[name]
        doubt = np.hypot(first.deviations()[name], second.deviations()[name])
        if np.isinf(deviation) and abs(here - there) > DIFFERS * doubt:
            told.append(STATED.format(name, here, _more(first), there, _more(second)))
    return "; ".join(told)


def _more(fit: Fit) -> str:
    return " + ".join(fit.composition.names)


def _choose_experiment(
    base: Fit,
    instrument: Instrument,
    library: Mapping[str, Effect],
    unseen: Sequence[str],
    possible: PossibleExperiments,
) -> Suggestion | None:
    """Choose the experiment that shows most of the unseen effects, and name those it shows."""
    if base.composition.input is FORCE:  # another force may show them: see ``_between``
        return None
    effects = [library[name] for name in unseen]

    def seen_in(measurement: Measurement) -> Sequence[float]:
        fit = refit(base, base.composition, instrument, [measurement])
        return () if fit is None else visibilities(fit, effects, instrument, fit.composition)

    most, best = (0, 0.0), None
    for (excitation, preload, duration, _), seen in _try_experiments(base, seen_in, possible):
        if not seen:
            continue
        shows = tuple(n for n, each in zip(unseen, seen, strict=True) if each > SEEN)
        if (len(shows), min(seen)) > most:
            most = len(shows), min(seen)
            best = Suggestion(excitation, preload, duration, np.nan, shows)
    if best is None or not best.shows:
        best = Suggestion({}, 0.0, 0.0, np.nan)
    helps = _calibrations([name for name in unseen if name not in best.shows], instrument)
    return replace(best, calibration=helps) if best.shows or helps else None


def _calibrations(names: Sequence[str], instrument: Instrument) -> str:
    """Name the calibrations that tell effects."""
    known = LED_CALIBRATIONS if instrument.rig.tip_is_position else CALIBRATIONS
    return "; ".join(dict.fromkeys(known[name] for name in names if name in known))


def _try_experiments(
    right: Fit, judged: Callable[[Measurement], _Told], possible: PossibleExperiments
) -> list[tuple[_Made, _Told]]:
    """Simulate experiments with a fitted model, and judge each."""
    experiments = list(_experiments(right, possible))
    told = map_shared(judged, [measurement for *_, measurement in experiments])
    return list(zip(experiments, told, strict=True))


def _experiments(right: Fit, possible: PossibleExperiments) -> Iterator[_Made]:
    """Simulate the experiments that a recorder can follow, with a fitted model."""
    scale = right.composition.scale
    for excitation, preload, duration in possible.motions:
        if _is_sampled(excitation, right.measurements[0].sample_period / scale.time):
            measurement = _simulate_experiment(
                right, {**excitation, "amplitude": possible.amplitude}, preload, duration
            )
            if measurement is not None:
                told = {
                    **_slow_excitation(excitation, scale),
                    "amplitude": possible.amplitude * scale.length,
                }
                yield told, preload * scale.length, duration * scale.time, measurement


def _slow_excitation(excitation: Mapping[str, object], scale: Scale) -> dict[str, object]:
    """Return an excitation for a record of a size."""
    slowed = {
        name: float(str(excitation[name])) / scale.time for name in RATE_SETTINGS & {*excitation}
    }
    if "duration" in excitation:
        slowed["duration"] = float(str(excitation["duration"])) * scale.time
    return {**excitation, **slowed}


def _is_sampled(excitation: Mapping[str, object], period: float) -> bool:
    """Whether a recorder of this sample period follows the excitation."""
    fastest = float(str(excitation.get("stop", excitation.get("frequency"))))
    return fastest * period * PER_CYCLE <= 1.0


def _simulate_experiment(
    fit: Fit, excitation: Mapping[str, object], preload: float, duration: float
) -> Measurement | None:
    """Simulate an experiment with a fitted model, from rest, with the noise it was fitted to."""
    from tissue_probe.excitation import parse_excitation

    first, scale = fit.measurements[0], fit.composition.scale
    period = first.sample_period / scale.time
    times = np.arange(round(duration / period), dtype=float) * period
    # A coil that has a mass goes off gently: a jump of its speed would tell models apart by that.
    gently = np.sin(0.5 * np.pi * np.minimum(times / SETTLING_TIME, 1.0)) ** 2
    position = parse_excitation(dict(excitation))(times)
    position = scale.length * (preload + gently * position)
    problem = Problem(fit.composition, [first], Instrument(fit.composition.rig))
    values = problem.runs.values_in(0, fit.values)
    start = problem.kernel.begin(values, position[0], _static(fit, position[0]))
    coil = course(problem.kernel, position, first.sample_period, values)
    force = respond(problem.kernel, values, start, coil).output
    if not np.isfinite(force).all():
        return None
    noisy = force + first.noise.own * np.random.default_rng(0).standard_normal(times.size)
    noise = Noise(first.noise.own)
    return Measurement(position, noisy, first.sample_period, True, noise, scale=scale)


def _static(fit: Fit, position: float) -> float:
    """Force of a coil that has stood at a position for long [N]."""
    known = fit.named()
    k, zero = known["stiffness"], known["contact_position"]
    k0 = known.get("load_cell_stiffness", np.inf)
    series = k if not np.isfinite(k0) else k * k0 / (k + k0)
    return series * (position - zero)


def _least_misfit(rivals: Sequence[Fit], instrument: Instrument, measurement: Measurement) -> float:
    """Return the least that any of the rivals leaves, see ``_misfit``."""
    return min(_misfit(rival, measurement, instrument) for rival in rivals)


def _misfit(rival: Fit, measurement: Measurement, instrument: Instrument) -> float:
    """Residual over noise that a rival leaves of another model's simulated measurement."""
    moved = refit(rival, rival.composition, instrument, [measurement])
    return np.inf if moved is None else moved.ratio
