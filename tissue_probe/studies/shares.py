"""In how many recordings each effect is missing, with the interval of Wilson.

E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from scipy.stats import binomtest

from tissue_probe.errors import ParameterError
from tissue_probe.studies.spread import Interval


def shares_missing(rows: Sequence[Mapping[str, Any]]) -> dict[str, Interval]:
    """Return the share of diagnosed recordings that miss each effect, the largest first.

    Raises
    ------
    ParameterError
        If no row has a verdict.
    """
    told = [each for each in rows if "verdict" in each]
    if not told:
        raise ParameterError("no recording has a verdict: run the study with task: diagnose")
    missing = [each["missing"].split(", ") if each["missing"] else [] for each in told]
    names = sorted({name for each in missing for name in each})
    shares = {name: _share(sum(name in each for each in missing), len(told)) for name in names}
    return dict(sorted(shares.items(), key=lambda one: -one[1].value))


def _share(count: int, of: int) -> Interval:
    ends = binomtest(count, of).proportion_ci(method="wilson")
    return Interval(count / of, float(ends.low), float(ends.high))
