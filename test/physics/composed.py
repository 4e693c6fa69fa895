"""Every effect in every form, in a composed model, and motions of the coil to try them on."""

import numpy as np

from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.response import Course, course, respond

PERIOD = 5e-4
FORMS = {
    name if number == 0 else f"{name}_{number}": form
    for name, effect in EFFECTS.items()
    for number, form in enumerate(effect.every_form)
}
BASE = Composition()


def values_of(composition: Composition, **changes: float) -> np.ndarray:
    """The default values, in the kernel's order."""
    known = {entry.name: entry.default for entry in composition.values}
    assert set(changes) <= set(known)
    return np.array(list((known | changes).values()))


def force_of(composition, values, position, period=PERIOD, start=None):
    """Force and sensitivities, from rest at 0 where no start is given."""
    kernel = composition.kernel
    start = np.zeros(len(kernel.states)) if start is None else start
    return respond(kernel, values, start, course(kernel, position, period, values))


def risen(times, duration):
    """From 0 to 1 in a time, with a third derivative that begins at 0."""
    s = np.clip(times / duration, 0.0, 1.0)
    return s**4 * (35 - 84 * s + 70 * s**2 - 20 * s**3)


def pressing(times):
    """Deeper and deeper into the tissue, to 2 mm."""
    return 2e-3 * risen(times, times[-1])


def vibrating(times):
    """Two sines of 10 and 33 Hz about the surface, begun gently."""
    sines = 1e-3 * np.sin(62.8 * times) + 5e-4 * np.sin(207.3 * times)
    return risen(times, 0.15) * sines


def halved(coil: Course) -> Course:
    """The same course in steps of half the length."""

    def split(pieces):
        c3, c2, c1, c0 = pieces
        h = coil.sample_period / 2
        later = [c3, c2 + 3 * h * c3, c1 + 2 * h * c2 + 3 * h**2 * c3,
                 c0 + h * c1 + h**2 * c2 + h**3 * c3]  # fmt: skip
        return np.ascontiguousarray(np.stack([pieces, later], axis=-1).reshape(4, -1))

    changes = (
        np.stack([split(change) for change in coil.changes])
        if len(coil.changes)
        else (np.zeros((0, 4, 2 * coil.pieces.shape[1])))
    )
    return Course(split(coil.pieces), coil.sample_period / 2, changes, coil.columns)
