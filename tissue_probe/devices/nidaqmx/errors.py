"""NI-DAQmx's errors as one sentence with the remedy."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import grpc
from nidaqmx.error_codes import DAQmxErrors as Code
from nidaqmx.errors import DaqError, DaqNotFoundError, DaqNotSupportedError, Error, RpcError

from tissue_probe.devices.device import DeviceError

_LOST = "samples were not fetched in time and are lost: this machine or the network is too busy"
_GONE = "the DAQ is gone: check its cable and power, then configure again"
_RESERVED = "another program uses the same channels: end it, or reset the DAQ"
_NO_CHANNEL = "the DAQ has no such channel: check the names in the nidaqmx parameters"
_DRY = "the output ran dry, since the driver could not feed it in time: the machine is too busy"

_SENTENCES = {
    Code.SAMPLES_NO_LONGER_AVAILABLE: _LOST,
    Code.INPUT_FIFO_OVERFLOW_2: _LOST,
    Code.DEV_CANNOT_BE_ACCESSED: _GONE,
    Code.DRIVER_DEVICE_GUID_NOT_FOUND_ROUTING: _GONE,
    Code.INVALID_DEVICE_ID: "there is no DAQ of this name: check nidaqmx.device",
    Code.PHYSICAL_CHAN_DOES_NOT_EXIST: _NO_CHANNEL,
    Code.PAL_RESOURCE_RESERVED: _RESERVED,
    Code.SAMPLES_NOT_YET_AVAILABLE: "no samples came in time: the DAQ's sample clock stands still",
    Code.GEN_STOPPED_TO_PREVENT_REGEN_OF_OLD_SAMPLES: _DRY,
    Code.OUTPUT_FIFO_UNDERFLOW_2: _DRY,
}

_NO_SERVER = (
    "the gRPC device server does not answer: is it running, and at the address nidaqmx.server?"
)

_RPC_SENTENCES = {
    grpc.StatusCode.UNAVAILABLE: _NO_SERVER,
    grpc.StatusCode.CANCELLED: _NO_SERVER,  # it died while it worked on the request
    grpc.StatusCode.DEADLINE_EXCEEDED: "the gRPC device server did not answer in time: it or the "
    "DAQ stalled",
}


@contextmanager
def convert_errors(doing: str) -> Iterator[None]:
    """Turn errors of ``nidaqmx`` into DeviceError, whose message begins with ``doing``."""
    try:
        yield
    except (Error, ValueError) as error:  # ValueError: grpc's error of a closed channel
        raise DeviceError(f"{doing}: {_sentence(error)}") from None


def _sentence(error: Exception) -> str:
    if isinstance(error, DaqError):
        said = _SENTENCES.get(error.error_type) or str(error).partition("\n")[0].rstrip(".")
        return f"{said} (NI-DAQmx {error.error_code})"
    if isinstance(error, RpcError):
        return (
            _RPC_SENTENCES.get(error.rpc_code)
            or f"the gRPC device server failed: {error.description}"
        )
    if isinstance(error, (DaqNotFoundError, DaqNotSupportedError)):
        return (
            "the driver NI-DAQmx is not installed on this machine: install it, or give "
            "nidaqmx.server, the address of a machine that has it"
        )
    return str(error).partition("\n")[0]
