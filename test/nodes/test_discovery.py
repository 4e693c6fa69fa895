"""What the suite starts by itself is heard on this host alone, unless the user says otherwise."""

from __future__ import annotations

from pathlib import Path

import pytest

from tissue_probe.nodes.session import NodeProcess

RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"


@pytest.mark.parametrize(("chosen", "used"), [(None, "LOCALHOST"), ("OFF", "OFF")])
def test_every_process_of_a_session_restricts_discovery(session, cold, monkeypatch, chosen, used):
    # Set first, so that monkeypatch takes away again what the session sets.
    monkeypatch.setenv(RANGE, chosen or "")
    if chosen is None:
        monkeypatch.delenv(RANGE)
    running = session(NodeProcess("stage", "stage", "/stage"))
    environment = Path(f"/proc/{running.processes['stage'].pid}/environ")
    running.wait_until(lambda: bool(environment.read_bytes()), "the process to have begun")
    assert f"{RANGE}={used}".encode() in environment.read_bytes().split(b"\0")
