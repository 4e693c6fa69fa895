"""Fits of data whose truth is known: from the challenge's simulator, or this folder's specimen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hidden import EXACT, TOLERANT, challenge, measurement
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from specimen import Specimen, multisine, sine

import tissue_probe as tp
from tissue_probe.diagnosis.fitting.problem import FARTHEST, Problem, history
from tissue_probe.diagnosis.fitting.search import Bar
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.ranking.candidates import fit_base, fit_candidates, refit
from tissue_probe.diagnosis.ranking.starts import extent
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.rigs import OWN

PERIOD = 5e-4


def specimen_measurement(specimen, motion, seed=0, duration=2.0):
    position, _, _, force = specimen.measure(motion, duration, seed)
    return Measurement(position, force, specimen.sample_period, at_rest=True)


def fitted(measurements, *effects, instrument=EXACT):
    base = fit_base(Composition(), measurements, instrument)
    for name in effects:
        (base,) = fit_candidates(base, [EFFECTS[name]], instrument)
    return base


def within(fit, truth, deviations=3.0):
    """Assert that fitted values are the true ones to so many of their standard deviations."""
    for name, value in truth.items():
        off = (fit.named()[name] - value) / fit.deviations()[name]
        assert abs(off) < deviations, f"{name} is off by {off:.1f} standard deviations"


def test_a_constant_that_ends_at_its_tolerances_limit_is_named():
    taken = [measurement(challenge(7, "cubic_stiffening", preload=2e-3).recording)]
    constants = {**OWN.known, "tip_mass": (0.06, 1e-4)}
    off = fitted(taken, "cubic_stiffening", instrument=replace(TOLERANT, constants=constants))
    assert "tip_mass" in off.exhausted
    assert fitted(taken, "cubic_stiffening", instrument=TOLERANT).exhausted == ()


def test_a_value_that_ends_at_its_bound_is_named():
    """The force runs ahead of the position: no damping does that but a negative one."""
    time = np.arange(2000) / 2000.0
    position = 1e-3 * np.sin(20.0 * np.pi * time)
    for damping, ended in ((-1.0, True), (2.0, False)):
        force = 450.0 * position + damping * np.gradient(position, time)
        force += 5e-3 * np.random.default_rng(0).standard_normal(time.size)
        record = {"t": time, "u": position, "F": force}
        found = tp.compare(record, rig="rigid_probe", constants={"tip_mass": 0.0}).to_dict()
        assert found["parameters"]["damping"]["at_limit"] is ended
        assert found["parameters"]["stiffness"]["at_limit"] is False


@pytest.mark.parametrize(
    ("effect", "seed", "preload", "names"),
    [
        ("standard_linear_solid", 3, None, {"branch_stiffness": "relaxing_stiffness",
                                            "branch_rate": "relaxation_rate"}),
        ("cubic_stiffening", 7, 2e-3, {"cubic": "cubic_stiffness"}),
        ("coulomb_friction", 5, None, {"coulomb": "coulomb_force"}),
        ("contact_loss", 4, None, {}),
    ],
)  # fmt: skip
def test_what_was_hidden_is_recovered_within_three_standard_deviations(
    effect, seed, preload, names
):
    made = challenge(seed, effect, preload=preload)
    fit = fitted([measurement(made.recording)], effect)
    assert fit.converged
    assert fit.ratio < 1.05
    hidden = made.answer.parameters[effect]
    truth = {ours: float(np.ravel(hidden[theirs])[0]) for theirs, ours in names.items()}
    within(fit, {**made.answer.tissue, **truth})


@pytest.mark.parametrize("cubic", [0.0, 6e7])
def test_95_percent_intervals_hold_the_truth_as_often_as_they_say(cubic):
    specimen = Specimen(stiffness=800.0, damping=4.0, cubic=cubic)
    position, _, force, _ = specimen.measure(sine(), 1.0)
    noises = 5e-3 * np.random.default_rng(0).standard_normal((20, force.size))
    truth = {"stiffness": 800.0, "damping": 4.0} | ({"cubic_stiffness": cubic} if cubic else {})
    effects = ["cubic_stiffening"] if cubic else []
    first = fitted([Measurement(position, force + noises[0], PERIOD, True)], *effects)
    hits = []
    for noise in noises:
        seen = Measurement(position, force + noise, PERIOD, True)
        fit = refit(first, first.composition, EXACT, [seen])
        values, deviations = fit.named(), fit.deviations()
        hits += [abs(values[n] - v) < 1.96 * deviations[n] for n, v in truth.items()]
        assert max(deviations[n] / abs(v) for n, v in truth.items()) < 0.1  # and not by being wide
    assert np.mean(hits) >= 0.85


def test_tolerances_are_drawn_to_the_nominal_rig_and_hold_the_true_one():
    made = challenge(12, excitation="msine60", rig="tolerant", preload=2e-3)
    fit = fitted([measurement(made.recording)], instrument=TOLERANT)
    true = {**made.answer.rig, "contact_position": made.answer.rig["contact_zero"]}
    for name, (nominal, tolerance) in OWN.known.items():
        assert abs(fit.named()[name] - nominal) < 3.5 * tolerance
        assert 0.0 < fit.deviations()[name] <= 1.05 * tolerance
        off = fit.named()[name] - true[name]
        assert abs(off) < 5.0 * fit.deviations()[name] + 0.5 * tolerance
    within(fit, made.answer.tissue, deviations=5.0)  # 1/f noise is not white


def test_a_rig_that_is_known_is_held():
    fit = fitted([measurement(challenge(7, preload=2e-3).recording)])
    for name, (nominal, _) in OWN.known.items():
        assert (fit.named()[name], fit.deviations()[name]) == (nominal, 0.0)


def test_samples_that_are_not_used_change_nothing():
    specimen = Specimen()
    clean = specimen_measurement(specimen, sine(), seed=1)
    spoilt, used = clean.force.copy(), np.ones(clean.force.size, dtype=bool)
    spoilt[1000:1400] += 5.0
    used[1000:1400] = False
    fit = fitted([replace(clean, force=spoilt, used=used)])
    within(fit, {"stiffness": specimen.stiffness, "damping": specimen.damping})
    assert fit.samples == clean.force.size - 400
    assert fit.ratio == pytest.approx(1.0, abs=0.05)
    assert fit.rmse == pytest.approx(5e-3, rel=0.05)
    assert fit.heldout_rmse == pytest.approx(5e-3, rel=0.05)
    assert fit.noise == pytest.approx(5e-3, rel=0.05)


def test_measurements_of_one_specimen_are_fitted_together():
    specimen = Specimen(stiffness=600.0, damping=6.0)
    runs = [
        specimen_measurement(specimen, motion, seed)
        for seed, motion in enumerate((sine(), sine(), multisine(), multisine(seed=1)))
    ]
    alone, together = fitted(runs[:1]), fitted(runs)
    within(together, {"stiffness": 600.0, "damping": 6.0})
    assert len(together.residuals) == len(together.starts) == 4
    assert together.samples == 4 * alone.samples
    assert together.deviations()["stiffness"] < 0.6 * alone.deviations()["stiffness"]
    assert together.ratio == pytest.approx(1.0, abs=0.03)


def test_measurements_of_two_specimens_do_not_fit_together():
    stiff = specimen_measurement(Specimen(stiffness=1200.0), sine())
    soft = specimen_measurement(Specimen(stiffness=600.0), sine())
    assert fitted([stiff]).ratio < 1.05
    assert fitted([stiff, soft]).ratio > 10.0


def test_what_is_held_out_shows_what_the_fit_hides():
    made = challenge(7, "cubic_stiffening", preload=2e-3)
    base = fitted([measurement(made.recording)])
    assert base.heldout_rmse >= base.rmse
    clean = fitted([measurement(challenge(7, preload=2e-3).recording)])
    assert clean.heldout_rmse == pytest.approx(clean.rmse, rel=0.01)


FEW = [EFFECTS[name] for name in ("cubic_stiffening", "contact_loss")]


@settings(max_examples=12, deadline=None)
@given(
    samples=hnp.arrays(
        float,
        st.tuples(st.integers(2, 2), st.integers(12, 120)),
        elements=st.floats(-1e6, 1e6, width=32) | st.sampled_from([0.0, 1e-3, 1.0]),
    ),
    at_rest=st.booleans(),
)
def test_any_finite_samples_are_fitted_or_refused_in_a_sentence(samples, at_rest):
    seen = Measurement(*samples, PERIOD, at_rest)
    assert np.isfinite(np.hstack(list(vars(seen.extent).values()))).all()
    try:
        base = fit_base(Composition(), [seen], TOLERANT)
    except ValueError as refused:
        assert "check the units" in str(refused)  # noqa: PT017
        return
    reach = extent(base, base.named(), EFFECTS["adhesion"])
    assert np.isfinite(np.hstack(list(vars(reach).values()))).all()
    for fit in (base, *fit_candidates(base, FEW, TOLERANT)):
        assert np.isfinite(fit.values).all()
        assert np.isfinite([fit.rmse, fit.heldout_rmse, fit.bic]).all()
        assert min(fit.deviations().values()) >= 0.0


def test_the_constants_of_a_rig_do_not_make_up_for_what_the_model_lacks():
    made = challenge(3, "force_lag", rig="tolerant")
    fit = fitted([measurement(made.recording)], instrument=TOLERANT)
    assert fit.ratio > 1.3
    for name, (value, deviation) in TOLERANT.constants.items():
        assert abs(fit.named()[name] - value) <= FARTHEST * deviation * (1 + 1e-9)


def test_a_coarse_encoder_explains_what_its_steps_leave():
    made = challenge(4, "encoder_quantization", excitation="msine60")
    (plain,) = [fitted([measurement(made.recording)])]
    found = fitted([measurement(made.recording)], "encoder_quantization")
    assert plain.ratio > 1.3
    assert found.ratio < 1.06
    assert found.rounding > 0.0
    assert plain.rounding == 0.0


@pytest.mark.parametrize("step", [1e-7, 5e-6])
def test_the_encoders_step_is_found_where_no_move_is_as_small(step):
    phase = 2 * np.pi * 10.0 * np.arange(400) * PERIOD + 0.4
    position = np.round((2.3e-3 + 8e-4 * np.sin(phase)) / step) * step
    assert Measurement(position, np.sin(phase), PERIOD).extent.step == pytest.approx(step)


def test_a_smooth_position_has_no_step():
    position = 8e-4 * np.sin(2 * np.pi * 10.0 * np.arange(400) * PERIOD)
    assert Measurement(position, position, PERIOD).extent.step == 0.0


def test_coarse_steps_that_a_model_does_not_smooth_are_not_counted_as_noise():
    made = challenge(4, "encoder_quantization", excitation="msine60")
    assert fitted([measurement(made.recording)], "encoder_interpolation").rounding == 0.0


def test_a_steep_error_of_the_encoder_explains_the_rounding_that_it_magnifies():
    made = challenge(360100, "encoder_interpolation", excitation="msine60")
    found = fitted([measurement(made.recording)], "encoder_interpolation")
    assert found.rounding > 0.2 * found.noise
    assert found.ratio < 1.03


def test_a_start_that_the_samples_hardly_tell_stays_within_reach():
    made = challenge(460024, "bouc_wen_hysteresis", excitation="sine10ss")
    whole = measurement(made.recording, at_rest=False)
    seen = replace(whole, used=np.arange(whole.force.size) >= 40)
    fit = fitted([seen], "bouc_wen_hysteresis")
    assert fit.ratio < 1.05
    yields = fit.named()["yield_displacement"]
    assert yields == pytest.approx(
        made.answer.parameters["bouc_wen_hysteresis"]["bouc_yield"], rel=0.02
    )
    elastic = dict(zip(fit.composition.kernel.states, fit.starts[0], strict=True))
    assert abs(elastic["elastic_displacement"]) < FARTHEST * yields


def test_a_search_is_given_up_where_what_exceeds_the_noise_will_not_come_near():
    every, exceeding = Bar(1.2), Bar(1.2, noise=1.0)
    assert not every.out_of_reach(1.4, gain=0.0)
    assert exceeding.out_of_reach(1.4, gain=0.0)
    assert not exceeding.out_of_reach(1.4, gain=0.02)  # ten more such steps lead near
    assert not exceeding.out_of_reach(1.25, gain=0.0)


def test_what_leaves_hardly_more_than_noise_is_not_given_up_for_a_better_one():
    assert not Bar(0.95, noise=1.0).out_of_reach(1.03, gain=0.0)
    assert Bar(0.95, noise=1.0).out_of_reach(1.06, gain=0.0)


def test_a_search_is_given_up_where_what_it_may_gain_would_not_count():
    bar = Bar(1.0, most=0.9)
    assert bar.out_of_reach(1.0, gain=0.001)
    assert not bar.out_of_reach(1.0, gain=0.02)


@given(hnp.arrays(float, st.integers(1, 6), elements=st.floats(0.05, 50.0)))
def test_branches_begin_as_one_history_of_the_tip_leaves_them(rates):
    """Against a sum over past moves of the tip, each as likely as any other."""
    past = np.geomspace(1e-5, 400.0, 4000)
    left = np.exp(-np.outer(rates, past)) * np.sqrt(np.gradient(past))
    left /= np.linalg.norm(left, axis=1)[:, None]
    alike = np.linalg.inv(history(np.concatenate([[0.0], rates]).tobytes()))
    np.testing.assert_allclose(alike[1:, 1:], left @ left.T, atol=1e-4)
    np.testing.assert_array_equal(alike[0], np.eye(rates.size + 1)[0])


def test_what_forgets_at_once_begins_by_itself():
    np.testing.assert_array_equal(history(np.array([np.inf, 3.0]).tobytes()), np.eye(2))


def test_branches_of_one_rate_begin_alike():
    inverse = history(np.array([3.0, 3.0]).tobytes())
    apart, alike = np.array([1.0, -1.0]), np.array([1.0, 1.0])
    assert apart @ inverse @ apart > 1e5 * (alike @ inverse @ alike)


@given(st.floats(0.05, 3000.0))
def test_a_branch_holds_at_the_start_no_more_than_was_felt_while_it_remembers(rate):
    made = challenge(432027, "springpot", excitation="sine10ss")
    (going,), (resting,) = (
        begun("standard_linear_solid", rate, measurement(made.recording, at_rest))
        for at_rest in (False, True)
    )
    extent = measurement(made.recording).extent
    branch = going.mean.size - 1
    assert going.deviation[branch] <= extent.speed / rate
    assert going.deviation[branch] >= min(extent.speed / rate, extent.indentation) * (1.0 - 1e-9)
    # What was at rest may have been pressed in long ago.
    slow = begun("standard_linear_solid", 0.05, measurement(made.recording, at_rest=True))
    assert resting.deviation[branch] == slow[0].deviation[branch]


def begun(effect, rate, seen):
    """Return what is known of the start of a model whose branch forgets at a rate [1/s]."""
    problem = Problem(Composition().plus(EFFECTS[effect]), [seen], EXACT)
    values = problem.nominal.copy()
    values[problem.kernel.values.index("relaxation_rate")] = rate
    return problem.begin(values)


def test_a_start_costs_no_more_than_parameters_do():
    made = challenge(432027, "springpot", excitation="sine10ss")
    seen = measurement(made.recording, at_rest=False)
    for name, branches in (("standard_linear_solid", 1), ("generalized_maxwell", 2)):
        fit = fitted([seen], name)
        assert 0.0 < fit.start_penalty <= branches * np.log(fit.samples) * (1.0 + 1e-9)
    # Eleven branches of one history are worth far fewer.
    assert fitted([seen], "springpot").start_penalty < 5.0 * np.log(fit.samples)


def test_out_of_contact_no_branch_is_stretched():
    made = challenge(488506, "contact_loss", "standard_linear_solid", excitation="sine10ss")
    fit = fitted(
        [measurement(made.recording, at_rest=False)], "contact_loss", "standard_linear_solid"
    )
    (stiffness,) = made.answer.parameters["standard_linear_solid"]["branch_stiffness"]
    (rate,) = made.answer.parameters["standard_linear_solid"]["branch_rate"]
    assert fit.named()["relaxing_stiffness"] == pytest.approx(stiffness, rel=0.03)
    assert fit.named()["relaxation_rate"] == pytest.approx(rate, rel=0.03)


def test_a_search_settles_where_no_step_lowers_the_cost_any_more():
    """A bottom of the cost that is flat to its last digits: every further step is refused there."""
    random, time = np.random.default_rng(18), np.arange(5000) / 1000.0
    rates, phases = 2.0 * np.pi * random.uniform(1.0, 30.0, 12), random.uniform(0.0, 6.28, 12)
    angles = rates * time[:, np.newaxis] + phases
    depth, speed = 4e-3 + 3e-4 * np.sin(angles).sum(1), 3e-4 * (rates * np.cos(angles)).sum(1)
    force = 500.0 * depth + 3.0 * speed + 5e-5 * random.standard_normal(time.size)
    record = {"t": time, "u": depth, "F": force}
    found = tp.compare(record, rig="rigid_probe", constants={"tip_mass": 0.0})
    assert found.fit.converged
    assert found.fit.named()["stiffness"] == pytest.approx(500.0, abs=0.02)
