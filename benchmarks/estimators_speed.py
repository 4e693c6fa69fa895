"""What a sample costs: the compiled kernels against plain C, filterpy and calls from Python.

All in one run, the same samples and the same work; minimum of the repetitions, in microseconds of
the thread's own CPU time, since the machine may be shared.
"""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.estimators_simulator import Experiment
from tissue_probe.estimation import ESTIMATORS, Estimator, EstimatorSettings
from tissue_probe.estimation.layout import force_variance
from tissue_probe.estimation.run import Run
from tissue_probe.signals import SampleBlock

HERE = Path(__file__).parent
SETTINGS = EstimatorSettings()
EULER = EstimatorSettings(discretisation="euler")
PERIOD = 5e-4
DOUBLES = ctypes.POINTER(ctypes.c_double)

BATCH = "batch, per sample [us]"
CALL = "one sample per call from Python [us]"
FASTER = "times faster than filterpy"
FRESH_PROCESS = "first estimate in a fresh process, warm cache [s]"
#: The functions of ``c/filters.c``, and the estimators that do the same.
C_FILTERS = {"ekf": "ekf", "ekf_offset": "robust_ekf", "ukf": "ukf"}
#: What is to be reached.
GOALS = {
    **{f"{name}: {BATCH}": "<=0.1" for name in ("ekf", "afekf", "robust_ekf")},
    **{f"{name}: {BATCH}": "<=0.25" for name in ("ukf", "afukf")},
    **{f"{name}: {CALL}": "<=1" for name in ESTIMATORS},
    **{f"{name}: times C -O3": "<=2" for name in C_FILTERS.values()},
    **{f"{name}, Euler: {FASTER}": ">=300" for name in ("ekf", "ukf")},
    FRESH_PROCESS: "<=0.7",
}


def cpu_time(work: Callable[[], object], repetitions: int = 25) -> float:
    """Return the least CPU time of the thread that one call took [us]."""
    times = []
    for _ in range(repetitions):
        begin = time.thread_time_ns()
        work()
        times.append(time.thread_time_ns() - begin)
    return min(times) / 1e3


def prepared(
    name: str, position: np.ndarray, force: np.ndarray, settings: EstimatorSettings = SETTINGS
) -> Run:
    """Return an estimator's kernel with these samples before it."""
    run = Run(ESTIMATORS[name].kernel(settings), settings, PERIOD)
    run.take(position, force, np.empty((11, position.size)))
    return run


def kernel_time(
    name: str, position: np.ndarray, force: np.ndarray, settings: EstimatorSettings = SETTINGS
) -> float:
    """Return the time of a sample in a whole recording [us]."""
    run = prepared(name, position, force, settings)

    def work() -> None:
        run.start()
        run.filter(0, position.size)

    return cpu_time(work) / position.size


def call_time(name: str, position: np.ndarray, force: np.ndarray) -> float:
    """Return the time of one call from Python for one sample [us]."""
    run, count = prepared(name, position, force).filter, 2000

    def work() -> None:
        for sample in range(count):
            run(sample, sample + 1)

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


def filterpy_time(position: np.ndarray, force: np.ndarray, *, unscented: bool) -> float:
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


def measure(say: Callable[[str], None] = print) -> dict[str, float]:
    """Return each time and each ratio by its name, which tells the unit.

    Parameters
    ----------
    say : callable
        Told what is under way.
    """
    say("speed: compiled kernels, C, filterpy")
    position, force = Experiment(duration=4.0).run()
    times = package_times(position, force) | other_times(position, force)
    return times | ratios(times) | {FRESH_PROCESS: fresh_process_time()}


def package_times(position: np.ndarray, force: np.ndarray) -> dict[str, float]:
    longer = Experiment(duration=16.0).run()
    return {
        **{f"{name}: {BATCH}": kernel_time(name, position, force) for name in ESTIMATORS},
        **{f"{name}: {CALL}": call_time(name, position, force) for name in ESTIMATORS},
        "robust_ekf: process() of a block of 10 [us]": block_time("robust_ekf", position, force),
        f"robust_ekf, 4 times as many samples: {BATCH}": kernel_time("robust_ekf", *longer),
        f"ekf, Euler: {BATCH}": kernel_time("ekf", position, force, EULER),
        f"ukf, Euler: {BATCH}": kernel_time("ukf", position, force, EULER),
    }


def other_times(position: np.ndarray, force: np.ndarray) -> dict[str, float]:
    few = position[:400], force[:400]
    times = {
        f"filterpy ekf, Euler: {BATCH}": filterpy_time(*few, unscented=False),
        f"filterpy ukf, Euler: {BATCH}": filterpy_time(*few, unscented=True),
    }
    for title, flags in {"-O3": (), "-O3 -march=native": ("-march=native",)}.items():
        library = c_library(*flags)
        for name in C_FILTERS:
            times[f"C {title}, {name}: {BATCH}"] = c_time(getattr(library, name), position, force)
    return times


def ratios(times: dict[str, float]) -> dict[str, float]:
    """Return how the package's times compare with the others'."""
    found = {}
    for c, ours in C_FILTERS.items():
        for title in ("-O3", "-O3 -march=native"):
            found[f"{ours}: times C {title}"] = (
                times[f"{ours}: {BATCH}"] / times[f"C {title}, {c}: {BATCH}"]
            )
    for name in ("ekf", "ukf"):
        theirs = times[f"filterpy {name}, Euler: {BATCH}"]
        found[f"{name}, Euler: {FASTER}"] = theirs / times[f"{name}, Euler: {BATCH}"]
        found[f"{name}, exact: {FASTER}'s Euler"] = theirs / times[f"{name}: {BATCH}"]
    return found
