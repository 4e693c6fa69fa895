"""Examples one click away.

Contents: the purpose of each, and how its files are read.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from tissue_probe.analysis.choices import OWN_RIG
from tissue_probe.configuration import stock_example
from tissue_probe.workbench.page_messages import ExampleMessage
from tissue_probe.workbench.question import StatedQuestion


@dataclass(frozen=True)
class Example:
    """One example: its files, the one to be fitted first; how they are read, and the question."""

    title: str
    told: str
    files: tuple[str, ...]
    layout: Mapping[str, str] = field(default_factory=dict)
    asked: StatedQuestion = field(
        default_factory=lambda: StatedQuestion({"rig": OWN_RIG, "starts": "at-rest"})
    )

    @property
    def paths(self) -> list[Path]:
        """Where its files lie."""
        return [stock_example(name) for name in self.files]


_OWN = {"force_polarity": "compression"}
EXAMPLES = {
    "sweep": Example(
        "A sweep to 60 Hz",
        "One effect is hidden, and a second recording tells whether the answer carries over.",
        ("sweep.csv", "sweep_second.csv"),
        _OWN,
    ),
    "relaxation": Example(
        "Press and hold",
        "The tissue relaxes while the probe stands still: memory that the model lacks.",
        ("relaxation.csv",),
        _OWN,
    ),
    "cyclic": Example(
        "Slow cycles",
        "Five triangles in and out: look at the loop over the indentation.",
        ("cyclic.csv",),
        _OWN,
    ),
    "machine": Example(
        "Export of a testing machine",
        "It does not say everything: columns, units and signs are asked for.",
        ("testing_machine.csv",),
    ),
    "scan": Example(
        "A scan of a phantom",
        "Sites on a grid: a map, and each site's recording behind it.",
        ("scan.mcap",),
        asked=StatedQuestion(),
    ),
}


def describe_examples() -> list[ExampleMessage]:
    """Return names, titles and descriptions."""
    return [{"name": n, "title": each.title, "told": each.told} for n, each in EXAMPLES.items()]
