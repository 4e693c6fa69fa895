"""White noise after resampling: it is smoother than before, and no longer white.

Contents: the power of such noise, told from an example.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.fft import dct

from tissue_probe.diagnosis.residuals.noise_floor import noise_beside_steps
from tissue_probe.signals import FloatArray

#: Cosines of noise in a band: so many squares have a mean that is right to a tenth.
BAND = 200


@dataclass(frozen=True)
class Resampling:
    """The change that resampling makes in white noise.

    Attributes
    ----------
    example : array, shape (m,)
        White noise of variance 1, resampled as the samples were; empty where these are as measured.
    """

    example: FloatArray

    @cached_property
    def left(self) -> float:
        """The share of a channel's noise that its roughness shows afterwards."""
        return noise_beside_steps(self.example) if self.example.size else 1.0

    def power(self, count: int) -> FloatArray:
        """Return the power of noise in each of so many cosines over that of white noise.

        Shape (count,), or () where it is 1 in all. Means over so many neighbours of an example's
        cosines that each is right to a tenth.
        """
        if not self.example.size:
            return np.ones(())
        power = dct(self.example, norm="ortho") ** 2
        bands = [float(np.mean(band)) for band in np.array_split(power, max(power.size // BAND, 1))]
        at = (np.arange(count) + 0.5) / count * len(bands) - 0.5
        return np.interp(at, np.arange(len(bands)), bands)


#: Samples as they were measured.
AS_MEASURED = Resampling(np.zeros(0))
