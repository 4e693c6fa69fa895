"""The driver on a DAQ, which is there only as its vendor's protocol, for as long as one likes.

Contents: that no sample is lost between the DAQ's clock and the recording, how fast its digital
lines are read, and what is found where the position comes over them.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import yaml

from benchmarks import suite
from benchmarks.live import measure_usage
from daq_server import USB_6002, X_SERIES, Board, DaqServer
from tissue_probe.configuration import stock_configuration
from tissue_probe.devices.calibration import Calibration
from tissue_probe.devices.nidaqmx.connection import Connection
from tissue_probe.devices.nidaqmx.decoder import Chip
from tissue_probe.devices.nidaqmx.settings import NiDaqmxSettings
from tissue_probe.estimation import Estimator, EstimatorSettings
from tissue_probe.nodes.session import NodeProcess, Session
from tissue_probe.recording.bags.reader import iterate_raw, read_recording
from tissue_probe.signals import NANOSECONDS

SAMPLES_TOPIC = "/probe/samples"
#: Stiffness [N/m] and damping [N s/m] under the probe on the paper's own DAQ.
SLOW_TISSUE = (620.0, 6.0)
#: Longest run of it [s].
LONGEST_SLOW_RUN = 10.0


def measure(
    folder: Path, seconds: float, say: Callable[[str], None] = print, readings: int = 500
) -> dict[str, object]:
    """Return what was counted of a run of the driver on the DAQ.

    Parameters
    ----------
    folder : path
        Gets ``daq.mcap``, the recording.
    seconds : float
        Duration of the run [s].
    say : callable
        Told what is under way.
    readings : int
        How many readings of the decoder are timed.

    Raises
    ------
    SessionError
        If a process ends or does not answer.
    """
    bag = folder / "daq.mcap"
    bag.unlink(missing_ok=True)
    board = Board(X_SERIES, Calibration.load(stock_configuration("calibration.yaml")))
    with DaqServer(board) as server:
        say(f"daq: the driver on a {board.model.product} at {server.address}, {seconds:g} s")
        on_daq = {"device": "nidaqmx", "nidaqmx.server": server.address}
        processes = [
            NodeProcess("driver", "driver", parameters=on_daq),
            NodeProcess("recorder", "recorder", parameters={"output": str(bag.absolute())}),
        ]
        with Session(processes) as session:
            session.activate({"/probe/driver": 1})
            begin = time.monotonic()
            pids = {"driver": session.processes["driver"].pid}
            usage = measure_usage(pids, partial(suite.spend, session), seconds)
            duration = time.monotonic() - begin
            session.deactivate()
            suite.spend(session, suite.LAST_WORDS)
            published = int(session.health["/probe/driver"]["samples published"])
    say("daq: the decoder on static lines")
    counted = count(bag, published)
    return {
        "seconds": duration,
        "published": published,
        **counted,
        **usage,
        "decoder": time_decoder(readings),
        "slow": first_stiffness(folder, min(seconds, LONGEST_SLOW_RUN)),
    }


def first_stiffness(folder: Path, seconds: float) -> dict[str, float]:
    """Return what ``robust_ekf`` finds with the paper's own DAQ and the stock file for it.

    Stiffness [N/m] and damping [N s/m] after ``seconds`` of contact, with standard deviations.
    """
    bag = folder / "usb6002.mcap"
    bag.unlink(missing_ok=True)
    parameters = stock_configuration("usb6002.yaml")
    board = Board(USB_6002, Calibration.load(stock_configuration("calibration.yaml")), *SLOW_TISSUE)
    with DaqServer(board) as server:
        processes = [
            NodeProcess("driver", "driver", parameters={"nidaqmx.server": server.address}),
            NodeProcess("recorder", "recorder", parameters={"output": str(bag.absolute())}),
        ]
        with Session(processes, parameters) as session:
            session.activate({"/probe/driver": 1})
            suite.spend(session, seconds)
            session.deactivate()
    named = yaml.safe_load(parameters.read_text())["/**/robust_ekf"]["ros__parameters"]
    estimator = Estimator("robust_ekf", EstimatorSettings(**named))
    (run,) = read_recording(bag).blocks
    found = estimator.process(run)
    return {
        "stiffness": float(found.stiffness[-1]),
        "stiffness_sd": float(found.stiffness_variance[-1] ** 0.5),
        "damping": float(found.damping[-1]),
        "damping_sd": float(found.damping_variance[-1] ** 0.5),
    }


def time_decoder(readings: int) -> dict[str, float]:
    """Return how long readings of an HCTL-2032 over a USB-6002's static lines take [s]."""
    settings = NiDaqmxSettings(encoder="hctl2032")
    with DaqServer(
        Board(USB_6002, Calibration.load(stock_configuration("calibration.yaml")))
    ) as on:
        connection = Connection(on.address, settings.timeout)
        chip = Chip(connection, settings)
        times = [chip.time_reading() for _ in range(readings)]
        chip.close()
        connection.close()
    median, high = np.percentile(times, (50, 99))
    return {"operation": USB_6002.digital_time, "median": float(median), "p99": float(high)}


def count(bag: Path, published: int) -> dict[str, float]:
    """Return how many samples a recording holds, how many it lacks, and how many came a second."""
    runs = read_recording(bag).blocks  # one, if nothing is missing
    recorded = sum(len(run) for run in runs)
    times = [message.publish_time for message in iterate_raw(bag, [SAMPLES_TOPIC])]
    elapsed = (times[-1] - times[0]) / NANOSECONDS
    return {
        "samples": recorded,
        "lost": max(published, runs[-1].sequence + len(runs[-1])) - recorded,
        "rate": recorded * (1.0 - 1.0 / len(times)) / elapsed,
    }


def sentence(counted: dict[str, object]) -> str:
    """Say what was counted and timed."""
    decoder, slow = counted["decoder"], counted["slow"]
    cores = counted["cpu_cores"]["driver"]
    return (
        f"{counted['seconds']:.0f} s on the DAQ: {counted['samples']} samples, {counted['lost']} "
        f"lost, {counted['rate']:.3f} a second; the driver kept {cores:.2f} cores busy\n"
        f"HCTL-2032 over static lines, {1e3 * decoder['operation']:g} ms an operation: a reading "
        f"takes {1e3 * decoder['median']:.1f} ms (median), {1e3 * decoder['p99']:.1f} ms (99 %), "
        f"so {1.0 / decoder['median']:.0f} a second at the most\n"
        f"USB-6002 with it, config/usb6002.yaml: stiffness {slow['stiffness']:.1f} ± "
        f"{slow['stiffness_sd']:.1f} N/m where it is {SLOW_TISSUE[0]:g}, damping "
        f"{slow['damping']:.2f} ± {slow['damping_sd']:.2f} N s/m where it is {SLOW_TISSUE[1]:g}, "
        "no delay taken out"
    )
