"""Fitting a composed model by output error: the unknowns, their scales and their priors.

Contents: unknowns, tolerances, priors of a start, noise and its weights.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from tissue_probe.diagnosis.fitting.runs import Runs
from tissue_probe.diagnosis.observation.flicker import Evening
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.errors import MeasurementError
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.extent import SLOWEST_RELAXATION
from tissue_probe.physics.kinds import RELAXATION
from tissue_probe.physics.response import Between, Response, course, respond
from tissue_probe.physics.rigs.constants import CONTACT_POSITION
from tissue_probe.signals import FloatArray, IntArray

#: A rig's constant stays within this many standard deviations of its tolerance, and the start of a
#: motion that goes on of its prior. Where the model lacks an effect, its residual would else
#: outweigh any prior, and rig or start make up for the effect.
FARTHEST = 4.0
#: Parameters whose bounds span more than this factor are searched by their logarithm.
LOGARITHMIC = 50.0
#: The place of the first touch, by name.
CONTACT_NAME = CONTACT_POSITION.name
#: How far a state may be off at the start at least [m]: at rest without load, or soon forgotten.
LEAST_START = 1e-8
#: How fast a probe at rest may be [m/s].
RESTING_SPEED = 1e-4


class StartPrior(NamedTuple):
    """The prior of the states at a first sample: mean and precision.

    ``precision``, shape (n, n), is the inverse of their covariance.
    """

    mean: FloatArray
    deviation: FloatArray
    precision: FloatArray


@lru_cache(maxsize=64)
def history(rates: bytes) -> FloatArray:
    """Return the inverse correlation of states that forget one history at these rates [1/s].

    A branch that forgets at the rate r holds the integral of exp(-r s) x'(-s) over the time s
    before the first sample. Of a tip's velocity x' that may have been any, as white noise, two
    branches hold integrals that correlate as 2 sqrt(r q) / (r + q): nearly the same where rates are
    near. States that do not forget, of rate 0, have each its own start, and so has a state that
    forgets at once.

    Parameters
    ----------
    rates : bytes
        Those of an array of float64, shape (n,).

    Returns
    -------
    array, shape (n, n)
    """
    r = np.frombuffer(rates)
    branches = np.flatnonzero((r > 0.0) & np.isfinite(r))
    inverse = np.eye(r.size)
    if branches.size > 1:
        r = r[branches]
        alike = 2.0 * np.sqrt(np.multiply.outer(r, r)) / np.add.outer(r, r)
        # Two of one rate are one: nothing but rounding separates them.
        alike.flat[:: r.size + 1] += 1e-6
        inverse[np.ix_(branches, branches)] = np.linalg.inv(alike)
    return inverse


class Problem:
    """Unknowns of a model under measurements: their scales and their priors.

    The unknowns are the values (constants of the rig held or drawn to their tolerances; those of
    ``Runs``), then the states at the start of each measurement, drawn to where a probe at rest has
    them.

    Parameters
    ----------
    composition : Composition
        The model.
    measurements : sequence of Measurement
        All of one specimen.
    instrument : Instrument
        The constants of the rig with their tolerances.
    """

    def __init__(
        self,
        composition: Composition,
        measurements: Sequence[Measurement],
        instrument: Instrument,
        held: Mapping[str, float] | None = None,
    ) -> None:
        self.composition, self.instrument = composition, instrument
        self.measurements = tuple(measurements)
        _check_output(composition, self.measurements)
        self.kernel = composition.kernel
        self.held = dict(held or {})
        self.runs = Runs(composition, self.measurements, instrument.of_run)
        entries = self.runs.entries
        constants = instrument.constants
        self.nominal = np.array([constants.get(e.name, (e.default, 0.0))[0] for e in entries])
        deviation = [constants.get(e.name, (0.0, np.inf))[1] for e in entries]
        self.deviation = np.array(deviation)
        for effect in composition.all_effects:
            self._hold([composition.kernel.values.index(n) for n in effect.of_part], effect.neutral)
        if instrument.free_touch:
            self._free_touch()
        for index, entry in enumerate(entries):
            if entry.name in self.held:
                self.nominal[index], self.deviation[index] = self.held[entry.name], 0.0
        own = np.isinf(self.deviation)
        self.lower = np.array([e.lower for e in entries])
        self.upper = np.array([e.upper for e in entries])
        slowest = SLOWEST_RELAXATION / max(m.begins + m.extent.duration for m in self.measurements)
        forgetting = np.isin(self.runs.meanings, _name_relaxation_rates(composition))
        self.lower = np.where(forgetting, np.maximum(self.lower, slowest), self.lower)
        tolerated = ~own & (self.deviation > 0)
        reach = np.where(tolerated, FARTHEST * self.deviation, 0.0)
        self.lower = np.where(tolerated, np.maximum(self.lower, self.nominal - reach), self.lower)
        self.upper = np.where(tolerated, np.minimum(self.upper, self.nominal + reach), self.upper)
        # A stated constant of a rig holds, however large or small it is.
        self.lower = np.where(own, self.lower, np.minimum(self.lower, self.nominal))
        self.upper = np.where(own, self.upper, np.maximum(self.upper, self.nominal))
        self.logarithmic = own & (self.lower > 0)
        self.logarithmic &= self.upper > LOGARITHMIC * np.where(self.lower > 0, self.lower, 1.0)
        self.free = self.deviation > 0
        self.unknowns = int(np.sum(own))
        self.states = len(self.kernel.states)
        self.count = len(entries)
        self.drawn = np.flatnonzero(tolerated)
        begun = self.states * len(self.measurements)
        self.searched = np.concatenate([self.free, np.ones(begun, dtype=bool)])
        self.by_logarithm = np.concatenate([self.logarithmic, np.zeros(begun, dtype=bool)])
        flicker = instrument.flicker_noise or 0.0
        self.evenings = [
            Evening.of(count, flicker / m.noise.own, m.resampling.power(count))
            for m, count in ((m, m.force.size) for m in self.measurements)
        ]

    def _hold(self, places: Sequence[int] | IntArray, value: float) -> None:
        self.nominal[places], self.deviation[places] = value, 0.0

    def _free_touch(self) -> None:
        """Let each run touch anywhere about the lower end of its travel, as far as that is long.

        A constant of the force would be the same to first order: there is none beside it.
        """
        zeros = {effect.zero for effect in self.composition.all_effects} - {""}
        self._hold(np.flatnonzero(np.isin(self.runs.meanings, list(zeros))), 0.0)
        contact, numbers = self.composition.kernel.values.index(CONTACT_NAME), self.runs.numbers
        for number in range(self.runs.count):
            pairs = zip(self.measurements, numbers, strict=True)
            positions = np.concatenate([each.position for each, run in pairs if run == number])
            place = self.runs.places[numbers.index(number)][contact]
            self.nominal[place], self.deviation[place] = np.min(positions), np.ptp(positions)

    def begin(self, values: FloatArray) -> list[StartPrior]:
        """Return the prior of the states at the start of each measurement."""
        begins = []
        for index, measurement in enumerate(self.measurements):
            own, extent = self.runs.values_in(index, values), measurement.extent
            rates = self.kernel.relaxation_rates(own)
            alike, forgetting = history(rates.tobytes()), rates > 0.0
            second = np.zeros(1) if measurement.input2 is None else measurement.input2
            first = measurement.position[0], measurement.force[0], second[0]
            z = self.kernel.begin(own, *first)
            loaded = abs(self._indentation(own, z, measurement.position[0]))
            depth = extent.indentation + loaded
            still = measurement.at_rest
            if not still:  # all that moves goes with the coil
                z[[spread == "speed" for spread in self.kernel.spreads]] = measurement.first_speed
            scale = self.composition.scale
            shortest = LEAST_START * scale.length
            length = loaded + shortest if still else depth
            spreads = {
                **dict(zip(self.kernel.values, map(float, own), strict=True)),
                "free": depth,
                "length": length,
                "branch": length,
                "speed": RESTING_SPEED * scale.of("m/s") if still else 2 * extent.speed,
                "none": 2 * measurement.noise.own,
                "counted": shortest,
                "input2": float(np.ptp(second)) + LEAST_START,
            }
            deviation = np.array([spreads[name] for name in self.kernel.spreads])
            if not still:  # a branch holds its memory times the speed
                felt = np.maximum(extent.speed / rates[forgetting], shortest)
                deviation[forgetting] = np.minimum(deviation[forgetting], felt)
            begins.append(StartPrior(z, deviation, alike / np.multiply.outer(deviation, deviation)))
        return begins

    def _indentation(self, values: FloatArray, z: FloatArray, position: float) -> float:
        """Indentation at the start: a state where the load cell yields, else the coil's place."""
        if "free" in self.kernel.spreads:
            return float(z[self.kernel.spreads.index("free")])
        return float(position - values[self.kernel.values.index(CONTACT_NAME)])

    def simulate(
        self, values: FloatArray, starts: Sequence[FloatArray]
    ) -> list[tuple[FloatArray, FloatArray]]:
        """Residual and sensitivity of the output for each measurement."""
        result = []
        for index, (measurement, start) in enumerate(zip(self.measurements, starts, strict=True)):
            response = self.response(index, measurement.input_values, values, start)
            sensitivity = self.runs.spread(index, response.sensitivity)
            result.append((measurement.output_values - response.output, sensitivity))
        return result

    def response(
        self, index: int, driven: FloatArray, values: FloatArray, start: FloatArray
    ) -> Response:
        """Simulate the model where a measurement's input was, or might have been, another."""
        measurement, own = self.measurements[index], self.runs.values_in(index, values)
        period, begins = measurement.sample_period, measurement.begins
        between = measurement.between or Between.smooth
        coil = course(
            *(self.kernel, measurement.on_grid(driven), period, own, begins),
            *(measurement.at_rest, between, measurement.fineness),
            None if measurement.input2 is None else measurement.on_grid(measurement.input2),
        )
        found = respond(self.kernel, own, start, coil)
        return Response(*map(measurement.interpolate_columns, (found.output, found.sensitivity)))

    def weighed(self, index: int, columns: FloatArray) -> FloatArray:
        """Return samples of a measurement, shape (N,) or (N, m), over the noise in them."""
        return self.evenings[index].even(self.measurements[index].over_noise(columns))

    def cosines(self, index: int, columns: FloatArray) -> FloatArray:
        """Return the cosines of ``weighed``."""
        return self.evenings[index].cosines(self.measurements[index].over_noise(columns))


def _name_relaxation_rates(composition: Composition) -> list[str]:
    """Name the values that are rates at which the tissue relaxes."""
    return [
        entry.name
        for effect in composition.all_effects
        if effect.family == RELAXATION
        for entry in effect.parameters
        if entry.unit == "1/s"
    ]


def _check_output(composition: Composition, measurements: Sequence[Measurement]) -> None:
    output = composition.output
    for measurement in measurements:
        if measurement.output is not output:
            raise MeasurementError(
                f"the rig {composition.rig} predicts the {output.name}, and the measurement is for "
                f"one that predicts the {measurement.output.name}; give Measurement(output=...)"
            )
