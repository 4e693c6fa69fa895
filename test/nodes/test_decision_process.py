"""Decisions in a process of their own: results and errors come back, and it ends with who asked."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import time

import pytest

from conftest import PATIENCE
from tissue_probe.nodes.decision_process import DecisionProcess

ASKS_AND_WAITS = """
import sys, time
from tissue_probe.nodes.decision_process import DecisionProcess
import os
process = DecisionProcess()
print(process.submit(os.getpid).result(), flush=True)
process.submit(time.sleep, 0.2)
sys.stdin.read()
"""


@pytest.fixture
def process():
    started = DecisionProcess()
    yield started
    started.close()


def test_results_come_in_the_order_of_the_questions(process):
    asked = [process.submit(math.sqrt, number) for number in (1.0, 4.0, 9.0)]
    assert [each.result(PATIENCE) for each in asked] == [1.0, 2.0, 3.0]


def test_it_is_another_process(process):
    assert process.submit(os.getpid).result(PATIENCE) != os.getpid()


def test_an_error_is_raised_where_the_result_is_taken_and_the_next_question_is_answered(process):
    wrong = process.submit(math.sqrt, -1.0)
    with pytest.raises(ValueError, match="math domain error"):
        wrong.result(PATIENCE)
    assert process.submit(math.sqrt, 4.0).result(PATIENCE) == 2.0


def test_a_process_that_has_ended_is_told(process):
    asked = process.submit(os._exit, 1)
    with pytest.raises(RuntimeError, match="has ended"):
        asked.result(PATIENCE)
    with pytest.raises(RuntimeError, match="has ended"):
        process.submit(math.sqrt, 4.0).result(PATIENCE)


def test_it_ends_with_who_asked_even_if_that_is_killed():
    asking = subprocess.Popen(
        [sys.executable, "-c", ASKS_AND_WAITS],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    number = int(asking.stdout.readline())
    asking.kill()
    asking.communicate()
    deadline = time.monotonic() + PATIENCE
    while is_there(number):
        assert time.monotonic() < deadline, "it goes on"
        time.sleep(0.05)


def is_there(number: int) -> bool:
    try:
        with open(f"/proc/{number}/stat") as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False
