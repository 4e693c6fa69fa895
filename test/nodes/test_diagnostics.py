"""What each node says of its health: the levels, and the numbers behind them."""

from __future__ import annotations

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from conftest import activate, collect, command, driver, estimator, stage_on_tissue
from tissue_probe.nodes import diagnostics
from tissue_probe.nodes.diagnostics import OK, STALE, WARN, Rate
from tissue_probe.nodes.driver import slowness
from tissue_probe.nodes.session import NodeProcess

MAPPER = NodeProcess("mapper", "mapper", parameters={"estimators": ["ekf"]})


class Health:
    """The latest status of every node, by its name."""

    def __init__(self, running) -> None:
        self._running = running
        self._arrays = collect(running.node, DiagnosticArray, "/diagnostics")

    def of(self, node: str) -> DiagnosticStatus | None:
        statuses = [s for array in self._arrays for s in array.status if s.name == node]
        return statuses[-1] if statuses else None

    def wait(self, node: str, level: bytes, message: str = "") -> dict[str, str]:
        """Wait until a node is at a level; return its values."""

        def reached() -> bool:
            status = self.of(node)
            return status is not None and status.level == level and message in status.message

        self._running.wait_until(reached, f"{node} to be at level {level}")
        return {value.key: value.value for value in self.of(node).values}


def test_levels_and_numbers_from_start_to_a_known_tissue(session, bag):
    running = session(
        driver(),
        stage_on_tissue(),
        estimator("ekf"),
        MAPPER,
        NodeProcess("recorder", "recorder", parameters={"output": str(bag)}),
    )
    health = Health(running)
    health.wait("/probe/driver", OK, "not acquiring")
    health.wait("/probe/ekf", STALE, "no samples in the last second")
    health.wait("/probe/mapper", STALE, "0 of 0 cells are measured; no estimates")
    activate(running)

    def rate(node: str, unit: str) -> float:
        return float(health.wait(node, OK).get(f"achieved rate [{unit}]", "0"))

    running.wait_until(lambda: rate("/probe/driver", "samples/s") > 1900.0, "the whole rate")
    running.wait_until(lambda: rate("/probe/ekf", "samples/s") > 1900.0, "the estimator's")
    running.wait_until(
        lambda: (
            rate("/probe/driver", "samples/s") == pytest.approx(2000.0, rel=0.1)
            and rate("/probe/mapper", "estimates/s") == pytest.approx(200.0, rel=0.2)
        ),
        "the rates of a driver that keeps time",
    )
    found = health.wait("/probe/ekf", OK)
    assert found["status"] == "CONVERGED"
    assert float(found["stiffness [N/m]"]) == pytest.approx(450.0, rel=0.05)
    assert float(found["standard deviation of stiffness [N/m]"]) < 10.0
    assert found["samples lost"] == "0"
    disk = health.wait("/probe/recorder", OK, "recording to")
    assert int(disk["disk left [bytes]"]) > 0
    assert float(disk["time left on the disk [s]"]) > 600.0
    assert float(disk["achieved rate [messages/s]"]) > 200.0
    health.wait("/stage/stage", OK, "ENABLED")


def test_an_estimator_goes_stale_when_its_driver_dies(session):
    running = session(driver(), estimator("ekf"))
    health = Health(running)
    activate(running)
    health.wait("/probe/ekf", OK)
    running.processes["driver"].kill()
    running.processes.pop("driver").wait()
    health.wait("/probe/ekf", STALE)


def test_a_stage_that_will_not_move_is_a_warning(session):
    running = session(NodeProcess("stage", "stage", "/stage"))
    health = Health(running)
    health.wait("/stage/stage", OK)
    command(running, "/stage", "disable", "DISABLED")
    health.wait("/stage/stage", WARN, "DISABLED")


@pytest.mark.parametrize(
    ("lateness", "rate", "said"),
    [
        (0.001, 2000.0, ""),
        (0.001, 1950.0, ""),
        (0.08, 2000.0, "a sample was fetched 80 ms late"),
        (0.001, 1500.0, "1500 samples a second come, not 2000"),
    ],
)
def test_the_driver_tells_what_is_too_slow(lateness, rate, said):
    assert slowness(lateness, rate, 2000.0) == said


def test_a_rate_is_counted_since_it_was_last_asked(monkeypatch):
    now = [100.0]
    monkeypatch.setattr(diagnostics.time, "monotonic", lambda: now[0])
    rate = Rate()
    for step, count, expected in ((1.0, 2000, 2000.0), (0.5, 2100, 200.0), (2.0, 2100, 0.0)):
        now[0] += step
        assert rate(count) == pytest.approx(expected)
    now[0] += 1.0
    assert rate(30) == pytest.approx(30.0), "a new count began"
