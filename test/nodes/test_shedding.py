"""Single samples go out while they leave acquisition its time, and come back when they do again."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from hypothesis import given, settings
from hypothesis import strategies as st

from conftest import PATIENCE, activate, collect
from tissue_probe.nodes.conversions import samples_from_message
from tissue_probe.nodes.qos import PER_SAMPLE
from tissue_probe.nodes.session import Session
from tissue_probe.nodes.shedding import MOST, RESUMING_SHARE, Shedding
from tissue_probe.signals import join
from tissue_probe_msgs.msg import ProbeSamples

PERIOD = 5e-4


def play(shedding: Shedding, share: float, seconds: float) -> int:
    """Let publishing one by one take a share of the time; return how many samples went out so."""
    sent = 0
    for _ in range(round(seconds / PERIOD)):
        singly = shedding.allows
        shedding.note(share * PERIOD if singly else 0.02 * PERIOD, PERIOD, singly=singly)
        sent += singly
    return sent


@settings(max_examples=20)
@given(share=st.floats(0.0, MOST - 1e-6))
def test_what_leaves_time_is_never_shed(share):
    shedding = Shedding()
    assert play(shedding, share, 1.0) == 2000
    assert not shedding.active


@settings(max_examples=10)
@given(share=st.floats(MOST + 1e-6, 20.0))
def test_what_leaves_no_time_is_shed_at_once_and_only_tried_then(share):
    shedding = Shedding()
    assert play(shedding, share, 0.1) < 120
    assert shedding.active
    # A trial a second, of five milliseconds.
    assert play(shedding, share, 10.0) < 10 * 12


def test_a_pause_of_the_machine_is_no_reason():
    shedding = Shedding()
    play(shedding, 0.3, 1.0)
    for _ in range(20):  # a block whose publication took fifty periods, twice a second
        shedding.note(50 * PERIOD, PERIOD, singly=shedding.allows)
        play(shedding, 0.3, 0.5)
    assert not shedding.active


@pytest.mark.parametrize("share", [0.0, 0.9 * RESUMING_SHARE])
def test_it_ends_within_seconds_when_there_is_time_again(share):
    shedding = Shedding()
    play(shedding, 2.0, 1.0)
    play(shedding, share, 6.0)
    assert not shedding.active
    assert play(shedding, share, 1.0) == 2000


def test_what_would_just_fit_is_not_taken_up_again():
    shedding = Shedding()
    play(shedding, 2.0, 1.0)
    play(shedding, 0.5 * (RESUMING_SHARE + MOST), 10.0)
    assert shedding.active


@pytest.fixture
def costly(session) -> Iterator[Session]:
    """A session beside a driver that needs all its time, and more, to publish one by one."""
    running = session()
    program = str(Path(__file__).with_name("costly_driver.py"))
    process = subprocess.Popen(
        [sys.executable, program, "--ros-args", "-r", "__ns:=/probe"],
        env={**os.environ, "COSTS": "0.0006"},
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    yield running
    process.send_signal(signal.SIGINT)
    assert process.wait(PATIENCE) == 0


def test_the_driver_sheds_single_samples_tells_it_and_loses_no_block(costly):
    told = collect(costly.node, DiagnosticArray, "/diagnostics")
    blocks = collect(costly.node, ProbeSamples, "/probe/samples")
    singles: list[WrenchStamped] = []
    reader = costly.node.create_subscription(
        WrenchStamped, "/probe/measured_cf", singles.append, PER_SAMPLE
    )

    def says(words: str) -> bool:
        statuses = [s for m in told for s in m.status if s.name == "/probe/driver"]
        return bool(statuses) and words in statuses[-1].message

    activate(costly)
    costly.wait_until(lambda: says("are not published"), "the driver to shed")
    count = len(blocks)
    costly.wait_until(lambda: len(blocks) > count + 400, "two seconds of samples")
    (run,) = join(samples_from_message(block) for block in blocks)
    assert len(singles) < 0.5 * len(run)
    costly.node.destroy_subscription(reader)
    costly.wait_until(lambda: not says("are not published"), "the driver to say that it is over")
