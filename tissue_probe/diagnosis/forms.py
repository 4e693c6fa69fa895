"""Which forms of an effect differ under a measured motion: what is one is searched once.

What belongs here: comparing forms of one effect. What does not: fitting them (``candidates``).
"""

from __future__ import annotations

import numpy as np

from tissue_probe.diagnosis.fit import Fit, Problem
from tissue_probe.diagnosis.measurement import Instrument
from tissue_probe.diagnosis.starts import begin_states, start_values
from tissue_probe.physics.effects import Effect
from tissue_probe.physics.rigs import admits
from tissue_probe.signals import FloatArray

#: Forms are one where, as strong as usual, they never differ by more than this share of the noise.
ONE = 1e-6
#: Two that were fitted leave the same where they differ by less than this share of the noise, rms.
UNSEEN = 0.01


def forms_apart(base: Fit, effect: Effect, instrument: Instrument) -> list[Effect]:
    """Return the forms of an effect that a rig has, without those that are one under its motion.

    Such as forms that differ in what happens where the tip comes off, while it never does. They are
    compared at the effect's usual strength, beside a fitted model.
    """
    forms = [form for form in effect.every_form if admits(base.composition.rig, form)]
    apart: list[tuple[Effect, FloatArray]] = []
    for form in forms if len(forms) > 1 else ():
        residual = _usual(base, form, instrument)
        if not any(np.max(np.abs(residual - other)) < ONE * base.noise for _, other in apart):
            apart.append((form, residual))
    return [form for form, _ in apart] if apart else forms


def _usual(base: Fit, form: Effect, instrument: Instrument) -> FloatArray:
    """Return the residuals beside a fitted model with a form of an effect as strong as usual."""
    problem = Problem(base.composition.plus(form), base.measurements, instrument)
    usual = {parameter.name: parameter.default for parameter in form.parameters}
    values = start_values(problem, base.named(), form, usual)
    with np.errstate(all="ignore"):  # one that diverges is told from every other
        simulated = problem.simulate(values, begin_states(problem, base, values))
    return np.concatenate([residual for residual, _ in simulated])


def leave_the_same(fit: Fit, other: Fit) -> bool:
    """Whether two forms of an effect leave the same, as far as noise would let it be seen."""
    pairs = zip(fit.residuals, other.residuals, strict=True)
    difference = np.concatenate([one - another for one, another in pairs])
    return float(np.sqrt(np.mean(difference**2))) < UNSEEN * fit.noise
