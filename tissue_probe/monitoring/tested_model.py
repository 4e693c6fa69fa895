"""The model under test: its equations, values to begin with, and the rig's tolerances.

Contents: that model, from the settings, and which models cannot be tested.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from tissue_probe.devices.calibration import Calibration
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.monitoring.settings import MonitorSettings
from tissue_probe.physics.composition import Composition
from tissue_probe.quantities import POSITION, SIDE
from tissue_probe.settings import SettingsError


@dataclass(frozen=True)
class TestedModel:
    """A model whose residual is tested.

    Attributes
    ----------
    composition : Composition
        Rig, tissue and effects.
    values : mapping of float
        Of its parameters, to begin the first search with (SI); typical ones where there are none.
    instrument : Instrument
        The rig's constants with their tolerances; the tip may touch anywhere.
    """

    composition: Composition
    values: Mapping[str, float]
    instrument: Instrument

    #: pytest takes classes of this name for tests.
    __test__ = False


def load_tested_model(settings: MonitorSettings) -> TestedModel:
    """Return the model that the settings name, compiled.

    Every parameter of tissue and effects is searched for anew in each window, so the values of a
    model file only begin the search: a window is rejected where no values explain it.

    Raises
    ------
    SettingsError
        If the model cannot be tested while it runs.
    ModelFileError, EffectError, OSError
        If a file cannot be used.
    """
    composition = Composition(settings.rig)
    values: Mapping[str, float] = {}
    if settings.model:
        from tissue_probe.physics.model_file import load

        fitted = load(settings.model, settings.effects)
        composition, values = fitted.composition, fitted.values
        _refuse(settings.model, composition)
    rig = composition.rig
    constants = rig.known
    if settings.calibration_file:
        constants = _apply_calibration(rig.known, _load_calibration(settings.calibration_file))
    elif settings.model:
        constants = {
            name: (values.get(name, value), deviation)
            for name, (value, deviation) in rig.known.items()
        }
    _ = composition.kernel
    return TestedModel(composition, values, Instrument(rig, constants, free_touch=True))


def _load_calibration(path: str) -> Calibration:
    try:
        return Calibration.load(path)
    except ValueError as error:
        raise SettingsError(f"calibration_file: {error}") from None


def _apply_calibration(
    known: Mapping[str, tuple[float, float]], calibration: Calibration
) -> dict[str, tuple[float, float]]:
    """Return a rig's constants as a calibration has them, with its own errors where it tells them.

    A value that was not measured is the nominal one, as far off as the rig says.
    """
    found = dict(known)
    for name, (nominal, deviation) in known.items():
        value = getattr(calibration, name, nominal)
        if name in calibration.intervals:
            low, high = calibration.intervals[name]
            deviation = (high - low) / (2.0 * SIDE)
        found[name] = value, deviation
    return found


def _refuse(path: str, composition: Composition) -> None:
    """Refuse a model with something that a window of its own time cannot be tested for."""
    if composition.input is not POSITION:
        raise SettingsError(
            f"{path}: in its rig {composition.rig} a force drives, and live samples are of a "
            "position that drives: test it on recordings, with `tissue_probe compare`"
        )
    for effect in composition.all_effects:
        if effect.hears_input2:
            raise SettingsError(
                f"{path}: {effect.name} follows a second input, which no live samples have: fit "
                "the model without it"
            )
        if effect.of_part:
            raise SettingsError(
                f"{path}: {effect.name} is of the parts of one recording: fit the model without it"
            )
