"""A model that is read and compiled beside a node, in a process of its own.

Contents: starting it; ``python -m tissue_probe.nodes.model_process`` is the process.

The node never composes a model: that takes Python a second or more, in which its samples would
wait. It gets plain values, and finds the machine code on disk.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from tissue_probe.nodes.side_process import SideProcess
from tissue_probe.side_answer import Say, answer_question


class ModelToCompile(Protocol):
    """A question of plain values, which a process can be given."""

    def read(self) -> Callable[[], object]:
        """Compose the model; return a function that compiles it, and returns plain values.

        Raises
        ------
        TissueProbeError, OSError
            If the model cannot be used.
        """


def start_compiling(model: ModelToCompile) -> SideProcess:
    """Return a process that says one word when the model is read, and another when compiled."""
    return SideProcess(__name__, model, "compiles the model")


def _compile(model: ModelToCompile, say: Say) -> object:
    compile_model = model.read()
    say(None)
    return compile_model()


if __name__ == "__main__":
    answer_question(_compile)
