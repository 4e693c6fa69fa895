"""A list of sites: where tissue was felt, and how stiff it was there.

Contents: the list, checked, and which of its rows tell something.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_probe.errors import ParameterError
from tissue_probe.signals import FloatArray

#: A tip that half hangs over a rim, or touches fluid, feels less than a tenth of the tissue.
LEAST_CONTACT = 0.1
#: Standard deviations over the value itself, beyond which it tells nothing: what the other sites
#: tell would be lost in rounding beside the square of it.
LEAST_KNOWN = 1e6
#: Memory and time rise with the square and cube of the number of sites.
MOST_MAPPED = 1000


@dataclass(frozen=True)
class Sites:
    """Results of sites in any order; repeats are rows of their own. Arrays have shape (n,).

    Attributes
    ----------
    x, y, z : array
        Position on the tissue's surface [m].
    t : array or None
        When each was felt [s], from any start.
    k, k_sd : array
        Stiffness and its standard deviation [N/m]; NaN where the site has no value.

    Raises
    ------
    ParameterError
        If arrays differ in length, or a place is not finite, or a value has no error.
    """

    x: FloatArray
    y: FloatArray
    z: FloatArray
    t: FloatArray | None
    k: FloatArray
    k_sd: FloatArray

    def __post_init__(self) -> None:
        columns = {"x": self.x, "y": self.y, "z": self.z, "k": self.k, "k_sd": self.k_sd}
        columns |= {"t": self.t} if self.t is not None else {}
        for name, values in columns.items():
            if values.shape != self.x.shape or values.ndim != 1:
                raise ParameterError(
                    f"{name} has shape {values.shape}, x {self.x.shape}: give a value a site"
                )
            if name in "xyzt" and not np.isfinite(values).all():
                row = int(np.flatnonzero(~np.isfinite(values))[0])
                raise ParameterError(f"{name} of site {row} is {values[row]}: give a number")
        bad = np.isfinite(self.k) & ~((self.k_sd >= 0.0) & np.isfinite(self.k_sd))
        if bad.any():
            row = int(np.flatnonzero(bad)[0])
            raise ParameterError(
                f"k_sd of site {row} is {self.k_sd[row]}: give its standard deviation in N/m, "
                "0 or above"
            )
        unknown = self.felt & (self.k_sd > LEAST_KNOWN * np.where(self.felt, self.k, 1.0))
        if unknown.any():
            row = int(np.flatnonzero(unknown)[0])
            raise ParameterError(
                f"k_sd of site {row} is {self.k_sd[row]:.4g} N/m, and its k {self.k[row]:.4g} N/m: "
                "it tells nothing; leave its k out (NaN), or check the units"
            )
        if self.felt.sum() > MOST_MAPPED:
            raise ParameterError(
                f"{self.felt.sum()} sites have a value; a map takes at most {MOST_MAPPED}: pool "
                "neighbours, or map a part"
            )

    @property
    def felt(self) -> np.ndarray:
        """Whether each site tells a stiffness: a value, positive, and of a tip in contact."""
        positive = np.isfinite(self.k) & (self.k > 0.0)
        if not positive.any():
            return positive
        return positive & (self.k > LEAST_CONTACT * np.median(self.k[positive]))

    @property
    def hanging(self) -> np.ndarray:
        """Whether each site was palpated without contact: there is no tissue, or none known."""
        hanging: np.ndarray = np.isfinite(self.k) & ~self.felt
        return hanging

    @property
    def left_out(self) -> tuple[str, ...]:
        """Why rows tell nothing, in sentences."""
        without = int((~np.isfinite(self.k)).sum())
        hanging = int(self.hanging.sum())
        told = []
        if without:
            told.append(f"{without} of {self.x.size} sites have no value: unknown there")
        if hanging:
            told.append(
                f"{hanging} of {self.x.size} sites feel less than {LEAST_CONTACT:.0%} of the "
                "median, which is no contact: unknown there"
            )
        return tuple(told)
