"""Whether any settings that are accepted, and any samples, make a filter lose its numbers.

Each sequence is of settings drawn from the whole of their ranges, and of samples as no probe should
send them: spikes, NaN, gaps, values beyond all measure, steps. All filters get the same.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise

import numpy as np
from pydantic.fields import FieldInfo

from tissue_probe.estimation import ESTIMATORS, Estimator, EstimatorSettings
from tissue_probe.settings import SettingsError, bound, build
from tissue_probe.signals import SampleBlock, TissueEstimates

PERIODS = (1e-4, 5e-4, 2e-3, 1e-2)
EXTREME = (0.0, -0.0, 1e-300, 1e-3, -1.0, 1e6, -1e12, 1e160, 1e300, np.nan, np.inf, -np.inf)
#: Of a range whose lower end is 0, so many orders of magnitude are drawn from.
ORDERS = 12.0
#: Of correlations: a smallest eigenvalue below minus this is no rounding of the eigenvalues.
ROUNDING = 1e-12
#: Of a sequence; the slowest sample is the mean of its sequence.
FAULTS = ("not finite", "k, beta indefinite", "state indefinite", "out of bounds")


SEQUENCES, SECONDS, SLOWEST = "sequences", "processor time [s]", "slowest sample [ms]"


def measure(
    count: int, first_seed: int, say: Callable[[str], None] = print
) -> dict[str, dict[str, float]]:
    """Return of each filter how many sequences showed which fault, and how long they took.

    Parameters
    ----------
    count : int
        Of sequences, for each filter.
    first_seed : int
        Of the first sequence.
    say : callable
        Told what is under way.
    """
    say(f"filters: {count} random sequences each, seeds from {first_seed} on")
    columns = (SEQUENCES, *FAULTS, SECONDS, SLOWEST)
    found = {name: dict.fromkeys(columns, 0.0) for name in ESTIMATORS}
    for seed in range(first_seed, first_seed + count):
        settings, blocks = sequence(seed)
        for name, counts in found.items():
            shown, seconds = examine(name, settings, blocks)
            counts[SEQUENCES] += 1
            counts[SECONDS] += seconds
            longest = 1e3 * seconds / sum(map(len, blocks))
            counts[SLOWEST] = max(counts[SLOWEST], longest)
            for fault in shown:
                counts[fault] += 1
    return found


def sequence(seed: int) -> tuple[EstimatorSettings, list[SampleBlock]]:
    """Return settings that are accepted, and samples."""
    random = np.random.default_rng(seed)
    return draw_settings(random), list(draw_blocks(random))


def draw_settings(random: np.random.Generator) -> EstimatorSettings:
    """Return settings of which each is anywhere in its range, or as it is by default."""
    while True:
        values = {
            name: _anywhere(entry, random)
            for name, entry in EstimatorSettings.model_fields.items()
            if entry.annotation is float and random.random() < 0.5
        }
        values["discretisation"] = "euler" if random.random() < 0.1 else "exact"
        try:
            return build(EstimatorSettings, values)
        except SettingsError:
            continue  # refused: those that go together are what is asked for


def _anywhere(entry: FieldInfo, random: np.random.Generator) -> float:
    """Return a value of any magnitude in a setting's range, of either sign where it has both."""
    lows, highs = (
        [value for kind in kinds if (value := bound(entry, kind)) is not None]
        for kinds in (("gt", "ge"), ("lt", "le"))
    )
    low, high = lows[0], highs[0]
    if low < 0.0:
        sign = random.choice([-1.0, 1.0]) if high > 0.0 else -1.0
        largest = high if sign > 0.0 else -low
        return float(sign * largest * 10.0 ** -random.uniform(0.0, ORDERS))
    if low > 0.1:
        return float(np.clip(random.uniform(low, high), low * (1 + 1e-9), high * (1 - 1e-9)))
    smallest = max(low * (1 + 1e-9), high * 10.0**-ORDERS)
    return float(high * (smallest / high) ** random.random())


def draw_blocks(random: np.random.Generator) -> Iterator[SampleBlock]:
    """Yield blocks of one stream: sines, spikes, steps, saturation, gaps, values of no meaning."""
    period, begun = float(random.choice(PERIODS)), 0
    for _ in range(random.integers(1, 5)):
        count = int(random.integers(1, 120))
        times = (begun + np.arange(count)) * period
        frequency = 10.0 ** random.uniform(-0.5, 2.0)
        amplitude = random.choice([0.0, 1e-6, 1e-3, 1e-3, 0.1, 1e4])
        position = amplitude * np.sin(2 * np.pi * frequency * times + random.uniform(0, 6))
        position += random.choice([0.0, 0.0, 1e-3, -5.0]) * (random.random(count) < 0.5).cumsum()
        force = random.choice([0.0, 450.0, -300.0, 1e5, 1e9]) * position
        force += random.choice([0.0, 5e-3, 10.0]) * random.standard_normal(count)
        if random.random() < 0.3:
            force = np.clip(force, -2.0, 2.0)
        for signal in (position, force):
            spoilt = random.integers(0, count, random.integers(0, 4))
            signal[spoilt] = random.choice(EXTREME, spoilt.size)
        begun += int(random.choice([0, 0, 1, 1000]))
        cut = [0, *sorted(random.integers(0, count, 8)), count]
        for first, last in pairwise(cut):
            if last > first:
                signals = (each[first:last] for each in (position, force, force))
                yield SampleBlock(begun * round(period * 1e9), begun + first, period, *signals)
        begun += count


def examine(
    name: str, settings: EstimatorSettings, blocks: Sequence[SampleBlock]
) -> tuple[list[str], float]:
    """Return the faults that a filter shows on one sequence, and its processor time [s]."""
    estimator = Estimator(name, settings)
    parts, covariances, seconds = [], [], 0.0
    for block in blocks:
        begin = time.thread_time()
        parts.append(estimator.process(block))
        seconds += time.thread_time() - begin
        covariances.append(estimator.covariance)
    return list(faults(settings, TissueEstimates.concatenate(parts), covariances)), seconds


def faults(
    settings: EstimatorSettings,
    estimates: TissueEstimates,
    covariances: Sequence[np.ndarray | None],
) -> Iterator[str]:
    """Yield the faults that estimates and covariances of the state show."""
    said = ("innovation", "normalized_innovation_squared")
    values = {name: getattr(estimates, name) for name in estimates.__dataclass_fields__}
    numbers = [v for n, v in values.items() if n not in ("estimator", "model", *said)]
    # A missing sample has no innovation, which is NaN.
    infinite = any(np.any(np.isinf(values[name])) for name in said)
    if infinite or not all(np.all(np.isfinite(each)) for each in numbers):
        yield FAULTS[0]
    kk, bb = estimates.stiffness_variance, estimates.damping_variance
    kb = estimates.stiffness_damping_covariance
    pair = np.stack([np.stack([kk, kb], -1), np.stack([kb, bb], -1)], -2)
    if is_indefinite(pair):
        yield FAULTS[1]
    if covariances[0] is not None and is_indefinite(np.array(covariances)):
        yield FAULTS[2]
    bounds = (
        (estimates.stiffness, settings.stiffness_minimum, settings.stiffness_maximum),
        (estimates.damping, settings.damping_minimum, settings.damping_maximum),
    )
    if any(np.any((value < low) | (value > high)) for value, low, high in bounds):
        yield FAULTS[3]


def is_indefinite(covariances: np.ndarray) -> bool:
    """Whether any of many covariances, shape (n, m, m), is one that no numbers have."""
    variances = np.diagonal(covariances, axis1=1, axis2=2)
    if not np.all(np.isfinite(covariances)):
        return False  # which is counted as such
    if not np.all(variances > 0.0):
        return True
    scale = np.sqrt(variances)
    correlations = covariances / scale[:, :, None] / scale[:, None, :]
    return bool(np.linalg.eigvalsh(correlations).min() < -ROUNDING)
