"""A record of the instrument's measure, the truth, and how a user would ask.

Contents: what it consists of, and what its maker needs to draw.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any
from zlib import crc32

import numpy as np

from benchmarks.ruler.dealt import Record


@dataclass(frozen=True)
class Truth:
    """What is in a record.

    Attributes
    ----------
    effects : mapping of str to str
        Families of the tissue's effects, by the library's names; empty for a plain tissue.
    values : mapping
        True values by the library's names [SI].
    widths : mapping
        Standard deviations [SI] that an exact simulation of the record has; empty where they are
        not asked for.
    besides : tuple of str
        Families that may be named besides, since the instrument has such a part.
    """

    effects: Mapping[str, str]
    values: Mapping[str, float]
    widths: Mapping[str, float] = field(default_factory=dict)
    besides: tuple[str, ...] = ()


@dataclass(frozen=True)
class Case:
    """One record, maybe with a second one of the same specimen.

    Attributes
    ----------
    group, kind : str
        Of which group, and which row of its table.
    seed : int
        Makes the same record again.
    first, second : Record
        To be diagnosed, and to validate.
    arguments : mapping
        Of ``tp.diagnose``.
    """

    group: str
    kind: str
    seed: int
    truth: Truth
    first: Record
    second: Record | None
    arguments: Mapping[str, Any]


def generator(group: str, seed: int) -> np.random.Generator:
    """Return the random numbers of a record; others for each group and seed."""
    return np.random.default_rng([crc32(group.encode()), seed])


def log_uniform(random: np.random.Generator, low: float, high: float) -> float:
    """Return a number between two, each decade as likely."""
    return float(np.exp(random.uniform(np.log(low), np.log(high))))
