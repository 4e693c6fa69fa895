"""The driver stops the coil where a scan node is silent while its probe may be in the tissue."""

from __future__ import annotations

import signal

import pytest
from std_msgs.msg import String
from test_driver import Witnessed

from conftest import (
    SCAN,
    STAGE,
    Scanning,
    activate,
    collect,
    driver,
    goal,
    set_parameter,
    site_publisher,
)
from crtk_msgs.msg import OperatingState
from tissue_probe.nodes.qos import LATCHED
from tissue_probe_msgs.msg import PalpationSite, ProbeSamples


@pytest.mark.parametrize("ending", [signal.SIGKILL, signal.SIGSTOP])
def test_the_coil_is_at_zero_where_the_scan_node_falls_silent_in_a_dwell(session, tmp_path, ending):
    running = session(STAGE, SCAN)
    # Longer than a busy machine holds up the scan node on its way to the dwell.
    witnessed = Witnessed(tmp_path, running, None, "-p", "limits.palpation_timeout:=3.0")
    try:
        activate(running)
        faults = collect(running.node, String, "/probe/fault", LATCHED)
        states = collect(running.node, OperatingState, "/probe/operating_state", LATCHED)
        Scanning(running, goal(dwell_time=100.0)).wait_for(PalpationSite.DWELL)
        witnessed.wait_until_driven()
        scan = running.processes.pop("scan")
        scan.send_signal(ending)
        running.wait_until(lambda: faults and faults[-1].data, "the fault")
        assert "the scan node fell silent in a dwell at site 0" in faults[-1].data
        assert witnessed.voltages()[-1] == 0.0
        running.wait_until(lambda: states[-1].state == "FAULT", "the state")
    finally:
        witnessed.process.kill()
        witnessed.process.wait()
        scan.kill()
        scan.wait()


def test_the_time_that_a_scan_may_be_silent_is_a_limit(session):
    running = session(driver(), STAGE, SCAN)
    activate(running)
    faults = collect(running.node, String, "/probe/fault", LATCHED)
    # Less than the scan promises cannot be asked for: it would not be heard at all.
    accepted, reason = set_parameter(running, "/probe/driver", "limits.palpation_timeout", 0.3)
    assert not accepted
    assert "Min: 0.5" in reason
    Scanning(running, goal(dwell_time=100.0)).wait_for(PalpationSite.DWELL)
    # Changed in a dwell, it watches that dwell on.
    limit = "limits.palpation_timeout"
    assert set_parameter(running, "/probe/driver", limit, 1.0) == (True, "")
    running.processes["scan"].kill()
    running.processes.pop("scan").wait()
    running.wait_until(lambda: faults and faults[-1].data, "the fault")
    assert "hangs (for 1 s)" in faults[-1].data


def test_a_scan_node_without_a_scan_may_be_silent_and_die(session):
    running = session(driver(limits__palpation_timeout=1.5), STAGE, SCAN)
    activate(running)
    faults = collect(running.node, String, "/probe/fault", LATCHED)
    samples = collect(running.node, ProbeSamples, "/probe/samples")
    answer = Scanning(running, goal(columns=1)).result()
    assert answer.result.sites_visited == 1

    def go_on(blocks: int) -> None:
        count = len(samples)
        running.wait_until(lambda: len(samples) > count + blocks, "samples")

    go_on(600)  # three seconds: twice as long as a scan may be silent
    running.processes["scan"].kill()
    running.processes.pop("scan").wait()
    go_on(600)
    assert [fault.data for fault in faults] == [""]


def test_who_announces_sites_without_a_promise_is_told_and_not_watched(session):
    """As a replay does, and a program of one's own that knows nothing of the watch."""
    running = session(driver(limits__palpation_timeout=0.5))
    activate(running)
    faults = collect(running.node, String, "/probe/fault", LATCHED)
    samples = collect(running.node, ProbeSamples, "/probe/samples")
    publisher = site_publisher(running.node)
    running.wait_until(lambda: "without the promise" in running.whole_log("driver"), "the warning")
    name = running.node.get_name()
    assert f"/{name} announces sites on /probe/palpation_site" in running.whole_log("driver")
    publisher.publish(PalpationSite(phase=PalpationSite.DWELL))
    count = len(samples)
    running.wait_until(lambda: len(samples) > count + 200, "samples")
    running.node.destroy_publisher(publisher)
    count = len(samples)
    running.wait_until(lambda: len(samples) > count + 200, "samples")
    assert [fault.data for fault in faults] == [""]
