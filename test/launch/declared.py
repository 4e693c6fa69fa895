"""The parameters of every node, from its settings classes, without starting it."""

from __future__ import annotations

from pathlib import Path

from pydantic import BaseModel

from tissue_probe.devices.limits import Limits
from tissue_probe.devices.registry import DEVICES
from tissue_probe.estimation import ESTIMATORS, EstimatorSettings
from tissue_probe.monitoring.settings import MonitorSettings
from tissue_probe.nodes.adapter import AdapterSettings
from tissue_probe.nodes.driver import DriverSettings, ExcitationSettings
from tissue_probe.nodes.estimator import EstimatorNodeSettings
from tissue_probe.nodes.estimators import EstimatorsSettings
from tissue_probe.nodes.identify import IdentifySettings
from tissue_probe.nodes.mapper import MapperSettings
from tissue_probe.nodes.recorder import RecorderSettings
from tissue_probe.nodes.replay import ReplaySettings
from tissue_probe.nodes.scan import ScanSettings
from tissue_probe.nodes.sensor import SensorSettings
from tissue_probe.nodes.stage import StageSettings

ROOT = Path(__file__).parents[2]

#: What each node declares, by its name: (prefix, settings).
SETTINGS: dict[str, list[tuple[str, type[BaseModel]]]] = {
    "adapter": [("", AdapterSettings)],
    "driver": [
        ("", DriverSettings),
        ("limits.", Limits),
        ("excitation.", ExcitationSettings),
        *((f"{name}.", device.settings) for name, device in DEVICES.items()),
    ],
    "estimators": [("", EstimatorsSettings)],
    "identify": [("", IdentifySettings)],
    "mapper": [("", MapperSettings)],
    "monitor": [("", MonitorSettings)],
    "recorder": [("", RecorderSettings)],
    "replay": [("", ReplaySettings)],
    "scan": [("", ScanSettings)],
    "sensor": [("", SensorSettings)],
    "stage": [("", StageSettings)],
    **{name: [("", EstimatorNodeSettings), ("", EstimatorSettings)] for name in ESTIMATORS},
}


def parameters_of(node: str) -> dict[str, object]:
    """Return the defaults of all parameters of a node, by name."""
    return {
        prefix + name: field.get_default(call_default_factory=True)
        for prefix, settings in SETTINGS[node]
        for name, field in settings.model_fields.items()
    }
