"""Constants of the simulated probe; apart from it, since every driver declares them."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

from tissue_probe.settings import setting


class SimulatedProbeSettings(BaseModel):
    """Constants of the simulated probe; the tool's are the paper's (section IV-A).

    The coil's are nominal values of a moving-coil actuator of 25 mm by 38 mm with its carriage.
    The paper's coil runs on plain bearings; the suspension keeps this one in place in free air.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    sample_rate: float = setting(
        2000.0,
        "Hz",
        "samples a second of the simulated DAQ, to the nearest period in whole nanoseconds",
        ge=500.0,
        le=10000.0,
    )
    tip_mass: float = setting(0.04, "kg", "mass m of the tip", gt=0.0, le=1.0)
    load_cell_stiffness: float = setting(9700.0, "N/m", "stiffness k0", gt=0.0, le=1e6)
    load_cell_damping: float = setting(0.8, "N s/m", "damping beta0", ge=0.0, le=100.0)
    coil_mass: float = setting(0.08, "kg", "mass of coil and carriage", gt=0.0, le=10.0)
    coil_resistance: float = setting(3.6, "ohm", "resistance of the coil", gt=0.0, le=100.0)
    coil_inductance: float = setting(0.001, "H", "inductance of the coil", ge=1e-4, le=0.1)
    force_constant: float = setting(4.5, "N/A", "force for each ampere", gt=0.0, le=100.0)
    bearing_damping: float = setting(0.5, "N s/m", "damping of the bearings", ge=0.0, le=100.0)
    suspension_stiffness: float = setting(
        800.0, "N/m", "stiffness that centres the coil", ge=0.0, le=1e5
    )
    encoder_resolution: float = setting(1e-7, "m", "step of the encoder", ge=0.0, le=1e-4)
    force_noise: float = setting(
        0.005, "N", "standard deviation of the load cell's white noise", ge=0.0, le=10.0
    )
    force_zero: float = setting(
        0.0, "N", "reading of the load cell without load", ge=-10.0, le=10.0
    )
    seed: int = setting(0, "", "seed of the noise", ge=0)
    phantom: str = setting(
        "",
        "",
        "YAML file of the phantom, or table (.csv) of the stiffness felt at points x, y [m]: "
        "k [N/m], perhaps the surface's height z [m] and beta [N s/m]; empty for the stock one",
    )
    model: str = setting(
        "",
        "",
        "model file (model.yaml) of tool and tissue; the phantom then tells only how much stiffer "
        "a place is than the background; empty for Kelvin-Voigt tissue",
    )
    effects: list[str] = setting(
        [], "", "Python files with the effects of your own that the model file needs; they are run"
    )
