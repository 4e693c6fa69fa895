"""``tissue_probe estimate``: a filter on a recording or a CSV file, off line."""

from __future__ import annotations

import math
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from tissue_probe.signals import Recording, TissueEstimates

from tissue_probe.cli.arguments import EffectFiles, Samples, Table, Topic


class Polarity(str, Enum):
    """Which forces are positive in a file."""

    compression = "compression"
    tension = "tension"


def estimate(
    samples: Samples,
    output: Table = Path("estimates.csv"),
    estimator: Annotated[
        str,
        typer.Option(
            "--estimator", "-e", metavar="NAME", help="Filter; see `tissue_probe estimators`."
        ),
    ] = "ekf",
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="Setting of the filter, such as force_noise=0.01; see `tissue_probe estimators`. "
            "By default a recording's own settings, else the paper's probe.",
        ),
    ] = None,
    model: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Model file (model.yaml) whose tool and effects a Kalman filter takes.",
            show_default="the recording's own, else Kelvin-Voigt tissue",
        ),
    ] = None,
    effects: EffectFiles = None,
    restart_at_site: Annotated[
        bool | None,
        typer.Option(
            help="Forget the tissue where a dwell at a site begins.  "
            "[default: as recorded, else yes]",
            show_default=False,
        ),
    ] = None,
    topic: Topic = None,
    time: Annotated[
        str, typer.Option(metavar="COLUMN", help="CSV column of time [s], from any zero.")
    ] = "t",
    position: Annotated[
        str,
        typer.Option(
            metavar="COLUMN",
            help="CSV column of the coil's displacement [m], positive into the tissue.",
        ),
    ] = "u",
    force: Annotated[
        str, typer.Option(metavar="COLUMN", help="CSV column of the load-cell force [N].")
    ] = "F",
    force_polarity: Annotated[
        Polarity, typer.Option(help="Which forces are positive in the CSV file.")
    ] = Polarity.compression,
) -> None:
    """Estimate stiffness and damping after every sample.

    On a recording the result is, bit for bit, what the live node published. The table has the
    columns time [s], stiffness [N/m], damping [N s/m], their variances, covariance_trace,
    innovation [N], normalized_innovation_squared and status. Time counts from the first sample of
    a recording, or from a CSV file's own zero.
    """
    from tissue_probe.cli.recorded import estimator_settings, read_samples, restarts_at_sites
    from tissue_probe.estimation.offline import estimate as run_estimator
    from tissue_probe.recording.tables import write_estimates

    if output.exists() and output.samefile(samples):
        raise ValueError(f"{output} holds the samples and would be replaced: give another --output")
    columns = {"time": time, "position": position, "force": force}
    recording, origin = read_samples(samples, topic, columns, force_polarity.value)
    changes = [*(settings or []), *([f"model={model}"] if model else [])]
    filter_settings = estimator_settings(recording, estimator, changes, effects or [])
    if restart_at_site is None:
        restart_at_site = restarts_at_sites(recording, estimator)
    estimates = run_estimator(
        recording, estimator, filter_settings, restart_at_site=restart_at_site
    )
    write_estimates(output, estimates, origin)
    print(f"{estimator}: {len(estimates)} samples written to {output}")
    print(_conclusion(estimates[: _last_contact(recording, estimates)]))


def _last_contact(recording: Recording, estimates: TissueEstimates) -> int:
    """Return how many estimates there are up to the end of the last dwell, or of the recording."""
    ends = [end for _, end in recording.dwells()]
    return max(1, int(estimates.stamp.searchsorted(ends[-1]))) if ends else len(estimates)


def _within(value: float, deviation: float, decimals: int) -> str:
    """Write a value and its deviation with as many decimals, or more where that is smaller yet."""
    if 0.0 < deviation < 10.0**-decimals:
        decimals = 1 - math.floor(math.log10(deviation))
    return f"{value:.{decimals}f} ± {deviation:.{decimals}f}"


def _conclusion(estimates: TissueEstimates) -> str:
    """Say what is known at the end, and what looks like a mistake in the data."""
    from tissue_probe.signals import Status

    stiffness, damping = estimates.stiffness[-1], estimates.damping[-1]
    stiffness_sd = estimates.stiffness_variance[-1] ** 0.5
    damping_sd = estimates.damping_variance[-1] ** 0.5
    told = (
        f"At the end of contact: stiffness {_within(stiffness, stiffness_sd, 2)} N/m, damping "
        f"{_within(damping, damping_sd, 3)} N s/m, {Status(estimates.status[-1]).name.lower()}"
    )
    if stiffness + 3.0 * stiffness_sd < -10.0:
        told += "\nA negative stiffness: is the force positive in tension? See --force-polarity."
    return told
