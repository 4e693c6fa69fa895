"""Several runs of one specimen: which values of a model belong to each, such as a phase.

What belongs here: values of all runs in one vector, and those of one measurement out of it.
What does not: how they are found (``problem``, ``search``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tissue_probe.diagnosis.fitting.measurement import Measurement
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.entry import Entry
from tissue_probe.signals import FloatArray


class Runs:
    """Values of a model under measurements of one or more runs.

    First come those of the first run, in the kernel's order; then of each further run what belongs
    to it (``Effect.of_run``). All else is the same in every run.

    Parameters
    ----------
    composition : Composition
        The model.
    measurements : sequence of Measurement
        Of one run those that say so (``Measurement.run``).
    """

    def __init__(self, composition: Composition, measurements: Sequence[Measurement]) -> None:
        names = composition.kernel.values
        meanings = list(names)
        of_run = {name for effect in composition.all_effects for name in effect.of_run}
        own = [place for place, name in enumerate(names) if name in of_run]
        numbers: dict[object, int] = {}
        #: The number of each measurement's run.
        self.numbers = [
            numbers.setdefault(m.run or index, len(numbers)) for index, m in enumerate(measurements)
        ]
        entries = list(composition.values)
        #: Of each run, the place of each of the kernel's values among all.
        self.places = [np.arange(len(names))]
        for number in range(1, len(numbers)):
            place = self.places[0].copy()
            place[own] = len(entries) + np.arange(len(own))
            self.places.append(place)
            entries += [_renamed(composition.values[each], number) for each in own]
            meanings += [names[each] for each in own]
        #: What is declared of each value.
        self.entries: tuple[Entry, ...] = tuple(entries)
        #: How many runs there are.
        self.count = len(self.places)
        #: Names of all values; of a further run see ``name_in``.
        self.names = tuple(entry.name for entry in entries)
        #: Their names in the kernel, which are those of the first run.
        self.meanings = tuple(meanings)

    def values_in(self, index: int, values: FloatArray) -> FloatArray:
        """Return the kernel's values for a measurement, shape (q,), of all values."""
        return values[self.places[self.numbers[index]]]

    def named_in(self, number: int, named: Mapping[str, float]) -> dict[str, float]:
        """Return values by the kernel's names, for a run, of all values by their names."""
        places = self.places[number]
        return {self.meanings[place]: named[self.names[place]] for place in places}

    def told_in(self, number: int, values: Mapping[str, float]) -> dict[str, float]:
        """Return values by their names among all, of values for a run by the kernel's names."""
        own = {self.meanings[place]: self.names[place] for place in self.places[number]}
        return {own[name]: value for name, value in values.items()}

    def spread(self, index: int, sensitivity: FloatArray) -> FloatArray:
        """Return derivatives by start and all values, of those by start and the kernel's values."""
        place = self.places[self.numbers[index]]
        states = sensitivity.shape[1] - place.size
        if len(self.entries) == place.size:
            return sensitivity
        spread = np.zeros((len(sensitivity), states + len(self.entries)))
        spread[:, :states] = sensitivity[:, :states]
        spread[:, states + place] = sensitivity[:, states:]
        return spread


def name_in(name: str, number: int) -> str:
    """Return the name of a value that belongs to a run, for that run; the first is number 0."""
    return f"{name} of run {number + 1}" if number else name


def _renamed(entry: Entry, number: int) -> Entry:
    return replace(entry, name=name_in(entry.name, number))
