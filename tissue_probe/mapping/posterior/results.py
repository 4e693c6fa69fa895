"""What a map says, in SI units: inclusions, surface, what could hide, background, check.

Contents: the results, as data.
"""

from __future__ import annotations

from dataclasses import dataclass

from tissue_probe.signals import FloatArray


@dataclass(frozen=True)
class Inclusion:
    """One inclusion, stiffer or softer than the background.

    Attributes
    ----------
    x, y : float
        Its middle [m].
    covariance : array, shape (2, 2)
        Of the middle [m^2].
    probability : float
        That it is there, its middle within 6 mm.
    stiffness, stiffness_sd : float
        Felt over its middle [N/m].
    contrast : float
        How many times stiffer that is than the background.
    felt_by : int or None
        How many visits feel it; one may be a slip. None where ``Check.model`` knows no inclusions.
    boundary_50, boundary_90, boundary_95 : array, shape (points, 2)
        Closed polygons of x and y [m], given that it is there: around the places more likely inside
        than outside; around the whole inclusion with 90 and 95 %.
    """

    x: float
    y: float
    covariance: FloatArray
    probability: float
    stiffness: float
    stiffness_sd: float
    contrast: float
    felt_by: int | None
    boundary_50: FloatArray
    boundary_90: FloatArray
    boundary_95: FloatArray


@dataclass(frozen=True)
class Raster:
    """A quantity over x and y.

    Attributes
    ----------
    x, y : array, shapes (n,) and (m,)
        [m], rising.
    """

    x: FloatArray
    y: FloatArray


@dataclass(frozen=True)
class SurfaceFelt(Raster):
    """Stiffness over the tissue; NaN where no site is near.

    Attributes
    ----------
    mean, sd : array, shape (m, n)
        [N/m].
    probability : array, shape (m, n)
        That the place is in an inclusion.
    """

    mean: FloatArray
    sd: FloatArray
    probability: FloatArray


@dataclass(frozen=True)
class CouldHide(Raster):
    """What the sites leave room for.

    Attributes
    ----------
    radius : array, shape (m, n)
        Of the largest round inclusion [m], at half its height, that the sites do not exclude at
        95 %; NaN beyond 10 mm.
    contrast : float
        How many times stiffer than the background its middle feels.
    """

    radius: FloatArray
    contrast: float


@dataclass(frozen=True)
class Check:
    """Whether the model holds, and how the map was made.

    Attributes
    ----------
    model : str
        ``inclusions``, or ``gaussian_process`` where these do not explain the sites.
    probability : float
        Of residuals as odd as these, if the model of inclusions is right.
    disagreement : float
        Largest difference between two halves of the chains in the probability of an inclusion.
    states : int
        Kept, of all chains together.
    notes : tuple of str
        All that a reader has to know, in sentences.
    """

    model: str
    probability: float
    disagreement: float
    states: int
    notes: tuple[str, ...]


@dataclass(frozen=True)
class TissueBackground:
    """The tissue between the inclusions.

    Attributes
    ----------
    stiffness, stiffness_sd : float
        In the middle of the sites [N/m].
    tilt : (float, float)
        Relative change along x and along y [1/m].
    variation : float
        Variation and noise of single sites about the trend, relative to k.
    drift : float
        By how much stiffer the tissue was when the scan began than when it ended, relative.
    """

    stiffness: float
    stiffness_sd: float
    tilt: tuple[float, float]
    variation: float
    drift: float


@dataclass(frozen=True)
class Again:
    """A place to palpate again: an inclusion there is felt by one site alone, which may err.

    Attributes
    ----------
    x, y : float
        A little aside of that site [m].
    probability : float
        Of the inclusion.
    """

    x: float
    y: float
    probability: float


@dataclass(frozen=True)
class PosteriorMap:
    """All that the sites say.

    Attributes
    ----------
    inclusions : tuple of Inclusion
        The most probable first; those of 5 % and more.
    again : tuple of Again
        Where to palpate again, the most probable inclusion first.
    """

    inclusions: tuple[Inclusion, ...]
    surface: SurfaceFelt
    could_hide: CouldHide
    background: TissueBackground
    check: Check
    again: tuple[Again, ...] = ()
