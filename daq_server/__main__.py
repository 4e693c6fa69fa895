"""``python -m daq_server``: a DAQ to try the driver on, until Ctrl-C."""

from __future__ import annotations

import signal
from enum import Enum
from typing import Annotated

import typer

from daq_server import MODELS, Board, DaqServer
from tissue_probe.configuration import stock_configuration
from tissue_probe.devices.calibration import Calibration

ModelName = Enum("ModelName", {name: name for name in MODELS}, type=str)


def main(
    model: Annotated[ModelName, typer.Option(help="Which DAQ.")] = ModelName["x-series"],
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port; 0 for any.")] = 31763,
    stiffness: Annotated[float, typer.Option(min=0.0, help="Of the tissue [N/m].")] = 450.0,
    damping: Annotated[float, typer.Option(min=0.0, help="Of the tissue [N s/m].")] = 5.0,
) -> None:
    """Serve a simulated probe behind a DAQ, as NI's gRPC device server would."""
    calibration = Calibration.load(stock_configuration("calibration.yaml"))
    board = Board(MODELS[model.value], calibration, stiffness, damping)
    # Waited for, not raised: so it ends here, whatever code is under way.
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    with DaqServer(board, port) as server:
        typer.echo(f"{board.model.product} as Dev1 at {server.address}; Ctrl-C ends it")
        signal.sigwait({signal.SIGINT})


if __name__ == "__main__":
    typer.run(main)
