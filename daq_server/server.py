"""The server: a board behind a socket."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import grpc
from nidaqmx._stubs.nidaqmx_pb2_grpc import add_NiDAQmxServicer_to_server

from daq_server.board import Board
from daq_server.service import Service


class DaqServer:
    """Serves a board on this host; a context manager that dies at its end.

    Parameters
    ----------
    board : Board
        The hardware; it goes on when the server dies, as hardware does.
    port : int
        The port; 0 for any free one.

    Attributes
    ----------
    address : str
        What the driver's parameter ``nidaqmx.server`` takes.
    """

    def __init__(self, board: Board, port: int = 0) -> None:
        self.board = board
        # Each request under way holds a thread; a driver has few.
        self._server = grpc.server(ThreadPoolExecutor(16, thread_name_prefix="daq"))
        add_NiDAQmxServicer_to_server(Service(board), self._server)
        self.address = f"127.0.0.1:{self._server.add_insecure_port(f'127.0.0.1:{port}')}"
        self._server.start()

    def die(self) -> None:
        """Break off every connection at once."""
        self._server.stop(grace=None).wait()

    def __enter__(self) -> DaqServer:
        return self

    def __exit__(self, *exception: object) -> None:
        self.board.faults.clear()
        self.die()

    @property
    def coil_voltage(self) -> float:
        """Voltage on the coil now [V]."""
        with self.board.lock:
            self.board.catch_up()
            return self.board.coil_voltage
