"""How the probe is wired to the DAQ, and how the DAQ is reached."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, model_validator

from tissue_probe.settings import setting


class NiDaqmxSettings(BaseModel):
    """Names as NI-DAQmx writes them, without the device: ``ai0``, not ``Dev1/ai0``."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    server: str = setting(
        "", "", "host:port of an NI gRPC Device Server; empty for a DAQ on this machine"
    )
    device: str = setting("Dev1", "", "name of the DAQ in NI MAX or NI Hardware Configuration")
    sample_rate: float = setting(
        2000.0,
        "Hz",
        "samples a second, rounded to a rate that the DAQ's clock can divide",
        ge=1.0,
        le=10000.0,
    )
    force_channel: str = setting("ai0", "", "analog input of the load cell's amplifier")
    force_terminals: Literal["rse", "nrse", "differential"] = setting(
        "rse", "", "reference of the amplifier's output"
    )
    force_low: float = setting(
        -10.0, "V", "lowest voltage that the load cell's amplifier gives", ge=-10.0, le=9.9
    )
    force_high: float = setting(10.0, "V", "highest voltage that it gives", ge=-9.9, le=10.0)
    coil_channel: str = setting("ao0", "", "analog output to the coil's amplifier")
    encoder: Literal["counter", "hctl2032", "hctl2032_interpolated"] = setting(
        "counter",
        "",
        "counter of the encoder: the DAQ's quadrature counter; an HCTL-2032, read for every "
        "sample, or as often as it can be, the position between readings interpolated",
    )
    counter: str = setting("ctr0", "", "counter that the encoder's A and B are wired to")
    decoder_data: str = setting(
        "port0/line0:7", "", "digital lines at D0 to D7 of the HCTL-2032, in this order"
    )
    decoder_control: str = setting(
        "port1/line0:2", "", "digital lines at OE, SEL1 and SEL2 of the HCTL-2032, in this order"
    )
    expiry: float = setting(
        0.5,
        "s",
        "how long the coil is driven on after the driver died, at least",
        ge=0.05,
        le=5.0,
    )
    timeout: float = setting(
        1.0, "s", "longest time for the DAQ to answer a request", gt=0.0, le=60.0
    )

    @model_validator(mode="after")
    def _span(self) -> NiDaqmxSettings:
        if self.force_low >= self.force_high:
            raise ValueError(
                f"force_low is {self.force_low:g} V: give one below force_high, "
                f"{self.force_high:g} V"
            )
        return self
