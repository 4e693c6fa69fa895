"""Compile what many tests use, once: processes that meet a kernel at the same time each compile it.

``make test`` runs it first. Tests that live in real time then find their kernels on disk, whatever
runs beside them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from multiprocessing import get_context

import numpy as np

#: As many as CI has cores.
PROCESSES = 2


def fit() -> None:
    """A model that is linear, and one with a switch."""
    import tissue_probe as tp

    time = np.arange(1000) / 1000.0
    position = 1e-3 * np.sin(60.0 * time)
    force = 450.0 * position + 5.0 * np.gradient(position, time)
    tp.compare({"t": time, "u": position, "F": force}, rig="compliant_probe").plus("contact_loss")


def pressed() -> None:
    """The contact of a robot, and one that is lost."""
    import tissue_probe as tp

    time = np.arange(500) / 250.0
    position = 2e-3 + 1e-3 * np.sin(15.0 * time)
    force = 1000.0 * np.maximum(position - 1.5e-3, 0.0)
    force += 0.02 * np.random.default_rng(0).standard_normal(time.size)
    table = {"t": time, "u": position, "F": force}
    tp.identify_contact(tp.read(table, force_polarity="compression"), delay=0.0)


def mapped() -> None:
    """The map of a scan."""
    import tissue_probe as tp

    x, y = (each.ravel() for each in np.meshgrid(np.arange(5) / 100.0, np.arange(5) / 100.0))
    k = 450.0 + 9.0 * np.random.default_rng(1).standard_normal(x.size)
    k[12] = 900.0
    tp.map({"x": x, "y": y, "k": k, "k_sd": 0.01 * k})


def simulated() -> None:
    """The simulated probe."""
    from tissue_probe.devices.simulated import SimulatedProbe
    from tissue_probe.devices.simulated_settings import SimulatedProbeSettings

    SimulatedProbe(SimulatedProbeSettings())


def estimated(name: str) -> None:
    """The stock filter of a name."""
    from tissue_probe.estimation import Estimator, EstimatorSettings
    from tissue_probe.signals import SampleBlock

    samples = np.zeros(100)
    block = SampleBlock(0, 0, 5e-4, samples, samples, samples)
    Estimator(name, EstimatorSettings()).process(block)


def challenged() -> None:
    """The simulator of the challenge."""
    from tissue_probe.challenge import make_challenge

    make_challenge(1, ("contact_loss",), "sine10")


def jobs() -> list[Callable[[], None]]:
    """The longest first, so that no process ends long after the other."""
    from tissue_probe.estimation import ESTIMATORS

    return [
        mapped,
        fit,
        pressed,
        challenged,
        simulated,
        *(partial(estimated, name) for name in ESTIMATORS),
    ]


def do(job: Callable[[], None]) -> None:
    job()


if __name__ == "__main__":
    # The compiler itself takes seconds to be loaded: once in each process.
    with get_context("spawn").Pool(PROCESSES) as pool:
        pool.map(do, jobs(), chunksize=1)
