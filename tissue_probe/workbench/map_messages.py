"""The map as pages draw it: sites and inclusions as JSON holds them, the raster as arrays.

Contents: layout and names of both.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissue_probe.analysis.mapping import Inclusion, MapResult
from tissue_probe.workbench.page_messages import (
    InclusionMessage,
    MapMessage,
    NoMessage,
    SiteMessage,
)
from tissue_probe.workbench.refusal import RequestRefused


def tell_map(found: MapResult) -> MapMessage:
    """Return all but the raster, in SI units."""
    return {
        "text": found.text,
        "contrast": found.map.could_hide.contrast,
        "sites": _sites(found),
        "inclusions": [_inclusion(one) for one in found.map.inclusions],
    }


def _inclusion(one: Inclusion) -> InclusionMessage:
    return {
        "x": one.x,
        "y": one.y,
        "probability": one.probability,
        "stiffness": one.stiffness,
        "stiffness_sd": one.stiffness_sd,
        "contrast": one.contrast,
        "boundary_50": one.boundary_50.tolist(),
        "boundary_95": one.boundary_95.tolist(),
    }


def _sites(found: MapResult) -> list[SiteMessage]:
    """Tell each place once: of its visits the last counts."""
    if not found.results:  # a table of sites, with no recording behind it
        sites = found.sites
        return [
            {"site": None, "x": x, "y": y, "stiffness": k, "stiffness_sd": sd,
             "verdict": "measured" if felt else "no contact"}
            for x, y, k, sd, felt in zip(
                *(each.tolist() for each in (sites.x, sites.y, sites.k, sites.k_sd, sites.felt)),
                strict=True,
            )
        ]  # fmt: skip
    last = {tuple(round(at, 6) for at in each.position[:2]): each for each in found.results}
    return [
        {"site": each.site, "x": x, "y": y, "stiffness": each.stiffness,
         "stiffness_sd": each.stiffness_stddev,
         "verdict": each.verdict.name.lower().replace("_", " ")}
        for (x, y), each in last.items()
    ]  # fmt: skip


def raster(found: MapResult | None) -> tuple[NoMessage, dict[str, NDArray[Any]]]:
    """Return the layers over the raster's places, row by row; NaN where nothing is known.

    Raises
    ------
    Refused
        If there is no map.
    """
    if found is None:
        raise RequestRefused("there is no map")
    surface, hide = found.map.surface, found.map.could_hide
    layers = {
        "mean": surface.mean, "sd": surface.sd, "probability": surface.probability,
        "radius": _at(hide.radius, (hide.x, hide.y), (surface.x, surface.y)),
    }  # fmt: skip
    arrays = {name: layer.ravel().astype(np.float32) for name, layer in layers.items()}
    return {}, {"x": surface.x, "y": surface.y, **arrays}


def _at(
    layer: NDArray[Any], own: tuple[NDArray[Any], ...], other: tuple[NDArray[Any], ...]
) -> NDArray[Any]:
    """Return a layer at the nearest places of another raster."""
    columns, rows = (
        np.abs(mine[np.newaxis, :] - its[:, np.newaxis]).argmin(axis=1)
        for mine, its in zip(own, other, strict=True)
    )
    return layer[np.ix_(rows, columns)]
