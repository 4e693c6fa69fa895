"""A record whose truth is known.

Contents: what it consists of.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

Array = np.ndarray


@dataclass(frozen=True)
class Record:
    """What a laboratory wrote down.

    Attributes
    ----------
    time, position, force : array, shape (n,)
        [s], [m], and [N], positive in compression.
    noise : float
        Rms that the noise of both channels leaves to the true model, in the unit of what the rig
        predicts: [N], of ``force_driven`` [m].
    """

    time: Array
    position: Array
    force: Array
    noise: float

    def columns(self) -> dict[str, Array]:
        """Return it as ``tp.read`` takes arrays by name."""
        return {"t": self.time, "u": self.position, "F": self.force}


@dataclass(frozen=True)
class Truth:
    """What is in a record.

    Attributes
    ----------
    hidden : str
        What was hidden, by the maker's own name; empty for nothing.
    effects, families : tuples of str
        By which names, and of which families, it is rightly told.
    ratio : float
        Rms that the best Kelvin-Voigt fit leaves, over the noise; 1 where nothing is hidden.
    values : mapping
        True values by the names of the library's models [SI], as far as the model that is asked
        about has them: where nothing is hidden they must lie within their intervals.
    """

    hidden: str
    effects: tuple[str, ...]
    families: tuple[str, ...]
    ratio: float
    values: Mapping[str, float]


@dataclass(frozen=True)
class Dealt:
    """A record, a second one of the same specimen, the truth, and how a user would ask.

    Attributes
    ----------
    protocol : str
        Kind of experiment.
    seed : int
        Makes the same record again.
    first, second : Record
        To be diagnosed, and to validate: of another amplitude or rate.
    truth : Truth
        What is in both.
    arguments : mapping
        Of ``tp.diagnose``: what a user of that laboratory knows.
    """

    protocol: str
    seed: int
    first: Record
    second: Record
    truth: Truth
    arguments: Mapping[str, Any] = field(default_factory=dict)
