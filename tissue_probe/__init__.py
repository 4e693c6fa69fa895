"""tissue_probe: stiffness and damping of soft tissue from a vibrating palpation probe.

    import tissue_probe as tp
    recording = tp.read("data.csv", force_polarity="tension")
    diagnosis = tp.diagnose(recording, starts="at-rest", validate="second.csv")

Each name is imported when it is first used: ``import tissue_probe`` takes no time.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tissue_probe.analysis.catalogue import effects as effects
    from tissue_probe.analysis.catalogue import estimators as estimators
    from tissue_probe.analysis.challenges import make_challenge as make_challenge
    from tissue_probe.analysis.comparing import compare as compare
    from tissue_probe.analysis.contact_export import design_admittance as design_admittance
    from tissue_probe.analysis.contact_export import mujoco_contact as mujoco_contact
    from tissue_probe.analysis.contacting import identify_contact as identify_contact
    from tissue_probe.analysis.diagnosing import diagnose as diagnose
    from tissue_probe.analysis.diagnosing import improve as improve
    from tissue_probe.analysis.estimating import estimate as estimate
    from tissue_probe.analysis.joint_export import mujoco_joint as mujoco_joint
    from tissue_probe.analysis.mapping import map_sites as map
    from tissue_probe.analysis.measurements import Measurements as Measurements
    from tissue_probe.analysis.measurements import read as read
    from tissue_probe.analysis.modulus import modulus as modulus
    from tissue_probe.analysis.previewing import preview as preview
    from tissue_probe.analysis.promising import promises as promises
    from tissue_probe.analysis.sensing import identify_sensor as identify_sensor
    from tissue_probe.analysis.simulating import simulate as simulate
    from tissue_probe.errors import TissueProbeError as TissueProbeError
    from tissue_probe.physics.model_file import load as load_model
    from tissue_probe.studies.row import row as row
    from tissue_probe.studies.running import study as study

__version__ = "0.2.0"

#: Where each public name is found.
_PLACES = {
    "Measurements": "tissue_probe.analysis.measurements:Measurements",
    "TissueProbeError": "tissue_probe.errors:TissueProbeError",
    "compare": "tissue_probe.analysis.comparing:compare",
    "design_admittance": "tissue_probe.analysis.contact_export:design_admittance",
    "diagnose": "tissue_probe.analysis.diagnosing:diagnose",
    "effects": "tissue_probe.analysis.catalogue:effects",
    "estimate": "tissue_probe.analysis.estimating:estimate",
    "estimators": "tissue_probe.analysis.catalogue:estimators",
    "identify_contact": "tissue_probe.analysis.contacting:identify_contact",
    "identify_sensor": "tissue_probe.analysis.sensing:identify_sensor",
    "improve": "tissue_probe.analysis.diagnosing:improve",
    "load_model": "tissue_probe.physics.model_file:load",
    "make_challenge": "tissue_probe.analysis.challenges:make_challenge",
    "map": "tissue_probe.analysis.mapping:map_sites",
    "modulus": "tissue_probe.analysis.modulus:modulus",
    "mujoco_contact": "tissue_probe.analysis.contact_export:mujoco_contact",
    "mujoco_joint": "tissue_probe.analysis.joint_export:mujoco_joint",
    "preview": "tissue_probe.analysis.previewing:preview",
    "promises": "tissue_probe.analysis.promising:promises",
    "read": "tissue_probe.analysis.measurements:read",
    "row": "tissue_probe.studies.row:row",
    "simulate": "tissue_probe.analysis.simulating:simulate",
    "study": "tissue_probe.studies.running:study",
}

__all__ = [
    "Measurements",
    "TissueProbeError",
    "__version__",
    "compare",
    "design_admittance",
    "diagnose",
    "effects",
    "estimate",
    "estimators",
    "identify_contact",
    "identify_sensor",
    "improve",
    "load_model",
    "make_challenge",
    "map",
    "modulus",
    "mujoco_contact",
    "mujoco_joint",
    "preview",
    "promises",
    "read",
    "row",
    "simulate",
    "study",
]


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, _, attribute = _PLACES[name].partition(":")
    found = getattr(import_module(module), attribute)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *_PLACES})
