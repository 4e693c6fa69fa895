"""The recorder and replay nodes: a run is on disk whole, and comes back as it was."""

from __future__ import annotations

import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import rclpy
from mcap.reader import make_reader
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.parameter_service import ParameterService
from rosbags.highlevel import AnyReader
from std_srvs.srv import SetBool

from conftest import (
    PATIENCE,
    SCAN,
    STAGE,
    Scanning,
    ask,
    collect,
    deactivate,
    driver,
    estimator,
    fails_with,
    goal,
    session_of_a_module,
)
from tissue_probe.analysis.recorded_facts import estimate_again, find_phantom, node_parameters
from tissue_probe.estimation import ESTIMATORS
from tissue_probe.nodes.conversions import estimate_from_message
from tissue_probe.nodes.session import NodeProcess
from tissue_probe.recording.bags.reader import read_estimates, read_map, read_recording
from tissue_probe.recording.bags.summary import summarize
from tissue_probe.signals import Phase, TissueEstimates
from tissue_probe_msgs.msg import ProbeSamples, TissueEstimate

#: In one process; all others each in one of its own.
TOGETHER = ["robust_ekf", "ekf", "ukf", "afekf"]
APART = [name for name in ESTIMATORS if name not in TOGETHER]
MAPPER = NodeProcess("mapper", "mapper", parameters={"estimators": list(ESTIMATORS)})


def recorder(bag: Path, **parameters: object) -> NodeProcess:
    return NodeProcess("recorder", "recorder", parameters={"output": str(bag), **parameters})


@pytest.fixture(scope="module")
def recorded(tmp_path_factory) -> Path:
    """A scan of two sites with all estimators and the mapper, recorded by the real recorder."""
    bag = tmp_path_factory.mktemp("recorded") / "run.mcap"
    processes = [
        SCAN,
        driver(),
        STAGE,
        NodeProcess("estimators", "estimators", parameters={"estimators": TOGETHER}),
        *(estimator(name) for name in APART),
        MAPPER,
        recorder(bag),
    ]
    with session_of_a_module(*processes) as running:
        running.activate(
            {
                "/probe/driver": 1 + len(APART) + 2,  # and the scan and the recorder
                # And the driver, the mapper twice, and the recorder.
                "/probe/scan": 1 + len(APART) + 4,
                **{f"/probe/{name}": 2 for name in ESTIMATORS},
            },
            publishers={
                "/probe/mapper": len(ESTIMATORS) + 1,  # and the scan
                **{f"/probe/{name}": 2 for name in ESTIMATORS},  # the driver and the scan
            },
        )
        assert Scanning(running, goal(dwell_time=0.5)).result().result.sites_visited == 2
        deactivate(running)
    return bag


def test_no_sample_is_lost_on_the_way_to_disk(recorded):
    summary = summarize(recorded)
    assert not summary.truncated
    assert [samples.lost for samples in summary.samples] == [0]
    recording = read_recording(recorded)
    assert len(recording.blocks) == 1
    assert recording.blocks[0].sequence == 0
    assert len(recording) > 2000


@pytest.mark.parametrize("name", ESTIMATORS)
def test_the_same_filter_off_line_gives_the_recorded_estimates_bit_for_bit(recorded, name):
    live = read_estimates(recorded)[name]
    again = estimate_again(read_recording(recorded), name)
    rows = np.searchsorted(again.sequence, live.sequence)
    assert len(live) > 200
    assert np.array_equal(again.sequence[rows], live.sequence)
    for ours, theirs in zip(again[rows].arrays(), live.arrays(), strict=True):
        assert np.array_equal(ours, theirs, equal_nan=True)


def test_the_filters_began_anew_at_each_site(recorded):
    recording = read_recording(recorded)
    dwells = [site.stamp for site in recording.sites if site.phase == Phase.DWELL]
    estimates = estimate_again(recording, "ekf")
    for begin in dwells:
        first = int(np.searchsorted(estimates.stamp, begin))
        assert estimates.stiffness_variance[first] > 1e4 * estimates.stiffness_variance[first - 1]


def test_the_map_that_was_published_is_recorded(recorded):
    found = read_map(recorded)
    assert found.stiffness.shape == (1, 2)
    assert np.isfinite(found.stiffness).all()
    assert found.stiffness[0, 0] == pytest.approx(450.0, rel=0.02)


def test_parameters_excitation_and_phantom_are_in_the_recording(recorded):
    recording = read_recording(recorded)
    parameters = node_parameters(recording, "excitation.kind", "sine")
    assert parameters["excitation.frequency"] == 10.0
    assert parameters["excitation.amplitude"] == 0.85
    assert find_phantom(recording).background_stiffness == 450.0
    assert node_parameters(recording, "estimator", "ukf")["load_cell_stiffness"] == 9700.0


def test_a_node_that_cannot_be_asked_yet_is_asked_when_it_can(session, bag):
    """Its name is known before its services are, on a busy machine by seconds."""
    running = session(recorder(bag))
    context = running.node.context
    late = rclpy.create_node(
        "late", namespace="/probe", context=context, start_parameter_services=False
    )
    late.declare_parameter("gain", 1.0)
    running.wait_until(
        lambda: running.node.count_clients("/probe/late/list_parameters") > 0, "a client of it"
    )
    services = ParameterService(late)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(late)

    def recorded_gain() -> str | None:
        executor.spin_once(timeout_sec=0.0)
        return summarize(bag).metadata.get("/probe/late", {}).get("gain")

    running.wait_until(lambda: recorded_gain() == "1.0", "the first value in the recording")
    late.set_parameters([Parameter("gain", value=2.0)])
    running.wait_until(lambda: recorded_gain() == "2.0", "the second value in the recording")
    executor.shutdown()
    del services
    late.destroy_node()


def test_what_repeats_other_messages_is_left_out_unless_asked_for(recorded, session, bag):
    topics = {topic.name for topic in summarize(recorded).topics}
    assert {"/probe/samples", "/probe/ekf/estimate", "/stage/measured_cp"} <= topics
    assert not {"/probe/measured_cp", "/probe/measured_cf"} & topics
    assert {each for each in topics if each.startswith("/probe/ekf/")} == {
        "/probe/ekf/estimate", "/probe/ekf/model",
    }  # fmt: skip
    running = session(driver(), estimator("ekf"), recorder(bag, per_sample=True))
    running.activate({"/probe/driver": 2, "/probe/ekf": 1}, {"/probe/ekf": 1})
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    running.wait_until(lambda: len(blocks) > 100, "samples")
    deactivate(running)
    running.processes["recorder"].send_signal(signal.SIGINT)
    assert running.processes.pop("recorder").wait(PATIENCE) == 0
    counts = {topic.name: topic.messages for topic in summarize(bag).topics}
    samples = summarize(bag).samples[0].recorded
    assert samples > 1000
    # Each is sent from the moment that the driver notices the subscriber.
    assert samples - 200 <= counts["/probe/measured_cf"] <= samples
    estimates = counts["/probe/ekf/estimate"]
    assert estimates > 100
    for value in ("stiffness", "damping", "covariance_trace"):
        assert estimates - 20 <= counts[f"/probe/ekf/{value}"] <= estimates


def test_plain_mcap_reads_it_with_schemas_that_name_the_units(recorded):
    with recorded.open("rb") as stream:
        reader = make_reader(stream)
        summary = reader.get_summary()
        assert reader.get_header().profile == "ros2"
    assert {chunk.compression for chunk in summary.chunk_indexes} == {"zstd"}
    schemas = {schema.name: schema for schema in summary.schemas.values()}
    definition = schemas["tissue_probe_msgs/msg/ProbeSamples"]
    assert definition.encoding == "ros2msg"
    assert b"positive in compression [N]" in definition.data
    assert b"MSG: std_msgs/Header" in definition.data
    assert {channel.message_encoding for channel in summary.channels.values()} == {"cdr"}


def test_plain_rosbags_reads_it_without_our_code(recorded):
    with AnyReader([recorded]) as reader:
        topics = [c for c in reader.connections if c.topic == "/probe/samples"]
        samples = [
            value
            for connection, _, data in reader.messages(topics)
            for value in reader.deserialize(data, connection.msgtype).force
        ]
    assert np.array_equal(samples, read_recording(recorded).force)


def test_a_killed_recorder_leaves_all_but_the_last_second(session, bag):
    running = session(driver(), recorder(bag))
    running.activate({"/probe/driver": 1})
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    running.wait_until(lambda: len(blocks) > 500, "samples")
    running.processes["recorder"].kill()
    seen = blocks[-1].sequence
    running.processes.pop("recorder").wait()
    assert summarize(bag).truncated
    recording = read_recording(bag)
    assert len(recording) >= seen - 2000
    assert "excitation.kind" in recording.metadata["/probe/driver"]


def test_a_recording_is_never_overwritten(bag):
    bag.write_text("precious")
    said = fails_with(recorder(bag))
    assert "never overwritten" in said
    assert bag.read_text() == "precious"


def test_a_full_disk_is_told_and_what_was_recorded_stays(session, bag):
    running = session(driver())
    # A limit on the file's size fails as a full disk does, without needing a disk to fill.
    limited = subprocess.Popen(
        recorder(bag).command(running.parameter_file),
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (120_000, 120_000)),
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        running.activate({"/probe/driver": 1})
        _, said = limited.communicate(timeout=PATIENCE)
    finally:
        limited.kill()
        limited.wait()
    assert limited.returncode == 1
    assert "the recording ends here" in said
    assert "Traceback" not in said
    assert len(read_recording(bag)) > 1000


def replay(bag: Path, **parameters: object) -> NodeProcess:
    return NodeProcess("replay", "replay", parameters={"bag": str(bag), **parameters})


def resume(running) -> None:
    pause(running, False)


def pause(running, wanted: bool) -> None:
    assert ask(running, SetBool, "/probe/replay/pause", SetBool.Request(data=wanted)).success


def test_estimators_on_the_replay_estimate_what_they_estimated_live(session, recorded):
    running = session(replay(recorded, paused=True, rate=2.0), estimator("afekf"))
    received = collect(running.node, TissueEstimate, "/probe/afekf/estimate")
    running.wait_for_subscribers({"/probe/replay": 1, "/probe/afekf": 1})
    resume(running)
    live = read_estimates(recorded)["afekf"]
    replaying = running.processes.pop("replay")
    running.wait_until(lambda: len(received) >= len(live), "as many estimates")
    assert replaying.wait(PATIENCE) == 0
    again = TissueEstimates.concatenate([estimate_from_message(m) for m in received])
    for ours, theirs in zip(again.arrays(), live.arrays(), strict=True):
        assert np.array_equal(ours, theirs, equal_nan=True)


def test_replay_keeps_the_rate_and_starts_where_it_is_told(session, recorded):
    running = session(replay(recorded, paused=True, start=1.0, rate=4.0))
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    running.wait_for_subscribers({"/probe/replay": 1})
    resume(running)
    running.wait_until(lambda: bool(blocks), "the first block")
    begin = time.monotonic()
    replaying = running.processes.pop("replay")
    running.wait_until(lambda: replaying.poll() is not None, "the replay's end")
    took = time.monotonic() - begin
    everything = read_recording(recorded)
    assert blocks[0].sequence > 0
    assert blocks[-1].sequence + len(blocks[-1].position) == len(everything)
    lasted = (len(everything) - blocks[0].sequence) * 0.0005
    # Never faster than four times; how much slower depends on the machine.
    assert took > 0.95 * (lasted / 4.0 - 0.05)


def test_replay_pauses_and_goes_on(session, recorded):
    running = session(replay(recorded, paused=True))
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    running.wait_for_subscribers({"/probe/replay": 1})
    pause(running, True)
    assert blocks == []
    resume(running)
    running.wait_until(lambda: len(blocks) > 50, "samples")
    pause(running, True)
    running.wait_until(lambda: running.node.count_publishers("/probe/samples") == 1, "the graph")
    count = len(blocks)
    resume(running)
    running.wait_until(lambda: len(blocks) > count, "more samples")
    assert [b.sequence for b in blocks] == list(range(0, 10 * len(blocks), 10))


def test_replay_waits_for_as_many_subscribers_as_it_is_told(session, recorded):
    running = session(replay(recorded, subscribers=1, rate=20.0))
    running.wait_until(lambda: "/probe/replay" in running.health, "the replay")
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    running.processes.pop("replay").wait(PATIENCE)
    whole = len(read_recording(recorded))
    running.wait_until(lambda: sum(len(b.position) for b in blocks) == whole, "every sample")


def test_a_looping_replay_begins_again(session, recorded):
    running = session(replay(recorded, paused=True, loop=True, rate=20.0))
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    running.wait_for_subscribers({"/probe/replay": 1})
    resume(running)
    running.wait_until(lambda: sum(b.sequence == 0 for b in blocks) >= 2, "the second round")


@pytest.mark.parametrize(
    ("content", "expected"),
    [(None, "none.mcap"), (b"", "empty"), (b"no bag at all", "not")],
)
def test_what_is_no_bag_is_refused_in_one_sentence(tmp_path, content, expected):
    file = tmp_path / "none.mcap"
    if content is not None:
        file.write_bytes(content)
    said = fails_with(replay(file))
    assert expected in said
    assert "Traceback" not in said


def test_a_bag_without_samples_is_refused(session, bag):
    running = session(recorder(bag))
    running.wait_until(lambda: running.node.count_publishers("/diagnostics") == 1, "the recorder")
    running.processes["recorder"].send_signal(signal.SIGINT)
    running.processes.pop("recorder").wait(PATIENCE)
    assert "has no samples to replay" in fails_with(replay(bag))


def test_no_bag_at_all_is_asked_for():
    assert "give the MCAP file to replay" in fails_with(NodeProcess("replay", "replay"))


def test_a_truncated_bag_is_replayed_up_to_its_last_whole_chunk(session, recorded, tmp_path):
    cut = tmp_path / "cut.mcap"
    content = recorded.read_bytes()
    cut.write_bytes(content[: 2 * len(content) // 3])
    whole = len(read_recording(cut))
    running = session(replay(cut, paused=True, rate=20.0))
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    running.wait_for_subscribers({"/probe/replay": 1})
    resume(running)
    running.processes.pop("replay").wait(PATIENCE)
    running.wait_until(lambda: sum(len(b.position) for b in blocks) == whole, "every sample")
    assert 0 < whole < len(read_recording(recorded))


def test_it_is_read_by_the_command_line(recorded, tmp_path):
    table = tmp_path / "estimates.csv"
    command = [sys.executable, "-m", "tissue_probe", "estimate", str(recorded), "-o", str(table)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    assert len(table.read_text().splitlines()) == len(read_recording(recorded)) + 1
