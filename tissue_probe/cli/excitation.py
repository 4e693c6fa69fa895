"""``tissue_probe excitation``: how well the tissue can be known, and when, before a run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tissue_probe.estimation.bound import Bound
    from tissue_probe.excitation import Excitation
    from tissue_probe.signals import FloatArray

SAMPLE_PERIOD = 5e-4  # s, the paper's 2 kHz
SHOWN_TIMES = (0.01, 0.02, 0.05, 0.1, 0.2, 1.0)  # s
WANTED = 5.0  # per cent, at two standard deviations


def excitation(
    kind: Annotated[
        str,
        typer.Option(metavar="KIND", help="sine, stepped_sweep, chirp or multisine."),
    ] = "sine",
    amplitude: Annotated[
        float, typer.Option(metavar="METRES", help="Largest displacement of the coil [m].")
    ] = 0.001,
    frequency: Annotated[
        float | None,
        typer.Option(metavar="HERTZ", help="Of the sine [Hz].  [default: 10]", show_default=False),
    ] = None,
    start: Annotated[
        float | None,
        typer.Option(
            metavar="HERTZ",
            help="Lowest frequency of sweep, chirp or multisine [Hz].  [default: 1]",
        ),
    ] = None,
    stop: Annotated[
        float | None,
        typer.Option(
            metavar="HERTZ",
            help="Highest frequency of sweep, chirp or multisine [Hz].  [default: 30]",
        ),
    ] = None,
    sweep_duration: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS", help="Time of one stepped_sweep or chirp [s].  [default: 10]"
        ),
    ] = None,
    steps: Annotated[
        int | None,
        typer.Option(metavar="NUMBER", help="Frequencies of a stepped_sweep.  [default: 10]"),
    ] = None,
    spacing: Annotated[
        float | None,
        typer.Option(metavar="HERTZ", help="Between the sines of a multisine [Hz].  [default: 1]"),
    ] = None,
    stiffness: Annotated[
        float, typer.Option(metavar="K", min=1e-3, max=1e6, help="Of the tissue [N/m].")
    ] = 450.0,
    damping: Annotated[
        float, typer.Option(metavar="BETA", min=1e-6, max=1e4, help="Of the tissue [N s/m].")
    ] = 5.0,
    duration: Annotated[
        float, typer.Option(metavar="SECONDS", min=0.01, max=60.0, help="Time in contact [s].")
    ] = 1.0,
    force_noise: Annotated[
        float,
        typer.Option(
            metavar="NEWTONS", min=1e-9, max=100.0, help="Standard deviation of the force [N]."
        ),
    ] = 0.005,
    force_offset: Annotated[
        bool, typer.Option(help="Whether the load cell's zero is unknown, too.")
    ] = True,
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", metavar="FILE", help="Picture to write: .png, .svg or .pdf."
        ),
    ] = Path("excitation.png"),
) -> None:
    """Say before a run how well the tissue can be known, and when.

    No unbiased estimate of stiffness [N/m] and damping [N s/m] from the samples so far has a
    standard deviation below the Cramer-Rao bound, which is printed and drawn against time [s]. The
    probe is the paper's, sampled at 2 kHz.
    """
    from tissue_probe.excitation import parse_excitation

    given = {
        "amplitude": amplitude,
        "frequency": frequency,
        "start": start,
        "stop": stop,
        "duration": sweep_duration,
        "steps": steps,
        "spacing": spacing,
    }
    values = {name: value for name, value in given.items() if value is not None}
    signal = parse_excitation({"kind": kind, **values})
    limit = compute_bound(signal, stiffness, damping, duration, force_noise, force_offset)
    draw(signal, limit, stiffness, damping).savefig(output, dpi=100)
    summarize(limit, stiffness, damping)
    print(f"The bound against time is in {output}.")


def compute_bound(
    signal: Excitation,
    stiffness: float,
    damping: float,
    duration: float,
    force_noise: float,
    force_offset: bool,
) -> Bound:
    """Return the bound after each sample from time 0 up to ``duration`` [s], both included.

    ``signal`` is the coil's displacement [m]; stiffness [N/m] and damping [N s/m] are the
    tissue's; ``force_noise`` [N] is a standard deviation.
    """
    import numpy as np

    from tissue_probe.estimation.bound import cramer_rao_bound
    from tissue_probe.estimation.settings import EstimatorSettings

    time = np.arange(round(duration / SAMPLE_PERIOD) + 1, dtype=float) * SAMPLE_PERIOD
    settings = EstimatorSettings(force_noise=force_noise)
    return cramer_rao_bound(signal(time), SAMPLE_PERIOD, stiffness, damping, settings, force_offset)


def summarize(limit: Bound, stiffness: float, damping: float) -> None:
    """Print the bound at a few times, and when each parameter can be known to 5 %."""
    from rich.console import Console
    from rich.table import Column, Table

    titles = ("time [ms]", "sd of k [N/m]", "[%]", "sd of beta [N s/m]", "[%]")
    table = Table(*(Column(title, justify="right") for title in titles))
    for time in SHOWN_TIMES:
        sample = round(time / SAMPLE_PERIOD)
        if sample < limit.stiffness.size:
            table.add_row(
                f"{1e3 * time:g}",
                *_cells(limit.stiffness[sample], stiffness),
                *_cells(limit.damping[sample], damping),
            )
    console = Console(highlight=False, markup=False)
    console.print(table)
    for name, deviations, value in (
        ("k", limit.stiffness, stiffness),
        ("beta", limit.damping, damping),
    ):
        print(f"{name} can be known to {WANTED:g} % at two standard deviations", end=" ")
        after = time_to_know(deviations, value)
        print("not within this time" if after is None else f"after {1e3 * after:g} ms")


def time_to_know(deviations: FloatArray, value: float) -> float | None:
    """Return when two standard deviations fall below 5 % of a value [s], None if never."""
    known = (2.0 * deviations <= WANTED / 100.0 * value).nonzero()[0]
    return float(known[0]) * SAMPLE_PERIOD if known.size else None


def _cells(deviation: float, value: float) -> tuple[str, str]:
    """Write a deviation absolute and in per cent; an unknown one is a dash."""
    if deviation == float("inf"):
        return "-", "-"
    return f"{deviation:.3g}", f"{100.0 * deviation / value:.3g}"


def draw(signal: Excitation, limit: Bound, stiffness: float, damping: float) -> Figure:
    """Draw the coil's displacement, and below it the bound in per cent of k and of beta."""
    import numpy as np
    from matplotlib.figure import Figure

    time = np.arange(limit.stiffness.size, dtype=float) * SAMPLE_PERIOD
    figure = Figure(figsize=(8.0, 6.0), layout="constrained")
    coil, bounds = figure.subplots(2, 1, height_ratios=(1, 2))
    coil.plot(time, 1e3 * signal(time), color="0.4", linewidth=1.0)
    coil.set(ylabel="coil [mm]", xlabel="time [s]", xlim=(0.0, time[-1]))
    bounds.loglog(1e3 * time, 100.0 * limit.stiffness / stiffness, color="#0072B2", label="k")
    bounds.loglog(1e3 * time, 100.0 * limit.damping / damping, "--", color="#E69F00", label="β")
    bounds.axhline(WANTED / 2.0, color="black", linestyle=":", label="5 % at two sd")
    # The first samples tell next to nothing; their bound would fill the picture.
    bounds.set(xlim=(5.0, 1e3 * time[-1]), ylim=(None, 100.0))
    bounds.set(xlabel="time [ms]", ylabel="least standard deviation [% of the value]")
    bounds.grid(which="both", alpha=0.3)
    bounds.legend()
    return figure
