"""The contents of a report, as plain data for a caller to fill.

Contents: the fields of the page, SI throughout.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from tissue_probe.diagnosis.residuals.localise import Localisation
from tissue_probe.diagnosis.residuals.residual_test import ResidualTest
from tissue_probe.quantities import FORCE, Quantity
from tissue_probe.signals import FloatArray

Verdict = Literal["adequate", "missing", "ambiguous", "unexplained"]


@dataclass(frozen=True)
class ReportParameter:
    """A parameter of a model with its 95 % interval.

    Parameters
    ----------
    name : str
        As in ``model.yaml``.
    symbol : str
        In LaTeX.
    value, low, high : float
        Estimate and ends of the interval, in ``unit``; NaN ends where it was held fixed.
    unit : str
        In words, as ``N s/m``; empty for a pure number.
    at_limit : bool
        Whether the rig's tolerance let it go no farther.
    start, lower, upper : float
        Where its search was begun, and its bounds; NaN where not known.
    """

    name: str
    symbol: str
    value: float
    low: float
    high: float
    unit: str
    at_limit: bool = False
    start: float = float("nan")
    lower: float = float("nan")
    upper: float = float("nan")


@dataclass(frozen=True)
class ReportStep:
    """A model on the ladder.

    Parameters
    ----------
    model : str
        The step, as ``Kelvin-Voigt``, ``+ cubic_stiffening`` or ``− force_bias``.
    reason : str
        Why, in a sentence.
    equations : tuple of str
        The model's equations in LaTeX, without delimiters.
    parameters : tuple of ReportParameter
        As fitted.
    training_rmse, heldout_rmse : float
        Error on the fitted data and on data held out; NaN where there is none.
    """

    model: str
    reason: str
    equations: tuple[str, ...]
    parameters: tuple[ReportParameter, ...]
    training_rmse: float
    heldout_rmse: float


@dataclass(frozen=True)
class ReportCandidate:
    """An effect that was tried beside the base model.

    Parameters
    ----------
    effect, family, description : str
        Its name, its family, and its physics in a line.
    heldout_rmse : float
        Error on held-out data with it.
    gain : float
        By how much it lowers the Bayesian information criterion.
    parameters : tuple of ReportParameter
        Its own, as fitted.
    indistinguishable : bool
        Whether it is one of those that this data cannot tell apart.
    settled : bool
        Whether the search for it settled; else its numbers are a guess.
    """

    effect: str
    family: str
    description: str
    heldout_rmse: float
    gain: float
    parameters: tuple[ReportParameter, ...] = ()
    indistinguishable: bool = False
    settled: bool = True


@dataclass(frozen=True)
class ReportSignals:
    """A record with the predictions of the first and the last model of the ladder.

    Parameters
    ----------
    name : str
        Which recording, and whether it was fitted or held out.
    time : array, shape (N,)
        Times of the samples [s].
    measured, base, final : array, shape (N,)
        The samples, and the predictions of the first and the last model.
    base_localisation, final_localisation : Localisation or None
        Where these fail.
    """

    name: str
    time: FloatArray
    measured: FloatArray
    base: FloatArray
    final: FloatArray
    base_localisation: Localisation | None = None
    final_localisation: Localisation | None = None


@dataclass(frozen=True)
class ReportExcitation:
    """The experiment to do next.

    Parameters
    ----------
    reason : str
        Its purpose, in a sentence.
    command : str
        The command line that runs it; empty for a calibration done by hand.
    settings : mapping of str to str
        Its settings with units.
    notes : tuple of str
        Notes on the command, in sentences.
    """

    reason: str
    command: str = ""
    settings: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class ReportSource:
    """A recording that went into the report.

    Parameters
    ----------
    name : str
        Its file.
    role : str
        Its use, as ``fitted`` or ``held out``.
    description : str
        How it was read: columns, units, and all that was assumed.
    digest : str
        The begin of its SHA-256.
    facts : tuple of str
        Samples, duration, travel, force, signs.
    """

    name: str
    role: str
    description: str
    digest: str = ""
    facts: tuple[str, ...] = ()


@dataclass(frozen=True)
class ReportRig:
    """The rig that the models are of: its name, one line on it, and a small picture (SVG)."""

    name: str
    summary: str
    drawing: str = ""


@dataclass(frozen=True)
class ReportSymbol:
    """A symbol of the equations: in LaTeX, its name in words, its unit (empty if none)."""

    symbol: str
    name: str
    unit: str


@dataclass(frozen=True)
class ReportShape:
    """The learnt shape of a force that no law explains.

    Parameters
    ----------
    picture : str
        The function with its band, or a surface (SVG).
    heldout_without, heldout_with : float
        Error on held-out data of the model that it was learnt beside, and with the shape.
    """

    picture: str
    heldout_without: float
    heldout_with: float


@dataclass(frozen=True)
class Report:
    """All that a report says.

    Parameters
    ----------
    title : str
        Heading of the page.
    verdict : {'adequate', 'missing', 'ambiguous', 'unexplained'}
        The decision.
    summary : tuple of str
        The verdict in words, a paragraph each.
    noise_floor : float
        Standard deviation of the output's white noise.
    steps : tuple of ReportStep
        The ladder from the base model on; at least one.
    ranking : tuple of ReportCandidate
        Best first.
    signals : tuple of ReportSignals
        Records to be drawn.
    findings : tuple of str
        The findings of the data's inspection, a sentence each.
    base_tests, final_tests : tuple of ResidualTest
        Of the residual of the first and of the last model; the latter empty if they are one.
    excitations : tuple of ReportExcitation
        Experiments to do next.
    sources : tuple of ReportSource
        The recordings.
    versions : mapping of str to str
        Versions of the programs that were used.
    created : str
        Date and time of the report.
    seconds : float
        Time that the analysis took [s].
    exhaustion : str
        The meaning of values at their limit; empty where none is.
    output : Quantity
        The predicted channel, whose errors all are.
    asked : str
        Rig, tissue, and all else that the user said, in one line.
    rig : ReportRig or None
        The rig.
    command : str
        The command line that repeats the analysis.
    symbols : tuple of ReportSymbol
        Of the last model's equations.
    correlations : tuple of (str, str, float)
        Pairs of values of the last model, by their symbols, whose errors go together most.
    shape : ReportShape or None
        The shape of the missing force; None where none is claimed.
    """

    title: str
    verdict: Verdict
    summary: tuple[str, ...]
    noise_floor: float
    steps: tuple[ReportStep, ...]
    ranking: tuple[ReportCandidate, ...] = ()
    signals: tuple[ReportSignals, ...] = ()
    findings: tuple[str, ...] = ()
    base_tests: tuple[ResidualTest, ...] = ()
    final_tests: tuple[ResidualTest, ...] = ()
    excitations: tuple[ReportExcitation, ...] = ()
    sources: tuple[ReportSource, ...] = ()
    versions: Mapping[str, str] = field(default_factory=dict)
    created: str = ""
    seconds: float = float("nan")
    exhaustion: str = ""
    output: Quantity = FORCE
    asked: str = ""
    rig: ReportRig | None = None
    command: str = ""
    symbols: tuple[ReportSymbol, ...] = ()
    correlations: tuple[tuple[str, str, float], ...] = ()
    shape: ReportShape | None = None

    def __post_init__(self) -> None:
        if not self.steps:
            raise ValueError("a report needs the base model at least; give its step")
