"""What kinds of DAQ there are: their abilities as NI-DAQmx tells them."""

from __future__ import annotations

from dataclasses import dataclass

from nidaqmx.constants import UsageTypeCI


@dataclass(frozen=True)
class Model:
    """Abilities of a DAQ.

    Attributes
    ----------
    product : str
        Name of the product.
    input_rate, output_rate : float
        Fastest clocked input and output [Hz].
    counts : tuple of UsageTypeCI
        What its counters measure.
    has_watchdog : bool
        Whether it ends its outputs by itself when it is no longer fed.
    digital_time : float
        Time that an unclocked digital operation takes [s].
    """

    product: str
    input_rate: float
    output_rate: float
    counts: tuple[UsageTypeCI, ...]
    has_watchdog: bool
    digital_time: float


#: The paper's. One USB 2.0 full-speed frame for an operation on its static lines.
USB_6002 = Model("USB-6002", 50e3, 5e3, (UsageTypeCI.COUNT_EDGES,), False, 1e-3)
#: A multifunction card with quadrature counters, without a watchdog for outputs.
X_SERIES = Model(
    "PCIe-6321",
    250e3,
    900e3,
    (UsageTypeCI.COUNT_EDGES, UsageTypeCI.POSITION_LINEAR_ENCODER),
    False,
    2e-5,
)
#: A chassis with counters and a watchdog for the outputs of its modules.
CDAQ = Model(
    "cDAQ-9189",
    100e3,
    100e3,
    (UsageTypeCI.COUNT_EDGES, UsageTypeCI.POSITION_LINEAR_ENCODER),
    True,
    2e-4,
)

MODELS = {"usb-6002": USB_6002, "x-series": X_SERIES, "cdaq": CDAQ}
