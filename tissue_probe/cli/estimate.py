"""``tissue_probe estimate``: a filter on a recording or any file of samples, off line."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from tissue_probe.signals import Recording, TissueEstimates

from tissue_probe.cli import measured
from tissue_probe.cli.arguments import EffectFiles, Table
from tissue_probe.cli.options_named import with_options

#: Findings that are told of a recording of this suite too: its driver checks all others.
TOLD_OF_OWN = ("wrong_polarity", "suspicious_units")
#: Stiffness of no soft tissue [N/m]: a unit is in doubt.
STIFFEST = 1e5


def estimate(
    samples: measured.Samples,
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
    position: measured.Position = None,
    force: measured.Force = None,
    time: measured.Time = None,
    sample_rate: measured.SampleRate = None,
    position_unit: measured.PositionUnit = None,
    force_unit: measured.ForceUnit = None,
    time_unit: measured.TimeUnit = None,
    force_polarity: measured.ForcePolarity = None,
    position_polarity: measured.PositionPolarity = measured.Direction.into,
    topic: measured.SamplesTopic = None,
    clock: measured.ClockOption = None,
    site: measured.Site = None,
) -> None:
    """Estimate stiffness and damping after every sample.

    On a recording the result is, bit for bit, what the live node published. The table has the
    columns time [s], stiffness [N/m], damping [N s/m], their variances, covariance_trace,
    innovation [N], normalized_innovation_squared and status. Time counts from the first sample of
    a recording, or from a table's own zero.
    """
    from tissue_probe.cli.recorded import estimator_settings, restarts_at_sites
    from tissue_probe.estimation.offline import estimate as run_estimator
    from tissue_probe.recording.any_file import is_own
    from tissue_probe.recording.open_bag import is_bag
    from tissue_probe.recording.stretches import dwell_blocks
    from tissue_probe.recording.tables import write_estimates

    if output.exists() and output.samefile(samples):
        raise ValueError(f"{output} holds the samples and would be replaced: give another --output")
    layout = measured.layout(
        position, force, time, sample_rate, position_unit, force_unit, time_unit,
        force_polarity, position_polarity, topic, clock,
    )  # fmt: skip
    recording, notes = measured.read(samples, layout)
    if site is not None:
        recording = replace(recording, blocks=dwell_blocks(recording, site))
    for note in (*notes, *_doubts(samples, recording, is_own(samples, layout))):
        print(f"note: {note}")
    changes = [*(settings or []), *([f"model={model}"] if model else [])]
    filter_settings = estimator_settings(recording, estimator, changes, effects or [])
    if restart_at_site is None:
        restart_at_site = restarts_at_sites(recording, estimator)
    estimates = run_estimator(
        recording, estimator, filter_settings, restart_at_site=restart_at_site
    )
    origin = recording.blocks[0].stamp if is_bag(samples) else 0
    write_estimates(output, estimates, origin)
    print(f"{estimator}: {len(estimates)} samples written to {output}")
    last = estimates[: _last_contact(recording, estimates)]
    print(_conclusion(last, recording.time_doubt, samples))


def _doubts(path: Path, recording: Recording, own: bool) -> Iterator[str]:
    """Yield what is wrong with the samples, as ``diagnose`` finds it.

    Raises
    ------
    ValueError
        If estimates from them would be worthless. A recording of this suite is estimated all the
        same: so were the live estimates, which are to come out again.
    """
    from tissue_probe.diagnosis.inspection.inspection import inspect

    longest = max(recording.blocks, key=len)
    for found in inspect(longest.position, longest.force, longest.sample_period).findings:
        if found.fatal and not own:
            raise ValueError(f"{path}: {found.sentence}")
        if not own or found.name in TOLD_OF_OWN:
            yield f"{path}: {with_options(found.sentence)}"


def _last_contact(recording: Recording, estimates: TissueEstimates) -> int:
    """Return how many estimates there are up to the end of the last dwell, or of the recording."""
    ends = [end for _, end in recording.dwells()]
    return max(1, int(estimates.stamp.searchsorted(ends[-1]))) if ends else len(estimates)


def _within(value: float, deviation: float, decimals: int) -> str:
    """Write a value and its deviation with as many decimals, or more where that is smaller yet."""
    if 0.0 < deviation < 10.0**-decimals:
        decimals = 1 - math.floor(math.log10(deviation))
    return f"{value:.{decimals}f} ± {deviation:.{decimals}f}"


def _conclusion(estimates: TissueEstimates, apart: float, path: Path) -> str:
    """Say what is known at the end, and what looks like a mistake in the data.

    Position and force may be ``apart`` in time [s]: the stiffness times that poses as damping.
    """
    from tissue_probe.signals import Status

    stiffness, damping = estimates.stiffness[-1], estimates.damping[-1]
    stiffness_sd = estimates.stiffness_variance[-1] ** 0.5
    damping_sd = math.hypot(estimates.damping_variance[-1] ** 0.5, apart * stiffness)
    status = Status(estimates.status[-1])
    told = (
        f"At the end of contact: stiffness {_within(stiffness, stiffness_sd, 2)} N/m, damping "
        f"{_within(damping, damping_sd, 3)} N s/m, {status.name.lower()}"
    )
    if stiffness + 3.0 * stiffness_sd < -10.0:
        told += "\nA negative stiffness: is the force positive in tension? See --force-polarity."
    if status in (Status.MODEL_REJECTED, Status.NO_CONTACT) or stiffness > STIFFEST:
        told += f"\nWhy, tells: tissue_probe diagnose {path}, with the same options."
    return told
