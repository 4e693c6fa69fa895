"""The node identify: records and diagnoses, and at any end the driver is as it was found."""

from __future__ import annotations

import os
import signal
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from lifecycle_msgs.msg import State, Transition
from rcl_interfaces.srv import GetParameters
from std_msgs.msg import String
from std_srvs.srv import Trigger

import tissue_probe
from conftest import (
    Acting,
    activate,
    ask,
    change_state,
    collect,
    driver,
    set_parameter,
    site_publisher,
    stage_on_tissue,
    state_of,
)
from tissue_probe.nodes.qos import LATCHED, LOANS
from tissue_probe.nodes.remote_driver import RemoteDriver
from tissue_probe.nodes.session import NodeProcess
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.model_file import load, save
from tissue_probe_msgs.action import Identify
from tissue_probe_msgs.msg import PalpationSite

FOUND = {"kind": "sine", "amplitude": 0.7, "frequency": 11.0}
CHIRP = {"kind": "chirp", "amplitude": 0.5, "start": 2.0, "stop": 40.0, "duration": 3.0}
#: Three diagnoses on a busy machine that finds no machine code of an earlier one [s].
LONG = 280.0


def probe(**parameters: object) -> NodeProcess:
    named = {f"excitation__{name}": value for name, value in FOUND.items()}
    return driver(**named, **parameters)


def identify(folder: Path, **parameters: object) -> NodeProcess:
    return NodeProcess("identify", "identify", parameters={"output": str(folder), **parameters})


def goal(seconds: float = 120.0, records: int = 3, **limits: float) -> Identify.Goal:
    return Identify.Goal(seconds=seconds, records=records, **limits)


def acting(running, asked: Identify.Goal) -> Acting:
    return Acting(running, Identify, "identify", asked)


def excitation_of(running) -> dict[str, object]:
    names = [f"excitation.{name}" for name in FOUND]
    request = GetParameters.Request(names=names)
    kind, amplitude, frequency = ask(
        running, GetParameters, "/probe/driver/get_parameters", request
    ).values
    return {
        "kind": kind.string_value,
        "amplitude": amplitude.double_value,
        "frequency": frequency.double_value,
    }


def is_as_found(running, state: int) -> bool:
    return state_of(running) == state and excitation_of(running) == FOUND


def wait_for_samples(running, work: Acting) -> None:
    """Wait until a part of the first record is there."""
    running.wait_until(
        lambda: any(each.doing.startswith("records, 1") for each in work.feedback), "samples"
    )


def children(pid: int) -> list[int]:
    """The processes that a process has started and that run."""
    found = [each.read_text().split() for each in Path(f"/proc/{pid}/task").glob("*/children")]
    return [int(child) for each in found for child in each]


def hidden_model(path: Path, effect: str) -> Path:
    composition = Composition(effects=(EFFECTS[effect],))
    values = {entry.name: entry.default for entry in composition.values}
    save(path, composition, {**values, "stiffness": 400.0, "damping": 2.0}, {})
    return path


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_a_hidden_effect_is_found_by_excitations_of_its_own_choice(session, tmp_path):
    model = hidden_model(tmp_path / "hidden.yaml", "structural_mode")
    running = session(probe(simulated__model=str(model)), stage_on_tissue(), identify(tmp_path))
    activate(running)
    work = acting(running, goal(LONG))
    ended = work.result(LONG)
    result = ended.result
    assert ended.status == GoalStatus.STATUS_SUCCEEDED, result.message
    assert result.settled
    assert result.verdict == "missing"
    assert result.effects[0] == "structural_mode"
    assert result.probabilities[0] > 0.9
    assert result.error_current > 1.5 > 1.1 > result.error_proposed
    assert [each.record for each in work.feedback] == sorted(e.record for e in work.feedback)
    assert "sine" in work.feedback[1].excitation
    assert len({each.excitation for each in work.feedback[1:]}) == len(result.recordings) > 1
    assert is_as_found(running, State.PRIMARY_STATE_ACTIVE)
    files = [Path(each) for each in result.recordings]
    assert len(files) == max(each.record for each in work.feedback)
    assert len(tissue_probe.read(*map(str, files))) > 2000 * 2 * len(files)
    kept = files[0].parent / "model.yaml"
    assert kept.read_text() == result.model
    assert load(kept).composition.names == ("structural_mode",)


@pytest.mark.parametrize("state", ["active", "inactive"])
def test_cancel_leaves_the_driver_as_it_was_found(session, tmp_path, state):
    running = session(probe(), stage_on_tissue(), identify(tmp_path))
    activate(running)
    found = State.PRIMARY_STATE_ACTIVE
    if state == "inactive":
        assert change_state(running, Transition.TRANSITION_DEACTIVATE)
        found = State.PRIMARY_STATE_INACTIVE
    work = acting(running, goal())
    wait_for_samples(running, work)
    work.handle.cancel_goal_async()
    ended = work.result()
    assert ended.status == GoalStatus.STATUS_CANCELED
    assert ended.result.message == "cancelled; there is no verdict yet"
    assert is_as_found(running, found)
    (file,) = ended.result.recordings
    assert len(tissue_probe.read(file)) > 1000


class Interrupted(Exception):
    pass


@pytest.mark.parametrize("state", [State.PRIMARY_STATE_ACTIVE, State.PRIMARY_STATE_INACTIVE])
def test_an_excitation_is_taken_back_whatever_happens_meanwhile(session, state):
    running = session(probe(), stage_on_tissue())
    activate(running)
    if state == State.PRIMARY_STATE_INACTIVE:
        assert change_state(running, Transition.TRANSITION_DEACTIVATE)
    remote = RemoteDriver(running.node, "driver")

    def wait(condition) -> None:
        running.wait_until(condition, "the driver")

    found = remote.look(wait)
    taken = []
    with suppress(Interrupted), remote.excite(found, CHIRP, wait, wait):
        taken += [excitation_of(running)["kind"], state_of(running)]
        raise Interrupted
    assert taken == ["chirp", State.PRIMARY_STATE_ACTIVE]
    assert is_as_found(running, state)


def test_a_coil_that_somebody_has_stopped_meanwhile_stays_at_zero(session):
    running = session(probe(), stage_on_tissue())
    activate(running)
    remote = RemoteDriver(running.node, "driver")

    def wait(condition) -> None:
        running.wait_until(condition, "the driver")

    with remote.excite(remote.look(wait), CHIRP, wait, wait):
        assert change_state(running, Transition.TRANSITION_DEACTIVATE)
    assert is_as_found(running, State.PRIMARY_STATE_INACTIVE)


def test_a_diagnosis_that_is_killed_or_cancelled_ends_it_with_a_sentence(session, tmp_path):
    running = session(probe(), stage_on_tissue(), identify(tmp_path))
    activate(running)
    identifying = running.processes["identify"].pid
    endings = {
        "killed": lambda work, pid: os.kill(pid, signal.SIGKILL),
        "cancelled": lambda work, pid: work.handle.cancel_goal_async(),
    }
    for told, end in endings.items():
        work = acting(running, goal())
        running.wait_until(lambda: children(identifying), "the diagnosis", LONG)
        (diagnosing,) = children(identifying)
        end(work, diagnosing)
        ended = work.result()
        assert told in ended.result.message
        assert ended.status in (GoalStatus.STATUS_ABORTED, GoalStatus.STATUS_CANCELED)
        running.wait_until(lambda: not children(identifying), "the end of the diagnosis")
        assert is_as_found(running, State.PRIMARY_STATE_ACTIVE)
        (file,) = ended.result.recordings
        assert len(tissue_probe.read(file)) > 4 * 1900


@pytest.mark.parametrize("ending", [signal.SIGKILL, signal.SIGSTOP])
def test_a_node_that_falls_silent_in_a_record_leaves_the_coil_at_zero(session, tmp_path, ending):
    running = session(probe(), stage_on_tissue(), identify(tmp_path))
    activate(running)
    assert change_state(running, Transition.TRANSITION_DEACTIVATE)
    faults = collect(running.node, String, "/probe/fault", LATCHED)
    wait_for_samples(running, acting(running, goal()))
    silent = running.processes.pop("identify")
    try:
        silent.send_signal(ending)
        running.wait_until(lambda: faults and faults[-1].data, "the fault")
        assert "changed the excitation for a record fell silent" in faults[-1].data
        running.wait_until(lambda: is_as_found(running, State.PRIMARY_STATE_INACTIVE), "the driver")
    finally:
        silent.kill()
        silent.wait()


def test_an_excitation_whose_borrower_falls_silent_is_put_back_by_the_driver(session):
    running = session(probe(), stage_on_tissue())
    activate(running)
    faults = collect(running.node, String, "/probe/fault", LATCHED)
    remote = RemoteDriver(running.node, "driver")

    def wait(condition) -> None:
        running.wait_until(condition, "the driver")

    with remote.excite(remote.look(wait), CHIRP, wait, wait):
        assert excitation_of(running)["kind"] == "chirp"
        running.wait_until(lambda: faults and faults[-1].data, "the fault")
        running.wait_until(lambda: is_as_found(running, State.PRIMARY_STATE_INACTIVE), "the driver")
    assert is_as_found(running, State.PRIMARY_STATE_INACTIVE)


def test_what_is_no_excitation_is_not_put_back(session):
    running = session(probe(), stage_on_tissue())
    activate(running)
    loans = running.node.create_publisher(String, "excitation_loan", LOANS)
    running.wait_until(loans.get_subscription_count, "the driver")
    for content in ("chirp", '{"kind": "none"}', '{"kind": "chirp", "start": 9, "stop": 9}'):
        loans.publish(String(data=content))
        said = f"is no excitation, and is passed over: {content!r}"
        running.wait_until(lambda said=said: said in running.whole_log("driver"), "the log")
    running.node.destroy_publisher(loans)
    assert is_as_found(running, State.PRIMARY_STATE_ACTIVE)


def test_a_fault_of_the_driver_ends_it_and_the_coil_stays_at_zero(session, tmp_path):
    running = session(probe(), stage_on_tissue(), identify(tmp_path))
    activate(running)
    work = acting(running, goal())
    wait_for_samples(running, work)
    assert ask(running, Trigger, "/probe/emergency_stop").success
    ended = work.result()
    assert ended.status == GoalStatus.STATUS_ABORTED
    assert "the driver has stopped the coil" in ended.result.message
    assert "emergency_stop" in ended.result.message
    assert is_as_found(running, State.PRIMARY_STATE_INACTIVE)


def test_a_driver_that_dies_ends_it_and_what_was_recorded_is_kept(session, tmp_path):
    running = session(probe(), stage_on_tissue(), identify(tmp_path))
    activate(running)
    work = acting(running, goal())
    wait_for_samples(running, work)
    killed = running.processes.pop("driver")
    killed.send_signal(signal.SIGKILL)
    killed.wait()
    ended = work.result()
    assert ended.status == GoalStatus.STATUS_ABORTED
    assert "no samples of this excitation come on /probe/samples" in ended.result.message
    (file,) = ended.result.recordings
    assert len(tissue_probe.read(file)) > 1000


def test_nothing_is_recorded_while_a_scan_is_under_way(session, tmp_path):
    running = session(probe(), stage_on_tissue(), identify(tmp_path))
    activate(running)
    sites = site_publisher(running.node)
    running.wait_until(sites.get_subscription_count, "identify")
    sites.publish(PalpationSite(site=3, phase=PalpationSite.DWELL))
    work = acting(running, goal())
    ended = work.result()
    assert ended.status == GoalStatus.STATUS_ABORTED
    assert "a scan is under way, at site 3" in ended.result.message
    assert is_as_found(running, State.PRIMARY_STATE_ACTIVE)
    sites.publish(PalpationSite(site=3, phase=PalpationSite.LIFTED))
    again = acting(running, goal())
    wait_for_samples(running, again)
    sites.publish(PalpationSite(site=4, phase=PalpationSite.APPROACH))
    assert "a scan is under way, at site 4" in again.result().result.message
    assert is_as_found(running, State.PRIMARY_STATE_ACTIVE)


def test_a_second_goal_and_goals_out_of_range_end_with_a_sentence(session, tmp_path):
    running = session(probe(), stage_on_tissue(), identify(tmp_path))
    unconfigured = acting(running, goal()).result()
    assert "the driver is not configured" in unconfigured.result.message
    activate(running)
    told = {
        "goal seconds": goal(np.nan),
        "goal records": goal(records=0),
        "goal amplitude_limit": goal(amplitude_limit=np.nan),
        "no experiment is within": goal(highest_frequency=2.0),
    }
    for words, asked in told.items():
        ended = acting(running, asked).result()
        assert ended.status == GoalStatus.STATUS_ABORTED
        assert words in ended.result.message
    first = acting(running, goal())
    wait_for_samples(running, first)
    second = acting(running, goal()).result()
    assert second.status == GoalStatus.STATUS_ABORTED
    assert "an identification is under way" in second.result.message
    first.handle.cancel_goal_async()
    assert first.result().status == GoalStatus.STATUS_CANCELED
    assert change_state(running, Transition.TRANSITION_DEACTIVATE)
    weak = acting(running, goal(amplitude_limit=0.1)).result()
    assert "beyond the limits of 0.1 V" in weak.result.message
    assert is_as_found(running, State.PRIMARY_STATE_INACTIVE)


def test_records_that_cannot_be_stored_end_it_with_a_sentence(session, tmp_path):
    (tmp_path / "taken").write_text("a file in place of a folder")
    running = session(probe(), stage_on_tissue(), identify(tmp_path / "taken"))
    activate(running)
    ended = acting(running, goal()).result()
    assert ended.status == GoalStatus.STATUS_ABORTED
    assert "taken" in ended.result.message
    assert is_as_found(running, State.PRIMARY_STATE_ACTIVE)


def test_two_nodes_on_one_driver_are_refused(session, tmp_path):
    running = session(
        probe(), stage_on_tissue(), identify(tmp_path),
        NodeProcess("identify", "other", parameters={"output": str(tmp_path)}),
    )  # fmt: skip
    activate(running)
    node = running.node
    running.wait_until(
        lambda: node.count_publishers("/probe/identify/_action/status") == 2, "both nodes"
    )
    assert "end all but one" in acting(running, goal()).result().result.message


def test_the_end_of_the_node_puts_the_driver_back(session, tmp_path):
    running = session(probe(), stage_on_tissue(), identify(tmp_path))
    activate(running)
    assert change_state(running, Transition.TRANSITION_DEACTIVATE)
    work = acting(running, goal())
    wait_for_samples(running, work)
    ending = running.processes.pop("identify")
    ending.send_signal(signal.SIGINT)
    running.wait_until(lambda: ending.poll() is not None, "the node's end")
    assert ending.wait() == 0
    assert is_as_found(running, State.PRIMARY_STATE_INACTIVE)
    assert set_parameter(running, "/probe/driver", "excitation.amplitude", 0.6)[0]
