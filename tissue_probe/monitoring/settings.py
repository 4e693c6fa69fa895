"""The settings of the monitor: which model is tested, on which windows, how often in vain.

Contents: these.
"""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import BaseModel, ConfigDict, model_validator

from tissue_probe.physics.rigs import OWN, RIGS
from tissue_probe.quantities import POSITION
from tissue_probe.settings import setting

#: Seconds in an hour.
HOUR = 3600.0
#: Names of the rigs that the monitor tests: the position drives, as in all live samples.
TESTED = [rig.name for rig in RIGS.values() if rig.input is POSITION]


class TestedModelSettings(BaseModel):
    """Which model is tested, on which instrument."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    # Pydantic takes a choice that is computed; mypy has no words for it.
    rig: Literal[tuple(TESTED)] = setting(  # type: ignore[valid-type]
        OWN.name, "", "how the instrument couples to the tissue; a model file names its own"
    )
    model: str = setting(
        "", "", "model file (model.yaml) that is tested; empty for Kelvin-Voigt tissue on the rig"
    )
    effects: list[str] = setting(
        [], "", "Python files with effects of your own that the model file needs; they are run"
    )
    calibration_file: str = setting(
        "", "", "calibration of the instrument; empty for the rig's nominal constants"
    )

    #: pytest takes classes of this name for tests.
    __test__: ClassVar[bool] = False


class MonitorSettings(TestedModelSettings):
    """Which model is tested, on which windows, and how often it may be rejected in vain."""

    window: float = setting(
        1.5, "s", "samples that are tested together; detection takes one or two", ge=0.3, le=20.0
    )
    step: float = setting(
        0.75, "s", "time between the begins of two windows; at most the window", ge=0.1, le=20.0
    )
    band: float = setting(
        60.0,
        "Hz",
        "residuals up to here are tested, at most up to half of what the samples can tell: what is "
        "above tells the noise. Choose the fastest motion of the drive",
        ge=1.0,
        le=1000.0,
    )
    false_alarms: float = setting(
        0.1, "1/h", "how often a right model may be rejected, by chance", ge=1e-6, le=60.0
    )
    kept: float = setting(
        4.0, "s", "last samples that a diagnosis gets; at least the window", ge=0.5, le=60.0
    )

    @model_validator(mode="after")
    def _go_together(self) -> MonitorSettings:
        if self.step > self.window:
            raise ValueError(
                f"step is {self.step:g} s and window {self.window:g} s: samples between two "
                "windows would not be tested; give a step of at most the window"
            )
        if self.kept < self.window:
            raise ValueError(
                f"kept is {self.kept:g} s and window {self.window:g} s: give kept at least the "
                "window"
            )
        return self

    @property
    def chance(self) -> float:
        """The chance at which a right model is rejected on one window.

        Windows that overlap are told apart as if they did not: alarms in vain are fewer then.
        """
        return self.false_alarms * self.step / HOUR
