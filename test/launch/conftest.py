"""What the package installs, as setup.py tells it."""

from __future__ import annotations

import runpy

import pytest
import setuptools
from declared import ROOT


@pytest.fixture
def package(monkeypatch) -> dict:
    """What setup.py tells setuptools."""
    told: dict = {}
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr(setuptools, "setup", lambda **arguments: told.update(arguments))
    runpy.run_path("setup.py")
    return told


@pytest.fixture
def executables(package) -> set[str]:
    """What `ros2 run tissue_probe` can start."""
    return {line.split(" = ")[0] for line in package["entry_points"]["console_scripts"]}
