"""No test of a device waits: the clock that devices sleep on is moved by hand."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import yaml

from tissue_probe.devices.simulated import SimulatedProbe
from tissue_probe.devices.simulated_settings import SimulatedProbeSettings


class Clock:
    """Stands for the module ``time``; it has no wall clock, so nothing can depend on one."""

    def __init__(self) -> None:
        self.now = 1000.0
        self.while_asleep: Callable[[], None] = lambda: None

    def monotonic(self) -> float:
        return self.now

    def sleep(self, duration: float) -> None:
        assert duration > 0.0
        self.now += duration
        self.while_asleep()


@pytest.fixture(autouse=True)
def clock(monkeypatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr("tissue_probe.pacing.time", clock)
    return clock


@pytest.fixture
def probe(tmp_path):
    """Make simulated probes on tissue of one stiffness [N/m] and damping [N s/m] everywhere."""

    def make(
        stiffness: float = 450.0, damping: float = 5.0, exact: bool = False, **settings: float
    ) -> SimulatedProbe:
        phantom = tmp_path / f"phantom_{stiffness}_{damping}.yaml"
        values = {"background_stiffness": stiffness, "background_damping": damping}
        phantom.write_text(yaml.safe_dump(values))
        if exact:
            settings |= {"force_noise": 0.0, "encoder_resolution": 0.0}
        return SimulatedProbe(SimulatedProbeSettings(phantom=str(phantom), **settings))

    return make
