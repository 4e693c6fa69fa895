"""The names that a kernel module has, for texts that become part of one: their types.

Nothing is here when the program runs: ``generate`` writes these functions and places. The texts
import the names for the type checker alone.
"""

from __future__ import annotations

from collections.abc import Callable

from tissue_probe.signals import FloatArray

# Places in ``constants`` (``layout``).
DRIVE_FREQUENCY: int
ENCODER_RESOLUTION: int
FORCE_VARIANCE: int
FORGETTING: int
LOAD_CELL_DAMPING: int
LOAD_CELL_STIFFNESS: int
LOWER: int
PRIOR: int
PRIOR_VARIANCE: int
SAMPLE_PERIOD: int
TIP_MASS: int
UPPER: int
# Places in ``memory``.
DAMPING: int
DIAGONAL: tuple[int, ...]
DISTURBED: int
MANY_OPENINGS: int
MEAN_NIS: int
OPENINGS: int
RECENT_NIS: int
RECENT_SQUARE: int
STIFFNESS: int
STIFFNESS_DAMPING: int
# Numbers.
FLOOR: float
LARGEST: float

# Functions; most of them work on ``constants`` and ``memory``.
cap: Callable[[FloatArray, FloatArray], None]
forget: Callable[[FloatArray, FloatArray], None]
has_recovered: Callable[[FloatArray], bool]
inflate: Callable[[FloatArray, FloatArray, float, float], None]
interrupt: Callable[[FloatArray], None]
judge_model: Callable[[FloatArray, FloatArray, float, float, float], None]
judge_noise: Callable[[FloatArray, float], None]
noise: Callable[[FloatArray, FloatArray], float]
output: Callable[[FloatArray, FloatArray], tuple[float, float]]
record: Callable[[FloatArray, FloatArray, FloatArray, int, float, float], None]
