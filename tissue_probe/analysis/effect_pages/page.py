"""The page of each effect, in Markdown with MathML, its picture, and the list of all pages."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from latex2mathml.converter import convert

from tissue_probe.analysis import fit_shown
from tissue_probe.analysis.comparing import compare
from tissue_probe.analysis.effect_pages.equations import equations
from tissue_probe.analysis.effect_pages.experiments import (
    NOISE,
    Outcome,
    best,
    outcomes,
    residual,
)
from tissue_probe.analysis.effect_pages.simulated_force import (
    PAGE_RATE,
    DriveMotion,
    force,
    rig_for,
    simulate_recording,
    typical,
)
from tissue_probe.analysis.symbols import letter
from tissue_probe.diagnosis.advice.separation import CALIBRATIONS, LED_CALIBRATIONS
from tissue_probe.errors import TissueProbeError
from tissue_probe.figures.effect_shown import ShownEffect, draw_effect
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import Effect, Parameter
from tissue_probe.physics.library import effects
from tissue_probe.physics.rigs import OWN
from tissue_probe.quantities import engineering

#: The motion of the pictures: slow enough to tell a spring from a damper by eye, and out of the
#: tissue for a part of each period.
DRAWN_MOTION = DriveMotion({"kind": "sine", "frequency": 5.0}, 0.8e-3, 2.0)
#: Other effects that a page names: more pass for one another than a reader can try.
RIVALS_NAMED = 5


def write_pages(folder: Path, library: Mapping[str, Effect]) -> None:
    """Write a page and a picture for each effect of a library, and ``index.md``.

    Parameters
    ----------
    folder : path
        Made if there is none.
    library : mapping of str to Effect
        Each is compared with all others, as ``physics.library.effects`` returns them.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name, told in outcomes(library).items():
        effect = library[name]
        draw_effect(_draw_effect(effect)).savefig(folder / f"{name}.png", dpi=80)
        lines = _page(effect, library, told)
        (folder / f"{name}.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (folder / "index.md").write_text("\n".join(_index(library)) + "\n", encoding="utf-8")


def _draw_effect(effect: Effect) -> ShownEffect:
    plain = Composition(rig_for(effect))
    added = plain.plus(effect.plain)
    return ShownEffect(
        DRAWN_MOTION.position,
        np.gradient(DRAWN_MOTION.position, 1.0 / PAGE_RATE),
        force(plain, typical(plain), DRAWN_MOTION),
        force(added, typical(added), DRAWN_MOTION),
        residual(effect, DRAWN_MOTION),
    )


def _page(effect: Effect, library: Mapping[str, Effect], told: Sequence[Outcome]) -> list[str]:
    return [
        f"# {effect.name}",
        f"{effect.physics}. Family: {effect.family}.",
        *_law(effect),
        *_values(effect),
        *_source(effect),
        *_picture(effect),
        *_how_it_shows(effect, best(told)),
        *_list_confused(effect, library, told),
        *_excitation(effect, told),
        *_python(effect),
    ]


def _law(effect: Effect) -> Iterator[str]:
    lines = equations(effect)
    yield "\n## Law\n"
    for line in lines:
        yield f'```{{raw}} html\n<p class="law">{convert(line, display="block")}</p>\n```'
    if not lines:
        yield "It has too many terms to be written here: see the source.\n"
    elsewhere = dict.fromkeys(form.physics for form in effect.forms)
    for physics in elsewhere:
        if physics != effect.physics:
            yield f"\nAnother form of it: {physics[:1].lower()}{physics[1:]}.\n"
    yield "\nk, β and m are stiffness, damping and mass of the tip, x its indentation.\n"


def _values(effect: Effect) -> Iterator[str]:
    yield "\n## Values\n"
    if not effect.parameters:
        yield "It has none: it is there, or it is not.\n"
        return
    yield "| value | letter | unit | typical | from | to |\n|---|---|---|---|---|---|"
    for each in effect.parameters:
        drawn = convert(letter(each.name))
        unit = "–" if each.unit == "1" else each.unit
        numbers = f"{each.default:g} | {each.lower:g} | {each.upper:g}"
        yield f"| `{each.name}` | {drawn} | {unit} | {numbers} |"
    if effect.says:
        meant = effect.told({each.name: each.default for each in effect.parameters})
        yield f"\nWith its typical values it means: {meant}."
    if effect.parameters[0].default != effect.neutral:
        yield f"\nAt `{effect.parameters[0].name}` = {effect.neutral:g} it is not there.\n"


def _source(effect: Effect) -> Iterator[str]:
    yield "\n## Assumptions and source\n"
    yield f"{effect.assumptions or 'None is stated'}.\n"
    yield f"Source: {effect.reference or 'none is stated'}.\n"


def _picture(effect: Effect) -> Iterator[str]:
    rig = rig_for(effect)
    yield "\n## Picture\n"
    yield f"![Force and residual over position and speed]({effect.name}.png)\n"
    yield (
        f"Simulated on the rig `{rig}` with typical values ({DRAWN_MOTION}). Below: the residual "
        "of the plain model, with the values that come nearest.\n"
    )


def _how_it_shows(effect: Effect, told: Outcome) -> Iterator[str]:
    yield "\n## How it shows\n"
    if not told.shows:
        yield "It does not show by itself: values of the plain model change in its place.\n"
        return
    rig, motion = rig_for(effect), told.motion
    model = Composition(rig).plus(effect.plain)
    measured = simulate_recording(model, typical(model), motion, NOISE)
    yield f"In a simulated recording ({motion}; white noise of {engineering(NOISE, 'N')})"
    try:
        fit = compare(measured, rig=rig, starts="at-rest", workers=1).fit
    except TissueProbeError as error:
        yield f"`compare` refuses the samples: {error}\n"
        return
    yield (
        f"the plain model leaves {fit.output.tell(fit.rmse)}, "
        f"{fit.rmse / fit.noise:.3g} times the noise."
    )
    failed = [each for each in fit_shown.tests(fit, fit.worst) if not each.passed]
    if failed:
        yield "Tests of its residual that fail:\n"
        yield from (f"- {each.name}: {each.finding}" for each in failed)
    if here := fit_shown.where(fit, fit.worst).here:
        yield f"\nThe residual stands out at {here.describe()}.\n"


def _list_confused(
    effect: Effect, library: Mapping[str, Effect], told: Sequence[Outcome]
) -> Iterator[str]:
    yield "\n## Easily confused with\n"
    shown = [each for each in told if each.shows]
    passing = [name for each in shown for name in each.passing]
    often = sorted(dict.fromkeys(passing), key=lambda name: -passing.count(name))[:RIVALS_NAMED]
    if often:
        yield (
            "These can take its place: they explain 90 % and more of the square of its residual.\n"
        )
    for name in often:
        yield f"- {_link(name)}: in {passing.count(name)} of {len(shown)} experiments that show it"
    if not often:
        told_apart = "At its typical strength no other effect explains 90 % of it.\n"
        yield told_apart if shown else "Other values of the plain model: see below.\n"
    library = {name: each for name, each in library.items() if name != effect.name}
    related = {
        "Of the same family": [n for n, each in library.items() if each.family == effect.family],
        "It contains": [n for n in effect.simpler if n in library],
        "It is contained in": [n for n, each in library.items() if effect.name in each.simpler],
    }
    if any(related.values()):
        yield "\nWhere the effect is faint, its relatives explain a recording nearly as well.\n"
    for relation, names in related.items():
        if names:
            yield f"- {relation}: {', '.join(map(_link, names))}"


def _excitation(effect: Effect, told: Sequence[Outcome]) -> Iterator[str]:
    yield "\n## Which excitation tells it\n"
    rig = rig_for(effect)
    calibration = (LED_CALIBRATIONS if rig.tip_is_position else CALIBRATIONS).get(effect.name)
    chosen = best(told)
    if chosen.shows:
        yield (
            f"Best of the experiments that `diagnose` suggests: **{chosen.motion}**. With typical "
            "values, the rms residual of the plain model, and of the effect that comes nearest:\n"
        )
        yield "| experiment | plain model [mN] | nearest other effect [mN] | which |"
        yield "|---|---|---|---|"
        yield from (_row(each) for each in told)
        yield f"\nTo first order in all values; not seen: beside noise of {1e3 * NOISE:g} mN rms.\n"
    else:
        yield "None of the experiments that `diagnose` suggests shows it at its typical strength.\n"
    if effect.of_part:
        yield "It differs between parts of a run: a gap in the times of a recording shows it.\n"
    if calibration:
        yield f"A calibration tells it: {calibration}.\n"


def _row(told: Outcome) -> str:
    if not told.shows:
        return f"| {told.motion} | not seen | | |"
    nearest = _link(told.nearest) if told.nearest else ""
    return f"| {told.motion} | {1e3 * told.left:.3g} | {1e3 * told.nearest_left:.3g} | {nearest} |"


def _python(effect: Effect) -> Iterator[str]:
    yield "\n## In Python\n"
    yield "```python\nimport tissue_probe as tp\n"
    if effect.hears_input2:
        yield 'measured = tp.read("data.csv", force_polarity="compression", input2="pressure")'
    else:
        yield 'measured = tp.read("examples/sweep.csv", force_polarity="compression")'
    own = "" if effect.name in effects() else ', effects=["my_effect.py"]'
    yield f'plain = tp.compare(measured, rig="{OWN.name}", starts="at-rest"{own})'
    yield f'print(plain.plus("{effect.name}"))\n```'


def _index(library: Mapping[str, Effect]) -> Iterator[str]:
    yield "# Effects\n\nA page for each effect that a model may lack.\n"
    yield "| effect | family | it is | typical strength |\n|---|---|---|---|"
    for name, each in library.items():
        strength = "".join(_strength(entry) for entry in each.parameters[:1])
        physics = each.physics.replace("|", "&#124;")
        yield f"| {_link(name)} | {each.family} | {physics} | {strength} |"
    yield from _toctree(library)


def _strength(entry: Parameter) -> str:
    return f"{entry.default:g} {'' if entry.unit == '1' else entry.unit}".strip()


def _toctree(names: Iterable[str]) -> Iterator[str]:
    yield "\n```{toctree}\n:hidden:\n"
    yield from names
    yield "```"


def _link(name: str) -> str:
    return f"[{name}]({name}.md)"
