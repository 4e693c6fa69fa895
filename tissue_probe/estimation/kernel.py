"""A compiled estimator, as the stream sees it, and how the Kalman filters' are come by."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from tissue_probe.estimation.considered import considered
from tissue_probe.estimation.layout import Layout
from tissue_probe.estimation.settings import EstimatorSettings
from tissue_probe.physics import code_cache, machine_code, numba_code
from tissue_probe.physics.machine_code import MachineCode
from tissue_probe.physics.rigs import RIGS, Live
from tissue_probe.physics.rigs.constants import CONTACT_POSITION
from tissue_probe.settings import SettingsError

FloatArray = NDArray[np.float64]


#: Names of the facts that a kernel's module holds of itself.
FACTS = ("STATE_NAMES", "EXTRA", "MEMORY")


@dataclass(frozen=True)
class Kernel:
    """Functions on two arrays: ``constants``, fixed for a stream, and ``memory``, carried along.

    Attributes
    ----------
    constants : callable
        (settings, sample period [s]) -> ``constants``.
    code : MachineCode
        Has the entries ``start_on``, ``reopen_on`` and ``run_on`` (see ``entries``).
    layout : Layout
        Where the numbers of a Kalman filter live; None for an estimator by hand.
    delay : float
        Time by which the force is late against the position [s]; negative where the position is.
    """

    constants: Callable[[EstimatorSettings, float], FloatArray]
    code: MachineCode
    layout: Layout | None = None
    delay: float = 0.0

    @property
    def size(self) -> int:
        """Length of ``memory``."""
        return int(self.code.facts["MEMORY"])


@dataclass(frozen=True)
class KalmanFilter:
    """Definition of an estimator by its equations.

    Attributes
    ----------
    equations : module
        Has ``predict(filter)`` and ``update(filter)``, which write equations in symbols; ``weigh``,
        which is Numba's Python; and ``EXTRA``, further numbers that the filter keeps.
    force_offset : bool
        Whether a constant force is estimated too.
    """

    equations: ModuleType
    force_offset: bool = False

    @property
    def summary(self) -> str:
        """The estimator in one line."""
        return (self.equations.__doc__ or "").splitlines()[0]

    def kernel(self, settings: EstimatorSettings) -> Kernel:
        """Return the compiled kernel, generated the first time that it is wanted."""
        if settings.model:
            return self._composed(settings)
        how, windowed = settings.discretisation, RIGS[settings.rig].live is Live.windows
        roughly = considered(settings, self.force_offset)
        name = f"{self._name}_rigid" if windowed else f"{self._name}_{how}"
        name += "_tolerant" if roughly else ""
        code = _code(name, lambda: self._source(settings.rig, how, roughly))
        states, extra = tuple(code.facts["STATE_NAMES"]), code.facts["EXTRA"]
        layout = Layout(states, extra, _known(roughly), windowed=windowed, considered=roughly)
        return Kernel(layout.constants, code, layout)

    def _composed(self, settings: EstimatorSettings) -> Kernel:
        """Return the kernel for the model in a file."""
        from tissue_probe.estimation.generate import source
        from tissue_probe.estimation.live_model import live_model

        live = live_model(settings, self.force_offset)
        roughly = considered(settings, self.force_offset)
        layout = replace(live.layout(self.equations.EXTRA), considered=roughly)
        code = _code(
            f"{self._name}_{settings.discretisation}_{live.digest}"
            + ("_tolerant" if roughly else ""),
            lambda: source(live.model, settings.discretisation, layout, self.equations),
        )

        def constants(settings: EstimatorSettings, sample_period: float) -> FloatArray:
            return layout.constants(live.with_tool(settings), sample_period)

        return Kernel(constants, code, layout, live.delay)

    @property
    def _name(self) -> str:
        return self.equations.__name__.rpartition(".")[2]

    def _source(self, rig: str, discretisation: str, roughly: tuple[str, ...]) -> str:
        # SymPy is imported only where a kernel has to be generated: it takes half a second.
        from tissue_probe.estimation.generate import WINDOW_SUMS, source

        model = RIGS[rig].compose(
            contact_position=CONTACT_POSITION.name in roughly, force_offset=self.force_offset
        )
        states = tuple(map(str, [*model.states, *model.parameters]))
        windowed = not model.states  # the force follows the input's derivatives at once
        extra = {**self.equations.EXTRA, **(WINDOW_SUMS if windowed else {})}
        layout = Layout(states, extra, _known(roughly), windowed=windowed, considered=roughly)
        return source(model, discretisation, layout, self.equations)


def _known(roughly: tuple[str, ...]) -> dict[str, float]:
    """Return the constants that no setting tells: the tip touches at 0, give or take."""
    return {CONTACT_POSITION.name: 0.0} if CONTACT_POSITION.name in roughly else {}


@dataclass(frozen=True)
class ByHand:
    """Definition of an estimator by the text of a file, which is Numba's Python.

    Attributes
    ----------
    path : Path
        Has ``start``, ``reopen``, ``run`` and ``MEMORY``, the length of their memory.
    """

    path: Path

    @property
    def summary(self) -> str:
        """The estimator in one line."""
        return (ast.get_docstring(ast.parse(self.path.read_text())) or "").splitlines()[0]

    def kernel(self, settings: EstimatorSettings) -> Kernel:
        """Return the compiled kernel; how steps are discretised makes no difference to it.

        Raises
        ------
        SettingsError
            If a model file is set: the equations in the file are Kelvin-Voigt's.
        """
        if settings.model:
            raise SettingsError(
                f"model is {settings.model!r}, but {self.path.stem} knows Kelvin-Voigt tissue "
                "only: choose a Kalman filter such as robust_ekf, or leave model empty"
            )
        layout = Layout(("tip_position", "tip_velocity", "stiffness", "damping"))

        def constants(settings: EstimatorSettings, sample_period: float) -> FloatArray:
            return layout.constants(_stiff(settings), sample_period)

        return Kernel(constants, _code(self.path.stem, lambda: self._source(layout)))

    def _source(self, layout: Layout) -> str:
        from tissue_probe.estimation.generate import source_by_hand

        return source_by_hand(layout, self.path)


def _stiff(settings: EstimatorSettings) -> EstimatorSettings:
    """Return a rigid probe's settings as those of a load cell that yields nothing: the limit."""
    if not RIGS[settings.rig].tip_is_position:
        return settings
    stiff = {"load_cell_stiffness": math.inf, "load_cell_damping": 0.0}
    return settings.model_copy(update=stiff)


def _code(name: str, write: Callable[[], str]) -> MachineCode:
    return machine_code.load(name, lambda: numba_code.text(code_cache.module(name, write), FACTS))
