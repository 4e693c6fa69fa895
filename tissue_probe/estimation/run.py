"""A kernel at work on one stream of samples.

Contents: calling machine code with the addresses of arrays.
"""

from __future__ import annotations

import ctypes

import numpy as np
from numpy.typing import NDArray

from tissue_probe.estimation.kernel import Kernel
from tissue_probe.estimation.settings import EstimatorSettings

FloatArray = NDArray[np.float64]

# The address of a list of addresses. ctypes calls its functions without Python's lock.
INITIALISE = ctypes.CFUNCTYPE(None, ctypes.c_void_p)
RUN = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p, *3 * [ctypes.c_int64])


class Run:
    """All that a kernel knows of one stream, and the samples that it is given next.

    Parameters
    ----------
    kernel : Kernel
        The kernel to run; it knows nothing but the prior yet.
    settings : EstimatorSettings
        Instrument, noise and prior.
    sample_period : float
        Time between two samples [s].

    Attributes
    ----------
    kernel : Kernel
        As given.
    constants : array
        Its numbers that do not change.
    """

    def __init__(self, kernel: Kernel, settings: EstimatorSettings, sample_period: float) -> None:
        self.kernel = kernel  # which keeps the machine code in memory
        entries = kernel.code.addresses
        self._start, self._reopen = (INITIALISE(entries[n]) for n in ("start_on", "reopen_on"))
        self._run = RUN(entries["run_on"])
        self.constants = kernel.constants(settings, sample_period)
        self._memory = np.zeros(kernel.size)
        self._samples = np.empty((2, 0))
        self._estimates = np.empty((11, 0))
        self._length = 0
        self._addresses = (ctypes.c_void_p * 5)()
        self._addresses[0] = _address(self.constants)
        self._addresses[1] = _address(self._memory)
        self._arrays = ctypes.addressof(self._addresses)
        self.start()

    @property
    def memory(self) -> FloatArray:
        """All that the kernel knows now, as a copy."""
        return self._memory.copy()

    def resume(self, memory: FloatArray) -> None:
        """Know all that is in a memory of this kernel."""
        self._memory[:] = memory

    def start(self) -> None:
        """Forget everything."""
        self._start(self._arrays)

    def reopen(self) -> None:
        """Keep the estimates of the tissue, where samples were lost."""
        self._reopen(self._arrays)

    def take(self, position: FloatArray, force: FloatArray, estimates: FloatArray) -> None:
        """Take in samples, and where their estimates go.

        Parameters
        ----------
        position, force : array, shape (n,)
            At least one sample.
        estimates : array of float64, shape (11, n)
            Contiguous; receives the rows of ``TissueEstimates`` from ``stiffness`` on.
        """
        length = len(position)
        if len(force) != length or estimates.shape != (11, length):
            raise ValueError(f"{position.shape}, {force.shape} and {estimates.shape} do not match")
        address = _address(estimates)
        if length > self._samples.shape[1]:
            self._samples = np.empty((2, length))
            self._addresses[2:4] = [_address(row) for row in self._samples]
        self._samples[0, :length] = position
        self._samples[1, :length] = force
        self._estimates, self._length = estimates, length  # kept, since the address is
        self._addresses[4] = address

    def filter(self, begin: int, end: int) -> int:
        """Filter the samples from ``begin`` to ``end``; return how many of them were missing."""
        return int(self._run(self._arrays, self._length, begin, end))


def _address(array: FloatArray) -> int:
    """Return where an array begins.

    Raises
    ------
    ValueError, TypeError
        If it does not hold float64, is not contiguous, or must not be written.
    """
    if array.dtype.char != "d":
        raise ValueError(f"numbers are {array.dtype}, not float64")
    return ctypes.addressof(ctypes.c_double.from_buffer(array.data))
