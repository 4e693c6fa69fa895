"""The model under test: its equations, values to begin with, and the rig's tolerances.

Contents: that model, from the settings, and which models cannot be tested.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tissue_probe.devices.calibration import Calibration
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.monitoring.settings import MonitorSettings
from tissue_probe.physics.composition import Composition
from tissue_probe.quantities import POSITION, SIDE
from tissue_probe.settings import SettingsError

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect


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
    """Return the model that the settings name; its kernel is compiled where it is first wanted.

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
    return TestedModel(composition, values, Instrument(rig, constants, free_touch=True))


@dataclass(frozen=True)
class TestedModelToCompile:
    """The question to a process that compiles a model under test, of plain values.

    Attributes
    ----------
    settings : MonitorSettings
        They name the model.
    """

    settings: MonitorSettings

    #: pytest takes classes of this name for tests.
    __test__ = False

    def read(self) -> Callable[[], None]:
        """Compose the model; return a function that compiles it.

        Raises
        ------
        TissueProbeError, OSError
            As ``load_tested_model``.
        """
        composition = load_tested_model(self.settings).composition

        def compile_model() -> None:
            _ = composition.kernel

        return compile_model


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
        if _has_instant(effect):
            raise SettingsError(
                f"{path}: {effect.name} begins at an instant of the recording that it was fitted "
                "to, and each window has a clock of its own: fit the model without it"
            )
        if effect.of_part:
            raise SettingsError(
                f"{path}: {effect.name} is of the parts of one recording: fit the model without it"
            )


def _has_instant(effect: Effect) -> bool:
    """Whether an effect's law is another one from a time of its recording on.

    Other effects that follow the clock are found anew in each window, by a search along
    derivatives, which tell nothing of an instant that is farther away than a window is long.
    """
    import sympy as sp  # which takes half a second: only where there is a model file

    from tissue_probe.physics.effects.effect import TIME

    laws = (effect.force, effect.contact, effect.drag, effect.inertia, effect.output)
    laws = (*laws, *effect.surface, *(state.motion for state in effect.states))
    sides = [side for switch in effect.switches for side in (switch.on, switch.off)]
    conditions = [each for law in laws for each in sp.sympify(law).atoms(sp.core.relational.Rel)]
    return any(sp.sympify(each).has(TIME) for each in (*sides, *conditions))
