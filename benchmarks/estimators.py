"""How fast, how exact and how honest the estimators are, against a truth that is known.

Every number comes from fresh noise, of seeds that neither the tests nor the tuning used, and what
changes does so at a random time within a period. Two values are those of k and of beta; a/b is
median/worst. One configuration serves all rows, except for what a user knows of his
instrument (noise, encoder) and, in the row that says so, a prior widened on purpose.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.estimators_bound import cramer_rao_bound
from benchmarks.estimators_simulator import Experiment, HardeningTissue, simulate_ramp
from tissue_probe.estimation import Estimator, EstimatorSettings
from tissue_probe.reproduction.filters import PAPER
from tissue_probe.signals import SampleBlock, TissueEstimates

STANDARD = EstimatorSettings()
K, B = 450.0, 5.0


@dataclass(frozen=True)
class Contestant:
    """A column of the tables."""

    title: str
    estimator: str
    settings: EstimatorSettings


CONTESTANTS = (
    Contestant("paper EKF", "ekf", PAPER),
    Contestant("paper AFEKF", "afekf", PAPER),
    Contestant("ekf", "ekf", STANDARD),
    Contestant("ukf", "ukf", STANDARD),
    Contestant("afekf", "afekf", STANDARD),
    Contestant("afukf", "afukf", STANDARD),
    Contestant("robust_ekf", "robust_ekf", STANDARD),
    Contestant("lock_in", "lock_in", STANDARD),
    Contestant("rls", "rls", STANDARD),
)


@dataclass(frozen=True)
class Run:
    """Estimates of one experiment beside its truth."""

    experiment: Experiment
    estimates: TissueEstimates

    @property
    def errors(self) -> np.ndarray:
        """Errors of k and beta over the truth (the first tissue's where it is 0), shape (2, n)."""
        stiffness, damping = self.experiment.truth()
        _, k, b = self.experiment.tissue[0]
        return np.array(
            [
                (self.estimates.stiffness - stiffness) / np.where(stiffness, stiffness, k),
                (self.estimates.damping - damping) / np.where(damping, damping, b),
            ]
        )

    def settled(self, begin: float, end: float) -> np.ndarray:
        """Time after ``begin`` from which both stay within 5 % until ``end`` [ms], inf if never."""
        first, last = (round(t / self.experiment.sample_period) for t in (begin, end))
        times = []
        for error in np.abs(self.errors[:, first:last]):
            outside = np.flatnonzero(~(error <= 0.05))
            sample = outside[-1] + 1 if outside.size else 0
            times.append(1e3 * sample * self.experiment.sample_period)
            if sample == error.size:
                times[-1] = np.inf
        return np.array(times)

    def late(self, begin: float) -> slice:
        """Return the samples from ``begin`` [s] on."""
        return slice(round(begin / self.experiment.sample_period), None)


def run(contestant: Contestant, experiment: Experiment, settings: EstimatorSettings) -> Run:
    position, force = experiment.run()
    block = SampleBlock(
        0, 0, experiment.sample_period, position, force, np.full(force.size, np.nan)
    )
    estimator = Estimator(contestant.estimator, settings)
    return Run(experiment, estimator.process(block))


def runs(
    who: Contestant, experiment: Experiment, seeds: Sequence[int], **changed: float
) -> list[Run]:
    """Run an experiment with each seed's noise; ``changed`` are settings that the user knows."""
    settings = who.settings.model_copy(update={"drive_frequency": experiment.frequency, **changed})
    return [run(who, replace(experiment, seed=seed), settings) for seed in seeds]


def random_part(seed: int) -> float:
    """Between 0 and 1: where in a period something happens."""
    return float(np.random.default_rng([seed, 7]).uniform())


def spread(values: Sequence[float], digits: int = 0) -> str:
    """Median / worst."""
    return f"{np.median(values):.{digits}f}/{np.max(values):.{digits}f}"


def settling(times: Sequence[np.ndarray]) -> str:
    """Median/worst settling times of k and of beta [ms]."""
    return ", ".join(spread(column) for column in np.transpose(times))


def from_zero(who: Contestant, seeds: Sequence[int]) -> str:
    return settling([r.settled(0.0, 2.0) for r in runs(who, Experiment(duration=2.0), seeds)])


def joining(who: Contestant, seeds: Sequence[int]) -> str:
    times = []
    for seed in seeds:
        phase = 2 * np.pi * random_part(seed)
        experiment = Experiment(duration=2.0, phase=phase, steady=True)
        times.append(runs(who, experiment, [seed])[0].settled(0.0, 2.0))
    return settling(times)


def over_bound(who: Contestant, seeds: Sequence[int]) -> str:
    """Rms error at 200 ms over the bound: ten times the seeds, since a rms needs many."""
    many = range(seeds[0], seeds[0] + 10 * len(seeds))
    squares, bounds = [], []
    for result in runs(who, Experiment(duration=0.2), many):
        squares.append((result.errors[:, -1] * [K, B]) ** 2)
        bounds.append(cramer_rao_bound(result.experiment) ** 2)
    ratios = np.sqrt(np.mean(squares, axis=0) / np.mean(bounds, axis=0))
    return ", ".join(f"{ratio:.2f}" for ratio in ratios)


def bias(who: Contestant, seeds: Sequence[int], frequency: float) -> str:
    results = runs(who, Experiment(duration=4.0, frequency=frequency), seeds)
    means = np.mean([result.errors[:, result.late(2.0)].mean(axis=1) for result in results], axis=0)
    return ", ".join(f"{100 * mean:.3f}" for mean in means)


def changes(
    who: Contestant, seeds: Sequence[int], *after: tuple[float, float], **disturbance: float
) -> str:
    """Time to follow the last change of the tissue, which comes at any time of a period [ms]."""
    times = []
    for seed in seeds:
        at = [1.0 + 0.7 * i + 0.1 * random_part(seed) for i in range(len(after))]
        pieces = [(t, *tissue) for t, tissue in zip(at, after, strict=True)]
        experiment = Experiment(tissue=((0.0, K, B), *pieces), duration=at[-1] + 2.0, **disturbance)
        first = np.ceil(at[-1] / 5e-4) * 5e-4
        times.append(runs(who, experiment, [seed])[0].settled(first, first + 1.9))
    return settling(times)


def steady_deviation(who: Contestant, seeds: Sequence[int]) -> str:
    results = runs(who, Experiment(duration=4.0), seeds)
    deviations = [result.errors[:, result.late(2.0)].std(axis=1) for result in results]
    return ", ".join(f"{100 * value:.3f}" for value in np.mean(deviations, axis=0))


def nis_in_band(who: Contestant, seeds: Sequence[int], **changed: float) -> str:
    """Share of the NIS below the 95 % point of chi-squared with one degree of freedom."""
    experiment = replace(Experiment(duration=4.0), **changed)
    results = runs(who, experiment, seeds, **changed)
    inside = [
        result.estimates.normalized_innovation_squared[result.late(0.1)] < 3.841
        for result in results
    ]
    return f"{np.mean(inside):.3f}"


def nees_in_band(who: Contestant, seeds: Sequence[int]) -> str:
    """Share of the NEES of (k, beta) below the 95 % point of chi-squared, two degrees."""
    inside = []
    for result in runs(who, Experiment(duration=4.0), seeds):
        e = result.errors[:, result.late(0.1)] * np.array([[K], [B]])
        p = result.estimates[result.late(0.1)]
        kk, bb, kb = (p.stiffness_variance, p.damping_variance, p.stiffness_damping_covariance)
        nees = (e[0] ** 2 * bb - 2 * e[0] * e[1] * kb + e[1] ** 2 * kk) / (kk * bb - kb**2)
        inside.append(nees < 5.991)
    return f"{np.mean(inside):.3f}"


def disturbed(who: Contestant, seeds: Sequence[int], **disturbance: float) -> str:
    """Bias, and in brackets the standard deviation, under a constant disturbance [%]."""
    results = runs(who, replace(Experiment(duration=3.0), **disturbance), seeds)
    late = [result.errors[:, result.late(1.0)] for result in results]
    means = 100 * np.mean([error.mean(axis=1) for error in late], axis=0)
    deviations = 100 * np.mean([error.std(axis=1) for error in late], axis=0)
    return ", ".join(f"{m:.3f} ({s:.2f})" for m, s in zip(means, deviations, strict=True))


def ramp(who: Contestant, seeds: Sequence[int], after: tuple[float, float]) -> str:
    """Rms error while k and beta go to other values within 100 ms [%]."""
    experiment = simulate_ramp((K, B), after, start=1.0, length=0.1, duration=1.5)
    results = runs(who, experiment, seeds)
    during = [result.errors[:, 2000:2200] for result in results]
    return ", ".join(
        f"{100 * np.sqrt(np.mean(np.square(d))):.1f}" for d in np.moveaxis(during, 1, 0)
    )


def wide_prior_failures(who: Contestant, seeds: Sequence[int]) -> str:
    """Failures (k off by 20 % or beta by 50 %) at 30 Hz, 2 mm, 3000 N/m, prior sd 1e4 N/m."""
    tissue = ((0.0, 3000.0, 10.0),)
    experiment = Experiment(tissue=tissue, frequency=30.0, amplitude=2e-3, duration=2.0)
    results = runs(who, experiment, seeds, stiffness_prior_sd=1e4)
    last = np.abs([result.errors[:, -1] for result in results])
    return f"{np.sum(~((last[:, 0] < 0.2) & (last[:, 1] < 0.5)))} of {len(seeds)}"


def coarse_encoder(who: Contestant, seeds: Sequence[int]) -> str:
    results = runs(
        who, Experiment(duration=2.0, encoder_resolution=5e-6), seeds, encoder_resolution=5e-6
    )
    times = settling([result.settled(0.0, 2.0) for result in results])
    return f"{times}; NIS {nis_in_band(who, seeds, encoder_resolution=5e-6)}"


RIGHT = Experiment(duration=3.0)
CHANGES = replace(RIGHT, tissue=((0.0, K, B), (1.0, 2 * K, 2 * B), (1.5, 0.0, 0.0), (2.0, K, B)))
HARD = HardeningTissue(duration=3.0, hardening=0.2)


def rejected(who: Contestant, seeds: Sequence[int], experiment: Experiment) -> str:
    """Share of the time, after the first second, in which the model is rejected."""
    results = runs(who, experiment, seeds)
    return f"{np.mean([r.estimates.status[r.late(1.0)] == 3 for r in results]):.3f}"


def hardening_deviation(who: Contestant, seeds: Sequence[int]) -> str:
    results = runs(who, HARD, seeds)
    deviations = [result.errors[:, result.late(2.0)].std(axis=1) for result in results]
    return ", ".join(f"{100 * value:.2f}" for value in np.mean(deviations, axis=0))


Row = Callable[[Contestant, Sequence[int]], str]
ROWS: dict[str, tuple[str, Row]] = {
    "from zero: within 5 % after, k, beta [ms]": ("<=15/<=40", from_zero),
    "joining a motion at any phase: within 5 % after [ms]": ("", joining),
    "rms over Cramer-Rao bound at 200 ms": ("<=1.2", over_bound),
    **{
        f"bias at {f} Hz, k, beta [%]": (
            "<=0.1" if f > 2 else "<=0.1, <=0.3",
            lambda who, seeds, f=f: bias(who, seeds, f),
        )
        for f in (2, 10, 30)
    },
    "k, beta doubled: within 5 % after [ms]": (
        "<=30/<=45",
        lambda who, seeds: changes(who, seeds, (2 * K, 2 * B)),
    ),
    "k, beta halved: within 5 % after [ms]": (
        "<=30/<=45",
        lambda who, seeds: changes(who, seeds, (K / 2, B / 2)),
    ),
    "contact lost: within 5 % after [ms]": (
        "<=25/<=45",
        lambda who, seeds: changes(who, seeds, (0.0, 0.0)),
    ),
    "softer tissue regained: within 5 % after [ms]": (
        "<=25/<=45",
        lambda who, seeds: changes(who, seeds, (0.0, 0.0), (250.0, 3.0)),
    ),
    "k alone doubled: within 5 % after [ms]": (
        "",
        lambda who, seeds: changes(who, seeds, (2 * K, B)),
    ),
    "beta alone doubled: within 5 % after [ms]": (
        "",
        lambda who, seeds: changes(who, seeds, (K, 2 * B)),
    ),
    "doubled, contact zero 1 mm off: within 5 % after [ms]": (
        "",
        lambda who, seeds: changes(who, seeds, (2 * K, 2 * B), contact_zero=1e-3),
    ),
    "steady standard deviation, k, beta [%]": ("<=0.03, <=0.08", steady_deviation),
    "NIS inside 95 %": ("0.93-0.97", nis_in_band),
    "NEES(k, beta) inside 95 %": (">=0.85", nees_in_band),
    "force offset 100 mN: bias (sd) [%]": (
        "<=0.05",
        lambda w, s: disturbed(w, s, force_offset=0.1),
    ),
    "contact zero 1 mm off: bias (sd) [%]": (
        "<=0.05",
        lambda w, s: disturbed(w, s, contact_zero=1e-3),
    ),
    "ramp x2 in 100 ms: rms error [%]": ("<=8", lambda w, s: ramp(w, s, (2 * K, 2 * B))),
    "ramp x2 in 100 ms of k alone: rms error [%]": ("", lambda w, s: ramp(w, s, (2 * K, B))),
    "ramp x2 in 100 ms of beta alone: rms error [%]": ("", lambda w, s: ramp(w, s, (K, 2 * B))),
    "wide prior, 30 Hz, 3000 N/m: failures": ("0", wide_prior_failures),
    "encoder of 5 um: within 5 % after [ms]; NIS": ("converges, in band", coarse_encoder),
    "model rejected though right, share of the time": ("0", lambda w, s: rejected(w, s, RIGHT)),
    "model rejected though right, softer and stiffer": ("0", lambda w, s: rejected(w, s, CHANGES)),
    "model rejected, hardening tissue: share of the time": ("1", lambda w, s: rejected(w, s, HARD)),
    "hardening tissue: steady standard deviation, k, beta [%]": ("", hardening_deviation),
}


def measure(
    seeds: Sequence[int],
    rows: Mapping[str, tuple[str, Row]] = ROWS,
    say: Callable[[str], None] = print,
) -> dict[str, dict[str, str]]:
    """Return for each row what is to be reached, and what each contestant reached.

    Parameters
    ----------
    seeds : sequence of int
        Of the noise, and of the times of changes.
    rows : mapping
        Those of ``ROWS`` that are wanted.
    say : callable
        Told what is under way.
    """
    say(f"estimators: {len(rows)} rows, {len(seeds)} seeds")
    return {
        title: {"to reach": goal, **{who.title: row(who, seeds) for who in CONTESTANTS}}
        for title, (goal, row) in rows.items()
    }
