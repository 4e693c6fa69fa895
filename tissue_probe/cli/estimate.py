"""``tissue_probe estimate``: a filter on a recording or a CSV file, off line."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from tissue_probe.cli.arguments import Samples, Table, Topic


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
    from tissue_probe.signals import Status

    if output.exists() and output.samefile(samples):
        raise ValueError(f"{output} holds the samples and would be replaced: give another --output")
    columns = {"time": time, "position": position, "force": force}
    recording, origin = read_samples(samples, topic, columns, force_polarity.value)
    filter_settings = estimator_settings(recording, estimator, settings or [])
    if restart_at_site is None:
        restart_at_site = restarts_at_sites(recording, estimator)
    estimates = run_estimator(
        recording, estimator, filter_settings, restart_at_site=restart_at_site
    )
    write_estimates(output, estimates, origin)
    last = {name: getattr(estimates, name)[-1] for name in ("stiffness", "damping")}
    deviation = {name: getattr(estimates, f"{name}_variance")[-1] ** 0.5 for name in last}
    print(
        f"{estimator}: {len(estimates)} samples; at the end stiffness "
        f"{last['stiffness']:.2f} ± {deviation['stiffness']:.2f} N/m, damping "
        f"{last['damping']:.3f} ± {deviation['damping']:.3f} N s/m, "
        f"{Status(estimates.status[-1]).name.lower()}; written to {output}"
    )
