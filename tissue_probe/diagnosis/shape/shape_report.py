"""The shape of a missing force, as it is told.

Contents: variables and their shares, other sets that explain as much, the curve.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.shape.choice import Choice
from tissue_probe.diagnosis.shape.confirmation import FittedShape, fit_shape
from tissue_probe.diagnosis.shape.curve import curve
from tissue_probe.diagnosis.shape.effect_file import write_effect
from tissue_probe.diagnosis.shape.formula import Formula, formula
from tissue_probe.diagnosis.shape.free_functions import VARIABLES, in_order
from tissue_probe.diagnosis.shape.learnt_curve import Curve
from tissue_probe.diagnosis.shape.shape import Shape, shape


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
    rivals : tuple of tuple of str
        Other sets that leave as little.
    fit : Fit
        The model.
    learnt : Shape
        The functions.
    as_effect : FittedShape or None
        The model with an effect of them; None where the functions leave more than noise, or no
        effect can be made of them.
    formula : Formula or None
        A simple one that explains as much; None where there is none, or nothing is told.
    """

    variables: tuple[str, ...]
    share: float
    shares: Mapping[str, Share]
    rivals: tuple[tuple[str, ...], ...]
    fit: Fit
    learnt: Shape
    as_effect: FittedShape | None = None
    formula: Formula | None = None

    @property
    def accepted(self) -> bool:
        """Whether the effect leaves noise only, where it was not fitted, too."""
        return self.as_effect is not None and self.as_effect.confirms

    @property
    def ratio(self) -> float:
        """Residual over the noise: of the effect, if it was tried; else of the functions."""
        fitted = self.as_effect
        return fitted.fit.ratio if fitted else self.learnt.choice.best.ratio

    @property
    def heldout(self) -> float:
        """The same of parts that are held out."""
        fitted = self.as_effect
        best = self.learnt.choice.best
        return fitted.fit.heldout_rmse / fitted.fit.noise if fitted else best.heldout

    @property
    def told(self) -> bool:
        """Whether the motion tells the variables from others: few loops often do not."""
        return not self.rivals

    @property
    def curve(self) -> Curve | None:
        """The function on a grid; None where it is not told, or has more than two variables."""
        return curve(self.learnt) if self.accepted and self.told else None


def find_shape(
    models: Sequence[Fit], instrument: Instrument, second: Sequence[Measurement] = ()
) -> FoundShape:
    """Return the shape beside the first model that it explains all with; else beside the last.

    It explains all where it does as an effect, fitted by output error.

    Parameters
    ----------
    models : sequence of Fit
        Models of the same measurements, one after the other.
    instrument : Instrument
        Constants of the rig with their tolerances.
    second : sequence of Measurement
        Other recordings of the specimen, on which the effect is tried.
    """
    for fit in models:
        found = _confirmed(_learnt(shape(fit, instrument)), instrument, second)
        if found.accepted:
            break
    return found


def _learnt(learnt: Shape) -> FoundShape:
    choice = learnt.choice
    return FoundShape(
        variables=in_order(choice.chosen),
        share=choice.share(choice.chosen),
        shares={name: _share(choice, name) for name in VARIABLES},
        rivals=tuple(sorted(map(in_order, choice.rivals), key=lambda each: (len(each), each))),
        fit=learnt.fit,
        learnt=learnt,
    )


def _confirmed(
    found: FoundShape, instrument: Instrument, second: Sequence[Measurement]
) -> FoundShape:
    """Return a shape as it does as an effect: of its formula, if it has one, or of tables."""
    if not found.learnt.choice.accepted:
        return found
    of_record = formula(found.learnt, instrument) if found.told else None
    for simple in dict.fromkeys((of_record, None)):
        text = write_effect(found.learnt, simple)
        as_effect = fit_shape(text, found.fit, instrument, second) if text else None
        found = replace(found, as_effect=as_effect, formula=simple)
        if found.accepted:
            break
    return found


def _share(choice: Choice, name: str) -> Share:
    return Share(choice.share(frozenset([name])), choice.beyond(name))
