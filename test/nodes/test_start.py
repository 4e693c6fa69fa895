"""Nodes start fast: each imports only the packages that its own work needs."""

import subprocess
import sys

import pytest

NODES = (
    "adapter",
    "driver",
    "estimator",
    "estimators",
    "mapper",
    "recorder",
    "replay",
    "scan",
    "stage",
)
#: Each takes a third of a second or more to be imported.
HEAVY = ("numba", "nidaqmx", "matplotlib", "sympy", "pandas")


@pytest.mark.parametrize("node", NODES)
def test_a_node_imports_no_heavy_package_before_it_needs_it(node):
    program = f"import sys, tissue_probe.nodes.{node}\nprint(*sys.modules)"
    ran = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert not set(HEAVY) & set(ran.stdout.split())
