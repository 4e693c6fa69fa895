"""A fault of samples: one finding, and the rows of samples that it concerns.

Contents: the record of a finding.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """Something wrong with the samples.

    Attributes
    ----------
    name : str
        One of those that ``inspection.inspect`` or ``fit_checks.check_fit`` lists, ``as_read``, or
        ``curtailed``.
    sentence : str
        The fault, and its remedy.
    fatal : bool
        Whether a fit of any model would be worthless.
    spans : tuple of (first, stop)
        Which samples it concerns; empty if all.
    channel : str
        ``position`` or ``force``, where it concerns one of them by its values alone.
    """

    name: str
    sentence: str
    fatal: bool = False
    spans: tuple[tuple[int, int], ...] = ()
    channel: str = ""

    @property
    def samples(self) -> int:
        """How many samples it concerns, where it concerns some."""
        return sum(stop - first for first, stop in self.spans)
