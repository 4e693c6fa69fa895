"""A DAQ that exists only as its vendor's protocol, with a simulated probe behind its channels.

A client cannot tell it from NI's gRPC device server: it speaks the services that the package
``nidaqmx`` ships. Tests and benchmarks run the driver against it; ``python -m daq_server`` starts
it for anyone else. The package ``tissue_probe`` knows nothing of it.
"""

from daq_server.board import Board
from daq_server.models import CDAQ, MODELS, USB_6002, X_SERIES, Model
from daq_server.server import DaqServer
from daq_server.stepped import Stepped

__all__ = ["CDAQ", "MODELS", "USB_6002", "X_SERIES", "Board", "DaqServer", "Model", "Stepped"]
