"""A filter on measurements, off line: the estimates that the live node would have published."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tissue_probe import arguments as take
from tissue_probe.analysis.choices import FILTERED_RIGS, FilteredRig
from tissue_probe.analysis.measurements import ReadRecording, Source, measurements_of
from tissue_probe.analysis.recorded_facts import (
    estimate_as_recorded,
    estimator_settings,
    models_in_force,
    restarts_at_sites,
)
from tissue_probe.analysis.segments import check_enough
from tissue_probe.diagnosis.inspection.inspection import inspect
from tissue_probe.errors import MeasurementError, ParameterError
from tissue_probe.estimation import EstimatorSettings
from tissue_probe.likeness import Alike
from tissue_probe.physics.rigs import RIGS
from tissue_probe.recording.clocks.stretches import dwell_blocks
from tissue_probe.recording.writing.tables import estimate_columns, write_estimates
from tissue_probe.signals import EstimatorModel, Status, TissueEstimates

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

#: Findings that are told of a recording of this suite too: its driver checks all others.
TOLD_OF_OWN = ("wrong_polarity", "suspicious_units")
#: Stiffness of no soft tissue [N/m]: a unit is in doubt.
STIFFEST_ESTIMATE = 1e5
#: A tissue pushes back: an estimate is negative by so much, and by three standard deviations, where
#: the force has the wrong sign [N/m].
PULLING = -10.0
#: The paper's tip is none of a testing machine or a robot, whose motions are slow.
NO_MASS = (
    "the tip is taken to have no mass, as `settings` tells none: a mass m that moves beyond the "
    "load cell makes the stiffness too small by m (2 pi f)^2 at a frequency f; state tip_mass"
)


@dataclass(frozen=True, eq=False, repr=False)
class EstimateResult(Alike):
    """Stiffness and damping after every sample.

    Attributes
    ----------
    estimates : TissueEstimates
        One a sample.
    measured : ReadRecording
        The recording that the filter ran on.
    notes : tuple of str
        How the samples were read, and their faults, in sentences.
    model : str
        Model file whose effects the filter took; empty for Kelvin-Voigt tissue.
    """

    estimates: TissueEstimates
    measured: ReadRecording
    notes: tuple[str, ...]
    model: str = ""

    @property
    def last(self) -> TissueEstimates:
        """The estimates up to the end of the last contact."""
        ends = [end for _, end in self.measured.recording.dwells()]
        if not ends:
            return self.estimates
        return self.estimates[: max(1, int(self.estimates.stamp.searchsorted(ends[-1])))]

    @property
    def stiffness(self) -> float:
        """Stiffness k at the end of contact [N/m]."""
        return float(self.last.stiffness[-1])

    @property
    def stiffness_deviation(self) -> float:
        """Standard deviation of its error [N/m]."""
        return math.sqrt(self.last.stiffness_variance[-1])

    @property
    def damping(self) -> float:
        """Damping beta at the end of contact [N s/m]."""
        return float(self.last.damping[-1])

    @property
    def damping_deviation(self) -> float:
        """Standard deviation of its error [N s/m].

        Where position and force may be apart in time, the stiffness times that poses as damping.
        """
        apart = self.measured.recording.time_doubt
        return math.hypot(math.sqrt(self.last.damping_variance[-1]), apart * self.stiffness)

    @property
    def status(self) -> Status:
        """The status of the estimate at the end of contact."""
        return Status(self.last.status[-1])

    @property
    def text(self) -> str:
        """The estimate at the end of contact in words, and likely mistakes."""
        stiffness = _within(self.stiffness, self.stiffness_deviation, 2)
        damping = _within(self.damping, self.damping_deviation, 3)
        told = (
            f"At the end of contact: stiffness {stiffness} N/m, damping {damping} N s/m, "
            f"{self.status.name.lower()}"
        )
        if self.stiffness + 3.0 * self.stiffness_deviation < PULLING:
            told += (
                "\nA negative stiffness: is the force positive in tension? See `force_polarity`."
            )
        return told

    @property
    def is_doubtful(self) -> bool:
        """Whether ``diagnose`` on the same samples would tell more."""
        doubtful = (Status.MODEL_REJECTED, Status.NO_CONTACT)
        return self.status in doubtful or self.stiffness > STIFFEST_ESTIMATE

    def __repr__(self) -> str:
        count = len(self.estimates)
        return f"{self.estimates.estimator}: {count} samples of {self.measured.name}\n{self.text}"

    def to_frame(self) -> pd.DataFrame:
        """Return the estimates as a pandas data frame, with the columns that ``save`` writes."""
        import pandas as pd

        return pd.DataFrame(estimate_columns(self.estimates, self.measured.origin))

    def to_dict(self) -> dict[str, Any]:
        """Return the estimate at the end of contact, in SI units."""
        return {
            "estimator": self.estimates.estimator,
            "stiffness": self.stiffness,
            "stiffness_deviation": self.stiffness_deviation,
            "damping": self.damping,
            "damping_deviation": self.damping_deviation,
            "status": self.status.name.lower(),
        }

    def plot(self) -> Figure:
        """Draw force, estimates and innovation over time."""
        from tissue_probe.figures.estimates import draw_estimates

        return draw_estimates(self.measured.recording, [self.estimates], None)

    @take.checks(path=take.path)
    def save(self, path: str | Path) -> None:
        """Write the estimates as a table, ``.csv`` or ``.parquet``."""
        write_estimates(path, self.estimates, self.measured.origin)


@take.checks(
    estimator=take.text,
    settings=take.optional(take.by_name(lambda name, given: given, "values")),
    model=take.optional(take.path),
    effects=take.several(take.path, "paths"),
    rig=take.optional(take.choice(*FILTERED_RIGS)),
    restart_at_site=take.optional(take.flag),
    site=take.optional(take.whole()),
)
def estimate(
    measured: Source,
    estimator: str = "ekf",
    *,
    settings: Mapping[str, object] | None = None,
    model: str | Path | None = None,
    effects: Sequence[str | Path] = (),
    rig: FilteredRig | None = None,
    restart_at_site: bool | None = None,
    site: int | None = None,
) -> EstimateResult:
    """Estimate stiffness and damping after every sample.

    On a recording of this suite the result is, bit for bit, that of the live node.

    Parameters
    ----------
    measured : Measurements, path, data frame or mapping of arrays
        One recording.
    estimator : str
        See ``estimators``.
    settings : mapping, optional
        Settings of the filter by name; by default as recorded, else the paper's probe.
    model : path, optional
        Model file whose tool and effects a Kalman filter takes; by default those that the recording
        has, each from its sample on.
    effects : sequence of path
        Python files with effects of the user's own that the model needs; they are run.
    rig : FilteredRig, optional
        How the instrument couples to the tissue; by default as recorded, else this suite's own
        probe. A known force that drives no filter takes: ``compare`` does.
    restart_at_site : bool, optional
        Whether the tissue is forgotten where a dwell begins; by default as recorded, else yes.
    site : int, optional
        Only the dwells at this site of a scan.

    Raises
    ------
    TissueProbeError
        If something cannot be read, there is no such filter or setting, or estimates would be
        worthless.
    """
    parts = measurements_of(measured).parts
    if len(parts) != 1:
        raise ParameterError(f"{len(parts)} recordings are given: a filter runs on one at a time")
    (part,) = parts
    recording = part.recording
    if site is not None:
        recording = replace(recording, blocks=dwell_blocks(recording, site))
        begins = recording.blocks[0].stamp if part.origin else 0
        part = replace(part, recording=recording, origin=begins)
    notes = (*part.notes, *_doubts(part))
    stated = {"model": str(model) if model else None, "rig": rig}
    changes = {**(settings or {}), **{name: each for name, each in stated.items() if each}}
    led = any(each.tip_is_position for each in RIGS.values() if each.name == changes.get("rig"))
    if led and "tip_mass" not in changes and not part.is_own:
        changes["tip_mass"] = 0.0
        notes = (*notes, NO_MASS)
    chosen = estimator_settings(recording, estimator, changes, tuple(map(Path, effects)))
    own_model = "model" in changes
    models = [] if own_model else models_in_force(recording, estimator)
    if effects and not (chosen.model or any(each.file for each in models)):
        raise ParameterError(
            "`effects` is for effects that a model file needs: give `model`, or leave it out"
        )
    if restart_at_site is None:
        restart_at_site = restarts_at_sites(recording, estimator)
    found = estimate_as_recorded(
        recording, estimator, chosen, restart_at_site=restart_at_site, own_model=own_model
    )
    result = EstimateResult(found, part, notes, chosen.model)
    notes = (*notes, *_at_limits(result, chosen), *_of_other_code(part.name, found, models))
    return replace(result, notes=notes)


def _doubts(part: ReadRecording) -> Iterator[str]:
    """Yield the faults of the samples, as ``diagnose`` finds them.

    Raises
    ------
    MeasurementError
        If estimates from them would be worthless. A recording of this suite is estimated all the
        same: so were the live estimates, which are to come out again.
    """
    longest = max(part.recording.blocks, key=len)
    if not part.is_own:
        check_enough(part.name, len(longest))
    for found in inspect(longest.position, longest.force, longest.sample_period).findings:
        if found.fatal and not part.is_own:
            raise MeasurementError(f"{part.name}: {found.sentence}")
        if not part.is_own or found.name in TOLD_OF_OWN:
            yield f"{part.name}: {found.sentence}"


def _of_other_code(
    name: str, found: TissueEstimates, models: Sequence[EstimatorModel]
) -> Iterator[str]:
    """Yield a sentence for each recorded model that is another one here."""
    for model in models:
        if model.model not in found.model:
            yield (
                f"{name}: its estimates were made by the model {model.model}, which is another one "
                "here: its effects were defined by other files or another version"
            )


def _at_limits(result: EstimateResult, settings: EstimatorSettings) -> Iterator[str]:
    """Yield a sentence for each value that the settings hold back."""
    for name, unit in (("stiffness", "N/m"), ("damping", "N s/m")):
        for side in ("minimum", "maximum"):
            limit = getattr(settings, f"{name}_{side}")
            if getattr(result, name) == limit:
                yield (
                    f"the {name} ends at {limit:g} {unit}, where {name}_{side} holds it: if the "
                    "tissue may be so, state a wider one by `settings`, with the prior's standard "
                    f"deviation, {name}_prior_sd"
                )


def _within(value: float, deviation: float, decimals: int) -> str:
    """Write a value and its deviation with as many decimals, or more where that is smaller yet."""
    if 0.0 < deviation < 10.0**-decimals:
        decimals = 1 - math.floor(math.log10(deviation))
    return f"{value:.{decimals}f} ± {deviation:.{decimals}f}"
