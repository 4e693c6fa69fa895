"""How a node's process ends, whatever it was doing then."""

from __future__ import annotations

import sys

import pytest
import rclpy
from rclpy.node import Node

from tissue_probe.nodes.process import run


class Failing(Node):
    """Fails in a callback; first shuts the context down, as SIGTERM does, if it is told so."""

    destroyed = False

    def __init__(self, told_to_end: bool) -> None:
        super().__init__("failing")
        self._told_to_end = told_to_end
        self.create_timer(0.01, self._fail)

    def _fail(self) -> None:
        if self._told_to_end:
            rclpy.shutdown()
        raise LookupError("a fault that nobody foresaw")

    def destroy_node(self) -> None:
        Failing.destroyed = True
        super().destroy_node()


@pytest.fixture(autouse=True)
def command_line(monkeypatch):
    monkeypatch.setattr(sys, "argv", ["failing"])
    monkeypatch.setattr(Failing, "destroyed", False)


def test_what_a_signal_ended_under_is_no_failure():
    assert run(lambda: Failing(told_to_end=True)) == 0
    assert Failing.destroyed


def test_a_failure_that_no_signal_explains_is_raised():
    with pytest.raises(LookupError):
        run(lambda: Failing(told_to_end=False))
    assert Failing.destroyed
