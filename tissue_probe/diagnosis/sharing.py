"""Work that this process shares with a copy of itself.

What belongs here: who does what, and how it comes back. What does not: what is done.

Nearly half of a search is Python: of that two threads do one thing at a time, and hand over to one
another so often that they gain a sixth. A copy of the process (fork) knows all that this one knows,
and is made in a few milliseconds.
"""

from __future__ import annotations

import gc
import io
import os
import pickle
import signal
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from struct import Struct
from typing import Any, NoReturn, TypeVar

_Given = TypeVar("_Given")
_Told = TypeVar("_Told")
_Results = dict[int, list[_Told]]

#: How the number of a work is written to those who take it.
NUMBER = Struct("=H")

_shared = False


def mapped(
    function: Callable[[_Given], _Told], given: Iterable[_Given], known: Sequence[object] = ()
) -> list[_Told]:
    """Return what a function makes of each of several things, as ``map`` does.

    Parameters
    ----------
    function : callable
        What is done; what it changes is lost.
    given : iterable
        What it is done to.
    known : sequence of object
        See ``in_turns``.
    """
    works = [map(function, [one]) for one in given]
    return [told for (told,) in in_turns(works, known)]


def in_turns(works: Sequence[Iterator[_Told]], known: Sequence[object] = ()) -> list[list[_Told]]:
    """Advance iterators by turns, each to its next item, until all have ended.

    Before one is advanced again all the others have begun, here or in the copy.

    Parameters
    ----------
    works : sequence of iterator
        What is done; what it changes is lost.
    known : sequence of object
        What the items may hold and both processes have: it is not copied, and stays what it is.

    Returns
    -------
    list of list
        The items of each.

    Raises
    ------
    Exception
        Whatever a work raises, here or in the copy.
    """
    if _shared or len(works) < 2 or not hasattr(os, "fork"):
        told = _advanced(works, iter(range(len(works))))
    else:
        told = _in_two(works, known)
    return [told[number] for number in range(len(works))]


def _advanced(works: Sequence[Iterator[_Told]], numbers: Iterator[int]) -> _Results[_Told]:
    """Advance by turns those works whose numbers are given, the first of each before any second."""
    told: _Results[_Told] = {}
    begun: deque[int] = deque()
    while True:
        number = next(numbers, None)
        if number is not None:
            told[number] = []
        elif begun:
            number = begun.popleft()
        else:
            return told
        items = list(_first(works[number]))
        told[number] += items
        begun.extend([number] * len(items))


def _first(work: Iterator[_Told]) -> Iterator[_Told]:
    for item in work:
        yield item
        return


def _in_two(works: Sequence[Iterator[_Told]], known: Sequence[object]) -> _Results[_Told]:
    """Advance works in this process and in a copy: each takes the next one when it is free."""
    waiting, add = os.pipe()
    os.write(add, b"".join(map(NUMBER.pack, range(len(works)))))
    os.close(add)
    answer, say = os.pipe()
    process = os.fork()
    if process == 0:
        _as_copy(works, waiting, say, known)
    os.close(say)
    try:
        with _sharing(), open(answer, "rb") as file:
            told = _advanced(works, _taken(waiting))
            others = _read(file, known)
    except BaseException:
        os.kill(process, signal.SIGKILL)
        raise
    finally:
        os.close(waiting)
        os.waitpid(process, 0)
    if isinstance(others, BaseException):
        raise others
    return told | others


def _taken(waiting: int) -> Iterator[int]:
    """Yield numbers that nobody took, until there are none."""
    while number := os.read(waiting, NUMBER.size):
        yield NUMBER.unpack(number)[0]


def _as_copy(
    works: Sequence[Iterator[Any]], waiting: int, say: int, known: Sequence[object]
) -> NoReturn:
    """Advance works, tell what they yield or raise, and end without the process's last words."""
    try:
        gc.disable()  # it ends before there is much
        with _sharing():
            try:
                told: object = _advanced(works, _taken(waiting))
            except BaseException as error:
                told = error
        with open(say, "wb") as file:
            file.write(_written(told, known))
    finally:
        os._exit(0)


@contextmanager
def _sharing() -> Iterator[None]:
    """Make no further copies meanwhile: all cores have something to do."""
    global _shared
    _shared = True
    try:
        yield
    finally:
        _shared = False


def _read(file: io.BufferedReader, known: Sequence[object]) -> Any:
    try:
        return _Reader(file, known).load()
    except EOFError:
        raise RuntimeError(
            "a copy of this process that did half of the work was ended from outside; "
            "if the machine is short of memory, end other programs"
        ) from None


def _written(told: object, known: Sequence[object]) -> bytes:
    file = io.BytesIO()
    _Writer(file, known).dump(told)
    return file.getvalue()


class _Writer(pickle.Pickler):
    """Writes what both processes have as its place among what is known."""

    def __init__(self, file: io.BytesIO, known: Sequence[object]) -> None:
        super().__init__(file, protocol=pickle.HIGHEST_PROTOCOL)
        self.places = {id(one): place for place, one in enumerate(known)}

    def persistent_id(self, obj: object) -> int | None:
        """Return the place of what is known, or None."""
        return self.places.get(id(obj))


class _Reader(pickle.Unpickler):
    """Reads what a ``_Writer`` wrote."""

    def __init__(self, file: io.BufferedReader, known: Sequence[object]) -> None:
        super().__init__(file)
        self.known = known

    def persistent_load(self, pid: int) -> object:
        """Return what is known at a place."""
        return self.known[pid]
