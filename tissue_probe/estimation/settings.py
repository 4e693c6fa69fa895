"""The settings of an estimator: one flat class, read by the nodes and the command line."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from tissue_probe.physics.rigs import OWN, RIGS, FilteredRig, name_rigs


def _setting(
    default: Any,
    unit: str,
    description: str,
    *,
    gt: float | None = None,
    ge: float | None = None,
    lt: float | None = None,
    le: float | None = None,
) -> Any:
    return Field(
        default=default,
        description=description,
        json_schema_extra={"unit": unit},
        gt=gt,
        ge=ge,
        lt=lt,
        le=le,
    )


def _tolerance(name: str, of: str) -> Any:
    """Return the setting of how far a constant of this suite's own rig may be off."""
    return _setting(
        0.0,
        "",
        f"Standard deviation of {of} as a share of it; 0: exact; this rig: "
        f"{OWN_TOLERANCES[name]:g} (Kalman filters)",
        ge=0,
        # Within four standard deviations a constant keeps its sign.
        le=0.25,
    )


def _own_tolerances() -> dict[str, float]:
    """Return the tolerances of this suite's own rig: shares, and of the touch a length [m]."""
    shares = {name: sd / value if value else sd for name, (value, sd) in OWN.known.items()}
    return {name: round(share, 12) for name, share in shares.items()}


OWN_TOLERANCES = _own_tolerances()
#: Names of the rigs whose samples filters take.

#: Fastest rate of the tip's motion that the exact step follows [1/s]. Then it divides a second of
#: samples into a million parts, for which a filter on sigma points needs about that second.
FASTEST = 3e5
#: How many standard deviations from its mean a sigma point tries the tissue.
REACH = 3.0
#: Settings that say which model a filter runs.
OF_MODEL = ("model", "effects")
#: Settings that tell how far constants of the rig may be off.
TOLERANCES = tuple(f"{constant.name}_tol" for constant in OWN.constants)


class EstimatorSettings(BaseModel):
    """Instrument, noise and prior knowledge that the estimators work with.

    The defaults are the paper's instrument (section IV) and priors wide enough for any soft tissue:
    one configuration for every experiment.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    tip_mass: float = _setting(
        0.04, "kg", "Moving mass m between load cell and tissue", ge=0, le=10
    )
    load_cell_stiffness: float = _setting(
        9700.0, "N/m", "Stiffness k0 of the load cell between coil and tip", ge=1e-3, le=1e8
    )
    load_cell_damping: float = _setting(
        0.8, "N s/m", "Damping beta0 of the load cell between coil and tip", ge=0, le=1e4
    )
    tip_mass_tol: float = _tolerance("tip_mass", "the moving mass")
    load_cell_stiffness_tol: float = _tolerance("load_cell_stiffness", "the load cell's stiffness")
    load_cell_damping_tol: float = _tolerance("load_cell_damping", "the load cell's damping")
    contact_position_tol: float = _setting(
        0.0,
        "m",
        "Standard deviation of the position at which the tip touches; 0: exact; this rig: "
        f"{OWN_TOLERANCES['contact_position']:g} (Kalman filters, which estimate a constant force "
        "then)",
        ge=0,
        le=1e-3,
    )
    force_noise: float = _setting(
        0.005, "N", "Standard deviation of the noise on the force", ge=1e-9, le=100
    )
    encoder_resolution: float = _setting(
        1e-7,
        "m",
        "Step of the encoder, or 3.5 times the noise of the position; it adds noise to the "
        "predicted force",
        ge=0,
        le=1e-3,
    )
    rig: FilteredRig = _setting(
        OWN.name,
        "",
        "How the coil moves the tip: through a load cell that yields, or rigidly, so that the "
        "position is the tip's (then load_cell_* and velocity_noise mean nothing)",
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
        1000.0, "N/m", "Standard deviation of the stiffness assumed before", ge=1e-6, le=1e6
    )
    damping_prior: float = _setting(
        0.0, "N s/m", "Damping assumed before the first sample", ge=-1e4, le=1e4
    )
    damping_prior_sd: float = _setting(
        20.0, "N s/m", "Standard deviation of the damping assumed before", ge=1e-8, le=1e4
    )
    tip_position_prior_sd: float = _setting(
        0.01,
        "m",
        "Standard deviation of the tip's position before the first sample",
        ge=1e-12,
        le=10,
    )
    tip_velocity_prior_sd: float = _setting(
        1.0,
        "m/s",
        "Standard deviation of the tip's velocity before the first sample",
        ge=1e-9,
        le=100,
    )
    force_offset_prior_sd: float = _setting(
        0.1,
        "N",
        "Standard deviation of the load cell's constant error (filters with a force offset)",
        ge=1e-9,
        le=1e3,
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
    effects: tuple[str, ...] = _setting(
        (), "", "Python files with the effects of your own that the model file needs; they are run"
    )
    estimate_effects: bool = _setting(
        False, "", "Whether the strengths of the model's effects are estimated too, not held"
    )
    drive_frequency: float = _setting(
        10.0, "Hz", "Frequency at which the coil is driven (lock_in only)", ge=1e-3, le=1000
    )
    forgetting: float = _setting(
        0.98, "", "Weight of a sample relative to the next (rls only)", gt=0.5, lt=1
    )

    @model_validator(mode="after")
    def _can_be_filtered(self) -> EstimatorSettings:
        """Refuse a prior outside the bounds, and a tip too fast for any filter to follow."""
        for name in ("stiffness", "damping"):
            prior, unit = getattr(self, f"{name}_prior"), self.unit(f"{name}_prior")
            low, high = getattr(self, f"{name}_minimum"), getattr(self, f"{name}_maximum")
            if not low <= prior <= high:
                raise ValueError(
                    f"{name}_prior is {prior:g} {unit}, outside of {name}_minimum, {low:g}, to "
                    f"{name}_maximum, {high:g} {unit}: estimates are held within these"
                )
        if not RIGS[self.rig].tip_is_position and self.tip_mass == 0.0:
            led = name_rigs(lambda rig: rig.tip_is_position)
            raise ValueError(f"tip_mass is 0 kg; only the tip of rig {led} may have no mass")
        if too_fast := self.too_fast():
            raise ValueError(too_fast)
        return self

    def exact(self) -> EstimatorSettings:
        """Return the same settings, all constants of the rig taken as known exactly."""
        return self.model_copy(update=dict.fromkeys(TOLERANCES, 0.0))

    def tolerant(self) -> EstimatorSettings:
        """Return the same settings, the constants known within the rig's tolerances."""
        return self.model_copy(
            update={f"{name}_tol": OWN_TOLERANCES[name] for name in OWN_TOLERANCES}
        )

    @classmethod
    def unit(cls, name: str) -> str:
        """Return the unit of a setting."""
        extra = cls.model_fields[name].json_schema_extra
        return str(extra["unit"]) if isinstance(extra, dict) else ""

    def too_fast(self) -> str:
        """Say why the exact step cannot follow the tip; nothing where it can.

        The tip on its load cell and the stiffest tissue that a filter may try moves at the rates
        sqrt(k / m) and beta / m. Forward Euler does not try to follow, and a rigid probe's moves as
        it is led.
        """
        if self.discretisation == "euler" or RIGS[self.rig].tip_is_position:
            return ""
        parts = {name: self._parts(name) for name in ("stiffness", "damping")}
        rates = {name: sum(part.values()) / self.tip_mass for name, part in parts.items()}
        rates["stiffness"] **= 0.5
        name = max(rates, key=rates.__getitem__)
        if rates[name] <= FASTEST:
            return ""
        largest = max(parts[name], key=parts[name].__getitem__)
        return (
            f"tip_mass is {self.tip_mass:g} kg and {largest} {getattr(self, largest):g} "
            f"{self.unit(largest)}: the tip would move at {rates[name]:.2g} 1/s, and no filter "
            f"follows more than {FASTEST:g} 1/s: give a greater tip_mass or a smaller {largest}"
        )

    def _parts(self, name: str) -> dict[str, float]:
        """Return the terms of the largest stiffness or damping that acts on the tip."""
        bounds = {bound: getattr(self, bound) for bound in (f"{name}_minimum", f"{name}_maximum")}
        bound = max(bounds, key=lambda each: abs(bounds[each]))
        deviation = f"{name}_prior_sd"
        return {
            f"load_cell_{name}": getattr(self, f"load_cell_{name}"),
            bound: abs(bounds[bound]),
            deviation: REACH * getattr(self, deviation),
        }
