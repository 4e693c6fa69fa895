"""Nodes start fast: each imports only the packages that its own work needs."""

import subprocess
import sys
from pathlib import Path

import pytest

from conftest import PATIENCE
from tissue_probe.nodes.session import NodeProcess, Session, started

EXAMPLE = Path(__file__).parents[2] / "examples" / "scan.mcap"
NODES = ("driver", "estimator", "estimators", "mapper", "recorder", "replay", "scan", "stage")
#: Each takes a third of a second or more to be imported.
HEAVY = ("numba", "nidaqmx", "matplotlib", "sympy", "pandas")


@pytest.mark.parametrize("node", NODES)
def test_a_node_imports_no_heavy_package_before_it_needs_it(node):
    program = f"import sys, tissue_probe.nodes.{node}\nprint(*sys.modules)"
    ran = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert not set(HEAVY) & set(ran.stdout.split())


@pytest.mark.parametrize("node", NODES)
def test_a_node_runs_as_a_program_of_its_own(node, monkeypatch, tmp_path):
    needed = {"recorder": {"output": str(tmp_path / "new.mcap")}, "replay": {"bag": str(EXAMPLE)}}
    name = "robust_ekf" if node == "estimator" else node
    process = NodeProcess(node, name, parameters=needed.get(node, {}))
    monkeypatch.setattr("tissue_probe.nodes.session.started", started)
    with Session([process]) as running:
        assert isinstance(running.processes[name], subprocess.Popen)
        running.wait_until(lambda: name in running.node.get_node_names(), name, PATIENCE)
    assert running.processes[name].returncode == 0
