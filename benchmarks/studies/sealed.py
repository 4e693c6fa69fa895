"""Whether the intervals of a study hold what is true, and whether what short records borrow helps.

Contents: sealed studies, drawn as tables of values; a study of records of 50 ms.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.stats import binomtest

import tissue_probe as tp
from benchmarks.studies.recordings import ASKED, PATTERN, Laboratory
from tissue_probe.studies.plan import StudyPlan, recordings_of
from tissue_probe.studies.spread import Interval, Spread, spread_of

#: Sealed studies, of seeds that no test and no tuning used.
STUDIES, FIRST_SEED = 200, 63_000
#: Least probability of so many intervals that hold, were they of 95 %.
LEAST = 1e-3
#: By how much the error of k is to be less, of records of 50 ms [s] with a noise of 0.05 N.
LESS, SHORT = 0.3, Laboratory(specimens=20, repeats=10, seconds=0.05, noise=0.05)


def measure(studies: int = STUDIES, say: Callable[[str], None] = print) -> dict[str, float]:
    """Return of each kind of interval the share that holds, and its probability; the shrinkage."""
    say(f"{studies} sealed studies")
    held: dict[str, list[bool]] = {}
    for seed in range(FIRST_SEED, FIRST_SEED + studies):
        for name, holds in marked(np.random.default_rng(seed)).items():
            held.setdefault(name, []).append(holds)
    told: dict[str, float] = {"sealed studies": float(studies)}
    for name, each in held.items():
        told[f"{name}: intervals that hold"] = float(np.mean(each))
        told[f"{name}: probability"] = float(binomtest(sum(each), len(each), 0.95).pvalue)
    say("records of 50 ms")
    return told | _shrinkage()


def goals(found: dict[str, float]) -> dict[str, str]:
    """Return what is to be reached, by the names of the results."""
    ends = {"probability": f"> {LEAST:g}", "less [%]": f">= {100 * LESS:g}"}
    return {
        name: next((goal for end, goal in ends.items() if name.endswith(end)), "") for name in found
    }


def marked(random: np.random.Generator) -> dict[str, bool]:
    """Draw a study of two groups, and say of each interval whether it holds the truth."""
    specimens, repeats = int(random.integers(6, 25)), int(random.integers(2, 6))
    between, within, stated = random.uniform((4.0, 1.0, 1.0), (20.0, 8.0, 6.0))
    middles = np.array([400.0, 400.0 + random.uniform(-30.0, 30.0)])
    of = np.repeat(np.arange(specimens), repeats)
    group = of % 2
    sd = stated * random.uniform(0.5, 1.5, of.size)
    truth = (
        middles[group]
        + between * random.standard_normal(specimens)[of]
        + within * random.standard_normal(of.size)
    )
    y = truth + sd * random.standard_normal(of.size)
    found = spread_of(y, sd, [str(each) for each in of], [str(each) for each in group])
    one = int(random.integers(of.size))
    own = 1.96 * found.borrowed_sd[one]
    return {
        name: interval.low <= true <= interval.high
        for name, (interval, true) in {
            **_spreads(found, between, within, float(np.median(sd))),
            "mean": (found.means["0"], middles[0]),
            "contrast": (found.contrasts["0", "1"], middles[1] - middles[0]),
            "borrowed": (
                Interval(found.borrowed[one], found.borrowed[one] - own, found.borrowed[one] + own),
                truth[one],
            ),
        }.items()
    }


def _spreads(
    found: Spread, between: float, within: float, typical: float
) -> dict[str, tuple[Interval, float]]:
    error = float(np.hypot(within, typical))
    return {
        "between": (found.between, between),
        "within": (found.within, within),
        "ICC": (found.reliability, between**2 / (between**2 + error**2)),
        "standard error of measurement": (found.measurement_error, error),
    }


def _shrinkage() -> dict[str, float]:
    """Return the error of k by each record alone, and with what others tell [N/m]."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        truths = SHORT.write(folder / "data", FIRST_SEED)
        recordings = recordings_of(str(folder / "data" / "*.csv"), PATTERN)
        question = {**ASKED, "settings": {"force_noise": SHORT.noise}}
        found = tp.study(StudyPlan(recordings, "estimate", question, folder / "answers"), workers=1)
    true = np.array([truths[Path(row["path"]).name] for row in found.rows])
    alone = np.array([row["stiffness"] for row in found.rows]) - true
    borrowed = found.spread().borrowed - true
    errors = [float(np.sqrt(np.mean(each**2))) for each in (alone, borrowed)]
    return {
        "k of 50 ms, error alone [N/m]": errors[0],
        "k of 50 ms, error with the others [N/m]": errors[1],
        "k of 50 ms, error less [%]": 100.0 * (1.0 - errors[1] / errors[0]),
    }
