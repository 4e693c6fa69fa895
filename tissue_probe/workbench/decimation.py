"""Samples made few enough to be drawn, so that the picture is the same.

Contents: the lowest and highest value of each column of pixels, and the pixels that points would
colour.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
#: Two samples a pixel are drawn as they are: lowest and highest would be as many.
PER_PIXEL = 2


def lines(
    signals: Mapping[str, FloatArray], first: int, stop: int, pixels: int
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Return the look of a line through samples first to stop on so many columns of pixels.

    Parameters
    ----------
    signals : mapping of str to array, shape (n,)
        Of one time.
    first, stop : int
        Which samples.
    pixels : int
        How wide the picture is.

    Returns
    -------
    numbers : array, shape (m,)
        Places of the points, in samples from the first of all.
    drawn : dict of str to array, shape (m,)
        The samples, where they are few; else of each column the lowest and the highest, in the
        order in which they come in the signal.
    """
    count = stop - first
    if count <= PER_PIXEL * pixels:
        numbers = np.arange(first, stop, dtype=np.float64)
        return numbers, {name: each[first:stop] for name, each in signals.items()}
    edges = first + np.arange(pixels, dtype=np.int64) * count // pixels
    middle = (edges + np.append(edges[1:], stop)) / 2.0
    quarter = count / pixels / 4.0
    numbers = np.stack([middle - quarter, middle + quarter], axis=1).ravel()
    return numbers, {name: _extremes(each[:stop], edges) for name, each in signals.items()}


def _extremes(values: FloatArray, edges: NDArray[np.int64]) -> FloatArray:
    low, high = np.minimum.reduceat(values, edges), np.maximum.reduceat(values, edges)
    # Where the signal falls within a column its highest comes first, as a line would draw it.
    ends = np.append(edges[1:], values.size) - 1
    falls = values[ends] < values[edges]
    return np.where(
        falls[:, np.newaxis], np.stack([high, low], axis=1), np.stack([low, high], axis=1)
    ).ravel()


def dots(
    x: FloatArray,
    y: FloatArray,
    limits: tuple[float, float, float, float],
    pixels: tuple[int, int],
) -> tuple[FloatArray, FloatArray]:
    """Return points that colour the same pixels as all points do, one in each.

    Parameters
    ----------
    x, y : array, shape (n,)
        The points; those that are not finite are left out.
    limits : tuple of float
        Lowest and highest x, lowest and highest y of the picture.
    pixels : tuple of int
        Its width and height.
    """
    left, right, bottom, top = limits
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    column = np.clip((x - left) / max(right - left, 1e-300) * pixels[0], 0, pixels[0] - 1)
    row = np.clip((y - bottom) / max(top - bottom, 1e-300) * pixels[1], 0, pixels[1] - 1)
    place = column.astype(np.int64) * pixels[1] + row.astype(np.int64)
    _, first = np.unique(place, return_index=True)
    return x[first], y[first]
