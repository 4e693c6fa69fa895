"""What is wrong with samples is found and said; of sound samples nothing is said."""

from functools import cache

import numpy as np
import pytest
from hidden import challenge, first_of
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.signal import decimate, lfilter
from scipy.stats import gamma
from specimen import Specimen, chirp, multisine, sine

from tissue_probe.diagnosis.inspection.inspection import inspect

PERIOD = 5e-4
MOTIONS = {"sine": sine(), "chirp": chirp(), "multisine": multisine(), "slow": sine(1.0)}
TISSUES = {
    "free surface": Specimen(),
    "preload": Specimen(preload=2e-3),
    "contact loss": Specimen(contact_loss=True),
    "stiffening": Specimen(cubic=4e8, preload=1e-3),
    "friction": Specimen(coulomb=0.1),
    "soft": Specimen(stiffness=150.0, damping=0.5),
    "stiff": Specimen(stiffness=3000.0, damping=15.0, preload=1e-3),
}


@cache
def without_noise(tissue, motion):
    """Return position in steps of 0.1 um and force."""
    position, _, force, _ = TISSUES[tissue].measure(MOTIONS[motion], 4.0)
    return np.round(position, 7), force


def measure(tissue="free surface", motion="sine", seed=0):
    """Return position in steps of 0.1 um, and force with 5 mN of noise."""
    position, force = without_noise(tissue, motion)
    noise = 5e-3 * np.random.default_rng(seed).standard_normal(force.size)
    return position.copy(), force + noise


def converted(force, bits, reach=10.0):
    """Return the force as a converter of so many bits gives it, from -reach to reach [N]."""
    step = 2.0 * reach / 2**bits
    return step * np.round(force / step)


def names(position, force, period=PERIOD, time=None):
    found = inspect(position, force, period, time).findings
    for finding in found:
        assert finding.sentence.endswith(".")
        assert ":" in finding.sentence or ";" in finding.sentence
    return {finding.name for finding in found}


@pytest.mark.parametrize("bits", [None, 12, 14, 16])
@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("tissue", TISSUES)
def test_of_sound_samples_nothing_is_said(tissue, motion, bits):
    for seed in range(3):
        position, force = measure(tissue, motion, seed=seed)
        if bits:
            force = converted(force, bits)
        assert names(position, force) == set()


@pytest.mark.parametrize("bits", [12, 16])
@pytest.mark.parametrize("tissue", TISSUES)
def test_of_sound_samples_without_noise_nothing_is_said(tissue, bits):
    for motion in MOTIONS:
        position, force = without_noise(tissue, motion)
        assert names(position, converted(force, bits)) == set()


def test_rest_before_and_after_the_motion_is_no_fault():
    position, force = (column[:4000] for column in measure())
    still = np.zeros(600)
    noise = 5e-3 * np.random.default_rng(1).standard_normal((2, 600))
    position = np.concatenate([still, position, still + position[-1]])
    force = np.concatenate([noise[0], force, noise[1] + force[-1]])
    assert names(position, converted(force, 14)) == set()


def test_the_steps_of_encoder_and_converter_are_told():
    position, force = measure()
    found = inspect(position, converted(force, 12), PERIOD)
    assert found.position_step == pytest.approx(1e-7, rel=1e-6)
    assert found.force_step == pytest.approx(20.0 / 4096, rel=1e-6)
    assert inspect(position, force, PERIOD).force_step is None


@pytest.mark.parametrize(
    ("motion", "share"),
    [("sine", 0.02), ("sine", 0.1), ("chirp", 0.05), ("multisine", 0.05), ("multisine", 0.1)],
)
@pytest.mark.parametrize("bits", [None, 14, 16])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_force_cut_off_is_no_stiffness_step(sign, motion, bits, share):
    position, force = measure("preload", motion)
    if motion == "sine":  # the start from rest reaches higher than all that follows
        position, force = position[1000:], force[1000:]
    limit = (sign * force).max() - share * np.ptp(force)
    cut = sign * np.minimum(sign * force, limit)
    cut = converted(cut, bits) if bits else cut
    found = inspect(position, cut, PERIOD)
    assert found.answer == "adc_saturation"
    finding = found["adc_saturation"]
    for first, stop in finding.spans:
        assert np.ptp(cut[first:stop]) == 0.0
        assert sign * cut[first] == (sign * cut).max()
    held = np.count_nonzero(sign * force > limit)
    assert 0.5 * held < finding.samples < 1.1 * held + 20


@pytest.mark.parametrize("channel", ["position", "force"])
@pytest.mark.parametrize("bits", [None, 12, 16])
@pytest.mark.parametrize("motion", ["sine", "chirp", "multisine"])
def test_a_channel_that_sticks_is_no_body_motion(motion, bits, channel):
    random = np.random.default_rng(4)
    position, force = measure("preload", motion)
    force = converted(force, bits) if bits else force
    values = position if channel == "position" else force
    stuck = np.zeros(values.size, dtype=bool)
    for first in range(500, values.size - 100, 700):
        length = random.integers(5, 51)
        values[first : first + length] = values[first]
        stuck[first : first + length] = True
    found = inspect(position, force, PERIOD)
    assert found.answer == "stuck_samples"
    finding = found["stuck_samples"]
    assert f"The {channel} is stuck" in finding.sentence
    marked = np.zeros(values.size, dtype=bool)
    for first, stop in finding.spans:
        marked[first:stop] = True
    assert np.count_nonzero(marked & ~stuck) <= 4 * len(finding.spans)
    assert np.count_nonzero(marked & stuck) > 0.6 * np.count_nonzero(stuck)


@pytest.mark.parametrize("motion", MOTIONS)
def test_forces_that_stand_alone_are_told_one_by_one(motion):
    position, force = measure("friction", motion)
    disturbed = [100, 2000, 2004, 6500]
    force[disturbed] += [0.5, -0.6, 0.5, 1.5]
    (found,) = inspect(position, force, PERIOD).findings
    assert found.name == "spikes"
    assert found.spans == tuple((index, index + 1) for index in disturbed)
    assert not found.fatal


@pytest.mark.parametrize("motion", MOTIONS)
def test_positions_that_stand_alone_are_told_one_by_one(motion):
    position, force = measure("friction", motion)
    disturbed = [100, 2000, 2004, 6500]
    position[disturbed] += [2e-4, -3e-4, 2e-4, 1e-3]
    (found,) = inspect(position, force, PERIOD).findings
    assert found.name == "position_spikes"
    assert found.spans == tuple((index, index + 1) for index in disturbed)
    assert not found.fatal


@pytest.mark.parametrize("order", [1, 2, 3, 4])
@pytest.mark.parametrize("lag", [0.1, 0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 20.0])
def test_a_force_that_reverses_within_samples_is_no_disturbance(order, lag):
    """As that of a drive whose friction turns: a step through lags of so many samples each."""
    position, force = measure(motion="slow", seed=order)
    sample = np.arange(force.size)
    for turn, at in enumerate((1700.3, 3500.7, 5900.0)):
        force += 2.0 * (-1) ** turn * gamma.cdf(sample - at, order, scale=lag)
    assert names(position, force) == set()


@pytest.mark.parametrize("step", [1e-6, 1e-5, 1e-4])
@pytest.mark.parametrize("motion", MOTIONS)
def test_a_coarse_encoder_that_ticks_back_and_forth_reads_nothing_alone(motion, step):
    position, force = measure("friction", motion)
    shaken = position + 0.2 * step * np.random.default_rng(8).standard_normal(position.size)
    assert "position_spikes" not in names(np.round(shaken / step) * step, force)


def test_a_hold_after_two_samples_of_motion_is_not_stuck():
    """A press that is at its place after two samples, and whose encoder has no noise."""
    time = 1e-3 * np.arange(5000.0)
    position = np.where(time < 1e-3, 0.0, np.where(time < 2e-3, 1.784e-3, 1.795e-3))
    force = 800.0 * position * (0.5 + 0.5 * np.exp(-time))
    force += 1e-3 * np.random.default_rng(0).standard_normal(time.size)
    assert "stuck_samples" not in names(position, force, 1e-3)


@pytest.mark.parametrize("seed", first_of([3, 30, 44, 88, 112, 155], 2))
def test_quick_moves_between_places_of_rest_have_no_spikes(seed):
    """A few steps whose corners are rounded, read by an encoder with noise.

    Of some 600 seeds those in whose corners few samples stood out.
    """
    random = np.random.default_rng(seed)
    period, lasts, wait = 0.07, random.uniform(0.3, 2.0), random.uniform(3.0, 9.0)
    noise, rounded = 10.0 ** random.uniform(-5.6, -5.0), random.uniform(0.05, 0.3) * lasts
    at = np.arange(500) * period + random.uniform(0.0, 1.0)
    fine = np.linspace(0.0, at[-1] + 1.0, 50000)
    begun = np.arange(1.0, 40.0, lasts + wait)
    speed = sum(((fine > each) & (fine < each + lasts)) * (2.4e-3 / lasts) for each in begun)
    width = max(1, round(rounded / fine[1]))
    speed = np.convolve(speed, np.full(width, 1.0 / width), mode="same")
    depth = np.interp(at, fine, np.cumsum(speed) * fine[1])
    position = depth + noise * random.standard_normal(at.size)
    force = 330.0 * depth + 80.0 * np.interp(at, fine, speed)
    force += 2e-3 * random.standard_normal(at.size)
    assert not {"position_spikes", "spikes"} & names(position, force, period)


def test_a_press_that_comes_to_rest_where_the_record_ends_is_not_stuck():
    """A staircase of few samples, whose steps pass for noise, and whose last place is held."""
    up = [1e-10, 4e-5, 1.2e-4, 1.25e-4, 1.25e-4, 1.25e-4, 8.5e-5, 8.8e-7]
    position = np.concatenate([np.zeros(10), np.cumsum(np.tile(up + [1e-18] * 14, 6))])
    position[-14:] = position[-15]
    relaxing = lfilter([1.0, -1.0], [1.0, -0.97], position)
    force = 1500.0 * position + 600.0 * relaxing
    force += 0.01 * np.random.default_rng(0).standard_normal(force.size)
    assert "stuck_samples" not in names(position, force, 0.05)


@pytest.mark.parametrize("seed", [489007, 489024, 489036])
def test_an_encoder_that_reads_no_motion_where_a_record_begins_is_not_stuck(seed):
    """Its periodic error passes for noise, by which no value would come so often."""
    made = challenge(seed, "encoder_interpolation", "mains_hum", excitation="msine60").recording
    assert names(made.position, made.force, made.sample_period) == set()


def test_a_channel_of_a_lower_rate_is_told_by_how_much():
    position, force = measure()
    finding = inspect(position, np.repeat(force[::4], 4), PERIOD)["stuck_samples"]
    assert "repeats each value about 4 times" in finding.sentence


def test_values_written_with_few_digits_and_resampled_in_part_are_no_fault():
    position, force = measure(motion="slow")
    force = np.round(force / 5e-3 * 2e-4, 4)  # noise of two digits' last place
    later = slice(5000, None)
    force[later] = 0.5 * (force[later] + np.roll(force, 1)[later])
    assert names(position, force) == set()


@pytest.mark.parametrize("count", [0, 1, 15, 63])
def test_too_few_samples_are_fatal(count):
    position, force = measure()
    found = inspect(position[:count], force[:count], PERIOD)
    assert found["too_short"].fatal
    assert f"{count} samples" in found["too_short"].sentence


@pytest.mark.parametrize(("noise", "enough"), [(0.01, True), (4.0, False)])
def test_whether_samples_are_enough_follows_from_what_they_tell(noise, enough):
    time = 0.02 * np.arange(101)
    position = 5e-3 * np.sin(0.5 * np.pi * time)
    force = 200.0 * position + 30.0 * np.gradient(position, 0.02)
    force += noise * np.random.default_rng(1).standard_normal(101)
    assert ("too_short" not in names(position, force, 0.02)) == enough


def test_samples_not_known_are_counted_and_do_not_hide_the_rest():
    position, force = measure()
    force[100:140] = np.nan
    position[700] = np.inf
    found = inspect(position, force, PERIOD)
    assert {finding.name for finding in found.findings} == {"missing_samples"}
    assert found["missing_samples"].spans == ((100, 140), (700, 701))
    assert "41 of 8000" in found["missing_samples"].sentence
    assert not found.fatal
    force[::2] = np.nan
    assert inspect(position, force, PERIOD)["missing_samples"].fatal


@pytest.mark.parametrize("channel", ["position", "force"])
def test_a_constant_column_is_fatal(channel):
    columns = dict(zip(("position", "force"), measure(), strict=True))
    columns[channel] = np.full(8000, 3.25)
    found = inspect(columns["position"], columns["force"], PERIOD)
    assert found[f"constant_{channel}"].fatal
    assert "is 3.25 throughout" in found[f"constant_{channel}"].sentence


@pytest.mark.parametrize(("felt", "moves"), [(True, True), (False, False)])
def test_a_position_that_jumps_once_is_a_motion_where_the_force_jumps_with_it(felt, moves):
    """A setpoint of a ramp that is quicker than a sample: 0 in the first row, then the depth."""
    random = np.random.default_rng(3)
    position = np.full(4000, 8e-4)
    position[0] = 0.0
    rest = 1.0 + np.exp(-np.arange(4000) / 1000.0)
    force = 5e-3 * random.standard_normal(4000) + rest * (position > 0.0 if felt else 1.0)
    assert ("no_motion" not in names(position, force)) == moves


def test_an_encoder_at_rest_is_no_motion():
    random = np.random.default_rng(2)
    force = 5e-3 * random.standard_normal(4000)
    flickering = 1e-7 * random.integers(0, 2, 4000)
    assert inspect(flickering, force, PERIOD)["no_motion"].fatal
    assert inspect(1e-6 * random.standard_normal(4000), force, PERIOD)["no_motion"].fatal


@pytest.mark.parametrize("bits", [None, 12])
def test_force_within_the_noise_is_no_contact(bits):
    position, _ = measure()
    force = 5e-3 * np.random.default_rng(2).standard_normal(position.size)
    force = converted(force, bits) if bits else force
    assert inspect(position, force, PERIOD)["no_contact"].fatal


@pytest.mark.parametrize("motion", [sine(), multisine(range(1, 21))])
def test_a_tip_in_the_air_is_no_contact(motion):
    position, _, _, force = Specimen(stiffness=0.0, damping=0.0).measure(motion, 4.0)
    position, force = np.round(position, 7)[2000:], force[2000:]  # the start has rung down
    mass = float(inspect(position, force, PERIOD)["no_contact"].sentence.split()[8])
    assert mass == pytest.approx(0.04, rel=0.1)


@pytest.mark.parametrize("tissue", TISSUES)
@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("flipped", ["position", "force"])
def test_a_wrong_sign_is_fatal(tissue, motion, flipped):
    position, force = measure(tissue, motion)
    signs = (-1.0, 1.0) if flipped == "position" else (1.0, -1.0)
    found = inspect(signs[0] * position, signs[1] * force, PERIOD)
    assert {finding.name for finding in found.findings} == {"wrong_polarity"}
    assert found.fatal
    assert "`force_polarity`" in found["wrong_polarity"].sentence


@pytest.mark.parametrize("late", [-200, -20, 60, 100])
@pytest.mark.parametrize("motion", ["chirp", "multisine"])
def test_channels_of_different_clocks_are_told_by_how_much(motion, late):
    position, force = measure(motion=motion)
    early, shift = max(0, -late), max(0, late)
    found = inspect(
        position[shift : position.size - early], force[early : force.size - shift], PERIOD
    )
    said = found["unsynchronised"].sentence
    assert found["unsynchronised"].fatal
    assert ("late" if late > 0 else "early") in said
    assert float(said.split()[3]) == pytest.approx(abs(late) / 2.0, abs=2.0)  # the tip lags too


@pytest.mark.parametrize("late", [4, 30])
def test_a_delay_that_is_an_effect_is_no_matter_of_clocks(late):
    position, force = measure(motion="chirp")
    assert names(position[late:], force[:-late]) == set()


@pytest.mark.parametrize(
    ("position_size", "force_size"),
    [(1.0, 1e6), (1e-6, 1.0), (1e4, 1.0), (1e3, 1.0), (1.0, 1e-3)],
)
def test_units_that_no_tissue_has_are_suspicious(position_size, force_size):
    position, force = measure()
    assert names(position_size * position, force_size * force) == {"suspicious_units"}


def test_jittering_times_and_gaps_are_told():
    position, force = measure()
    time = PERIOD * np.arange(position.size)
    assert names(position, force, time=time) == set()
    jittering = time + 0.1 * PERIOD * np.random.default_rng(0).uniform(-1.0, 1.0, time.size)
    assert names(position, force, time=jittering) == {"irregular_sampling"}
    time[4000:] += 0.3
    found = inspect(position, force, PERIOD, time)
    assert found["gaps"].spans == ((3999, 4001),)
    assert "1 gaps in time, the longest 0.3 s" in found["gaps"].sentence


@pytest.mark.parametrize("step", [4e-6, 2e-5])
@pytest.mark.parametrize("motion", MOTIONS)
def test_coarse_steps_of_the_encoder_are_told(motion, step):
    position, force = measure(motion=motion)
    found = inspect(step * np.round(position / step), force, PERIOD)
    assert {finding.name for finding in found.findings} == {"coarse_encoder"}
    assert found.position_step == pytest.approx(step, rel=1e-6)
    assert f"steps of {step:.3g} m" in found["coarse_encoder"].sentence


def test_too_few_samples_a_cycle_are_told():
    position, force = (decimate(column, 10) for column in measure(motion="multisine"))
    finding = inspect(position, force, 10 * PERIOD)["low_rate"]
    assert "only 200 samples a second" in finding.sentence


def test_a_quasistatic_staircase_is_motion():
    depth = np.tile(np.linspace(0.0, 3e-3, 10), 100) + 1e-5 * np.random.default_rng(0).normal(
        size=1000
    )
    assert names(np.round(depth, 7), 300.0 * depth, 0.1) == {"low_rate"}


finite = st.floats(allow_nan=False, allow_infinity=False)
some = st.sampled_from([0.0, 1.0, -1.0, 5e-324, 1e308, -1e308, 1e-7])


@given(
    columns=st.integers(0, 60).flatmap(
        lambda size: st.tuples(
            *(arrays(np.float64, size, elements=finite | some) for _ in range(2))
        )
    ),
    period=st.sampled_from([1e-9, 5e-4, 1.0, 1e9]),
)
@settings(max_examples=200, deadline=None)
def test_no_finite_samples_raise(columns, period):
    for finding in inspect(*columns, period).findings:
        assert finding.sentence
        assert all(0 <= first < stop <= columns[0].size for first, stop in finding.spans)


@given(
    scale=st.sampled_from([1e-300, 1e-12, 1e12, 1e300]),
    what=st.sampled_from(["position", "force", "both"]),
)
@settings(max_examples=12, deadline=None)
def test_samples_of_any_size_are_judged(scale, what):
    position, force = measure()
    found = inspect(
        position * (scale if what != "force" else 1.0),
        force * (scale if what != "position" else 1.0),
        PERIOD,
    )
    assert {finding.name for finding in found.findings} <= {"suspicious_units"}


def test_arrays_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match=r"shapes \(3,\) and \(2,\)"):
        inspect(np.zeros(3), np.zeros(2), PERIOD)
    with pytest.raises(ValueError, match="sample_period is 0"):
        inspect(np.zeros(3), np.zeros(3), 0.0)


def test_coarse_steps_of_the_encoder_are_not_taken_for_another_clock():
    made = challenge(480032, "encoder_quantization", excitation="stepped30").recording
    found = inspect(made.position, made.force, made.sample_period)
    assert not found.fatal
    assert "unsynchronised" not in {finding.name for finding in found.findings}


@pytest.mark.parametrize(
    ("seed", "hidden", "excitation", "rig"),
    [
        (446043, ("encoder_interpolation",), "chirp60", "exact"),
        (443015, ("encoder_interpolation", "force_gain"), "msine60", "tolerant"),
        (445009, ("encoder_interpolation",), "chirp60", "tolerant"),
        (441016, ("tissue_motion", "encoder_interpolation"), "msine60", "exact"),
    ],
    ids=["chirp", "multisine", "where it turns", "left as it was entered"],
)
def test_where_an_interpolated_encoder_reads_no_motion_it_is_not_stuck(
    seed, hidden, excitation, rig
):
    """Its error's slope all but undoes the motion's, once in each period of the grating."""
    made = challenge(seed, *hidden, excitation=excitation, rig=rig).recording
    assert not inspect(made.position, made.force, made.sample_period).findings


def test_a_delay_of_less_than_a_millisecond_is_not_taken_for_another_clock():
    """Stiffness and mass, late by 4 ms, are as good as the damping that is there."""
    hidden = ("channel_delay", "tissue_motion")
    made = challenge(1900029, *hidden, excitation="msine60").recording
    assert not inspect(made.position, made.force, made.sample_period).findings


@pytest.mark.parametrize("turned", [0.0, 0.25, 0.5])
def test_a_motion_of_four_samples_a_period_is_one_where_the_force_answers_at_any_phase(turned):
    cycles = 0.2497 * np.arange(4000)
    position, force = (np.sin(2.0 * np.pi * (cycles + late)) for late in (0.0, turned))
    assert "no_motion" not in names(1e-3 * position, force)


@given(steps=st.integers(1, 20), hold=st.integers(0, 800))
@settings(max_examples=20, deadline=None)
def test_a_ramp_at_one_speed_is_no_coarse_encoder_and_goes_one_way_unless_it_holds(steps, hold):
    """It comes in as many steps as it has samples, each as long as the one before."""
    share = hold / (800 + hold)
    assume(abs(share - 0.1) > 0.02)  # a speed is told over some samples, and so is its end
    position = np.append(np.arange(800) * steps * 1e-6, np.full(hold, 799 * steps * 1e-6))
    noise = 1e-3 * np.random.default_rng(0).standard_normal(position.size)
    found = names(position, 500.0 * position + noise)
    assert "coarse_encoder" not in found
    assert ("one_way" in found) == (hold < 0.1 * position.size)


@pytest.mark.parametrize("cycle", [4.12, 5.15])
def test_too_few_samples_a_cycle_are_refused_for_that(cycle):
    """The noise of such a record is not known, so that nothing can be said of contact or clocks."""
    phase = 2 * np.pi * np.arange(500) / cycle
    position = 2e-3 + 1e-3 * np.sin(phase)
    force = 0.6 + 0.3 * np.sin(phase - 2.2) + 2e-3 * np.random.default_rng(1).standard_normal(500)
    for found in inspect(position, force, 0.02).findings:
        assert found.name not in ("no_contact", "unsynchronised") or not found.fatal
        assert not found.fatal or "samples a cycle" in found.sentence
