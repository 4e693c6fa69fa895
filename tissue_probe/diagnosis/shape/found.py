"""The shape of a missing force, as it is told.

Contents: variables and their shares, other sets that explain as much, the curve.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.shape.choice import Choice
from tissue_probe.diagnosis.shape.curve import curve
from tissue_probe.diagnosis.shape.formula import Formula, formula
from tissue_probe.diagnosis.shape.free_functions import VARIABLES
from tissue_probe.diagnosis.shape.learnt_curve import Curve
from tissue_probe.diagnosis.shape.shape import Shape, first_explained


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
    fit: Fit
    ratio: float
    heldout: float
    learnt: Shape
    formula: Formula | None = None

    @property
    def told(self) -> bool:
        """Whether the motion tells the variables from others: few loops often do not."""
        return not self.rivals

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
