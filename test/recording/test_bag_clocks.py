"""Whatever the clocks of a bag do is told, and made good or refused: never a wrong damping."""

import numpy as np
import pytest
from bags import EPOCH, STIFFNESS, fitted, force_channel, position_channel, write_bag

from tissue_probe.recording.any_file import read_any
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.layout import Layout

NAMES = {"/ft": force_channel, "/pose": position_channel}


def read(path, **stated):
    layout = Layout(position="/pose", force="/ft", force_polarity="compression", **stated)
    recording, notes = read_any(path, layout)
    return recording, " | ".join(notes)


@pytest.fixture
def read_with(tmp_path):
    """Read a bag whose channels' clocks were changed: by topic, (log times, stamps) -> same."""

    def read_with(changes, stated=None, **rates):
        topics = {}
        for topic, make in NAMES.items():
            logged, stamps, messages = make(**rates.get(topic[1:], {}))
            if topic in changes:
                logged, stamps = changes[topic](logged, stamps)
            topics[topic] = logged, stamps, messages
        return read(write_bag(tmp_path / "bag", topics), **(stated or {}))

    return read_with


def right(recording, tolerance=0.03):
    k, beta = fitted(recording)
    return k == pytest.approx(STIFFNESS, rel=5e-3) and beta == pytest.approx(4.0, rel=tolerance)


def both(change):
    return {"/ft": change, "/pose": change}


def after(stamps, seconds=3.0):
    return stamps - EPOCH > seconds * 1e9


def test_clocks_that_agree_need_no_word(read_with):
    recording, notes = read_with({})
    assert right(recording)
    assert notes.count("|") == 0
    assert len(recording.blocks) == 1


@pytest.mark.parametrize("by", [300, 40, 5000])
def test_a_host_s_clock_that_steps_back_splits_the_recording(by, read_with):
    def step(logged, stamps):
        back = np.where(after(stamps), by * 10**6, 0)
        return logged - back, stamps - back

    recording, notes = read_with(both(step))
    size = f"{by} ms" if by < 1000 else f"{by // 1000} s"
    assert notes.count(f"steps back by {size}") == 2
    assert len(recording.blocks) == 2
    assert (np.diff(recording.stamps) > 0).all()
    assert right(recording)


@pytest.mark.parametrize("topic", NAMES)
@pytest.mark.parametrize(("by", "said"), [(0.3, "forward by 300 ms"), (-0.3, "back by 300 ms")])
def test_a_step_of_one_channel_s_clock_is_taken_out_and_splits(topic, by, said, read_with):
    def step(logged, stamps):
        return logged, stamps + np.where(after(stamps), round(by * 1e9), 0)

    recording, notes = read_with({topic: step})
    assert f"the clock that stamps {topic}" in notes
    assert f"steps {said}, 3" in notes
    assert len(recording.blocks) == 2
    assert right(recording)


def test_a_step_is_found_under_jitter(read_with):
    generator = np.random.default_rng(0)

    def step(logged, stamps):
        late = np.rint(generator.exponential(2e6, stamps.size)).astype(np.int64)
        return logged + late, stamps + np.where(after(stamps), 3 * 10**7, 0)

    recording, notes = read_with({"/ft": step})
    assert "steps forward by 30 ms" in notes
    assert "the delays of /ft.wrench.force.z vary by" in notes
    assert right(recording)


def test_the_recorder_s_clock_alone_stepping_leaves_stamps_as_they_are(read_with):
    def step(logged, stamps):
        return logged - np.where(after(stamps), 3 * 10**8, 0), stamps

    recording, notes = read_with(both(step))
    assert "comes 300 ms earlier from" in notes
    assert len(recording.blocks) == 1
    assert right(recording)


@pytest.mark.parametrize(("size", "called"), [(2**32, "2^32 ns"), (2**32 * 1000, "2^32 us")])
def test_a_counter_that_rolls_over_is_counted_on(size, called, read_with):
    def roll(logged, stamps):
        counted = stamps - EPOCH + size - 3 * 10**9
        return logged, counted % size

    recording, notes = read_with(both(roll))
    assert notes.count(f"begin anew at {called} once") == 2
    assert len(recording.blocks) == 1
    assert right(recording)


def drift(ppm):
    def drifting(logged, stamps):
        return logged, stamps + np.rint((stamps - EPOCH) * ppm * 1e-6).astype(np.int64)

    return drifting


def test_a_drift_that_both_share_is_corrected(read_with):
    recording, notes = read_with(both(drift(2000)))
    assert "runs 1996 ppm faster than the recorder's, for both signals alike" in notes
    assert recording.blocks[0].sample_period == pytest.approx(2e-3, rel=1e-5)
    assert right(recording)


def test_a_drift_of_one_is_refused_unless_the_user_decides(read_with, tmp_path):
    with pytest.raises(RecordingError, match=r"drift apart by 1996 ppm, 12 ms .* `clock`"):
        read_with({"/ft": drift(2000)})
    recording, notes = read(tmp_path / "bag", clock="recorder")
    assert "that of /ft.wrench.force.z is off by -1996 ppm" in notes
    assert right(recording)
    _, notes = read(tmp_path / "bag", clock="stamps")
    assert "go by their stamps as they are" in notes


def test_simulated_time_that_runs_slower_is_right(read_with):
    def simulated(logged, stamps):
        return EPOCH + 3 * (logged - EPOCH), stamps - EPOCH

    recording, notes = read_with(both(simulated))
    assert "as those of a simulation or a replay do" in notes
    assert recording.blocks[0].stamp == 0
    assert right(recording)


def test_messages_stored_out_of_order_are_put_in_order_and_told(read_with):
    def late(logged, stamps):
        return logged, stamps

    def swapped(logged, stamps):
        order = np.arange(stamps.size)
        order[100:102] = 101, 100
        order[500:503] = 501, 502, 500
        return logged, stamps[order]

    recording, notes = read_with({"/pose": late, "/ft": swapped})
    assert "messages of /ft.wrench.force.z were stored out of order, by up to" in notes
    assert len(recording.blocks) == 1


def test_no_stamps_and_even_arrival_go_by_the_recorder(read_with):
    recording, notes = read_with(both(lambda logged, stamps: (logged, 0 * stamps)))
    assert "have no stamps: both signals are taken at the times they were recorded" in notes
    assert right(recording)


def test_no_stamps_and_uneven_arrival_ask_for_the_rate_and_take_it(read_with, tmp_path):
    generator = np.random.default_rng(0)

    def unstamped(logged, stamps):
        late = np.rint(generator.exponential(2e6, stamps.size)).astype(np.int64)
        return np.maximum.accumulate(logged + late), 0 * stamps

    with pytest.raises(RecordingError, match=r"recorded irregularly, 500.* state `sample_rate`"):
        read_with({"/ft": unstamped})
    recording, notes = read(tmp_path / "bag", sample_rate=500.0)
    assert "taken as sampled evenly at 500 Hz, none of its" in notes
    assert right(recording, tolerance=0.05)


@pytest.mark.parametrize("rate", [1000.0, 480.0, 520.0])
def test_a_rate_that_the_times_of_recording_contradict_is_refused_with_theirs(rate, read_with):
    def unstamped(logged, stamps):
        return logged, 0 * stamps

    with pytest.raises(RecordingError, match=r"`sample_rate` is .* recorded at 500 a second"):
        read_with({"/ft": unstamped}, stated={"sample_rate": rate})


def test_a_rate_that_is_nearly_right_is_put_right_by_the_recorder(read_with):
    recording, notes = read_with(
        {"/ft": lambda logged, stamps: (logged, 0 * stamps)}, stated={"sample_rate": 499.0}
    )
    assert "499 Hz was stated, which the recorder's clock shows to be 500 Hz" in notes
    assert right(recording)


def test_a_step_between_even_stamps_leaves_no_doubt(read_with):
    def step(logged, stamps):
        return logged, stamps + np.where(after(stamps), 3 * 10**8, 0)

    recording, _ = read_with({"/ft": step})
    assert recording.time_doubt == 0.0


def test_the_doubt_of_a_step_between_uneven_stamps_is_that_of_the_stamps(read_with):
    generator = np.random.default_rng(1)

    def step(logged, stamps):
        early = np.rint(generator.normal(0.0, 2e5, stamps.size)).astype(np.int64)
        return logged, stamps + np.where(after(stamps), 3 * 10**8, 0) + early

    recording, _ = read_with({"/ft": step})
    assert 1e-4 < recording.time_doubt < 1e-3


def test_a_position_without_stamps_that_comes_unevenly_is_refused(read_with):
    generator = np.random.default_rng(0)

    def unstamped(logged, stamps):
        late = np.rint(generator.exponential(4e6, stamps.size)).astype(np.int64)
        return np.maximum.accumulate(logged + late), 0 * stamps

    with pytest.raises(RecordingError, match="record it with stamps"):
        read_with({"/pose": unstamped})


def test_stamps_in_coarse_ticks_are_spread_evenly(read_with):
    def ticked(logged, stamps):
        return logged, stamps - (stamps - EPOCH) % 10**7

    recording, notes = read_with(both(ticked))
    assert recording.time_doubt == pytest.approx(5e-3)
    assert (
        "come in steps of 10 ms, several messages to a step: they are taken as even, 500" in notes
    )
    assert "shift the damping by 0.005 s times the stiffness" in notes
    k, _ = fitted(recording)
    assert k == pytest.approx(STIFFNESS, rel=0.02)


def test_coarse_ticks_with_losses_are_refused_unless_the_recorder_counts(read_with, tmp_path):
    def ticked(logged, stamps):
        lost = np.where(after(stamps), 10**8, 0)
        return logged + lost, stamps + lost - (stamps - EPOCH) % 10**7

    with pytest.raises(RecordingError, match=r"in steps of 10 ms.*`clock` recorder"):
        read_with(both(ticked))
    recording, _ = read(tmp_path / "bag", clock="recorder")
    k, _ = fitted(recording)
    assert k == pytest.approx(STIFFNESS, rel=0.02)


def test_a_force_that_repeats_old_values_is_thinned_and_told(tmp_path):
    logged, stamps, messages = force_channel()
    held = [messages[number // 5 * 5] for number in range(len(messages))]
    topics = {"/ft": (logged, stamps, held), "/pose": position_channel()}
    recording, notes = read(write_bag(tmp_path / "bag", topics))
    assert "/ft.wrench.force.z repeats old values, each 5 times: 600 fresh ones, at 100 Hz" in notes
    assert recording.blocks[0].sample_period == pytest.approx(1e-2)
    assert right(recording)


@pytest.mark.parametrize(
    ("rate", "said"), [(3.5, "it cannot follow"), (5.0, "too few for a spline")]
)
def test_a_position_too_slow_for_the_motion_is_told_with_its_consequence(rate, said, read_with):
    _, notes = read_with({}, pose={"rate": rate})
    assert said in notes
    assert "damping" in notes
