"""An effect of the library by its place in it: name, form, size and odds.

Contents: telling the place, and finding the effect again.
"""

from __future__ import annotations

from dataclasses import replace

from tissue_probe.physics.effect_scale import resize_effect
from tissue_probe.physics.effects import EFFECTS, Effect
from tissue_probe.physics.scale import Scale

Place = tuple[str, int | None, Scale, float]
"""Name; which form, None for an effect with all of its forms; size; odds."""


def find_in_library(effect: Effect) -> Place | None:
    """Return where the package's library has an effect; None where it has not."""
    known = EFFECTS.get(effect.name)
    if known is None:
        return None
    written = (effect.origin or effect).with_odds(known.odds)
    if written == known:
        # One without other forms is the same as its only form.
        return effect.name, None, effect.scale, effect.odds
    forms = known.every_form
    if written not in forms:
        return None
    return effect.name, forms.index(written), effect.scale, effect.odds


def of_library(name: str, form: int | None, scale: Scale, odds: float) -> Effect:
    """Return the effect at a place of the library."""
    known = EFFECTS[name]
    found = resize_effect(known if form is None else known.every_form[form], scale)
    return found if found.odds == odds else replace(found.with_odds(odds))
