"""The shape of a missing force, as it is told.

Contents: variables and their shares, other sets that explain as much, the curve.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.shape.choice import Choice
from tissue_probe.diagnosis.shape.curve import curve
from tissue_probe.diagnosis.shape.formula import Formula, formula
from tissue_probe.diagnosis.shape.free_functions import VARIABLES
from tissue_probe.diagnosis.shape.learnt_curve import Curve
from tissue_probe.diagnosis.shape.shape import Shape, first_explained

#: Share of a motion's power within a line from which on it is one sine.
ONE_SINE = 0.995


@dataclass(frozen=True)
class Share:
    """The share of the residual beyond the noise, on held-out parts, from 0 to 1.

    ``alone`` is that of a free function of a variable, ``beyond`` how much it adds to the chosen
    others.
    """

    alone: float
    beyond: float


@dataclass(frozen=True, eq=False)
class FoundShape:
    """The variables of the force that is missing beside a model, and the function.

    Attributes
    ----------
    variables : tuple of str
        The first choice, in the order of ``VARIABLES``; none where nothing helps.
    share : float
        The share that they explain together.
    shares : mapping of str to Share
        Of each variable.
    accepted : bool
        Whether they leave noise only, in parts that are held out, too.
    rivals : tuple of tuple of str
        Other sets that leave as little.
    steady : bool
        Whether the motion is one steady sine: a single loop of indentation and velocity.
    fit : Fit
        The model.
    ratio, heldout : float
        Residual over the noise, of all samples and of parts that are held out.
    learnt : Shape
        The functions.
    formula : Formula or None
        A simple one that explains as much; None where there is none, or nothing is told.
    """

    variables: tuple[str, ...]
    share: float
    shares: Mapping[str, Share]
    accepted: bool
    rivals: tuple[tuple[str, ...], ...]
    steady: bool
    fit: Fit
    ratio: float
    heldout: float
    learnt: Shape
    formula: Formula | None = None

    @property
    def told(self) -> bool:
        """Whether the motion tells the variables from others: a single loop may not."""
        return not (self.steady and self.rivals)

    @property
    def curve(self) -> Curve | None:
        """The function on a grid; None where it is not told, or has more than two variables."""
        return curve(self.learnt) if self.accepted and self.told else None


def found_shape(models: Sequence[Fit], instrument: Instrument) -> FoundShape:
    """Return the shape beside the first model whose residual it explains; else beside the last."""
    learnt = first_explained(models, instrument)
    choice = learnt.choice
    found = FoundShape(
        variables=in_order(choice.chosen),
        share=choice.share(choice.chosen),
        shares={name: _share(choice, name) for name in VARIABLES},
        accepted=choice.accepted,
        rivals=tuple(sorted(map(in_order, choice.rivals), key=lambda each: (len(each), each))),
        steady=all(map(one_sine, learnt.fit.measurements)),
        fit=learnt.fit,
        ratio=choice.best.ratio,
        heldout=choice.best.heldout,
        learnt=learnt,
    )
    if not (found.accepted and found.told):
        return found
    return replace(found, formula=formula(learnt, instrument))


def in_order(variables: frozenset[str]) -> tuple[str, ...]:
    """Return variables in the order in which they are told."""
    return tuple(name for name in VARIABLES if name in variables)


def _share(choice: Choice, name: str) -> Share:
    return Share(choice.share(frozenset([name])), choice.beyond(name))


def one_sine(measurement: Measurement) -> bool:
    """Whether the input is one sine that had gone on before the first sample."""
    if measurement.at_rest:
        return False
    driven = measurement.input_values - np.mean(measurement.input_values)
    power = np.abs(np.fft.rfft(np.hanning(driven.size) * driven)) ** 2
    peak = int(np.argmax(power))
    return bool(power[max(peak - 3, 0) : peak + 4].sum() > ONE_SINE * power.sum())
