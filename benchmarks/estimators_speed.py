"""What a sample costs: the compiled kernels against plain C, filterpy and calls from Python.

    python benchmarks/estimators_speed.py [--json speed.json]

All in one run, the same samples and the same work; minimum of the repetitions, in microseconds of
the thread's own CPU time, since the machine may be shared.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parent))

from estimators_simulator import Experiment

from tissue_probe.estimation import ESTIMATORS, Estimator, EstimatorSettings
from tissue_probe.estimation.layout import force_variance
from tissue_probe.signals import SampleBlock

HERE = Path(__file__).parent
SETTINGS = EstimatorSettings()
EULER = EstimatorSettings(discretisation="euler")
PERIOD = 5e-4
DOUBLES = ctypes.POINTER(ctypes.c_double)


def cpu_time(work: Callable[[], object], repetitions: int = 25) -> float:
    """Return the least CPU time of the thread that one call took [us]."""
    times = []
    for _ in range(repetitions):
        begin = time.thread_time_ns()
        work()
        times.append(time.thread_time_ns() - begin)
    return min(times) / 1e3


def kernel_time(
    name: str, position: np.ndarray, force: np.ndarray, settings: EstimatorSettings = SETTINGS
) -> float:
    """Return the time of a sample in a whole recording [us]."""
    kernel = ESTIMATORS[name].kernel(settings)
    constants, memory = kernel.constants(settings, PERIOD), np.zeros(kernel.size)
    estimates = np.empty((11, position.size))

    def work() -> None:
        kernel.start(constants, memory)
        kernel.run(constants, memory, position, force, estimates, 0, position.size)

    return cpu_time(work) / position.size


def call_time(name: str, position: np.ndarray, force: np.ndarray) -> float:
    """Return the time of one call from Python for one sample [us]."""
    kernel = ESTIMATORS[name].kernel(SETTINGS)
    constants, memory = kernel.constants(SETTINGS, PERIOD), np.zeros(kernel.size)
    kernel.start(constants, memory)
    estimates, run, count = np.empty((11, position.size)), kernel.run, 2000

    def work() -> None:
        for sample in range(count):
            run(constants, memory, position, force, estimates, sample, sample + 1)

    return cpu_time(work, 10) / count


def block_time(name: str, position: np.ndarray, force: np.ndarray) -> float:
    """Return the time of ``process`` for a live block of ten samples [us]."""
    blocks = [
        SampleBlock(i * 500_000, i, PERIOD, *(s[i : i + 10] for s in (position, force, force)))
        for i in range(0, 4000, 10)
    ]

    def work() -> None:
        estimator = Estimator(name, SETTINGS)
        for block in blocks:
            estimator.process(block)

    return cpu_time(work, 10) / len(blocks)


def c_library(*flags: str) -> ctypes.CDLL:
    """Compile the C version with gcc."""
    library = Path(tempfile.mkdtemp()) / "filters.so"
    source = HERE / "c" / "filters.c"
    command = ["gcc", "-O3", *flags, "-shared", "-fPIC", str(source), "-o", str(library), "-lm"]
    subprocess.run(command, check=True)
    return ctypes.CDLL(str(library))


def c_time(function: ctypes._CFuncPtr, position: np.ndarray, force: np.ndarray) -> float:
    """Return the time of a sample in C [us], after checking that it filters."""
    s = SETTINGS
    constants = np.array(
        [s.tip_mass, s.load_cell_stiffness, s.load_cell_damping, PERIOD, force_variance(s),
         s.velocity_noise]
    )  # fmt: skip
    deviations = [
        s.tip_position_prior_sd, s.tip_velocity_prior_sd, s.stiffness_prior_sd, s.damping_prior_sd,
        s.force_offset_prior_sd,
    ]  # fmt: skip
    variances = np.square(deviations)
    k, b = np.empty(position.size), np.empty(position.size)
    arrays = [a.ctypes.data_as(DOUBLES) for a in (position, force, constants, variances, k, b)]
    arguments = [*arrays[:2], ctypes.c_long(position.size), *arrays[2:]]
    elapsed = cpu_time(lambda: function(*arguments)) / position.size
    reference = Estimator("ekf", SETTINGS).process(
        SampleBlock(0, 0, PERIOD, position, force, force)
    )
    if abs(k[-1] / reference.stiffness[-1] - 1) > 1e-3:
        raise SystemExit(
            f"the C filter ends at {k[-1]} N/m, the package's at {reference.stiffness[-1]}"
        )
    return elapsed


def filterpy_time(position: np.ndarray, force: np.ndarray, unscented: bool) -> float:
    """Return the time of a sample in filterpy, with the Euler model in NumPy [us]."""
    from filterpy.kalman import ExtendedKalmanFilter, MerweScaledSigmaPoints, UnscentedKalmanFilter

    m, k0, b0, dt = 0.04, 9700.0, 0.8, PERIOD

    def advance(x: np.ndarray, _dt: float, u: float, du: float) -> np.ndarray:
        a = (k0 * (u - x[0]) + b0 * (du - x[1]) - x[2] * x[0] - x[3] * x[1]) / m
        return np.array([x[0] + dt * x[1], x[1] + dt * a, x[2], x[3]])

    if unscented:
        points = MerweScaledSigmaPoints(4, 1.0, 0.0, -1.0)
        filter = UnscentedKalmanFilter(4, 1, dt, lambda x, u: k0 * (u - x[:1]), advance, points)
    else:
        filter = ExtendedKalmanFilter(4, 1)
    filter.x = np.zeros(4)
    filter.P = np.diag([1e-4, 1.0, 1e6, 400.0])
    filter.R, filter.Q = np.array([[2.5e-5]]), np.diag([0, 1e-8, 0, 0])
    H = np.array([[-k0, 0, 0, 0]])
    rates = np.diff(position, prepend=0.0) / dt

    def work() -> None:
        for u, du, f in zip(position, rates, force, strict=True):
            if unscented:
                filter.predict(u=u, du=du)
                filter.update(np.array([f]), u=u)
            else:
                x = filter.x
                F = np.eye(4)
                F[0, 1] = dt
                F[1] = [
                    -dt * (k0 + x[2]) / m,
                    1 - dt * (b0 + x[3]) / m,
                    -dt * x[0] / m,
                    -dt * x[1] / m,
                ]
                filter.F = F
                filter.x = advance(x, dt, u, du)
                filter.P = F @ filter.P @ F.T + filter.Q
                filter.update(np.array([f]), lambda _: H, lambda y, u=u: k0 * (u - y[:1]))

    return cpu_time(work, 3) / position.size


def fresh_process_time() -> float:
    """Return the wall time from nothing to the first estimate, kernels on disk [s]."""
    text = (
        "import numpy as np; from tissue_probe.estimation import *;"
        "from tissue_probe.signals import SampleBlock; a = np.zeros(10);"
        "Estimator('robust_ekf', EstimatorSettings()).process(SampleBlock(0, 0, 5e-4, a, a, a))"
    )
    environment = os.environ | {"PYTHONPATH": str(HERE.parent)}
    times = []
    for _ in range(4):
        begin = time.perf_counter()
        subprocess.run([sys.executable, "-c", text], check=True, env=environment)
        times.append(time.perf_counter() - begin)
    return min(times)


def main() -> None:
    """Print the table; keep it as JSON where asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, help="also write the numbers to this file")
    options = parser.parse_args()
    position, force = Experiment(duration=4.0).run()
    numbers: dict[str, float] = {}
    for name in ESTIMATORS:
        numbers[f"{name}: batch, per sample [us]"] = kernel_time(name, position, force)
    for name in ESTIMATORS:
        numbers[f"{name}: one sample per call from Python [us]"] = call_time(name, position, force)
    numbers["robust_ekf: process() of a block of 10 [us]"] = block_time(
        "robust_ekf", position, force
    )
    for title, flags in {"-O3": (), "-O3 -march=native": ("-march=native",)}.items():
        library = c_library(*flags)
        for name in ("ekf", "ekf_offset", "ukf"):
            key = f"C {title}, {name}: per sample [us]"
            numbers[key] = c_time(getattr(library, name), position, force)
    numbers["filterpy EKF, Euler: per sample [us]"] = filterpy_time(
        position[:400], force[:400], False
    )
    numbers["filterpy UKF, Euler: per sample [us]"] = filterpy_time(
        position[:400], force[:400], True
    )
    for kind, ours, c in (("EKF", "ekf", "ekf"), ("EKF with offset", "robust_ekf", "ekf_offset"),
                          ("UKF", "ukf", "ukf")):  # fmt: skip
        own = numbers[f"{ours}: batch, per sample [us]"]
        for title in ("-O3", "-O3 -march=native"):
            numbers[f"{kind}: times C {title}"] = own / numbers[f"C {title}, {c}: per sample [us]"]
        if kind != "EKF with offset":
            other = numbers[f"filterpy {kind}, Euler: per sample [us]"]
            euler = kernel_time(ours, position, force, EULER)
            numbers[f"{kind}, Euler: batch, per sample [us]"] = euler
            numbers[f"{kind}, Euler: times faster than filterpy"] = other / euler
            numbers[f"{kind}, exact: times faster than filterpy's Euler"] = other / own
    numbers["first estimate in a fresh process, warm cache [s]"] = fresh_process_time()
    double = Experiment(duration=16.0).run()
    numbers["robust_ekf: cost of a sample, 4 times as many samples [ratio]"] = (
        kernel_time("robust_ekf", *double) / numbers["robust_ekf: batch, per sample [us]"]
    )
    for title, value in numbers.items():
        print(f"{title:65} {value:8.3f}")
    if options.json:
        options.json.write_text(json.dumps(numbers, indent=1))


if __name__ == "__main__":
    main()
