"""Random tissues: stiffness over place, from nodules of several shapes and a varying background.

Contents: the truth, and how sites feel it. Nothing is taken from the package: a map would otherwise
be held against its own assumptions.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter, map_coordinates
from scipy.special import erfc

SIDE = 40.0  # mm
STIFFNESS = 450.0  # N/m
#: Depth by which a nodule is felt half as much [mm].
FADING = 8.0
#: What the filters say of a site: 0.05 % of k, far less than sites differ by.
STATED = 0.0005
_STEP = 0.5  # mm, of the background's raster
_MARGIN = 10.0  # mm


@dataclass(frozen=True)
class Nodule:
    """A nodule [mm] and the excess that is felt above its middle; ``shape`` names a profile."""

    x: float
    y: float
    radius: float
    depth: float
    excess: float
    shape: str
    angle: float

    @property
    def width(self) -> float:
        """How wide it is felt [mm]."""
        return math.hypot(self.radius, self.depth)

    def felt(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return its profile at places [mm], 1 in the middle."""
        return PROFILES[self.shape](self, x - self.x, y - self.y)


def _gaussian(nodule: Nodule, dx: np.ndarray, dy: np.ndarray) -> np.ndarray:
    return np.exp(-(dx**2 + dy**2) / nodule.width**2)


def _plateau(nodule: Nodule, dx: np.ndarray, dy: np.ndarray) -> np.ndarray:
    """Return a flat top with an edge that is as wide as the nodule is deep, at least 1.5 mm."""
    edge = max(0.6 * nodule.depth, 1.5)
    distance = np.hypot(dx, dy)
    return erfc((distance - nodule.radius) / edge) / erfc(-nodule.radius / edge)


def _heavy_tail(nodule: Nodule, dx: np.ndarray, dy: np.ndarray) -> np.ndarray:
    return 1.0 / (1.0 + (dx**2 + dy**2) / (0.85 * nodule.width) ** 2) ** 1.5


def _ellipse(nodule: Nodule, dx: np.ndarray, dy: np.ndarray) -> np.ndarray:
    along = math.cos(nodule.angle) * dx + math.sin(nodule.angle) * dy
    beside = math.cos(nodule.angle) * dy - math.sin(nodule.angle) * dx
    return np.exp(-(along**2 / 1.7 + beside**2 * 1.7) / nodule.width**2)


def _disc(nodule: Nodule, dx: np.ndarray, dy: np.ndarray) -> np.ndarray:
    return (np.hypot(dx, dy) <= nodule.radius).astype(float)


def _own(nodule: Nodule, dx: np.ndarray, dy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return places along a nodule's own axes, in its radius."""
    cosine, sine = math.cos(nodule.angle), math.sin(nodule.angle)
    return (cosine * dx + sine * dy) / nodule.radius, (cosine * dy - sine * dx) / nodule.radius


def _triangle(nodule: Nodule, dx: np.ndarray, dy: np.ndarray) -> np.ndarray:
    """Return an equilateral triangle; the radius is that to its corners."""
    u, v = _own(nodule, dx, dy)
    sides = [math.cos(a) * u + math.sin(a) * v for a in math.pi * np.array([1.0, 1 / 3, -1 / 3])]
    return (np.max(sides, axis=0) <= 0.5).astype(float)


def _rectangle(nodule: Nodule, dx: np.ndarray, dy: np.ndarray) -> np.ndarray:
    """Return a rectangle of sides of two radii and of one."""
    u, v = _own(nodule, dx, dy)
    return ((np.abs(u) <= 1.0) & (np.abs(v) <= 0.5)).astype(float)


def _grown_together(nodule: Nodule, dx: np.ndarray, dy: np.ndarray) -> np.ndarray:
    """Return two discs of the radius whose middles are 1.6 of it apart."""
    u, v = _own(nodule, dx, dy)
    return (np.hypot(np.abs(u) - 0.8, v) <= 1.0).astype(float)


#: Profiles of nodules, by name.
PROFILES: dict[str, Callable[[Nodule, np.ndarray, np.ndarray], np.ndarray]] = {
    "disc": _disc,
    "triangle": _triangle,
    "rectangle": _rectangle,
    "grown together": _grown_together,
    "gaussian": _gaussian,
    "plateau": _plateau,
    "heavy tail": _heavy_tail,
    "ellipse": _ellipse,
}


@dataclass(frozen=True)
class Condition:
    """How unlike the plain tissue a tissue is, each up to so much.

    Attributes
    ----------
    variation, noise, tilt, curvature : float
        Standard deviation of the background, which so varies by twice as much, and of the sites;
        change over the side, and from the middle to the corner; relative.
    relaxation : float
        By how much stiffer the tissue is when the scan begins; fades with 15 s.
    nodules : int
        At most.
    slips : float
        Share of the sites that are felt 1.5 to 3 times as stiff as they are.
    tails : float
        Noise of two degrees of freedom of Student's t, instead of a normal one; its scale,
        relative.
    """

    variation: float = 0.05
    noise: float = 0.05
    tilt: float = 0.20
    curvature: float = 0.05
    relaxation: float = 0.0
    nodules: int = 4
    slips: float = 0.0
    tails: float = 0.0


MIXED = Condition()
#: Conditions under which sites err with tails.
ERRING = {
    "5 % of the sites slip": replace(MIXED, slips=0.05),
    "noise of heavy tails, 2 %": replace(MIXED, tails=0.02),
}
#: Bodies whose form the map does not know, by name: profile, radius and middles [mm].
BODIES: dict[str, tuple[str, float, tuple[tuple[float, float], ...]]] = {
    "circle": ("disc", 6.0, ((20.0, 20.0),)),
    "two circles": ("disc", 5.0, ((12.0, 13.0), (28.0, 27.0))),
    "triangle": ("triangle", 10.0, ((20.0, 20.0),)),
    "rectangle": ("rectangle", 9.0, ((20.0, 20.0),)),
    "grown together": ("grown together", 5.0, ((20.0, 20.0),)),
}


@dataclass(frozen=True)
class Tissue:
    """A tissue of SIDE by SIDE mm.

    Attributes
    ----------
    nodules : tuple of Nodule
        What is to be found.
    noise : float
        Standard deviation of the sites, drawn.
    condition : Condition
        What it was drawn for.
    """

    nodules: tuple[Nodule, ...]
    noise: float
    condition: Condition
    _tilt: np.ndarray
    _curvature: float
    _variation: np.ndarray

    @staticmethod
    def random(seed: int, shape: str, condition: Condition = MIXED) -> Tissue:
        """Draw a tissue."""
        rng = np.random.default_rng([seed, 45])
        size = int((SIDE + 2 * _MARGIN) / _STEP) + 1
        field = gaussian_filter(rng.standard_normal((size, size)), 3.5 / _STEP / math.sqrt(2.0))
        field *= rng.uniform(0.0, condition.variation) / field.std()
        angle = rng.uniform(0.0, 2.0 * math.pi)
        tilt = rng.uniform(0.0, condition.tilt) * np.array([math.cos(angle), math.sin(angle)])
        return Tissue(
            _nodules(rng, shape, condition.nodules),
            rng.uniform(0.0, condition.noise),
            condition,
            tilt,
            rng.uniform(-condition.curvature, condition.curvature),
            field,
        )

    @staticmethod
    def of_bodies(name: str, seed: int) -> Tissue:
        """Return a plain tissue with hard-edged bodies of ``BODIES``, moved a little, 5 % noise."""
        rng = np.random.default_rng([seed, 46])
        plain = Tissue.random(seed, "disc", Condition(0.0, 0.0, 0.0, 0.0, nodules=0))
        shape, radius, middles = BODIES[name]
        bodies = tuple(
            Nodule(
                *(np.array(middle) + rng.uniform(-2.0, 2.0, 2)), radius, 0.0, rng.uniform(0.5, 2.0),
                shape, rng.uniform(0.0, 2.0 * math.pi),
            )
            for middle in middles
        )  # fmt: skip
        return replace(plain, nodules=bodies, noise=0.05)

    def background(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the stiffness without nodules at places [mm], in N/m."""
        u, v = x / SIDE - 0.5, y / SIDE - 0.5
        shape = 1.0 + self._tilt[0] * u + self._tilt[1] * v + 4 * self._curvature * (u**2 + v**2)
        cells = [(np.asarray(each) + _MARGIN) / _STEP for each in (y, x)]
        varied = map_coordinates(self._variation, cells, order=1, mode="nearest")
        return STIFFNESS * shape * (1.0 + varied)

    def stiffness(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the stiffness at places [mm], in N/m."""
        excess = sum((one.excess * one.felt(x, y) for one in self.nodules), np.zeros(np.shape(x)))
        return self.background(x, y) * (1.0 + excess)

    def palpated(self, x: np.ndarray, y: np.ndarray, seed: int) -> dict[str, np.ndarray]:
        """Return the table of a scan of sites in this order, 1.57 s a site, in m, s and N/m.

        A site keeps its value when further ones follow.
        """
        rng, tails, slips, factors = (
            np.random.default_rng([seed, stream]) for stream in (451, 452, 453, 454)
        )
        t = 1.571 * np.arange(x.size)
        k = self.stiffness(x, y) * (1.0 + self.condition.relaxation * np.exp(-t / 15.0))
        noise = self.noise * rng.standard_normal(x.size)
        if self.condition.tails:
            # Of two degrees of freedom, by its quantiles: a draw a site.
            u = tails.uniform(-1.0, 1.0, x.size)
            noise = self.condition.tails * u * np.sqrt(2.0 / (1.0 - u**2))
        k *= np.exp(noise) if self.condition.tails else 1.0 + noise
        slipped = slips.random(x.size) < self.condition.slips
        k[slipped] *= factors.uniform(1.5, 3.0, x.size)[slipped]
        return {"x": 1e-3 * x, "y": 1e-3 * y, "t": t, "k": k, "k_sd": STATED * k}


def _nodules(rng: np.random.Generator, shape: str, most: int) -> tuple[Nodule, ...]:
    wanted, nodules = rng.integers(0, most + 1), []
    while len(nodules) < wanted:
        x, y = rng.uniform(0.0, SIDE, 2)
        if all(math.hypot(x - other.x, y - other.y) >= 8.0 for other in nodules):
            depth, ratio = rng.uniform(1.0, 6.0), rng.uniform(1.3, 3.0)
            excess = (ratio - 1.0) / (1.0 + (depth / FADING) ** 2)
            radius, angle = rng.uniform(3.0, 8.0), rng.uniform(0.0, math.pi)
            nodules.append(Nodule(x, y, radius, depth, excess, shape, angle))
    return tuple(nodules)


def raster(sites: int) -> tuple[np.ndarray, np.ndarray]:
    """Return places of sites by sites, in serpentine order [mm]."""
    along = np.linspace(0.0, SIDE, sites)
    rows = [(along if row % 2 == 0 else along[::-1], y) for row, y in enumerate(along)]
    return np.concatenate([x for x, _ in rows]), np.repeat(along, sites)
