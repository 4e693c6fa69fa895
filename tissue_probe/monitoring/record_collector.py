"""One record out of the stream of samples: from where the coil follows an excitation on.

Contents: the samples that are collected.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tissue_probe.excitation import parse_excitation
from tissue_probe.monitoring.experiments import own_settings
from tissue_probe.monitoring.identification import LiveRecord
from tissue_probe.signals import FloatArray, SampleBlock

#: A command is that of an excitation where it is right to this share of the amplitude: 16 bits of
#: 10 V, as a DAQ has them, are 0.3 mV of the usual volt.
SAME = 1e-3


class RecordCollector:
    """Collects consecutive samples in which the coil follows an excitation.

    Samples of an earlier excitation are passed over. After a hole it begins anew: a record has
    none.

    Parameters
    ----------
    excitation : mapping
        As the driver has it.
    seconds : float
        Length of the record [s].
    path : str
        Of the file of the record, if it has one.
    """

    def __init__(self, excitation: Mapping[str, object], seconds: float, path: str = "") -> None:
        self._excitation = own_settings(excitation)
        self._command = parse_excitation(dict(self._excitation))
        self._seconds, self._path = seconds, path
        self._blocks: list[SampleBlock] = []

    @property
    def seconds(self) -> float:
        """Time collected so far [s]."""
        return sum(len(each) * each.sample_period for each in self._blocks)

    def takes(self, block: SampleBlock) -> bool:
        """Take the next samples, if the coil follows the excitation in all of them.

        Raises
        ------
        ValueError
            If some are not finite.
        """
        number = block.sequence + np.arange(len(block), dtype=np.float64)
        wanted = self._command(number * block.sample_period)
        # A command that is not known is none of this excitation.
        if not (abs(block.command - wanted) <= SAME * self._command.amplitude).all():
            self._blocks.clear()
            return False
        if not (np.isfinite(block.position).all() and np.isfinite(block.force).all()):
            raise ValueError(
                "samples are not finite: look at the cables of encoder and load cell, then ask "
                "again"
            )
        if self._blocks and not block.continues(self._blocks[-1]):
            self._blocks.clear()
        self._blocks.append(block)
        return True

    def record(self) -> LiveRecord | None:
        """Return the record; None while it is not complete."""
        if not self._blocks or self.seconds < self._seconds:
            return None
        return LiveRecord(
            self._join("position"),
            self._join("force"),
            self._join("command"),
            self._blocks[0].sample_period,
            self._excitation,
            self._path,
        )

    def _join(self, channel: str) -> FloatArray:
        return np.concatenate([getattr(block, channel) for block in self._blocks])
