"""Recordings of a laboratory, as tables on disk: specimens, each measured several times.

The motion is that of ``benchmarks.estimators_simulator``, which shares nothing with the package.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
from pyarrow.csv import write_csv

from benchmarks.estimators_simulator import Experiment


@dataclass(frozen=True)
class Laboratory:
    """Specimens whose stiffness spreads [N/m], and the recordings of each.

    ``seconds`` is the time of one recording, ``noise`` that of its force [N].
    """

    specimens: int
    repeats: int
    seconds: float = 2.0
    noise: float = 5e-3
    middle: float = 400.0
    between: float = 60.0
    within: float = 4.0
    damping: float = 5.0

    def write(self, folder: Path, seed: int) -> dict[str, float]:
        """Leave ``SPECIMEN_REPEAT.csv`` of each recording; return the true stiffness of each."""
        folder.mkdir(parents=True)
        random = np.random.default_rng(seed)
        of = self.middle + self.between * random.standard_normal(self.specimens)
        truths = {}
        for specimen, repeat in np.ndindex(self.specimens, self.repeats):
            k = float(of[specimen] + self.within * random.standard_normal())
            experiment = Experiment(
                tissue=((0.0, k, self.damping),),
                duration=self.seconds,
                phase=float(random.uniform(0.0, 2.0 * np.pi)),
                steady=True,
                force_noise=self.noise,
                seed=int(random.integers(2**32)),
            )
            u, f = experiment.run()
            t = experiment.sample_period * np.arange(u.size)
            path = folder / f"{specimen:04d}_{repeat}.csv"
            write_csv(pa.table({"t": t, "u": u, "F": f}), path)
            truths[path.name] = k
        return truths


#: How its tables are asked about: ``fitted`` where a model is fitted, too.
ASKED = {"force_polarity": "compression"}
FITTED = {**ASKED, "rig": "compliant_probe"}
PATTERN = "{specimen}_{repeat}.csv"
