"""Decisions in a process of their own: ``python -m tissue_probe.mapping.exploration.worker``.

Contents: the loop of that process.

Pickled tuples (number, function, arguments, named arguments) come in on standard input, pickled
tuples (number, result, exception) go out on standard output. It ends with its input, so with
whoever started it.
"""

from __future__ import annotations

import pickle
import signal
import sys


def main() -> None:
    """Answer until the input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # meant for who asks
    while True:
        try:
            number, function, arguments, named = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        answer: tuple[int, object, Exception | None]
        try:
            answer = number, function(*arguments, **named), None
        except Exception as error:  # whatever it was, who asks has to hear of it
            answer = number, None, error
        pickle.dump(answer, sys.stdout.buffer)
        sys.stdout.buffer.flush()


if __name__ == "__main__":
    main()
