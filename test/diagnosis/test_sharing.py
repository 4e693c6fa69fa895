"""Work shared with a copy of the process: all is done once, in turns, and errors come back."""

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from multiprocessing import Value
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tissue_probe.diagnosis.fitting.search import Bar
from tissue_probe.diagnosis.sharing import in_turns, map_shared


@pytest.fixture(autouse=True, scope="module")
def alone():
    """As in a program by itself: the thread of pytest-xdist waits, and holds no lock."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(threading, "active_count", lambda: 1)
        yield


def _processes(number: int) -> tuple[int, int]:
    return number, os.getpid()


@given(st.lists(st.integers(), max_size=40))
@settings(max_examples=25, deadline=None)
def test_mapped_makes_of_each_thing_what_map_does(numbers: list[int]) -> None:
    assert map_shared(lambda number: 3 * number, numbers) == [3 * number for number in numbers]


@given(st.lists(st.lists(st.text(), max_size=5), max_size=12))
@settings(max_examples=25, deadline=None)
def test_iterators_are_advanced_to_their_ends(items: list[list[str]]) -> None:
    assert in_turns([iter(each) for each in items]) == items


def test_none_is_advanced_twice_before_all_have_begun() -> None:
    def order_in_one_process(_: int) -> list[int]:
        advanced: list[int] = []

        def work(number: int) -> Iterator[None]:
            for _ in range(number):
                advanced.append(number)
                yield

        in_turns([work(number) for number in (1, 2, 3)])
        return advanced

    assert map_shared(order_in_one_process, [0, 1]) == [[1, 2, 3, 2, 3, 3]] * 2


def test_two_processes_take_part_and_no_more_within_them() -> None:
    meeting = Value("i", 0)

    def within(number: int) -> list[tuple[int, int]]:
        with meeting.get_lock():
            meeting.value += 1
        while meeting.value < 2:  # until the other process has come, too
            pass
        return map_shared(_processes, [number, number + 1])

    inner = map_shared(within, [0, 10])
    assert [[number for number, _ in each] for each in inner] == [[0, 1], [10, 11]]
    processes = [{process for _, process in each} for each in inner]
    assert [len(each) for each in processes] == [1, 1]
    assert len(set.union(*processes)) == 2
    assert os.getpid() in set.union(*processes)


def test_what_both_processes_know_stays_what_it_is() -> None:
    known = [object() for _ in range(30)]
    assert all(
        a is b for a, b in zip(map_shared(lambda one: one, known, known), known, strict=True)
    )


def children() -> set[str]:
    """The processes that this one has started; other tests may have left some."""
    lists = Path("/proc/self/task").glob("*/children")
    return {number for each in lists for number in each.read_text().split()}


@pytest.mark.parametrize("here", [True, False])
def test_an_error_is_raised_wherever_it_happens(here: bool) -> None:
    process = os.getpid()
    others = Value("i", 0)

    def fail(_: int) -> None:
        with others.get_lock():
            others.value += 1
        while others.value < 2:  # each process has one
            pass
        if (os.getpid() == process) is here:
            raise ValueError("no such tissue")

    before = children()
    with pytest.raises(ValueError, match="no such tissue"):
        map_shared(fail, [0, 1])
    assert children() <= before  # none is left behind


def test_what_fails_on_the_way_is_not_passed_over() -> None:
    def work() -> Iterator[str]:
        yield "found"
        raise ValueError("diverged")

    with pytest.raises(ValueError, match="diverged"):
        in_turns([work()])


def test_a_copy_that_is_killed_is_told() -> None:
    process = os.getpid()
    begun = Value("i", 0)

    def be_killed(_: int) -> None:
        with begun.get_lock():
            begun.value += 1
        while begun.value < 2:
            pass
        if os.getpid() != process:
            os.kill(os.getpid(), signal.SIGKILL)

    with pytest.raises(RuntimeError, match="ended from outside"):
        map_shared(be_killed, [0, 1])


INTERRUPTED = """
import os, signal
from tissue_probe.diagnosis.sharing import map_shared

def work(_):
    os.write(1, b"begun ")
    signal.pause()

signal.signal(signal.SIGINT, signal.default_int_handler)  # where it was ignored before
try:
    map_shared(work, [0, 1])
except KeyboardInterrupt:
    os.write(1, b"interrupted")
"""


def test_ctrl_c_ends_both_and_the_copy_says_nothing() -> None:
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    command = [sys.executable, "-c", INTERRUPTED]
    process = subprocess.Popen(command, start_new_session=True, **pipes)
    assert process.stdout.read(12) == b"begun begun "
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does, to both
    rest, errors = process.communicate(timeout=30)  # until neither can say any more
    assert (rest, errors, process.returncode) == (b"interrupted", b"", 0)


def test_the_lowest_cost_is_known_to_both_processes() -> None:
    bar = Bar(100.0)
    map_shared(bar.note_cost, [70.0, 50.0, 90.0, 60.0])
    assert bar.cost == 50.0


def test_a_process_with_other_threads_makes_no_copy_of_itself(monkeypatch) -> None:
    """A lock that one of them holds would stay locked in the copy."""
    monkeypatch.setattr(threading, "active_count", lambda: 2)
    assert {process for _, process in map_shared(_processes, range(8))} == {os.getpid()}
