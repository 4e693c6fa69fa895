"""Public records of system identification, with their official splits and published errors.

Contents: their files, the law that their authors state, and figures of others.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tissue_probe.signals import FloatArray

#: Samples of a test that start a model, and are not scored.
STARTING = 50


@dataclass(frozen=True)
class Set:
    """Records of one object: one to learn from, and others to predict.

    Attributes
    ----------
    name, folder : str
        Of the set, and where its files are.
    tests : tuple of str
        Names of the tests; each is a file.
    law : tuple of str
        Effects that the authors' law has.
    unit, per_unit : str, float
        In which errors are told, and how many of it are one unit of the file.
    published : dict of str to tuple of float
        Root mean square errors of others in the order of the tests, in that unit; NaN where none
        is published.
    source : str
        Where the data, and those figures, come from.
    """

    name: str
    folder: str
    tests: tuple[str, ...]
    law: tuple[str, ...]
    unit: str
    per_unit: float
    published: dict[str, tuple[float, ...]]
    source: str

    def path(self, data: Path, part: str = "train") -> Path:
        """Return the file of a part: "train", or a test."""
        return data / self.folder / f"{part}.csv"

    def arrays(self, data: Path, part: str = "train") -> tuple[FloatArray, FloatArray, float]:
        """Return the driving force, the position, and the period of their samples [s]."""
        time, position, force = np.loadtxt(
            self.path(data, part), delimiter=",", skiprows=1, unpack=True
        )
        return force, position, float(np.median(np.diff(time)))


SETS = (
    Set(
        "Silverbox",
        "silverbox",
        ("multisine_test", "arrow_test", "arrow_no_extrapolation_test"),
        ("cubic_stiffening", "force_bias"),
        "mV",
        1e3,
        {
            "published, the best": (0.29, np.nan, np.nan),
        },
        "T. Wigren and J. Schoukens, Three free data sets for development and benchmarking in "
        "nonlinear system identification, European Control Conference (2013), 2933",
    ),
    Set(
        "Bouc-Wen",
        "bouc_wen",
        ("multisine_test", "sweep_test"),
        ("bouc_wen_hysteresis",),
        "um",
        1e6,
        {
            "published, polynomial state space": (12.0, np.nan),
            "published, another": (18.7, np.nan),
            "published, a third": (45.0, np.nan),
            "published, a fourth": (163.0, np.nan),
        },
        "J. P. Noel and M. Schoukens, Hysteretic benchmark with a dynamic nonlinearity, Workshop "
        "on Nonlinear System Identification Benchmarks (2016), 7",
    ),
)
