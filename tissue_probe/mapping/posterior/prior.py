"""How likely an inclusion is before any site was felt: number, place, extent, contrast, shape.

Contents: the prior, and draws from it.

An inclusion is a row of seven numbers, whose columns are named here. Its contrast c says how many
times stiffer than the background its middle feels; ``LOG_CONTRAST`` holds log c, negative where it
is softer.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from tissue_probe.signals import FloatArray

X, Y, LOG_RADIUS, LOG_CONTRAST, LOG_EXPONENT, LOG_ASPECT, ANGLE = range(7)
PARAMETERS = 7
#: An inclusion more than so many is the sign of a model that does not fit.
MOST_INCLUSIONS = 16

#: Of each further inclusion over one fewer.
FURTHER = 0.6
#: Two whose distance is a share of the sum of their radii are so likely: that share to this power.
OVERLAP_POWER = 8.0
#: The felt radius, at half height [mm]. A tip of 3 mm radius feels nothing narrower than about
#: itself; inclusions that are sought have 3 to 10 mm (nodules in lung and liver, prostate).
RADIUS, RADIUS_SPREAD = 4.5, 0.4
LEAST_RADIUS, LARGEST_INCLUSION = 1.5, 20.0
#: |log c| is a gamma variable of shape 2: an inclusion without contrast is none, and contrasts of
#: 1.3 to 3 are felt (finite elements: 1.2 to 1.7 for nodules eight times stiffer).
CONTRAST_SCALE = 0.3
LARGEST_LOG_CONTRAST = 3.0
#: Soft inclusions (cysts, abscesses) are sought less often.
SOFT = 0.1
#: Soft ones, however many overlap, leave this share of the background's stiffness: tissue pushes.
LEAST_LEFT = 0.05
#: Exponent p of the shape 2^-(r/R)^p: 1 is peaked with a long tail, 2 a Gaussian, 8 a plateau, 60 a
#: step. Tissue above an inclusion smooths its edge; one at the surface has a hard edge, and the
#: data choose between the two kinds.
EDGE_EXPONENT, EXPONENT_SPREAD = 2.0, 0.45
HARD, HARD_EXPONENT, HARD_SPREAD = 0.25, 15.0, 0.7
LEAST_EXPONENT, LARGEST_EXPONENT = 0.9, 60.0
#: log of the ratio of the axes, half-normal.
ASPECT_SPREAD = 0.4
LARGEST_ASPECT = 3.0


@njit(cache=True, nogil=True, error_model="numpy")
def log_normal(value: float, middle: float, spread: float) -> float:
    """Return the log density of a normal variable, up to a constant that is the same each time."""
    return -0.5 * ((value - middle) / spread) ** 2 - math.log(spread)


@njit(cache=True, nogil=True, error_model="numpy")
def log_prior_of_contrast(log_contrast: float) -> float:
    """Return the log density of log c, -inf beyond the largest."""
    size = abs(log_contrast)
    if size > LARGEST_LOG_CONTRAST or size == 0.0:
        return -np.inf
    sign = SOFT if log_contrast < 0.0 else 1.0 - SOFT
    return math.log(sign) + math.log(size / CONTRAST_SCALE**2) - size / CONTRAST_SCALE


@njit(cache=True, nogil=True, error_model="numpy")
def log_prior_of_hard(exponent: float) -> float:
    """Return the log density of the log of the exponent of a hard edge, its share counted."""
    return math.log(HARD) + log_normal(exponent, math.log(HARD_EXPONENT), HARD_SPREAD)


@njit(cache=True, nogil=True, error_model="numpy")
def log_prior_of_exponent(exponent: float) -> float:
    """Return the log density of the log of the exponent, of either kind of edge."""
    smooth = math.log(1.0 - HARD) + log_normal(exponent, math.log(EDGE_EXPONENT), EXPONENT_SPREAD)
    return math.log(math.exp(smooth) + math.exp(log_prior_of_hard(exponent)))


@njit(cache=True, nogil=True, error_model="numpy")
def log_prior_of_shape(row: FloatArray) -> float:
    """Return the log density of extent, exponent and ellipse, up to a constant; -inf outside."""
    radius, exponent, aspect = row[LOG_RADIUS], row[LOG_EXPONENT], row[LOG_ASPECT]
    if (
        not math.log(LEAST_RADIUS) < radius < math.log(LARGEST_INCLUSION)
        or not math.log(LEAST_EXPONENT) < exponent < math.log(LARGEST_EXPONENT)
        or not 0.0 <= aspect < math.log(LARGEST_ASPECT)
    ):
        return -np.inf
    return (
        log_normal(radius, math.log(RADIUS), RADIUS_SPREAD)
        + log_prior_of_exponent(exponent)
        + log_normal(aspect, 0.0, ASPECT_SPREAD)
    )


@njit(cache=True, nogil=True, error_model="numpy")
def draw_shape(row: FloatArray) -> None:
    """Draw extent, exponent and ellipse from the prior."""
    while True:
        row[LOG_RADIUS] = math.log(RADIUS) + RADIUS_SPREAD * np.random.standard_normal()
        middle, spread = math.log(EDGE_EXPONENT), EXPONENT_SPREAD
        if np.random.random() < HARD:
            middle, spread = math.log(HARD_EXPONENT), HARD_SPREAD
        row[LOG_EXPONENT] = middle + spread * np.random.standard_normal()
        row[LOG_ASPECT] = abs(ASPECT_SPREAD * np.random.standard_normal())
        row[ANGLE] = np.pi * np.random.random()
        if log_prior_of_shape(row) > -np.inf:
            return


@njit(cache=True, nogil=True, error_model="numpy")
def draw_contrast() -> float:
    """Draw log c from the prior."""
    size = -CONTRAST_SCALE * math.log(np.random.random() * np.random.random())
    return -size if np.random.random() < SOFT else size
