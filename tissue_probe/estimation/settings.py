"""What a user may set on an estimator: one flat class, read by the nodes and the command line."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field


def _setting(default: Any, unit: str, description: str, **bounds: float) -> Any:
    return Field(default, description=description, json_schema_extra={"unit": unit}, **bounds)


class EstimatorSettings(BaseModel):
    """Instrument, noise and prior knowledge that the estimators work with.

    The defaults are the paper's instrument (section IV) and priors wide enough for any soft tissue:
    one configuration for every experiment.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    tip_mass: float = _setting(
        0.04, "kg", "Moving mass m between load cell and tissue", gt=0, le=10
    )
    load_cell_stiffness: float = _setting(
        9700.0, "N/m", "Stiffness k0 of the load cell between coil and tip", gt=0, le=1e8
    )
    load_cell_damping: float = _setting(
        0.8, "N s/m", "Damping beta0 of the load cell between coil and tip", ge=0, le=1e4
    )
    force_noise: float = _setting(
        0.005, "N", "Standard deviation of the noise on the force", gt=0, le=100
    )
    encoder_resolution: float = _setting(
        1e-7,
        "m",
        "Step of the encoder; its rounding adds noise to the predicted force",
        ge=0,
        le=1e-3,
    )
    discretisation: Literal["exact", "euler"] = _setting(
        "exact", "", "Step from sample to sample: exact, or the paper's forward Euler"
    )
    velocity_noise: float = _setting(
        1e-9,
        "m^2/s^2",
        "Variance added to the tip velocity in each sample (the paper, section V-A, has 1e-8)",
        ge=0,
        le=1,
    )
    fading: float = _setting(
        1.003, "", "Growth of the covariance in each sample, alpha (afekf only)", ge=1, le=1.2
    )
    stiffness_prior: float = _setting(
        0.0, "N/m", "Stiffness assumed before the first sample", ge=-1e6, le=1e6
    )
    stiffness_prior_sd: float = _setting(
        1000.0, "N/m", "Standard deviation of the stiffness assumed before", gt=0, le=1e6
    )
    damping_prior: float = _setting(
        0.0, "N s/m", "Damping assumed before the first sample", ge=-1e4, le=1e4
    )
    damping_prior_sd: float = _setting(
        20.0, "N s/m", "Standard deviation of the damping assumed before", gt=0, le=1e4
    )
    tip_position_prior_sd: float = _setting(
        0.01, "m", "Standard deviation of the tip's position before the first sample", gt=0, le=10
    )
    tip_velocity_prior_sd: float = _setting(
        1.0, "m/s", "Standard deviation of the tip's velocity before the first sample", gt=0, le=100
    )
    force_offset_prior_sd: float = _setting(
        0.1, "N", "Standard deviation of the load cell's constant error (robust_ekf)", gt=0, le=1e3
    )
    deviation_ceiling: float = _setting(
        1.0, "", "How many times its prior a standard deviation may become", ge=1, le=1e6
    )
    stiffness_minimum: float = _setting(
        -2000.0, "N/m", "Estimates of the stiffness are held above", ge=-1e6, le=0
    )
    stiffness_maximum: float = _setting(
        30000.0, "N/m", "Estimates of the stiffness are held below", gt=0, le=1e6
    )
    damping_minimum: float = _setting(
        -20.0, "N s/m", "Estimates of the damping are held above", ge=-1e4, le=0
    )
    damping_maximum: float = _setting(
        500.0, "N s/m", "Estimates of the damping are held below", gt=0, le=1e4
    )
    contact_stiffness: float = _setting(
        20.0, "N/m", "A stiffness certainly below this means that there is no contact", ge=0, le=1e5
    )
    model: str = _setting(
        "",
        "",
        "Model file (model.yaml) whose effects and tool the Kalman filters take; empty for "
        "Kelvin-Voigt tissue and the tool's constants above",
    )
    effects: list[str] = _setting(
        [], "", "Python files with the effects of your own that the model file needs; they are run"
    )
    estimate_effects: bool = _setting(
        False, "", "Whether the strengths of the model's effects are estimated too, not held"
    )
    drive_frequency: float = _setting(
        10.0, "Hz", "Frequency at which the coil is driven (lock_in only)", gt=0, le=1000
    )
    forgetting: float = _setting(
        0.98, "", "Weight of a sample relative to the next (rls only)", gt=0.5, lt=1
    )
