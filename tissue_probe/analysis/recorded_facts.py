"""Facts that a recording holds of its run: filters' settings, sites, phantom."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from types import MappingProxyType
from typing import Any

from pydantic import ValidationError

from tissue_probe import bounded_yaml
from tissue_probe.estimation import ESTIMATORS, EstimatorSettings
from tissue_probe.estimation.offline import estimate
from tissue_probe.mapping.fusion import MapBuilder
from tissue_probe.physics.felt_table import FeltTable
from tissue_probe.physics.phantom import Phantom
from tissue_probe.settings import SettingsError, build
from tissue_probe.signals import EstimatorModel, Recording, TissueEstimates


def node_parameters(recording: Recording, key: str, value: object) -> dict[str, Any]:
    """Return the parameters of the first recorded node whose ``key`` is ``value``, or nothing."""
    for parameters in recording.metadata.values():
        if key in parameters and metadata_value(parameters[key]) == value:
            return {name: metadata_value(text) for name, text in parameters.items()}
    return {}


def metadata_value(text: object) -> Any:
    """Return a text's value in YAML, or the text: metadata of other recorders may be any."""
    try:
        return bounded_yaml.parse(text) if isinstance(text, str) else text
    except bounded_yaml.YamlError:
        return text


def estimator_settings(
    recording: Recording,
    estimator: str,
    changes: Mapping[str, object],
    effect_files: Sequence[Path] = (),
) -> EstimatorSettings:
    """Return the settings an estimator had when recorded, else the defaults, with changes.

    Python files that a recording names are not among them: only the user says which code runs.

    Parameters
    ----------
    recording : Recording
        The recorded channels.
    estimator : str
        The estimator's name.
    changes : mapping
        Other values, by the settings' names.
    effect_files : sequence of path
        Python files with effects of the user's own.

    Raises
    ------
    SettingsError
        If there is no such estimator or setting, or a value is out of its range.
    """
    if estimator not in ESTIMATORS:
        raise SettingsError(
            f"there is no estimator {estimator!r}; there are {', '.join(ESTIMATORS)}"
        )
    recorded = node_parameters(recording, "estimator", estimator)
    values = {name: recorded[name] for name in EstimatorSettings.model_fields if name in recorded}
    if "effects" in changes:
        raise SettingsError("the setting effects is no number: name the Python file by `effects`")
    values |= changes
    values["effects"] = tuple(map(str, effect_files))
    return build(EstimatorSettings, values)


def restarts_at_sites(recording: Recording, estimator: str) -> bool:
    """Return whether the recorded estimator forgot the tissue at each site; yes if not known."""
    return bool(node_parameters(recording, "estimator", estimator).get("restart_at_site", True))


def estimate_again(
    recording: Recording,
    estimator: str,
    effect_files: Sequence[Path] = (),
    changes: Mapping[str, object] = MappingProxyType({}),
) -> TissueEstimates:
    """Run an estimator on a recording as it ran when recorded, one estimate a sample.

    ``effect_files`` are Python files with the effects of the user's own that its model needs,
    ``changes`` settings that are to be others than recorded.
    """
    return estimate_as_recorded(
        recording,
        estimator,
        estimator_settings(recording, estimator, changes, effect_files),
        restart_at_site=restarts_at_sites(recording, estimator),
        own_model="model" in changes,
    )


def estimate_as_recorded(
    recording: Recording,
    estimator: str,
    settings: EstimatorSettings,
    *,
    restart_at_site: bool,
    own_model: bool,
) -> TissueEstimates:
    """Run an estimator on a recording by the models that it had, each from its sample on.

    Models are read from the recording, which has the content of their files.

    Parameters
    ----------
    recording : Recording
        The recorded channels.
    estimator : str
        The estimator's name.
    settings : EstimatorSettings
        Its settings.
    restart_at_site : bool
        Whether the tissue is forgotten where a dwell at a site begins.
    own_model : bool
        Whether the model of ``settings`` is to hold throughout, in place of the recorded ones.

    Raises
    ------
    SettingsError
        If a model cannot be used.
    """
    models = [] if own_model else models_in_force(recording, estimator)
    with TemporaryDirectory() as folder:
        changes = [
            (model.stamp, _with_model(settings, model, Path(folder, f"{number}_model.yaml")))
            for number, model in enumerate(models)
        ]
        begun = changes.pop(0)[1] if changes else settings
        return estimate(
            recording, estimator, begun, restart_at_site=restart_at_site, changes=changes
        )


def models_in_force(recording: Recording, estimator: str) -> list[EstimatorModel]:
    """Return by which models an estimator ran, from the one at the first sample on.

    Of recordings of earlier versions there are none.
    """
    models = [model for model in recording.models if model.estimator == estimator]
    begin = recording.blocks[0].stamp
    before = sum(model.stamp <= begin for model in models)
    return models[max(before - 1, 0) :]


def _with_model(
    settings: EstimatorSettings, model: EstimatorModel, path: Path
) -> EstimatorSettings:
    """Return settings with a recorded model, whose content is written to a file."""
    if model.file:
        path.write_bytes(model.content.encode())
    return settings.model_copy(update={"model": str(path) if model.file else ""})


def gather_sites(recording: Recording, estimates: Sequence[TissueEstimates]) -> MapBuilder:
    """Gather estimates over the sites of a recording."""
    builder = MapBuilder()
    for site in recording.sites:
        builder.announce(site)
    for found in estimates:
        builder.add(found)
    return builder


def find_phantom(recording: Recording) -> Phantom | FeltTable | None:
    """Return the phantom of a simulated run; None where none is recorded that can be read."""
    for parameters in recording.metadata.values():
        description = metadata_value(metadata_value(parameters.get("device_description")))
        if isinstance(description, dict) and "phantom" in description:
            for kind in (Phantom, FeltTable):
                with suppress(ValidationError):
                    return kind.model_validate(description["phantom"])
    return None
