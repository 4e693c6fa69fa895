"""``python -m daq_server``: a DAQ to try the driver on, until Ctrl-C."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from enum import Enum
from typing import Annotated

import typer

from daq_server import MODELS, Board, DaqServer
from tissue_probe.configuration import stock_configuration
from tissue_probe.devices.calibration import Calibration

ModelName = Enum("ModelName", {name: name for name in MODELS}, type=str)

#: The driver as a program; signals that this one waits for are blocked in what it starts.
DRIVER = """
import signal
signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT, signal.SIGTERM})
from tissue_probe.nodes.driver import main
raise SystemExit(main())
"""


def main(
    model: Annotated[ModelName, typer.Option(help="Which DAQ.")] = ModelName["x-series"],
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port; 0 for any.")] = 31763,
    stiffness: Annotated[float, typer.Option(min=0.0, help="Of the tissue [N/m].")] = 450.0,
    damping: Annotated[float, typer.Option(min=0.0, help="Of the tissue [N s/m].")] = 5.0,
    drive: Annotated[
        bool, typer.Option("--drive", help="Run the driver on it, too; its log tells the rate.")
    ] = False,
) -> None:
    """Serve a simulated probe behind a DAQ, as NI's gRPC device server would."""
    calibration = Calibration.load(stock_configuration("calibration.yaml"))
    board = Board(MODELS[model.value], calibration, stiffness, damping)
    # Waited for, not raised: so it ends here, whatever code is under way.
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    with DaqServer(board, port) as server:
        typer.echo(f"{board.model.product} as Dev1 at {server.address}; Ctrl-C ends it")
        with driver_on(server.address) if drive else nullcontext():
            signal.sigwait({signal.SIGINT, signal.SIGTERM})


@contextmanager
def driver_on(address: str) -> Iterator[None]:
    """Run the driver on a DAQ behind this address, configured and activated by itself."""
    parameters = ("device:=nidaqmx", f"nidaqmx.server:={address}", "autostart:=true")
    command = [sys.executable, "-c", DRIVER, "--ros-args", "-r", "__ns:=/probe"]
    for each in parameters:
        command += ["-p", each]
    # Of its own group: Ctrl-C comes here, and ends it in order.
    process = subprocess.Popen(command, start_new_session=True)
    try:
        yield
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(timeout=20.0)


if __name__ == "__main__":
    typer.run(main)
