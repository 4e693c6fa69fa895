"""The question to a diagnosis, and its answer: plain values, to pass between processes.

Contents: question and answer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_probe.monitoring.tested_model import TestedModel
from tissue_probe.physics.rigs.constants import CONTACT_POSITION
from tissue_probe.signals import FloatArray, SampleBlock


@dataclass(frozen=True)
class MonitorQuestion:
    """Samples, and the model that is asked about.

    Attributes
    ----------
    position, force : array, shape (n,)
        Displacement of the coil [m], force [N].
    sample_period : float
        Time between two samples [s].
    rig, model : str
        The rig's name; the model file, empty for Kelvin-Voigt tissue.
    effects : tuple of str
        Python files with effects that the model file needs.
    constants : dict
        Value and standard deviation of the rig's constants, and of the place of the touch (SI).
    """

    position: FloatArray
    force: FloatArray
    sample_period: float
    rig: str
    model: str
    effects: tuple[str, ...]
    constants: dict[str, tuple[float, float]]


@dataclass(frozen=True)
class MonitorAnswer:
    """The answer.

    Attributes
    ----------
    verdict : str
        ``adequate``, ``missing``, ``ambiguous`` or ``unexplained``.
    effects : tuple of (str, float)
        Effects that may be missing, with their probabilities, the most probable first.
    error_current, error_proposed : float
        Residual over noise of the model asked about, and of the proposed one.
    unseen : tuple of str
        Effects that these samples could not have shown.
    experiment : str
        The recording that would tell more; empty if none.
    text : str
        The verdict in sentences.
    proposed_model : str
        Content of a model file.
    """

    verdict: str
    effects: tuple[tuple[str, float], ...]
    error_current: float
    error_proposed: float
    unseen: tuple[str, ...]
    experiment: str
    text: str
    proposed_model: str


def question(
    model: TestedModel, block: SampleBlock, file: str = "", effects: tuple[str, ...] = ()
) -> MonitorQuestion:
    """Ask which effect a model misses on samples, which are finite.

    The tip may touch anywhere, as in the test: about the lower end of its travel, as far as that is
    long.
    """
    return MonitorQuestion(
        block.position,
        block.force,
        block.sample_period,
        model.composition.rig.name,
        file,
        effects,
        touch_anywhere(model, block.position),
    )


def touch_anywhere(model: TestedModel, position: FloatArray) -> dict[str, tuple[float, float]]:
    """Return a rig's constants, with a touch that may be anywhere about the travel's lower end."""
    constants = {
        name: given for name, given in model.instrument.constants.items() if np.isfinite(given[1])
    }
    constants[CONTACT_POSITION.name] = float(np.min(position)), float(np.ptp(position))
    return constants
