"""What a map says, held against the tissue.

Contents: marks of one map.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist

from benchmarks.maps.finite_elements import FELT, Block
from benchmarks.maps.tissues import SIDE, Nodule, Tissue

HIT = 6.0  # mm
DECLARED = 0.9
STRONG = 1.0  # peak excess
STEP = 0.5  # mm
#: Quantile of chi squared of two degrees of freedom.
_OF_95 = 5.99
#: A map says so where its chains disagree by more.
DISAGREE = 0.05


@dataclass(frozen=True)
class Marks:
    """Marks of one map; lists have an entry an inclusion, or a nodule that was hit.

    Attributes
    ----------
    nodules, strong, hits, strong_hits, false : int
        Counts, declared at P >= .9.
    location, hausdorff, dice : list of float
        Of hits [mm, mm, -].
    within : list of bool
        Whether the middle is in the ellipse that holds it at 95 %, of hits.
    disagreement : float
        That the map tells of its chains; NaN where it is not asked.
    stated : list of (float, bool)
        Probability of each inclusion that is told, and whether there is a nodule.
    covered, covered_in : float
        Share of places, and of those inside nodules, where truth is within 2 sd; NaN without.
    hidden : bool or None
        Whether a nodule of contrast 1.5 or more is larger than what could hide there; None without
        such a nodule.
    held : list of bool
        Whether the boundary of 95 % holds all of the nodule, of hits.
    felt : list of float
        How many times stiffer than the background each sphere of a block feels.
    seconds : float
        Of the processor.
    again : int
        Sites that were palpated again for it.
    """

    shape: str
    nodules: int = 0
    strong: int = 0
    hits: int = 0
    strong_hits: int = 0
    false: int = 0
    location: list[float] = field(default_factory=list)
    hausdorff: list[float] = field(default_factory=list)
    dice: list[float] = field(default_factory=list)
    within: list[bool] = field(default_factory=list)
    disagreement: float = np.nan
    stated: list[tuple[float, bool]] = field(default_factory=list)
    held: list[bool] = field(default_factory=list)
    felt: list[float] = field(default_factory=list)
    covered: float = np.nan
    covered_in: float = np.nan
    hidden: bool | None = None
    seconds: float = 0.0
    again: int = 0


def marks_of(tissue: Tissue, found: dict[str, Any], shape: str, seconds: float) -> Marks:
    """Return the marks of a map, as its JSON has it."""
    inclusions = found["inclusions"]
    centres = 1e3 * np.array([(one["x"], one["y"]) for one in inclusions]).reshape(-1, 2)
    true = np.array([(n.x, n.y) for n in tissue.nodules]).reshape(-1, 2)
    distance = cdist(centres, true)
    stated = np.array([one["probability"] for one in inclusions])
    declared = np.flatnonzero(stated >= DECLARED)
    pairs = [(declared[a], b) for a, b in _paired(distance[declared])]
    strong = [n.excess >= STRONG for n in tissue.nodules]
    marks = Marks(
        shape,
        len(true),
        sum(strong),
        len(pairs),
        sum(strong[b] for _, b in pairs),
        declared.size - len(pairs),
        hidden=_hidden(tissue, found["could_hide"]),
        seconds=seconds,
        disagreement=found["check"]["disagreement"],
        **_coverage(tissue, found["surface"]),
    )
    for a, b in pairs:
        marks.location.append(float(distance[a, b]))
        off = centres[a] - true[b]
        covariance = 1e6 * np.array(inclusions[a]["covariance"])
        marks.within.append(bool(off @ np.linalg.solve(covariance, off) < _OF_95))
        _mark_boundary(marks, inclusions[a], tissue.nodules[b])
    marks.stated.extend(_stated(stated, distance))
    return marks


def marks_of_block(found: dict[str, Any], of: Block, seconds: float) -> Marks:
    """Return how many of the spheres that are felt are found, and how many inclusions are false.

    A sphere that is felt too little to count is not false where it is found.
    """
    sure = [one for one in found["inclusions"] if one["probability"] >= DECLARED]
    centres = 1e3 * np.array([(one["x"], one["y"]) for one in sure]).reshape(-1, 2)
    distance = cdist(centres, np.array([(one.x, one.y) for one in of.spheres]))
    felt = [of.contrast(sphere) for sphere in of.spheres]
    pairs = _paired(distance)
    return Marks(
        "spheres",
        nodules=sum(each >= FELT for each in felt),
        hits=sum(felt[b] >= FELT for _, b in pairs),
        false=len(sure) - len(pairs),
        felt=felt,
        seconds=seconds,
    )


def _paired(distance: np.ndarray) -> list[tuple[int, int]]:
    near = distance <= HIT
    rows, columns = linear_sum_assignment(np.where(near, distance, 1e3))
    return [(int(a), int(b)) for a, b in zip(rows, columns, strict=True) if near[a, b]]


def _stated(stated: np.ndarray, distance: np.ndarray) -> list[tuple[float, bool]]:
    """Pair the surest inclusion first: each with the nearest nodule that is free."""
    free, told = set(range(distance.shape[1])), []
    for a in np.argsort(-stated):
        near = [b for b in free if distance[a, b] <= HIT]
        if near:
            free.remove(min(near, key=lambda b: distance[a, b]))
        told.append((float(stated[a]), bool(near)))
    return told


def _mark_boundary(marks: Marks, inclusion: dict[str, Any], nodule: Nodule) -> None:
    likely, whole = (1e3 * np.array(inclusion[f"boundary_{p}"]).reshape(-1, 2) for p in (50, 95))
    x = np.arange(nodule.x - 30.0, nodule.x + 30.0, STEP)
    y = np.arange(nodule.y - 30.0, nodule.y + 30.0, STEP)
    columns, rows = np.meshgrid(x, y)
    true = nodule.felt(columns, rows) >= 0.5
    inside = _inside(likely, columns, rows)
    marks.dice.append(2.0 * float((true & inside).sum()) / float(true.sum() + inside.sum()))
    marks.held.append(bool(_inside(whole, columns, rows)[true].mean() > 0.995))
    edge = np.column_stack([columns[_edge(true)], rows[_edge(true)]])
    if len(likely):
        between = cdist(edge, likely)
        both = np.concatenate([between.min(axis=1), between.min(axis=0)])
        marks.hausdorff.append(float(np.quantile(both, 0.95)))


def _edge(mask: np.ndarray) -> np.ndarray:
    inner = mask.copy()
    for axis in (0, 1):
        for shift in (-1, 1):
            inner &= np.roll(mask, shift, axis)
    return mask & ~inner


def _inside(polygon: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return whether places are inside, by the crossings of a ray."""
    inside = np.zeros(x.shape, dtype=bool)
    for (ax, ay), (bx, by) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if ay != by:
            inside ^= ((ay > y) != (by > y)) & (x < (bx - ax) * (y - ay) / (by - ay) + ax)
    return inside


def _coverage(tissue: Tissue, surface: dict[str, Any]) -> dict[str, float]:
    x, y = (1e3 * np.array(surface[name]) for name in "xy")
    mean, sd = (np.array(surface[name], dtype=float) for name in ("mean", "sd"))
    columns, rows = np.meshgrid(x, y)
    on = np.isfinite(mean) & (columns >= 0) & (columns <= SIDE) & (rows >= 0) & (rows <= SIDE)
    within = np.abs(mean - tissue.stiffness(columns, rows)) <= 2.0 * sd
    inside = np.zeros(on.shape, dtype=bool)
    for nodule in tissue.nodules:
        inside |= nodule.felt(columns, rows) >= 0.5
    inside &= on
    return {
        "covered": float(within[on].mean()),
        "covered_in": float(within[inside].mean()) if inside.any() else np.nan,
    }


def _hidden(tissue: Tissue, hide: dict[str, Any]) -> bool | None:
    x, y = (1e3 * np.array(hide[name]) for name in "xy")
    radius = 1e3 * np.array(hide["radius"], dtype=float)
    wrong = []
    for nodule in tissue.nodules:
        if nodule.excess >= hide["contrast"] - 1.0:
            room = radius[int(np.abs(y - nodule.y).argmin()), int(np.abs(x - nodule.x).argmin())]
            wrong.append(bool(room < felt_radius(nodule)))
    return any(wrong) if wrong else None


def felt_radius(nodule: Nodule) -> float:
    """Return the radius of the circle of the area that is felt above half of the peak [mm]."""
    along = np.arange(-25.0, 25.0, 0.25)
    dx, dy = np.meshgrid(along, along)
    area = (nodule.felt(nodule.x + dx, nodule.y + dy) >= 0.5).sum() * 0.25**2
    return float(np.sqrt(area / np.pi))
