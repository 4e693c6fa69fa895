"""Whether the question of an exploration is answered, and what is still open.

Contents: the probability that an inclusion of the sought size is somewhere in the area, how well
the boundaries of those that were found are known, and both in words.

All is read off the states, in which inclusions lie where nothing was felt as often as the prior
has them there: "nothing is there" is not sure before enough of the area was felt.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.spatial.distance import cdist

from tissue_probe.errors import ParameterError
from tissue_probe.mapping.posterior.check import LEAST_PASSED, predictive_probability
from tissue_probe.mapping.posterior.found_inclusions import LEAST_PROBABILITY, LINK, FoundInclusion
from tissue_probe.mapping.posterior.posterior_sample import LEAST_SITES, Sampled
from tissue_probe.mapping.posterior.prior import LOG_CONTRAST, LOG_RADIUS, X, Y
from tissue_probe.mapping.posterior.shape import metric
from tissue_probe.signals import FloatArray, IntArray

_MM = 1e3
#: Neighbouring rays are a quarter of the radius apart at the boundary of an ellipse.
_RAYS = 24
#: Enough for a standard deviation that is right to 6 %.
_DEVIATION_MEMBERS = 150
_NUMBERS = ("no", "one", "two", "three", "four", "five", "six")


@dataclass(frozen=True)
class Sought:
    """The question.

    Attributes
    ----------
    radius : float
        Smallest radius at half height, of the circle of the same area, that matters [m].
    contrast : float
        Smallest stiffness over the background's that matters.
    probability : float
        At which an answer is given.
    boundary : float
        Standard deviation at which a boundary is known well enough [m].
    """

    radius: float = 4e-3
    contrast: float = 1.5
    probability: float = 0.95
    boundary: float = 1e-3

    def __post_init__(self) -> None:
        if not 0.0 < self.radius < math.inf:
            raise ParameterError(f"radius is {self.radius} m; it must be positive and finite")
        if not 1.0 < self.contrast < 100.0:
            raise ParameterError(f"contrast is {self.contrast}; it must be above 1 and below 100")
        if not 0.5 < self.probability < 1.0:
            raise ParameterError(
                f"probability is {self.probability}; it must be above 0.5 and below 1"
            )
        if not 0.0 < self.boundary < math.inf:
            raise ParameterError(f"boundary is {self.boundary} m; it must be positive and finite")

    @property
    def text(self) -> str:
        """The sought inclusions in words."""
        return f"inclusion of {_MM * self.radius:.3g} mm or more at contrast {self.contrast:.3g}"


@dataclass(frozen=True)
class KnownInclusion:
    """An inclusion that is there, or may be, and may be of the sought size.

    Attributes
    ----------
    x, y : float
        Its middle [m].
    probability : float
        That there is one.
    boundary_sd : float
        Standard deviation of its boundary, root mean square around it [m].
    felt_by_one : bool
        Whether one site alone feels it, and is to be palpated again: it may have slipped.
    """

    x: float
    y: float
    probability: float
    boundary_sd: float
    felt_by_one: bool


@dataclass(frozen=True)
class SiteAnswer:
    """What is known of the question.

    Attributes
    ----------
    sought : Sought
        The question.
    none : float
        Probability that no inclusion of the sought size is in the area.
    no_further : float
        Probability that there is none but those of ``inclusions`` that are certain.
    inclusions : tuple of KnownInclusion
        Those that may be of the sought size, the most probable first.
    answered : bool
        Whether it is answered.
    text : str
        The answer, or how far it is, in a sentence.
    open : tuple of str
        What is still open; nothing once it is answered.
    """

    sought: Sought
    none: float
    no_further: float
    inclusions: tuple[KnownInclusion, ...]
    answered: bool
    text: str
    open: tuple[str, ...]


def answer(sampled: Sampled, sought: Sought = Sought(), *, checked: bool = True) -> SiteAnswer:
    """Return what the states say to the question whether inclusions are in their area.

    Parameters
    ----------
    sampled : Sampled
        Drawn for the sites in the area.
    sought : Sought
        The question.
    checked : bool
        Whether it counts that the model makes sites like these; that takes as long as the rest.
    """
    state, relevant, states = _relevant(sampled, sought)
    none = 1.0 - np.unique(state).size / states
    places = len(sampled.felt.visits)
    if places < LEAST_SITES:
        few = (
            f"{places} sites cannot tell an inclusion from a tilted background: give "
            f"{LEAST_SITES} or more"
        )
        return SiteAnswer(sought, none, none, (), False, "not known yet", (few,))
    far = _distances(relevant, sampled.found)
    # Beyond the numbers of all where none is as near as a tip.
    nearest = np.column_stack([far, np.full(len(far), LINK)]).argmin(axis=1)
    doubted = {doubt.number for doubt in sampled.doubts if doubt.alone}
    by_number = {
        number: KnownInclusion(
            float(one.centre[0]) / _MM,
            float(one.centre[1]) / _MM,
            one.probability,
            _boundary_sd(one) / _MM,
            number in doubted,
        )
        for number, one in enumerate(sampled.found)
        if np.unique(state[nearest == number]).size >= LEAST_PROBABILITY * states
    }
    known = tuple(by_number.values())
    sure = [
        number
        for number, one in by_number.items()
        if one.probability >= sought.probability and not one.felt_by_one
    ]
    certain = [by_number[number] for number in sure]
    no_further, unfound = (
        np.unique(state[(far[:, numbers] >= LINK).all(axis=1)]).size / states
        for numbers in (sure, list(by_number))
    )
    no_further = 1.0 - no_further
    still_open = _open(sought, known, no_further, unfound)
    holds = not checked or _holds(sampled)
    if not holds:
        still_open.append("inclusions on a smooth background do not explain the sites")
    if none >= sought.probability:
        still_open = [] if holds else still_open
        told = f"no {sought.text}, {_round_down(none)}"
    elif certain:
        told = f"{_number(len(certain))}, {_boundaries(certain)}; "
        told += f"no further {sought.text}, {_round_down(no_further)}"
    else:
        told = f"not known yet: no {sought.text}, {_round_down(none)}"
    return SiteAnswer(sought, none, no_further, known, not still_open, told, tuple(still_open))


def _holds(sampled: Sampled) -> bool:
    likely = predictive_probability(sampled.states, sampled.background, sampled.felt.log_k)
    return likely >= LEAST_PASSED


def _relevant(sampled: Sampled, sought: Sought) -> tuple[np.ndarray, FloatArray, int]:
    """Return the state and the middle [mm] of each inclusion of the sought size, and all states.

    One whose middle is beyond the area's edge may reach into it: it counts, too.
    """
    rows, count, _, _ = sampled.states.flat()
    state, place = np.nonzero(np.arange(rows.shape[1]) < count[:, None])
    each = rows[state, place]
    large = np.exp(each[:, LOG_RADIUS]) >= _MM * sought.radius
    large &= each[:, LOG_CONTRAST] >= math.log(sought.contrast)
    return state[large], each[large][:, [X, Y]], count.size


def _distances(places: FloatArray, found: list[FoundInclusion]) -> FloatArray:
    """Return how far places [mm] are from each inclusion's nearest part [mm]; (places, found)."""
    far = np.empty((len(places), len(found)))
    for column, one in zip(far.T, found, strict=True):
        column[:] = cdist(places, one.places).min(axis=1)
    return far


def _open(
    sought: Sought, known: tuple[KnownInclusion, ...], no_further: float, unfound: float
) -> list[str]:
    """Say what is still to be learnt."""
    told = []
    for one in known:
        if one.felt_by_one:
            told.append(
                f"the inclusion near {_place(one.x, one.y)}, {_round_down(one.probability)}, is "
                "felt by one site: palpate again"
            )
        elif one.probability < sought.probability:
            told.append(
                f"an inclusion may be near {_place(one.x, one.y)}, {_round_down(one.probability)}"
            )
        elif one.boundary_sd > sought.boundary:
            told.append(
                f"the boundary of the inclusion near {_place(one.x, one.y)} is known to "
                f"{_MM * one.boundary_sd:.1f} mm"
            )
    if no_further < sought.probability and (unfound > 1.0 - sought.probability or not told):
        told.append(f"an {sought.text} may be elsewhere, {_round_down(unfound)}")
    return told


def _boundary_sd(one: FoundInclusion) -> float:
    """Return the standard deviation of the boundary along rays from the middle, rms [mm]."""
    rows, count, _ = one.some(_DEVIATION_MEMBERS)
    reach = np.zeros((count.size, _RAYS))
    x, y = one.centre
    _reaches(rows, count, x, y, reach)
    return float(np.sqrt(reach.var(axis=0).mean()))


@njit(cache=True, nogil=True, error_model="numpy")
def _reaches(rows: FloatArray, count: IntArray, x: float, y: float, out: FloatArray) -> None:
    """Write how far the boundary is from a place [mm] along rays.

    The rows are those of ``FoundInclusion.some``.
    """
    for state in range(count.size):
        for part in range(count[state]):
            row = rows[state, part]
            a, b, c = metric(row)
            dx, dy = x - row[X], y - row[Y]
            beyond = a * dx**2 + 2.0 * b * dx * dy + c * dy**2 - 1.0
            for ray in range(_RAYS):
                angle = 2.0 * math.pi * ray / _RAYS
                ux, uy = math.cos(angle), math.sin(angle)
                # (rho / R)^2 = 1 on the ray, a quadratic in the distance.
                square = a * ux**2 + 2.0 * b * ux * uy + c * uy**2
                half = a * ux * dx + b * (ux * dy + uy * dx) + c * uy * dy
                left = half**2 - square * beyond
                if left > 0.0:
                    out[state, ray] = max(out[state, ray], (math.sqrt(left) - half) / square)


def _place(x: float, y: float) -> str:
    return f"({_MM * x:.0f}, {_MM * y:.0f}) mm"


def _number(count: int) -> str:
    number = _NUMBERS[count] if count < len(_NUMBERS) else str(count)
    return f"{number} inclusion{'s' if count > 1 else ''}"


def _boundaries(certain: list[KnownInclusion]) -> str:
    worst = _MM * max(one.boundary_sd for one in certain)
    which = "boundaries" if len(certain) > 1 else "boundary"
    return f"{which} known to {worst:.1f} mm"


def _round_down(probability: float) -> str:
    """Return a probability to two places, never rounded up to more than is known."""
    if probability > 0.99:
        return "P > .99"
    return f"P = {math.floor(100.0 * probability) / 100.0:.2f}".replace("= 0.", "= .")
