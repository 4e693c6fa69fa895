"""The variables of a missing force, in words.

Contents: sentences.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from tissue_probe.quantities import engineering

if TYPE_CHECKING:
    from tissue_probe.diagnosis.shape.shape_report import FoundShape

#: How each variable is called in a sentence.
VARIABLE_NAMES = {
    "indentation": "the indentation",
    "velocity": "the velocity",
    "past": "the past of the indentation",
    "path": "the path",
    "force": "the force in its channel",
    "clock": "the time",
}
#: How each is called that adds nothing.
ADDS = {
    "indentation": "the indentation",
    "velocity": "the velocity",
    "past": "memory",
    "path": "the path",
    "force": "the force channel",
    "clock": "the time",
}
#: Share below which a variable adds nothing.
NOTHING_ADDED = 0.01


def describe_shape(found: FoundShape | None) -> list[str]:
    """Name the variables of the missing force, and other sets; nothing where none was learnt."""
    if found is None or not found.variables:
        return []
    said = f"{100 * found.share:.0f} % of the missing force is a function of "
    said += _join_names([VARIABLE_NAMES[name] for name in found.variables]) + _others(found)
    sentences = [said + "."]
    if not found.accepted:
        return [*sentences, f"{_refused(found)}: no shape is claimed."]
    if found.rivals:
        others = "; or ".join(
            _join_names([VARIABLE_NAMES[n] for n in each]) for each in found.rivals[:3]
        )
        sentences.append(
            f"This motion cannot tell that from a function of {others}: record another, such as "
            "a multisine."
        )
    if found.told:
        sentences.append(_formula(found))
    return sentences


def _refused(found: FoundShape) -> str:
    """Say why a shape is not claimed."""
    if not found.learnt.choice.accepted:
        return "More is missing than that"
    if found.as_effect is None:
        return "No effect can be made of such a function, so that it cannot be tried in the model"
    if not found.as_effect.leaves_noise:
        return f"Fitted as an effect of the model it leaves {found.ratio:.2f} times the noise"
    return "Fitted as an effect of the model it does not carry over to the second recording"


def _join_names(names: Sequence[str]) -> str:
    if len(names) == 1:
        return names[0]
    return f"{', '.join(names[:-1])} and {names[-1]} together"


def _others(found: FoundShape) -> str:
    """Name the variables that add nothing."""
    none = [
        ADDS[name]
        for name, share in found.shares.items()
        if name not in found.variables and share.beyond < NOTHING_ADDED
    ]
    if not none:
        return ""
    listed = none[0] if len(none) == 1 else f"{', '.join(none[:-1])} and {none[-1]}"
    return f"; {listed} {'adds' if len(none) == 1 else 'add'} nothing"


def _formula(found: FoundShape) -> str:
    if found.formula is None:
        return "No simple formula explains it as well as a free function."
    constants = ", ".join(
        f"{each.name} = {engineering(each.value, each.unit)}"
        if each.unit in ("N", "m", "m/s")
        else f"{each.name} = {each.value:.4g} {'' if each.unit == '1' else each.unit}".rstrip()
        for each in found.formula.constants
    )
    said = f"A formula that explains as much: {found.formula.text}, {constants}"
    if found.formula.rivals:
        return f"{said}; others within the noise: {', '.join(found.formula.rivals)}."
    return f"{said}."
