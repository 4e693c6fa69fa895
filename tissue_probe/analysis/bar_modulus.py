"""Modulus, stress and strain of a bar between grips or plates, from a fitted model.

Contents: of a bar only; a tip's modulus has a file of its own.
"""

from __future__ import annotations

import math
from dataclasses import replace

from tissue_probe.analysis.modulus_in_motion import add_motion, propagate_error
from tissue_probe.analysis.modulus_result import Modulus
from tissue_probe.errors import ParameterError
from tissue_probe.physics.bars import UniformBar
from tissue_probe.physics.complex_stiffness import TissueInSmallMotion
from tissue_probe.physics.fitted_model import FittedModel
from tissue_probe.physics.rigs.constants import CONTACT_POSITION

NO_DEVIATION = "The model has no standard deviation of its stiffness: no interval is told."


def find_bar_modulus(
    found: FittedModel, bar: UniformBar, depth: float | None, frequencies: tuple[float, ...]
) -> Modulus:
    """Return the modulus of a bar: the slope of stress over strain, after all relaxation.

    Parameters
    ----------
    found : FittedModel
        The model.
    bar : UniformBar
        Its length and area.
    depth : float, optional
        Extension or shortening at which a curved model has the slope [m].
    frequencies : tuple of float
        At which storage and loss are asked for [Hz].

    Raises
    ------
    ParameterError
        If the model is curved and no depth is stated, or has no storage and loss.
    """
    curved = found.composition.has_curved_spring
    if curved and depth is None:
        raise ParameterError(
            "`depth`: the spring of the model is curved, so that the modulus differs with the "
            "strain: give the extension or shortening at which you want it"
        )
    tissue, at = TissueInSmallMotion(found.composition), depth or 0.0
    value, fitted = propagate_error(found, lambda values: tissue.spring(values, at) / bar.slope)
    young = Modulus(
        value,
        math.hypot(fitted, bar.relative_deviation * value),
        at if curved else math.nan,
        (NO_DEVIATION,) if math.isnan(fitted) else (),
    )
    moving = add_motion(found, young, depth, frequencies, bar.relative_deviation)
    return _add_strain(found, tissue, bar, moving)


def _add_strain(
    found: FittedModel, tissue: TissueInSmallMotion, bar: UniformBar, young: Modulus
) -> Modulus:
    """Add the strain that the model was fitted to, its stress, and the meaning of both."""
    said = "Stress and strain are engineering ones, by area and length without load"
    data, rig = found.data, found.composition.rig
    if data is None or data.lowest is None or data.highest is None or rig.load_cell_yields:
        note = f"{said}; the modulus is that of a small strain about the mean."
        return replace(young, notes=(*young.notes, note))
    zero = found.values.get(CONTACT_POSITION.name, 0.0)
    low, high = data.lowest - zero, data.highest - zero
    strain = (low / bar.length, high / bar.length)
    stress = [tissue.force(found.values, each) / bar.area for each in (low, high)]
    largest = 100.0 * max(map(abs, strain))
    note = (
        f"{said}; the modulus is that of a small strain about the mean of {50.0 * sum(strain):.3g} "
        f"%. True stress differs by about as much as the strain, up to {largest:.2g} %."
    )
    return replace(young, strain=strain, stress=(stress[0], stress[1]), notes=(*young.notes, note))
