"""Values that are kept for as long as a call of the Python interface lasts, and go with it.

Contents: such caches.

A fit asks for the same thing of the same samples again and again. Once it is done nobody does:
of a long record a cache would hold hundreds of megabytes for as long as the program runs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from threading import Lock
from typing import Any, TypeVar

_F = TypeVar("_F", bound=Callable[..., Any])

_forget: list[Callable[[], None]] = []
_lock, _calls = Lock(), 0


def for_a_call(most: int) -> Callable[[_F], _F]:
    """Keep a function's last answers, at most so many, until no call is under way."""

    def keep_results(function: _F) -> _F:
        kept = lru_cache(maxsize=most)(function)
        _forget.append(kept.cache_clear)
        return kept  # type: ignore[return-value]

    return keep_results


@contextmanager
def during_a_call() -> Iterator[None]:
    """Forget the kept values afterwards, unless another call is still under way."""
    global _calls
    with _lock:
        _calls += 1
    try:
        yield
    finally:
        with _lock:
            _calls -= 1
            last = not _calls
        if last:
            for forget in _forget:
                forget()
