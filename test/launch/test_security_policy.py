"""The SROS 2 policy allows what the nodes open, and nothing else."""

from __future__ import annotations

import pytest
from security_policy import OPERATOR, PARAMETER_SERVICES, Policy, live_policy, read_policy

from tissue_probe.estimation import ESTIMATORS

#: Who works on the force beside a lone estimator; the driver looks whether another one drives.
OTHERS = ("estimators", "identify", "monitor", "scan", "recorder", "operator", "driver")
#: What carries the force, and what moves or feeds the coil.
FORCE = {"/probe/samples", "/probe/measured_cf"}


@pytest.fixture(scope="module")
def allowed() -> Policy:
    return read_policy()


def test_the_file_allows_exactly_what_the_live_nodes_open(allowed, tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    live = live_policy(tmp_path, enough=lambda found: found == allowed)
    assert live.keys() == allowed.keys()
    for node, rules in live.items():
        assert rules == allowed[node], f"write it anew: see security_policy.py ({node})"


def who_may(policy: Policy, kind: str, permission: str, names: set[str]) -> set[str]:
    return {
        enclave
        for (enclave, _, _), rules in policy.items()
        if rules.get((kind, permission), set()) & names
    }


def test_only_driver_adapter_and_replay_publish_samples(allowed):
    sources = {"/probe/driver", "/probe/adapter", "/probe/replay"}
    assert who_may(allowed, "topics", "publish", FORCE) == sources


def test_only_who_works_on_the_force_reads_it(allowed):
    readers = {f"/probe/{name}" for name in (*ESTIMATORS, *OTHERS)}
    assert who_may(allowed, "topics", "subscribe", FORCE) == readers


def test_only_the_operator_stops_and_arms_the_coil(allowed):
    assert who_may(allowed, "topics", "publish", {"/probe/emergency_stop"}) == {OPERATOR[0]}
    reset = {"/probe/reset", "/probe/emergency_stop"}
    assert who_may(allowed, "services", "request", reset) == {OPERATOR[0]}


def test_only_the_operator_and_who_identifies_command_the_driver(allowed):
    services = allowed["/probe/driver", "/probe", "driver"]["services", "reply"]
    commands = {name for name in services if name.rpartition("/")[2] not in PARAMETER_SERVICES}
    assert "/probe/driver/change_state" in commands
    both = {OPERATOR[0], "/probe/identify"}
    assert who_may(allowed, "services", "request", commands) == both
    setters = {"/probe/driver/set_parameters", "/probe/driver/set_parameters_atomically"}
    assert who_may(allowed, "services", "request", setters) == both
    assert who_may(allowed, "topics", "publish", {"/probe/state_command"}) == {OPERATOR[0]}


def test_only_the_scan_moves_the_stage_and_only_the_operator_enables_it(allowed):
    assert who_may(allowed, "topics", "publish", {"/stage/servo_cp"}) == {"/probe/scan"}
    commands = who_may(allowed, "topics", "publish", {"/stage/state_command"})
    assert commands == {OPERATOR[0]}
