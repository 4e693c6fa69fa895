"""``tissue_probe challenge``: how far to trust a diagnosis, by effects hidden and then sought."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, cast

import typer

from tissue_probe.analysis.choices import Starts
from tissue_probe.analysis.question_items import ITEMS_BY_NAME
from tissue_probe.cli.measurement_options import Site, read
from tissue_probe.quantities import SIDE

if TYPE_CHECKING:
    from tissue_probe.challenge.folder import Format
    from tissue_probe.challenge.grading import Count, Grade, GradedDiagnosis
    from tissue_probe.challenge.measured_motion import Measured
    from tissue_probe.challenge.series import Hide
    from tissue_probe.challenge.simulator import Excitation, Rig
    from tissue_probe.challenge.trajectory import Kind
    from tissue_probe.physics.fitted_model import FittedModel

challenge = typer.Typer(
    no_args_is_help=True,
    rich_markup_mode=None,
    help="Hide effects, and count how often a diagnosis finds them.",
)


Answers = Annotated[
    Path,
    typer.Option(metavar="FILE", help="The sealed answers, outside the recordings' folder."),
]


@challenge.command()
def make(
    folder: Annotated[
        Path, typer.Argument(metavar="OUT_DIR", help="Where to leave 0001.csv, 0001_second.csv...")
    ],
    count: Annotated[
        int, typer.Option(metavar="NUMBER", min=1, max=9999, help="Of recordings.")
    ] = 20,
    seed: Annotated[
        int,
        typer.Option(
            metavar="NUMBER", min=0, help="With all else alike, makes the same recordings again."
        ),
    ] = 0,
    rig: Annotated[
        str, typer.Option(metavar="RIG", help="exact, or tolerant: off within its tolerances.")
    ] = "exact",
    excitation: Annotated[
        str,
        typer.Option(
            metavar="NAME|FILE",
            help="sine10, sine10ss, stepped30, chirp60 or msine60; any: one of these for each "
            "recording; or your own: a recording of this suite, or a table with the columns t [s] "
            "and u [m], whose motion of the coil is repeated.",
        ),
    ] = "chirp60",
    starts: Annotated[Starts, typer.Option(help=ITEMS_BY_NAME["starts"].about)] = "auto",
    site: Site = None,
    hide: Annotated[
        str, typer.Option(metavar="WHAT", help="one, two, none, outside, spoilt or mixed.")
    ] = "mixed",
    format: Annotated[str, typer.Option(metavar="ENDING", help="csv or mcap.")] = "csv",
    answers: Answers = Path("answers.sealed.json"),
) -> None:
    """Make recordings of simulated tissue with hidden effects.

    Columns of CSV: t [s], u [m], F [N], positive in compression, at 2 kHz. NAME_second is the same
    specimen with another motion of the coil. --starts and --site are of a FILE's motion.
    """
    from tissue_probe.challenge.folder import check_sealed, seal, write_recordings
    from tissue_probe.challenge.series import make_series

    check_sealed(answers, folder)
    told = {}
    # Both refuse a name that they do not know.
    known, ending, exactness = cast("Hide", hide), cast("Format", format), cast("Rig", rig)
    motion = choose_motion(excitation, starts, site)
    made = make_series(known, count, seed, motion, exactness)
    for number, each in enumerate(made, start=1):
        name = f"{number:04d}"
        write_recordings(folder, name, each, ending)
        told[name] = each.answer
    seal(answers, told, folder)
    many = f"{count} recordings, and as many second ones, are"
    print(f"{'1 recording, and a second one, are' if count == 1 else many} in {folder}.")
    print(f"The answers are in {answers}; do not look.")


def choose_motion(excitation: str, starts: Starts, site: int | None) -> Excitation | Literal["any"]:
    """Return the name of an excitation, or the motion in a file; prints the motion's summary.

    Raises
    ------
    ValueError
        If there is no such name or file, the file has no motion that can be repeated, or options
        on a file stand beside a name.
    OSError
        If the file cannot be read.
    """
    from tissue_probe.challenge.series import ANY
    from tissue_probe.challenge.trajectory import DURATIONS

    names: list[Kind | Literal["any"]] = [*DURATIONS, ANY]
    path = Path(excitation)
    named = next((name for name in names if name == excitation), None)
    if named is None and path.exists():
        motion = read_motion(path, starts, site)
        begins = "from rest" if motion.at_rest else "in motion"
        print(
            f"The coil moves as in {path}: {motion.duration:g} s, begun {begins}, by "
            f"{1e3 * motion.amplitude:.3g} mm about {1e3 * motion.preload:.3g} mm, up to "
            f"{motion.highest:.3g} Hz."
        )
        return motion
    if named is None:
        raise ValueError(
            f"there is no excitation {excitation!r}, and no such file; there are {', '.join(names)}"
        )
    if starts != "auto" or site is not None:
        raise ValueError(f"--starts and --site are of a file's motion; leave them out with {path}")
    return named


def read_motion(path: Path, starts: Starts, site: int | None) -> Measured:
    """Read how the coil moved from a recording of this suite, or a table of t [s] and u [m].

    Raises
    ------
    ValueError
        If it cannot be read, or its motion cannot be repeated.
    OSError
        If it cannot be read.
    """
    import numpy as np

    from tissue_probe.challenge.record import follow
    from tissue_probe.recording.bags.open_bag import is_bag
    from tissue_probe.recording.clocks.stretches import dwell_blocks
    from tissue_probe.recording.layout import Layout
    from tissue_probe.signals import NANOSECONDS

    # Of a table's force nothing is asked.
    motion = Layout(position="u", force="u", force_unit="1", force_polarity="compression")
    (part,) = read([path], Layout() if is_bag(path) else motion).parts
    blocks = dwell_blocks(part.recording, site)
    stamps = np.concatenate([block.stamps for block in blocks])
    position = np.concatenate([block.position for block in blocks])
    rested = None if starts == "auto" else starts == "at-rest"
    return follow((stamps - stamps[0]) / NANOSECONDS, position, str(path), rested)


@challenge.command("grade")
def grade_command(
    folder: Annotated[
        Path,
        typer.Argument(metavar="DIR", help="Folder of 0001.json, ... of tissue_probe diagnose."),
    ],
    answers: Answers = Path("answers.sealed.json"),
    json: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Marks as JSON; replaced if there.")
    ] = None,
) -> None:
    """Mark the diagnoses of a series, and show which effects were mistaken.

    A recording without a diagnosis counts as wrong. docs/challenge.md says which answers count as
    right.
    """
    from tissue_probe.challenge.folder import read_answers
    from tissue_probe.challenge.grading import grade

    marks = grade(sealed := read_answers(answers), read_diagnoses(folder, list(sealed)))
    summarize(marks)
    if json is not None:
        write_marks(json, marks)


@challenge.command("open")
def open_command(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Of a recording, such as 0001.")],
    model: Annotated[
        Path, typer.Option("--model", metavar="FILE", help="model.yaml that was found for it.")
    ],
    answers: Answers = Path("answers.sealed.json"),
) -> None:
    """Open the seal of one recording, and show the truth beside the diagnosis."""
    from rich.console import Console
    from rich.table import Table

    from tissue_probe.challenge.folder import read_answers
    from tissue_probe.physics.model_file import load

    sealed = read_answers(answers)
    if name not in sealed:
        raise ValueError(f"{answers} has no {name}; it has {', '.join(sealed)}")
    told, found = sealed[name], load(model)
    true: dict[str, object] = {**told["tissue"], **told["rig"]}
    for effect, values in told["parameters"].items():
        true |= {f"{effect}: {each}": value for each, value in values.items()}
    table = Table("", "true", "found")
    table.add_row("effects", ", ".join(told["effects"]) or "none", _name_found(found))
    for each in dict.fromkeys((*true, *found.values)):
        at, doubt = found.values.get(each), found.deviations.get(each, 0.0)
        told_of = "" if at is None else f"{at:.5g} +- {SIDE * doubt:.2g}"
        table.add_row(each, _number(true.get(each)), told_of)
    Console(highlight=False, markup=False).print(table)


def _name_found(found: FittedModel) -> str:
    return ", ".join(found.composition.names) or "none"


def _number(value: object) -> str:
    """Write a true value; of a simulator's own lists only how many there are."""
    if isinstance(value, list):
        return f"{len(value)} values"
    return f"{value:.5g}" if isinstance(value, (int, float)) else str(value or "")


def read_diagnoses(folder: Path, names: list[str]) -> dict[str, GradedDiagnosis]:
    """Return the diagnoses that are there, by the recordings' names.

    Raises
    ------
    ValueError
        If there is none at all, or one cannot be read.
    """
    from tissue_probe.challenge.folder import read_json
    from tissue_probe.challenge.grading import GradedDiagnosis

    found = {}
    for name in names:
        path = folder / f"{name}.json"
        if path.exists():
            try:
                found[name] = GradedDiagnosis.parse(read_json(path))
            except ValueError as error:
                raise ValueError(f"{path}: {error}") from error
    if not found:
        raise ValueError(f"{folder} holds none of {names[0]}.json to {names[-1]}.json")
    return found


MARK_ROWS = {
    "first": "one effect hidden: ranked first",
    "declared": "  ranked first, or declared indistinguishable or unseen",
    "first_three": "  among the first three, named or unseen",
    "first_three_named": "  among the first three, by a verdict that names one",
    "family": "  an effect of its family ranked first",
    "covered": "  claimed sets that hold it",
    "absorbed": "one that Kelvin-Voigt absorbs: adequate, or listed",
    "false_alarms": "none hidden: false alarms",
    "two": "two hidden: both named",
    "two_declared": "  both named, or one and the other declared",
    "one_of_two": "  at least one named",
    "unexplained": "outside the library: unexplained",
    "spoilt": "converter at fault: told",
}


def summarize(marks: Grade) -> None:
    """Print the marks, and which effect was mistaken for which."""
    from rich.console import Console
    from rich.table import Column, Table

    console = Console(highlight=False, markup=False)
    table = Table("", *(Column(title, justify="right") for title in ("of", "number", "[%]")))
    for name, title in MARK_ROWS.items():
        table.add_row(title, *_cells(getattr(marks, name)))
    console.print(table)
    if marks.mean_claimed is not None:
        print(f"A claimed set has {marks.mean_claimed:.2f} effects on average.")
    if marks.undiagnosed:
        print(f"Without a diagnosis, and so wrong: {', '.join(marks.undiagnosed)}.")
    confusion = Table("hidden", Column("times", justify="right"), "named first")
    for hidden in sorted(marks.confusion):
        named = marks.confusion[hidden]
        told = ", ".join(f"{name} {count}" for name, count in named.most_common())
        confusion.add_row(hidden, str(named.total()), told)
    console.print(confusion)


def _cells(count: Count) -> tuple[str, str, str]:
    share = "-" if count.share is None else f"{100.0 * count.share:.1f}"
    return str(count.total), str(count.right), share


def write_marks(path: Path, marks: Grade) -> None:
    """Write marks as JSON: each right, total and share; mean_claimed; undiagnosed; confusion."""
    import json

    told: dict[str, object] = {"version": 1}
    for name in MARK_ROWS:
        count = getattr(marks, name)
        told[name] = {"right": count.right, "total": count.total, "share": count.share}
    told["mean_claimed"] = marks.mean_claimed
    told["undiagnosed"] = marks.undiagnosed
    told["confusion"] = {hidden: dict(named) for hidden, named in marks.confusion.items()}
    path.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
