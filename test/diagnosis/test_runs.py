"""Parts of one run share a clock; of several runs each has its own phases and instants."""

from dataclasses import replace

import numpy as np
import pytest
from hidden import EXACT, challenge, first_of, library, measurement
from hypothesis import given, settings
from hypothesis import strategies as st

from tissue_probe.diagnosis.diagnosis import diagnose
from tissue_probe.diagnosis.fitting.runs import Runs
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.observation.noise import Noise
from tissue_probe.diagnosis.ranking.other_runs import carry_model
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS

TIMED = "mains_hum", "tissue_motion", "force_drift", "stiffness_step", "stiffness_ramp"
#: What else might be told instead.
OTHERS = "force_bias", "structural_mode", "standard_linear_solid", "cubic_stiffening"
NUMBERS = dict(zip(TIMED, range(700001, 700006), strict=True))


def hidden(name):
    return challenge(NUMBERS[name], name, excitation="chirp60")


def parts(whole: Measurement, *, cut: int, lost: int) -> list[Measurement]:
    """What remains of a run of which some samples in the midst are lost."""
    before = replace(
        whole, position=whole.position[:cut], force=whole.force[:cut], used=None, run="it"
    )
    after = replace(
        whole,
        position=whole.position[cut + lost :],
        force=whole.force[cut + lost :],
        used=None,
        at_rest=False,
        run="it",
        begins=(cut + lost) * whole.sample_period,
    )
    return [before, after]


@pytest.mark.parametrize("name", first_of(TIMED, 2))
def test_what_moves_with_time_is_found_across_a_gap(name):
    whole = measurement(hidden(name).recording)
    pieces = parts(whole, cut=1600, lost=21)
    effects = library(name, *OTHERS)
    of_whole, of_parts = (
        diagnose(Composition(), each, EXACT, effects).ladder.final for each in ([whole], pieces)
    )
    assert of_parts.composition.names == of_whole.composition.names == (name,)
    assert of_parts.ratio < 1.03
    assert of_parts.names == of_whole.names
    kept = np.delete(of_whole.predicted[0], np.arange(1600, 1621))
    off = np.concatenate(of_parts.predicted) - kept
    assert np.sqrt(np.mean(off**2)) < 0.2 * whole.noise.own


@pytest.mark.parametrize("name", first_of(TIMED, 2))
def test_two_runs_have_each_its_own_phase_or_instant(name):
    made = hidden(name)
    both = [measurement(made.recording), measurement(made.second)]
    final = diagnose(Composition(), both, EXACT, library(name, *OTHERS)).ladder.final
    assert final.composition.names == (name,)
    assert final.ratio < 1.03
    own = {f"{each} of run 2" for each in EFFECTS[name].of_run}
    assert set(final.names) - set(final.composition.kernel.values) == own
    # Each run's own values are those that it has alone, all else being held.
    for number, one in enumerate(both):
        alone = carry_model(final.composition, final.named(), [one], EXACT)
        assert alone.misfits[0] == pytest.approx(final.misfits[number], rel=0.01)


@pytest.mark.parametrize("name", first_of(TIMED, 2))
def test_a_model_carries_over_whatever_the_phase_or_instant_of_the_other_run(name):
    made = hidden(name)
    one, other = measurement(made.recording), measurement(made.second)
    found = diagnose(Composition(), [one], EXACT, library(name, *OTHERS), [other])
    assert found.carries_over
    assert found.heldout(found.ladder.final) < 1.05 * other.noise.own


@pytest.mark.parametrize("name", ["mains_hum", "tissue_motion", "stiffness_step"])
@pytest.mark.parametrize("later", first_of([1500, 377], 1))
def test_a_phase_or_an_instant_is_found_wherever_it_is_in_the_other_run(name, later):
    made = hidden(name)
    one, other = measurement(made.recording), measurement(made.second)
    fit = diagnose(Composition(), [one], EXACT, library(name)).ladder.final
    late = replace(
        other,
        position=other.position[later:],
        force=other.force[later:],
        used=None,
        at_rest=False,
    )
    assert carry_model(fit.composition, fit.named(), [late], EXACT).rmse < 1.05 * other.noise.own


@given(runs=st.lists(st.sampled_from(["", "a", "b"]), min_size=1, max_size=5))
@settings(max_examples=50)
def test_every_measurement_has_the_values_of_its_run(runs):
    zeros = np.zeros(20)
    composition = Composition().plus(EFFECTS["mains_hum"])
    measurements = [Measurement(zeros, zeros, 1e-3, noise=Noise(1.0), run=run) for run in runs]
    layout = Runs(composition, measurements)
    own = len({run for run in runs if run}) + runs.count("")
    size = len(composition.values)
    assert layout.count == own
    assert len(set(layout.names)) == len(layout.names) == size + 2 * (own - 1)
    values = np.arange(len(layout.names), dtype=float)
    for index, run in enumerate(runs):
        got = dict(zip(composition.kernel.values, layout.values_in(index, values), strict=True))
        told = layout.name_for_run(
            layout.numbers[index], dict(zip(layout.names, values, strict=True))
        )
        assert got == told
        same = [i for i in range(len(runs)) if run and runs[i] == run] or [index]
        assert {layout.numbers[i] for i in same} == {layout.numbers[index]}
        # Derivatives stand where the values do, and nowhere else.
        columns = layout.spread(index, np.ones((3, 2 + size)))
        assert columns.shape == (3, 2 + len(values))
        assert columns.sum() == 3 * (2 + size)
        moved = values.copy()
        moved[np.flatnonzero(columns[0, 2:] == 0.0)] = -1.0
        assert np.array_equal(layout.values_in(index, moved), list(got.values()))
