"""The way to NI-DAQmx: the driver on this machine, or an NI gRPC Device Server."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, NamedTuple

import grpc
import nidaqmx
import nidaqmx.system
from nidaqmx.grpc_session_options import GrpcSessionOptions
from nidaqmx.system.watchdog import WatchdogTask


class _Details(NamedTuple):
    method: str
    timeout: float | None
    metadata: Any
    credentials: Any
    wait_for_ready: bool | None
    compression: Any


class _CallDetails(_Details, grpc.ClientCallDetails):  # type: ignore[misc]  # gRPC has no types
    """The details that gRPC asks an interceptor to hand on."""


class _Deadline(grpc.UnaryUnaryClientInterceptor):  # type: ignore[misc]  # gRPC has no types
    """Gives every request a deadline: ``nidaqmx`` itself would wait for an answer for ever."""

    def __init__(self, timeout: float) -> None:
        self._timeout = timeout

    def intercept_unary_unary(
        self, continuation: Callable[..., Any], details: grpc.ClientCallDetails, request: Any
    ) -> Any:
        # A read or write may itself wait for its own timeout first.
        timeout = self._timeout + max(0.0, getattr(request, "timeout", 0.0))
        given: dict[str, Any] = {name: getattr(details, name, None) for name in _Details._fields}
        return continuation(_CallDetails(**given | {"timeout": timeout}), request)


class Connection:
    """Makes the objects on the DAQ.

    Parameters
    ----------
    server : str
        Host and port of the gRPC server; empty for this machine.
    timeout : float
        Longest time for the server to answer a request [s].
    clock : callable
        The time [s] by which requests are placed.

    Attributes
    ----------
    clock : callable
        That clock.
    """

    def __init__(
        self, server: str, timeout: float, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.clock = clock
        self._channel: grpc.Channel | None = None
        self._options: GrpcSessionOptions | None = None
        if server:
            self._channel = grpc.insecure_channel(server)
            deadlined = grpc.intercept_channel(self._channel, _Deadline(timeout))
            self._options = GrpcSessionOptions(deadlined, session_name="")

    def task(self) -> nidaqmx.Task:
        """Make an empty task."""
        return nidaqmx.Task(grpc_options=self._options)

    def device(self, name: str) -> nidaqmx.system.Device:
        """Return the DAQ of that name."""
        return nidaqmx.system.Device(name, grpc_options=self._options)

    def watchdog(self, device: str, timeout: float) -> WatchdogTask:
        """Make the DAQ's watchdog, to expire after ``timeout`` [s]."""
        return WatchdogTask(device, timeout=timeout, grpc_options=self._options)

    def close(self) -> None:
        """Hang up; the objects on the DAQ must be closed before."""
        if self._channel is not None:
            self._channel.close()
