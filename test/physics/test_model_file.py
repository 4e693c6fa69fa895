"""model.yaml: what is saved is loaded again, and each mistake is told in one sentence."""

import hashlib
from pathlib import Path

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.library import load_effects
from tissue_probe.physics.model_file import Data, ModelFileError, UnnamedEffectError, load, save

EXAMPLE = Path(__file__).parents[2] / "docs" / "my_effect.py"
CUBIC = Composition(effects=(EFFECTS["cubic_stiffening"],))
NAMES = (
    "tip_mass", "load_cell_stiffness", "load_cell_damping", "contact_position", "stiffness",
    "damping", "cubic_stiffness",
)  # fmt: skip
VALUES = dict(zip(NAMES, (0.04, 9700.0, 0.8, 0.0, 450.0, 5.0, 1e8), strict=True))


@st.composite
def fitted(draw):
    """A model with effects in any order and form, and values within their bounds."""
    names = draw(st.lists(st.sampled_from(sorted(EFFECTS)), max_size=3, unique=True))
    chosen = [draw(st.sampled_from([EFFECTS[n], *EFFECTS[n].forms])) for n in names]
    composition = Composition("compliant_probe", draw(st.sampled_from(["kelvin_voigt", "maxwell"])),
                              tuple(chosen))  # fmt: skip
    entries = composition.entries(map(str, composition.model.values))
    values = {e.name: draw(st.floats(e.lower, e.upper)) for e in entries}
    deviations = {e.name: draw(st.floats(0.0, 1e6)) for e in entries}
    return composition, values, deviations


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(fitted())
def test_what_is_saved_is_loaded_again_to_the_last_digit(tmp_path_factory, model):
    path = tmp_path_factory.getbasetemp() / "round_trip.yaml"
    composition, values, deviations = model
    save(path, composition, values, deviations)
    loaded = load(path)
    assert loaded.composition.names == composition.names
    assert [repr(e).partition("forms=")[0] for e in loaded.composition.effects] == [
        repr(e).partition("forms=")[0] for e in composition.effects
    ]
    assert loaded.composition.model.motion == composition.model.motion
    assert loaded.composition.model.output == composition.model.output
    assert loaded.values == values
    assert loaded.deviations == deviations


@pytest.mark.parametrize("tissue", ["standard_linear_solid", "generalized_maxwell"])
def test_a_tissue_of_table_one_has_its_branches_in_the_file(tissue, tmp_path):
    composition = Composition(tissue=tissue)
    entries = composition.entries(map(str, composition.model.values))
    values = {entry.name: entry.default for entry in entries}
    save(tmp_path / "model.yaml", composition, values, {})
    own = {entry.name for entry in EFFECTS[tissue].parameters}
    assert own <= set(yaml.safe_load((tmp_path / "model.yaml").read_text())["parameters"])
    assert load(tmp_path / "model.yaml").composition == composition


def test_the_data_are_told_with_their_checksum(tmp_path):
    run = tmp_path / "run.mcap"
    run.write_bytes(b"samples")
    data = Data.of([run], noise=0.005, rmse_training=0.0051, rmse_heldout=0.0052)
    save(tmp_path / "model.yaml", CUBIC, VALUES, {"stiffness": 1.5}, data)
    loaded = load(tmp_path / "model.yaml")
    assert loaded.data == data
    assert loaded.data.files[0].name == "run.mcap"
    assert loaded.data.files[0].sha256 == hashlib.sha256(b"samples").hexdigest()
    assert loaded.deviations["stiffness"] == 1.5
    assert loaded.deviations["damping"] == 0.0


def test_a_fit_that_did_not_settle_is_known_by_its_file_and_an_old_file_settled(tmp_path):
    path = tmp_path / "model.yaml"
    data = Data.of([], noise=5e-3, rmse_training=5e-3, rmse_heldout=5e-3, converged=False)
    save(path, CUBIC, VALUES, {}, data)
    content = yaml.safe_load(path.read_text())
    assert content["data"]["converged"] is False
    assert not load(path).data.converged
    del content["data"]["converged"]
    path.write_text(yaml.safe_dump(content))
    assert load(path).data.converged
    content["data"]["fastest"] = "very"
    path.write_text(yaml.safe_dump(content))
    with pytest.raises(ModelFileError, match=r"data.fastest is 'very': give a number of 0 or more"):
        load(path)
    del content["data"]["fastest"]
    content["data"]["converged"] = "perhaps"
    path.write_text(yaml.safe_dump(content))
    with pytest.raises(ModelFileError, match=r"data\.converged is 'perhaps': give true or false"):
        load(path)


def test_an_effect_of_a_users_own_is_read_again_from_the_file_that_the_user_names(tmp_path):
    own = tmp_path / "effects" / "drag.py"
    own.parent.mkdir()
    own.write_text(EXAMPLE.read_text())
    composition = CUBIC.plus(load_effects(own)[0])
    with pytest.raises(ModelFileError, match="quadratic_drag is not in the library"):
        save(tmp_path / "model.yaml", composition, {**VALUES, "drag_coefficient": 2.0}, {})
    save(tmp_path / "model.yaml", composition, {**VALUES, "drag_coefficient": 2.0}, {}, None, [own])
    content = yaml.safe_load((tmp_path / "model.yaml").read_text())
    assert content["effects"][1] == {"name": "quadratic_drag", "file": "effects/drag.py"}
    moved = own.rename(tmp_path / "moved.py")  # the file told is where it was
    loaded = load(tmp_path / "model.yaml", [moved])
    assert loaded.composition.model.motion == composition.model.motion
    assert loaded.effect_files == (moved,)
    with pytest.raises(ModelFileError, match=r"drag\.py: there is no such file of effects"):
        load(tmp_path / "model.yaml", [own])


def test_a_model_file_runs_no_code_that_the_user_has_not_named(tmp_path):
    own, ran = tmp_path / "own.py", tmp_path / "ran"
    own.write_text(EXAMPLE.read_text())
    path = tmp_path / "model.yaml"
    composition = CUBIC.plus(load_effects(own)[0])
    save(path, composition, {**VALUES, "drag_coefficient": 2.0}, {}, None, [own])
    own.write_text(f"open({str(ran)!r}, 'w')\n{own.read_text()}")
    with pytest.raises(UnnamedEffectError) as failure:
        load(path)
    assert not ran.exists()
    assert str(failure.value) == (
        f"{path} needs the effect 'quadratic_drag', which is not in the library but in the Python "
        f"file '{own}': a model file runs no code by itself, so, if you trust that file, name it "
        "by `effects`"
    )
    load(path, [own])
    assert ran.exists()


def test_nothing_is_written_where_a_value_is_missing(tmp_path):
    with pytest.raises(ModelFileError, match="no value for cubic_stiffness"):
        save(tmp_path / "model.yaml", CUBIC, dict(list(VALUES.items())[:-1]), {})
    assert not (tmp_path / "model.yaml").exists()


def changed(content: dict, place: str, value: object) -> None:
    """Set what stands at a dotted place; None takes it away."""
    *folders, last = place.split(".")
    for folder in folders:
        content = content[int(folder) if folder.isdigit() else folder]
    if value is None:
        del content[last]
    else:
        content[last] = value


MISTAKES = [
    ("version", 2, "version is 2: give one of 1"),
    ("rig", "robot", "rig is 'robot': give one of compliant_probe, rigid_probe"),
    ("tissue", "jelly", "tissue is 'jelly': give one of kelvin_voigt, maxwell"),
    ("tissue", None, "tissue is missing"),
    ("colour", "red", "there is no colour; there are version, rig"),
    ("effects", "cubic_stiffening", "effects is 'cubic_stiffening': give a list of effects"),
    ("effects.0.name", "square", "there is no effect 'square'; there are standard_linear_solid"),
    ("effects.0.form", 1, "effect cubic_stiffening has no form 1: give 0 to 0"),
    ("effects.0.from", "x.py", "there is no effects.0.from; there are name, form, file"),
    ("effects", [], "parameters.cubic_stiffness is nothing that this model has"),
    ("effects", [{"name": "cubic_stiffening"}] * 2, "effect cubic_stiffening is there twice"),
    ("effects", [{"name": "cubic_stiffening"}, {"name": "force_bias"}],
     r"parameters.force_bias is missing: give it \[N\]"),
    ("parameters.stiffness.value", "stiff", "value is 'stiff': give a number"),
    ("parameters.stiffness.value", float("nan"), "value is nan: give a number"),
    ("parameters.stiffness.value", 1e12, r"give a number from 0 to 1e\+09 \[N/m\]"),
    ("parameters.stiffness.unit", "N/mm", "unit is 'N/mm': convert to 'N/m'"),
    ("parameters.stiffness.deviation", -1.0, "deviation is -1.0: give a number from 0"),
    ("parameters.stiffness", 450.0, "parameters.stiffness is 450.0: give the fields value"),
    ("parameters.stiffness", None, "parameters.stiffness is missing"),
    ("constants", None, "constants is missing"),
    ("data", {"date": "soon"}, "data.date is 'soon': give a day"),
]  # fmt: skip


@pytest.mark.parametrize(("place", "value", "told"), MISTAKES)
def test_a_mistake_is_told_in_one_sentence(place, value, told, tmp_path):
    path = tmp_path / "model.yaml"
    save(path, CUBIC, VALUES, {})
    content = yaml.safe_load(path.read_text())
    changed(content, place, value)
    path.write_text(yaml.safe_dump(content))
    with pytest.raises(ModelFileError, match=told) as failure:
        load(path)
    assert str(failure.value).startswith(str(path))
    assert "\n" not in str(failure.value)


def test_effects_that_the_rig_cannot_have_are_told(tmp_path):
    path = tmp_path / "model.yaml"
    composition = Composition(effects=(EFFECTS["load_cell_stiffness_error"],))
    entries = composition.entries(map(str, composition.model.values))
    save(path, composition, {entry.name: entry.default for entry in entries}, {})
    path.write_text(path.read_text().replace("compliant_probe", "rigid_probe"))
    with pytest.raises(ModelFileError, match="load_cell_stiffness_error acts on the load cell"):
        load(path)


@pytest.mark.parametrize(
    "content",
    [b"a: [", b"", b"just a text", b"- 1", b"\x00", b"\xff", b"t,u,F\n0,1e-3,0.5\n", b"mass: 0.04"],
)
def test_a_file_that_is_no_model_is_told_and_not_quoted(content, tmp_path):
    path = tmp_path / "model.yaml"
    path.write_bytes(content)
    with pytest.raises(ModelFileError) as failure:
        load(path)
    told = str(failure.value)
    assert told.startswith(f"{path} is not a model.yaml: ")
    assert "\n" not in told
    assert "1e-3" not in told
    assert len(told) < len(str(path)) + 120


def test_the_line_that_is_no_yaml_is_told(tmp_path):
    path = tmp_path / "model.yaml"
    path.write_text("version: 1\nrig: [\n")
    with pytest.raises(ModelFileError, match=r"it is not YAML \(line 3: "):
        load(path)
