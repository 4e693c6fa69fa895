"""Waves of the world about, such as hum: which of them samples can show.

Contents: the fastest that a record tells from slow motion, and the largest that its force allows.

Near half of the sampling rate, and beyond, a wave is read as a slow one: of any drift or relaxation
a large enough hum makes a part.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.observation.measurement import Measurement

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect

#: Share of the sampling rate up to which a wave is told: two and a half samples a period.
HIGHEST_WAVE = 0.4


def fastest_shown(measurements: Sequence[Measurement]) -> float:
    """Return the highest frequency that the slowest of some recordings shows [Hz]."""
    return HIGHEST_WAVE / max(each.sample_period for each in measurements)


def slowest_wave(effect: Effect) -> float:
    """Return the lowest frequency at which an effect is sought [Hz]; 0 where it has none."""
    return min((each.lower for each in effect.parameters if each.unit == "Hz"), default=0.0)


def is_no_fold(fit: Fit, effect: Effect) -> bool:
    """Whether a wave that was added is slow enough to be seen, and no larger than the force."""
    if not effect.absolute:
        return True
    values = fit.named()
    size = np.hypot.reduce([values[each.name] for each in effect.parameters[: effect.strengths]])
    fastest = max(values[each.name] for each in effect.parameters if each.unit == "Hz")
    largest = max(float(np.ptp(each.force[each.used])) for each in fit.measurements) / 2.0
    return bool(size <= largest and fastest <= fastest_shown(fit.measurements))
