"""``tissue_probe estimate``: a filter on a recording or any file of samples, off line."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from tissue_probe.cli import measurement_options
from tissue_probe.cli.arguments import EffectFiles, Table
from tissue_probe.cli.groups import add_groups
from tissue_probe.cli.options_named import with_options


@add_groups
def estimate(
    samples: measurement_options.Samples,
    signals: measurement_options.Signals,
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
    rig: measurement_options.FilteredRigOption = None,
    restart_at_site: Annotated[
        bool | None,
        typer.Option(
            help="Forget the tissue where a dwell at a site begins.  "
            "[default: as recorded, else yes]",
            show_default=False,
        ),
    ] = None,
    site: measurement_options.Site = None,
) -> None:
    """Estimate stiffness and damping after every sample.

    On a recording the result is, bit for bit, that of the live node. The table has the
    columns time [s], stiffness [N/m], damping [N s/m], their variances, covariance_trace,
    innovation [N], normalized_innovation_squared and status. Time counts from the first sample of
    a recording, or from a table's own zero.
    """
    from tissue_probe.analysis.estimating import estimate as run

    if output.exists() and output.samefile(samples):
        raise ValueError(f"{output} holds the samples and would be replaced: give another --output")
    layout = signals.layout()
    result = run(
        measurement_options.read([samples], layout),
        estimator,
        settings=_changes(settings or []),
        model=model,
        effects=effects or [],
        rig=rig,
        restart_at_site=restart_at_site,
        site=site,
    )
    measurement_options.tell(result.notes)
    result.save(output)
    print(f"{estimator}: {len(result.estimates)} samples written to {output}")
    print(with_options(result.text))
    if result.is_doubtful:
        print(f"Why, tells: tissue_probe diagnose {samples}, with the same options.")


def _changes(texts: Sequence[str]) -> dict[str, str]:
    """Return settings by name, of NAME=VALUE each."""
    found = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals:
            raise ValueError(f"--set {text}: write NAME=VALUE, such as force_noise=0.01")
        found[name.strip()] = value.strip()
    return found
