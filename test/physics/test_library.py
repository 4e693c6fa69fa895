"""Effects of a user's own: found, checked, and refused in one sentence."""

import signal
import subprocess
import sys
from dataclasses import replace
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from tissue_probe.physics import library
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.library import EffectError, effects, load_effects

EXAMPLE = Path(__file__).parents[2] / "docs" / "my_effect.py"


def written(tmp_path, **changes: str) -> Path:
    """The example with some of its texts replaced."""
    text = EXAMPLE.read_text(encoding="utf-8")
    for old, new in changes.values():
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / "other_effect.py"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_example_is_twenty_lines_and_joins_the_library():
    assert len([line for line in EXAMPLE.read_text().splitlines() if line.strip()]) <= 20
    found = effects([EXAMPLE])
    assert set(found) - set(EFFECTS) == {"quadratic_drag"}
    model = Composition(effects=(found["quadratic_drag"],)).model
    assert "drag_coefficient" in map(str, model.parameters)
    assert not model.is_linear


def test_the_example_of_a_rubber_band_has_the_force_of_ideal_rubber():
    (band,) = load_effects(EXAMPLE.with_name("rubber_band.py"))
    stiffness, length = 7.0, 0.08
    strain = {"strain_per_metre": 1.0 / length, "flowing_stiffness": 0.0, "flow_rate": 0.1}
    for stretch in (1.0, 1.3, 2.0, 5.0):
        depth = length * (stretch - 1.0)
        values = {**strain, "indentation": depth, "stiffness": stiffness, "elastic_elongation": 0}
        force = stiffness * depth + band.force.subs(
            {each: values[each.name] for each in band.force.free_symbols}
        )
        expected = stiffness * length / 3.0 * (stretch - stretch**-2)
        assert float(force) == pytest.approx(expected, abs=1e-12)


def test_an_installed_package_offers_effects_by_entry_point(monkeypatch):
    point = EntryPoint("drag", "example:QUADRATIC_DRAG", library.GROUP)
    monkeypatch.setattr(EntryPoint, "load", lambda self: load_effects(EXAMPLE)[0])
    monkeypatch.setattr(library, "entry_points", lambda group: [point] * (group == library.GROUP))
    assert "quadratic_drag" in effects()
    monkeypatch.setattr(EntryPoint, "load", lambda self: 3)
    with pytest.raises(
        EffectError, match=r"entry point drag = example:QUADRATIC_DRAG is no Effect"
    ):
        effects()


MISTAKES = {
    "a name that is taken": (("quadratic_drag", "coulomb_friction"), "name of another effect"),
    "no name": (('"quadratic_drag"', '"quadratic drag"'), "letters, digits and underscores"),
    "a default out of bounds": (("lower=0.0", "lower=9.0"), "out of its bounds 9 to 10000"),
    "a parameter of another's name": (
        ('"drag_coefficient"', '"coulomb_force"'), "of the effect coulomb_friction: rename it"
    ),
    "a parameter of the model's name": (
        ('"drag_coefficient"', '"stiffness"'), "which is one of the model: rename it"
    ),
    "a symbol that nothing tells": (
        ("drag=DRAG", 'drag=sp.Symbol("viscosity")'), "uses the symbol viscosity"
    ),
    "an effect at no strength": (("drag=DRAG *", "drag=(1 + DRAG) *"), "must leave the model as"),
    "a function without machine code": (
        ("sp.Abs(TIP_VELOCITY)", "sp.besselj(0, TIP_VELOCITY)"),
        "effect 'quadratic_drag' cannot be composed: no machine code can be made of besselj",
    ),
    "a function without derivative": (
        ("sp.Abs(TIP_VELOCITY)", "sp.floor(TIP_VELOCITY)"), "of the derivative of floor"
    ),
    "a signal where it is not known": (
        ("* TIP_VELOCITY,", "* TIP_VELOCITY, inertia=DRAG * sp.Symbol('stretch', real=True),"),
        "nothing tells the symbol stretch",
    ),
    "starts for what is not there": (
        ("    drag=", '    starts=lambda extent: [{"width": 1.0}],\n    drag='), "starts for width"
    ),
    "a list for a tuple": (("drag=DRAG", "simpler=[], drag=DRAG"), "write tuples"),
    "no effect": (("QUADRATIC_DRAG =", "_HIDDEN ="), "defines no effect"),
    "no Python": (("drag=DRAG", "drag=)DRAG"), "cannot be run: SyntaxError"),
    "an import that fails": (("import sympy", "import nosuchmodule, sympy"), "nosuchmodule"),
    "an exit": (("import sympy", "exit(0)\nimport sympy"), "cannot be run: SystemExit: 0"),
    "what is no Exception": (
        ("import sympy", "raise GeneratorExit\nimport sympy"), "cannot be run: GeneratorExit"
    ),
    "starts that exit": (
        ("    drag=", "    starts=lambda extent: exit(0),\n    drag="), "cannot propose: SystemExit"
    ),
    "starts that are none": (
        ("    drag=", "    starts=lambda extent: [3],\n    drag="), "cannot propose: AttributeError"
    ),
    "bounds that are no numbers": (("upper=1e4", "upper=None"), "cannot be used: TypeError"),
    "a force that is a text": (("    drag=", "    force='k x',\n    drag="), "cannot be used: "),
    "forms that are none": (("    drag=", "    forms=(3,),\n    drag="), "cannot be used: "),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_in_a_file_is_told_in_one_sentence(mistake, tmp_path):
    change, told = MISTAKES[mistake]
    path = written(tmp_path, change=change)
    with pytest.raises(EffectError, match=told) as failure:
        effects([path])
    assert str(failure.value).startswith(str(path))
    assert "\n" not in str(failure.value)


def test_a_file_that_is_not_there_or_no_python_is_told(tmp_path):
    with pytest.raises(EffectError, match="no such file of effects"):
        load_effects(tmp_path / "none.py")
    (tmp_path / "effect.txt").write_text("")
    with pytest.raises(EffectError, match=r"ends in \.py"):
        load_effects(tmp_path / "effect.txt")


def test_what_an_effect_raises_in_a_search_is_told_with_its_file(tmp_path):
    once = "    starts=lambda extent: [{}] if extent.force == 0.3 else [1 / 0],\n    drag="
    path = written(tmp_path, change=("    drag=", once))
    effect = effects([path])["quadratic_drag"]
    assert effect.starts(library.USUAL_EXTENT) == [{}]
    with pytest.raises(EffectError, match=r"'quadratic_drag' cannot propose: ZeroDivisionError"):
        effect.starts(replace(library.USUAL_EXTENT, force=0.1))


def test_ctrl_c_ends_the_program_whatever_file_of_effects_runs(tmp_path):
    path = tmp_path / "slow.py"
    path.write_text("import time\nprint('here', flush=True)\nwhile True:\n    time.sleep(0.01)\n")
    program = f"from tissue_probe.physics.library import load_effects; load_effects({str(path)!r})"
    running = subprocess.Popen(
        [sys.executable, "-c", program],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    with running:
        assert running.stdout.readline() == "here\n"
        running.send_signal(signal.SIGINT)
        _, said = running.communicate(timeout=60)
    assert running.returncode == -signal.SIGINT
    assert said.splitlines()[-1] == "KeyboardInterrupt"
    assert "EffectError" not in said


@pytest.mark.parametrize("name", EFFECTS)
def test_every_effect_of_the_suite_passes_the_checks_that_users_effects_must(name):
    others = {other: effect for other, effect in EFFECTS.items() if other != name}
    library._check(EFFECTS[name], "the suite", others)
    with pytest.raises(EffectError, match="name of another effect"):
        library._check(replace(EFFECTS[name]), "a copy", EFFECTS)
