"""Several runs of one specimen, and their parts: which values of a model belong to each.

Contents: values of all runs in one vector, and those of one measurement out of it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.entry import Entry
from tissue_probe.signals import FloatArray, IntArray


class Runs:
    """Values of a model under measurements of one or more runs, each of one or more parts.

    First come those of the first measurement, in the kernel's order; then of each further run its
    own values (``Effect.of_run``), and of each further part of a run its differences from the first
    (``Effect.of_part``). All else is the same everywhere.

    Parameters
    ----------
    composition : Composition
        The model.
    measurements : sequence of Measurement
        Of one run those that say so (``Measurement.run``): its parts.
    constants : collection of str
        Constants of the instrument that belong to a run, too.
    """

    def __init__(
        self,
        composition: Composition,
        measurements: Sequence[Measurement],
        constants: Collection[str] = (),
    ) -> None:
        names = composition.kernel.values
        numbers: dict[object, int] = {}
        #: The number of each measurement's run.
        self.numbers = [
            numbers.setdefault(m.run or index, len(numbers)) for index, m in enumerate(measurements)
        ]
        by_run, by_part = (
            [place for place, name in enumerate(names) if name in of]
            for of in (of_run(composition).union(constants), of_part(composition))
        )
        entries, meanings = list(composition.values), list(names)
        places: list[IntArray] = []

        def add(own: Sequence[int], place: IntArray, called: str) -> None:
            place[own] = len(entries) + np.arange(len(own))
            entries.extend(_rename_entry(composition.values[each], called) for each in own)
            meanings.extend(names[each] for each in own)

        for index, number in enumerate(self.numbers):
            first = self.numbers.index(number)
            place = np.arange(len(names)) if first == index else places[first].copy()
            if first == index and number:
                add(by_run, place, f"run {number + 1}")
            if first < index:
                add(by_part, place, f"part {index + 1}")
            places.append(place)
        #: Of each measurement, the place of each of the kernel's values among all.
        self.places = places
        #: The declaration of each value.
        self.entries: tuple[Entry, ...] = tuple(entries)
        #: How many runs there are.
        self.count = len(numbers)
        #: Names of all values: of a further run, or part, with its number among all measurements.
        self.names = tuple(entry.name for entry in entries)
        #: Their names in the kernel, which are those of the first measurement.
        self.meanings = tuple(meanings)

    def values_in(self, index: int, values: FloatArray) -> FloatArray:
        """Return the kernel's values for a measurement, shape (q,), of all values."""
        return values[self.places[index]]

    def name_for_run(self, number: int, named: Mapping[str, float]) -> dict[str, float]:
        """Return values by the kernel's names, for a run, of all values by their names."""
        places = self._of_run(number)
        return {self.meanings[place]: named[self.names[place]] for place in places}

    def name_among_all(self, number: int, values: Mapping[str, float]) -> dict[str, float]:
        """Return values by their names among all, of values for a run by the kernel's names."""
        own = {self.meanings[place]: self.names[place] for place in self._of_run(number)}
        return {own[name]: value for name, value in values.items()}

    def spread(self, index: int, sensitivity: FloatArray) -> FloatArray:
        """Return derivatives by start and all values, of those by start and the kernel's values."""
        place = self.places[index]
        states = sensitivity.shape[1] - place.size
        if len(self.entries) == place.size:
            return sensitivity
        spread = np.zeros((len(sensitivity), states + len(self.entries)))
        spread[:, :states] = sensitivity[:, :states]
        spread[:, states + place] = sensitivity[:, states:]
        return spread

    def _of_run(self, number: int) -> IntArray:
        """Return the places of the values of a run's first part."""
        return self.places[self.numbers.index(number)]


def of_run(composition: Composition) -> set[str]:
    """Name the values of a model that belong to a run."""
    return {name for effect in composition.all_effects for name in effect.of_run}


def of_part(composition: Composition) -> set[str]:
    """Name the values of a model that belong to a part of a run."""
    return {name for effect in composition.all_effects for name in effect.of_part}


def _rename_entry(entry: Entry, called: str) -> Entry:
    return replace(entry, name=f"{entry.name} of {called}")
