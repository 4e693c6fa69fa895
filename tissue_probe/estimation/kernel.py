"""A compiled estimator, as the stream sees it, and how the Kalman filters' are come by."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from tissue_probe.estimation.considered_constants import list_considered, may_touch_elsewhere
from tissue_probe.estimation.layout import StateLayout
from tissue_probe.estimation.settings import EstimatorSettings
from tissue_probe.physics import code_cache, machine_code, numba_code
from tissue_probe.physics.machine_code import MachineCode, Text
from tissue_probe.physics.rigs import RIGS, Live
from tissue_probe.settings import SettingsError

FloatArray = NDArray[np.float64]


#: Names of the facts that a kernel's module holds of itself.
FACTS = ("STATE_NAMES", "EXTRA", "MEMORY")
#: The model of a filter that is given no model file.
PLAIN = "kelvin_voigt"


@dataclass(frozen=True)
class Plan:
    """All of a kernel but its machine code: plain values, to pass between processes.

    Attributes
    ----------
    code : str
        Name under which the machine code is on disk.
    layout : Layout
        Where the numbers live.
    is_kalman : bool
        Whether the numbers are a mean and a covariance.
    tool : mapping of float
        Settings that the kernel replaces: the tool of a model file, with its encoder.
    delay : float
        Time by which the force is late against the position [s]; negative where the position is.
    moved : str
        The position that moves the tip, in words of the model; empty where it is the sample's.
    model : str
        Short name of the model: its tissue and effects, and of a file a digest of its content.
    content : str
        Content of the model file.
    """

    code: str
    layout: StateLayout
    is_kalman: bool = True
    tool: Mapping[str, float] = field(default_factory=dict)
    delay: float = 0.0
    moved: str = ""
    model: str = PLAIN
    content: str = ""


@dataclass(frozen=True)
class Kernel:
    """Functions on two arrays: ``constants``, fixed for a stream, and ``memory``, carried along.

    Attributes
    ----------
    plan : Plan
        What the numbers in the arrays mean.
    code : MachineCode
        Has the entries ``start_on``, ``reopen_on`` and ``run_on`` (see ``entries``).
    """

    plan: Plan
    code: MachineCode

    @property
    def size(self) -> int:
        """Length of ``memory``."""
        return int(self.code.facts["MEMORY"])

    def constants(self, settings: EstimatorSettings, sample_period: float) -> FloatArray:
        """Return ``constants`` for given settings and sample period [s]."""
        settings = settings.model_copy(update=dict(self.plan.tool))
        return self.plan.layout.constants(settings, sample_period)


def find_kernel(plan: Plan) -> Kernel:
    """Return the kernel that another process has compiled.

    Raises
    ------
    SettingsError
        If its machine code is not on disk.
    """
    return Kernel(plan, machine_code.load(plan.code, _refuse_to_write))


def _refuse_to_write() -> Text:
    raise SettingsError(
        "the compiled filter is not on the disk any more: is the folder of the cache being emptied "
        "(TISSUE_PROBE_CACHE)? Set the model again"
    )


@dataclass(frozen=True)
class Draft:
    """A kernel before it is compiled.

    Attributes
    ----------
    plan : Plan
        What the numbers in its arrays mean.
    compile : callable
        Returns its machine code, found on disk where an earlier process has compiled it.
    """

    plan: Plan
    compile: Callable[[], MachineCode]

    def kernel(self) -> Kernel:
        """Return the kernel, compiled."""
        return Kernel(self.plan, self.compile())


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
        return self.draft(settings).kernel()

    def draft(self, settings: EstimatorSettings) -> Draft:
        """Return the kernel before it is compiled.

        Raises
        ------
        SettingsError
            If the model file of the settings cannot be used, or cannot run live.
        """
        if settings.model:
            return self._composed(settings)
        how, windowed = settings.discretisation, RIGS[settings.rig].live is Live.windows
        roughly, offset = list_considered(settings), self._has_offset(settings)
        name = f"{self._name}_rigid" if windowed else f"{self._name}_{how}"
        name += self._tolerances(roughly, offset)
        code = _code(name, lambda: self._source(settings.rig, how, roughly, offset))
        states, extra = tuple(code.facts["STATE_NAMES"]), code.facts["EXTRA"]
        layout = StateLayout(states, extra, windowed=windowed, considered=roughly)
        return Draft(Plan(name, layout), lambda: code)

    def _composed(self, settings: EstimatorSettings) -> Draft:
        """Return the kernel for the model in a file, before it is compiled."""
        from tissue_probe.estimation.generate import source
        from tissue_probe.estimation.live_model import live_model

        roughly, offset = list_considered(settings), self._has_offset(settings)
        live = live_model(settings, offset)
        layout = replace(live.layout(self.equations.EXTRA), considered=roughly)
        name = f"{self._name}_{settings.discretisation}_{live.digest}"
        name += self._tolerances(roughly, offset)
        plan = Plan(
            name,
            layout,
            tool=live.tool(settings),
            delay=live.delay,
            moved=live.moved,
            model=live.name,
            content=live.content,
        )
        how, equations = settings.discretisation, self.equations
        return Draft(plan, lambda: _code(name, lambda: source(live.model, how, layout, equations)))

    def _has_offset(self, settings: EstimatorSettings) -> bool:
        """Whether a constant force is a state: a place of contact that is off shifts the force."""
        return self.force_offset or may_touch_elsewhere(settings)

    def _tolerances(self, roughly: tuple[str, ...], offset: bool) -> str:
        """Return the part of the code's name that says what is known roughly."""
        told = "_tolerant" if roughly else ""
        return told + ("_touch" if offset and not self.force_offset else "")

    @property
    def _name(self) -> str:
        return self.equations.__name__.rpartition(".")[2]

    def _source(self, rig: str, discretisation: str, roughly: tuple[str, ...], offset: bool) -> str:
        # SymPy is imported only where a kernel has to be generated: it takes half a second.
        from tissue_probe.estimation.generate import WINDOW_SUMS, source

        model = RIGS[rig].compose(force_offset=offset)
        states = tuple(map(str, [*model.states, *model.parameters]))
        windowed = not model.states  # the force follows the input's derivatives at once
        extra = {**self.equations.EXTRA, **(WINDOW_SUMS if windowed else {})}
        layout = StateLayout(states, extra, windowed=windowed, considered=roughly)
        return source(model, discretisation, layout, self.equations)


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
        """Return the compiled kernel, as ``draft``."""
        return self.draft(settings).kernel()

    def draft(self, settings: EstimatorSettings) -> Draft:
        """Return the kernel before it is compiled; how steps are discretised does not matter.

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
        layout = StateLayout(("tip_position", "tip_velocity", "stiffness", "damping"))
        # A rigid probe's load cell yields nothing: the limit.
        stiff = {"load_cell_stiffness": math.inf, "load_cell_damping": 0.0}
        led = RIGS[settings.rig].tip_is_position
        plan = Plan(self.path.stem, layout, is_kalman=False, tool=stiff if led else {})
        return Draft(plan, lambda: _code(self.path.stem, lambda: self._source(layout)))

    def _source(self, layout: StateLayout) -> str:
        from tissue_probe.estimation.generate import source_by_hand

        return source_by_hand(layout, self.path)


def _code(name: str, write: Callable[[], str]) -> MachineCode:
    return machine_code.load(name, lambda: numba_code.text(code_cache.module(name, write), FACTS))
