"""A model file as a filter can run it: without memory of switches, its further numbers held.

Contents: which of a model's numbers a filter estimates, which it holds, their priors, and which
models cannot run live.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import sympy as sp

from tissue_probe.estimation.layout import Prior, StateLayout
from tissue_probe.estimation.settings import EstimatorSettings
from tissue_probe.physics.effects import Effect
from tissue_probe.physics.effects.effect import (
    DAMPING,
    ELASTIC_DEPTH,
    INDENTATION,
    POSITION,
    POSITION_BEFORE,
    POSITION_RATE,
    TIME,
    State,
)
from tissue_probe.physics.fitted_model import FittedModel
from tissue_probe.physics.model import Model
from tissue_probe.physics.model_file import load
from tissue_probe.physics.rigs import RIGS, Live, Rig, name_rigs
from tissue_probe.physics.tissues import TISSUES
from tissue_probe.settings import SettingsError

#: A phase is forgotten in this time [s]: mains and heart keep no exact frequency.
PHASE_TIME = 30.0
TOOL = ("tip_mass", "load_cell_stiffness", "load_cell_damping")


@dataclass(frozen=True)
class LiveModel:
    """The numbers and equations that a filter needs of a model file.

    Attributes
    ----------
    model : Model
        Its parameters are estimated; all its other numbers are among its constants.
    values : mapping of float
        Every constant and parameter of the file (SI).
    priors : mapping of Prior
        Of the states that the filter's settings do not know.
    name : str
        Short name: tissue, effects, and sixteen hexadecimal digits that stand for the content of
        the file and for the equations of its effects.
    content : str
        Content of the file.
    """

    model: Model
    values: Mapping[str, float]
    priors: Mapping[str, Prior]
    name: str
    content: str

    @cached_property
    def digest(self) -> str:
        """Sixteen hexadecimal digits that stand for the equations."""
        walks = [name for name, prior in self.priors.items() if prior.walk > 0.0]
        return _digits((self.model, walks))

    @property
    def moved(self) -> str:
        """The position that moves the tip, in words; empty where it is the sample's."""
        position = self.model.position
        if position == POSITION:
            return ""
        return str(position.subs({s: self.values.get(str(s), s) for s in position.free_symbols}))

    def layout(self, extra: Mapping[str, float]) -> StateLayout:
        """Return where the filter's numbers live; ``extra`` are the estimator's own."""
        model = self.model
        states = tuple(map(str, [*model.states, *model.parameters]))
        if any(expression.has(TIME) for expression in [*model.motion, model.output]):
            extra = {**extra, "SAMPLES": 0.0}
        if model.position.has(POSITION_BEFORE):
            extra = {**extra, "POSITION_BEFORE": 0.0}
        names = [str(symbol) for symbol in model.constants]
        known = {name: self.values[name] for name in names if name not in TOOL}
        return StateLayout(states, extra, known, self.priors)

    @property
    def delay(self) -> float:
        """Time by which the force is late against the position [s]."""
        return self._valued(self.model.delay)

    def tool(self, settings: EstimatorSettings) -> dict[str, float]:
        """Return the file's tool, and its encoder's steps where it tells them."""
        tool = {name: self.values[name] for name in TOOL}
        rounded = self._valued(self.model.rounded)
        return {**tool, "encoder_resolution": max(settings.encoder_resolution, rounded)}

    def _valued(self, expression: sp.Expr) -> float:
        expression = sp.sympify(expression)
        return float(expression.subs({s: self.values[str(s)] for s in expression.free_symbols}))


def live_model(settings: EstimatorSettings, force_offset: bool) -> LiveModel:
    """Read the model file that the settings name, and make a model of it that a filter can run.

    Stiffness, damping and (with ``force_offset``) a constant force are estimated; those of a fluid
    from the file's values on, since without damping it has no motion. The effects'
    parameters are held at the file's values; with ``estimate_effects`` their strengths are
    estimated, from the file's value give or take half of it. An effect that follows the clock (hum,
    drift, breathing) began at another phase in the file's recording: its strengths are always
    estimated.

    An effect that changes the tissue's stiffness at a time of that recording is left out: stiffness
    is estimated. Where a channel is late, the other is read as late, and the estimates are of then.

    A switch, such as contact, remembers nothing live: it is on where it would come on. So adhesion
    holds the tip only while it is in the tissue, as without it; friction that sticks creeps.

    Parameters
    ----------
    settings : EstimatorSettings
        ``model`` names the file, ``effects`` the Python files of effects that it needs.
    force_offset : bool
        Whether a constant force is estimated.

    Raises
    ------
    SettingsError
        If the file cannot be used, or holds something that cannot run live.
    """
    path = Path(settings.model)
    if not _runs_live(RIGS[settings.rig]):
        raise SettingsError(
            f"rig is {settings.rig}, but the filters take model files of {name_rigs(_runs_live)} "
            "only: leave model empty"
        )
    fitted = load(path, settings.effects)
    composition = fitted.composition
    for reason in _refusals(fitted):
        raise SettingsError(f"{path}: {reason}")
    effects = [_sampled(each) for each in composition.all_effects if not _is_followed(each)]
    # Effects that correct the position come before effects of the corrected position on the coil.
    effects.sort(key=lambda effect: effect.position.has(POSITION_BEFORE))
    tissue = TISSUES[composition.tissue]
    model = composition.rig.compose(effects, tissue, True, force_offset)
    priors = {str(state.symbol): _of_state(state, settings) for state in model.begin[2:]}
    if _flows(composition.tissue):
        priors |= {name: _about(fitted.values[name]) for name in ("stiffness", "damping")}
    for effect in effects:
        priors |= _strengths(effect, fitted.values, settings.estimate_effects)
    model = _memoryless(_estimating(model, priors))
    live = LiveModel(model, fitted.values, priors, _name(fitted), fitted.content)
    if too_fast := settings.model_copy(update=live.tool(settings)).too_fast():
        raise SettingsError(f"{path}: {too_fast}")
    return live


def _name(fitted: FittedModel) -> str:
    composition = fitted.composition
    parts = [composition.tissue, *(effect.name for effect in composition.effects)]
    return f"{'+'.join(parts)} {_digits((fitted.content, composition.model))}"


def _digits(content: object) -> str:
    """Return sixteen hexadecimal digits that stand for a content."""
    return hashlib.sha256(repr(content).encode()).hexdigest()[:16]


def _runs_live(rig: Rig) -> bool:
    return rig.live is Live.models


def _refusals(fitted: FittedModel) -> list[str]:
    """Name the effects that cannot run live, and why."""
    composition = fitted.composition
    if not _runs_live(composition.rig):
        return [
            f"the rig {composition.rig} cannot run live: model files of {name_rigs(_runs_live)} can"
        ]
    said: dict[str, Callable[[Effect], bool]] = {
        "it moves the coil, and does not say how from sample to sample (sampled)": lambda effect: (
            effect.coil != (POSITION, POSITION_RATE) and effect.sampled is None
        ),
        "it follows a second input, which no probe sends": lambda effect: effect.hears_input2,
        "it happens at a time of the recording that it was fitted to": lambda effect: any(
            sp.sympify(expression).has(TIME)
            for expression in (
                *(effect.force, effect.contact, effect.drag, effect.inertia, effect.position),
                *(state.motion for state in effect.states),
                *(side for switch in effect.switches for side in (switch.on, switch.off)),
            )
        ),
    }
    return [
        f"{effect.name} cannot run live: {why}; fit the model without it"
        for effect in composition.all_effects
        for why, applies in said.items()
        if applies(effect) and not _is_followed(effect)
    ]


def _sampled(effect: Effect) -> Effect:
    """Read the coil's position from sample to sample, in place of following its motion."""
    if effect.sampled is None:
        return effect
    still = (POSITION, POSITION_RATE)
    return replace(effect, coil=still, position=effect.sampled, states=(), switches=())


def _is_followed(effect: Effect) -> bool:
    """Whether an effect is another stiffness at another time, and nothing else."""
    stiffness = sp.sympify(effect.force).subs(ELASTIC_DEPTH, INDENTATION) / INDENTATION
    symbols = {*stiffness.free_symbols}
    known = {TIME, *(p.symbol for p in effect.parameters), *(s.symbol for s in effect.switches)}
    timed = stiffness.has(TIME) or any(
        sp.sympify(side).has(TIME) for switch in effect.switches for side in (switch.on, switch.off)
    )
    same = replace(effect, force=sp.S.Zero, switches=())
    return timed and symbols <= known and not effect.states and _acts_nowhere(same)


def _acts_nowhere(effect: Effect) -> bool:
    none = Effect(effect.name, effect.family, effect.physics)
    acts = (
        *("force", "contact", "surface", "drag", "moving", "inertia", "coil", "stretch"),
        *("engaged", "cell", "output", "position", "delay", "rounded"),
    )
    return all(getattr(effect, field) == getattr(none, field) for field in acts)


def _estimating(model: Model, priors: Mapping[str, Prior]) -> Model:
    """Move every parameter that has no prior of its own among the constants, but the tissue's."""
    tissue = {"stiffness", "damping", "force_offset"}
    estimated = [p for p in model.parameters if str(p) in priors or str(p) in tissue]
    held = tuple(p for p in model.parameters if p not in estimated)
    return replace(model, parameters=sp.Matrix(estimated), constants=(*model.constants, *held))


def _memoryless(model: Model) -> Model:
    alone = {
        switch.symbol: sp.Piecewise((1, switch.off < 0), (0, True))
        if switch.alone is None
        else switch.alone
        for switch in model.switches
    }
    motion, output = model.motion.subs(alone), model.output.subs(alone)
    return replace(model, motion=motion, output=output, switches=())


def _flows(tissue: str) -> bool:
    """Whether a tissue is a fluid, which has no motion at a damping of 0."""
    rates = (state.motion for state in TISSUES[tissue].states)
    return any(rate.subs(DAMPING, 0).has(sp.zoo, sp.nan) for rate in rates)


def _about(value: float) -> Prior:
    """Return the prior of a value known give or take half of it, and by its order for certain."""
    return Prior(value, value / 2, value / 10, value * 10)


def _of_state(state: State, settings: EstimatorSettings) -> Prior:
    """Return how far an effect's state may be from 0, of where and how fast the tip may be."""
    length = settings.tip_position_prior_sd
    deviation = {
        "speed": settings.tip_velocity_prior_sd,
        # A state that starts at the measured force.
        "none": settings.load_cell_stiffness * length,
    }.get(state.spread, length)
    return Prior(0.0, deviation)


def _strengths(effect: Effect, values: Mapping[str, float], wanted: bool) -> dict[str, Prior]:
    """Return priors of those of an effect's strengths that are estimated."""
    clocked = [sp.sympify(e) for e in (effect.output, *effect.surface)]
    clocked = [expression for expression in clocked if expression.has(TIME)]
    if not (wanted or clocked):
        return {}
    periodic = any(angle.has(TIME) for e in clocked for angle in e.atoms(sp.sin, sp.cos))
    priors = {}
    of_channels = (effect.position, sp.sympify(effect.rounded), sp.sympify(effect.delay))
    fixed = {symbol for expression in of_channels for symbol in expression.free_symbols}
    strengths = [p for p in effect.parameters[: effect.strengths] if p.symbol not in fixed]
    for entry in strengths:
        own = values[entry.name]
        if clocked:
            alike = [values[p.name] for p in strengths if p.unit == entry.unit]
            deviation = sum(value**2 for value in alike) ** 0.5 or abs(entry.default)
            walk = deviation**2 / PHASE_TIME if periodic else 0.0
            priors[entry.name] = Prior(0.0, deviation, entry.lower, entry.upper, walk)
        else:
            deviation = abs(own or entry.default) / 2
            priors[entry.name] = Prior(own, deviation, entry.lower, entry.upper)
    return priors
