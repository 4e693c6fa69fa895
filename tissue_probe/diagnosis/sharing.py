"""Work that this process shares with a copy of itself.

Contents: the division of the work, and how results come back.

Nearly half of a search is Python: of that two threads do one thing at a time, and hand over to one
another so often that they gain a sixth. A copy of the process (fork) knows all that this one knows,
and is made in a few milliseconds.
"""

from __future__ import annotations

import gc
import io
import multiprocessing
import pickle
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from mmap import mmap
from multiprocessing.connection import Connection
from os import getpid
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

#: Processes that share a call, where nobody says otherwise.
WORKERS = 2

_Given = TypeVar("_Given")
_Told = TypeVar("_Told")

#: Whether no copy is to be made: of each thread, and of the copy as of who made it.
_alone = ContextVar("alone", default=False)


def map_shared(
    function: Callable[[_Given], _Told], given: Iterable[_Given], known: Sequence[object] = ()
) -> list[_Told]:
    """Return the results of a function for each of several things, as ``map`` does.

    Parameters
    ----------
    function : callable
        The work; changes that it makes to its surroundings are lost.
    given : iterable
        The things that it is applied to.
    known : sequence of object
        See ``in_turns``.
    """
    works = [map(function, [one]) for one in given]
    return [told for (told,) in in_turns(works, known)]


def in_turns(works: Sequence[Iterator[_Told]], known: Sequence[object] = ()) -> list[list[_Told]]:
    """Advance iterators by turns, each to its next item, until all have ended.

    In each process none is advanced again before all others have begun, here or in the copy.

    Parameters
    ----------
    works : sequence of iterator
        The work; changes that it makes to its surroundings are lost.
    known : sequence of object
        Objects in the items that both processes have: they are not copied, and stay the same.

    Returns
    -------
    list of list
        The items of each.

    Raises
    ------
    Exception Any exception that a work raises, here or in the copy.
    RuntimeError
        If the copy is ended from outside.
    """
    if _alone.get() or len(works) < 2 or not _may_copy():
        told = _advance_works(works, iter(range(len(works))))
    else:
        told = _in_two(works, known)
    return [told[number] for number in range(len(works))]


def _may_copy() -> bool:
    """Whether this process may have a copy: some systems know no fork, some processes may not.

    Nor may one with other threads, as a notebook's: a lock that one of them holds would stay locked
    in the copy.
    """
    by_fork = "fork" in multiprocessing.get_all_start_methods()
    alone = threading.active_count() == 1
    return by_fork and alone and not multiprocessing.current_process().daemon


def _advance_works(
    works: Sequence[Iterator[_Told]], numbers: Iterator[int]
) -> dict[int, list[_Told]]:
    """Advance by turns those works whose numbers are given, the first of each before any second."""
    told: dict[int, list[_Told]] = {}
    begun: deque[int] = deque()
    while True:
        number = next(numbers, None)
        if number is not None:
            told[number] = []
        elif begun:
            number = begun.popleft()
        else:
            return told
        for item in works[number]:
            told[number].append(item)
            begun.append(number)
            break


def _in_two(works: Sequence[Iterator[_Told]], known: Sequence[object]) -> dict[int, list[_Told]]:
    """Advance works in this process and in a copy: each takes the next one when it is free."""
    fork = multiprocessing.get_context("fork")
    waiting = fork.SimpleQueue()
    for number in (*range(len(works)), None, None):  # an end for each process
        waiting.put(number)
    answer, say = fork.Pipe(duplex=False)
    numbers = iter(waiting.get, None)
    copy = fork.Process(target=_tell, args=(works, numbers, say, known), daemon=True)
    try:
        with _hold_off_interrupt():
            copy.start()
        say.close()
        with _forbid_sharing():
            told = _advance_works(works, numbers)
        others: dict[int, list[_Told]] | BaseException = _hear_answer(answer, known)
    except BaseException:
        if copy.is_alive():
            copy.kill()
        raise
    finally:
        if copy.pid is not None:
            copy.join()
        answer.close()
        waiting.close()
    if isinstance(others, BaseException):
        raise others
    return told | others


def _tell(
    works: Sequence[Iterator[Any]],
    numbers: Iterator[int],
    say: Connection,
    known: Sequence[object],
) -> None:
    """Advance works in the copy, and send back each item or exception."""
    gc.disable()  # the copy ends before there is much
    told: object
    try:
        with _forbid_sharing():
            told = _advance_works(works, numbers)
    except BaseException as error:
        told = error
    file = io.BytesIO()
    _CopyWriter(file, known).dump(told)
    say.send_bytes(file.getbuffer())


def _hear_answer(answer: Connection, known: Sequence[object]) -> Any:
    """Return the answer of the copy."""
    try:
        return _CopyReader(io.BytesIO(answer.recv_bytes()), known).load()
    except EOFError:
        raise RuntimeError(
            "a copy of this process that did half of the work was ended from outside; "
            "if the machine is short of memory, end other programs"
        ) from None


@contextmanager
def _hold_off_interrupt() -> Iterator[None]:
    """Let a copy that is made meanwhile never hear of Ctrl-C: this process does, and ends it."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def among(workers: int) -> Iterator[None]:
    """Share the work meanwhile among so many processes; 1 is this one alone, and 2 are the most."""
    before = _alone.set(workers < 2 or _alone.get())
    try:
        yield
    finally:
        _alone.reset(before)


def _forbid_sharing() -> AbstractContextManager[None]:
    """Make no further copies meanwhile: all cores have something to do."""
    return among(1)


class Numbers:
    """A number of this process and one of its copy, which both see at any time.

    Parameters
    ----------
    begin : float
        The value that both begin with.
    """

    def __init__(self, begin: float) -> None:
        # Memory that a copy of the process shares, a place for each: none writes over the other's.
        self._places, self._maker = np.frombuffer(mmap(-1, 16)), getpid()
        self._places[:] = begin

    @property
    def both(self) -> NDArray[np.float64]:
        """The two numbers."""
        return self._places

    @property
    def own(self) -> float:
        """The number of the process that asks."""
        return float(self._places[self._own])

    @own.setter
    def own(self, number: float) -> None:
        self._places[self._own] = number

    @property
    def _own(self) -> int:
        return int(getpid() != self._maker)


class _CopyWriter(pickle.Pickler):
    """Writes an object that both processes have as its place among the known ones."""

    def __init__(self, file: io.BytesIO, known: Sequence[object]) -> None:
        super().__init__(file, protocol=pickle.HIGHEST_PROTOCOL)
        self.places = {id(one): place for place, one in enumerate(known)}

    def persistent_id(self, obj: object) -> int | None:
        """Return the place of a known object, or None."""
        return self.places.get(id(obj))


class _CopyReader(pickle.Unpickler):
    """Reads the bytes of a ``_CopyWriter``."""

    def __init__(self, file: io.BytesIO, known: Sequence[object]) -> None:
        super().__init__(file)
        self.known = known

    def persistent_load(self, pid: int) -> object:
        """Return the known object at a place."""
        return self.known[pid]
