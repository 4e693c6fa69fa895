"""The table of rigs: each is whole in its own file, its facts hold for its equations, nobody else
names it."""

from pathlib import Path
from typing import get_args
from xml.etree import ElementTree

import pytest

from tissue_probe.physics import rigs
from tissue_probe.physics.rigs import OWN, RIGS, FilteredRig, Live, RigName

PACKAGE = Path(rigs.__file__).parents[2]
PAGE = PACKAGE.parent / "docs" / "rigs.md"
FOLDER = Path(rigs.__file__).parent

rig_by_rig = pytest.mark.parametrize("rig", RIGS.values(), ids=str)


def test_the_names_that_checkers_of_types_know_are_those_of_the_table():
    assert get_args(RigName) == tuple(RIGS)
    assert get_args(FilteredRig) == tuple(
        rig.name for rig in RIGS.values() if rig.live is not Live.no
    )


def test_no_file_but_a_rigs_own_names_it():
    named = {
        (rig, path.relative_to(PACKAGE).as_posix())
        for path in PACKAGE.rglob("*.py")
        if path.parent != FOLDER or path.stem in RIGS
        for rig in RIGS
        if rig in path.read_text(encoding="utf-8")
    }
    assert named == {(rig, f"physics/rigs/{rig}.py") for rig in RIGS}


@rig_by_rig
def test_a_rig_declares_the_constants_of_its_equations(rig):
    model = rig.compose(contact_position=True)
    assert {str(symbol) for symbol in model.constants} == set(rig.known)
    for each in rig.constants:
        assert each.entry.lower <= each.value <= each.entry.upper
        assert each.deviation >= 0.0


@rig_by_rig
def test_nothing_moves_by_itself_where_the_tip_is_at_the_position(rig):
    assert rig.tip_is_position == (not rig.compose().states)


@rig_by_rig
def test_what_drives_is_the_input_of_the_equations(rig):
    model = rig.compose()
    assert str(model.input) == rig.input.name
    assert {str(symbol) for symbol in model.output.free_symbols}.isdisjoint({rig.output.name})


@rig_by_rig
def test_filters_take_by_windows_what_does_not_move_and_no_force_that_drives(rig):
    assert (rig.live is Live.windows) == rig.tip_is_position
    assert (rig.live is Live.no) == (rig.input.name == "force")


@rig_by_rig
def test_a_drawing_is_a_small_picture_that_takes_the_pages_colour(rig):
    picture = ElementTree.fromstring(rig.drawing)
    assert picture.tag == "{http://www.w3.org/2000/svg}svg"
    assert (picture.get("width"), picture.get("height")) == ("220", "60")
    assert picture.get("stroke") == "currentColor"
    assert len(rig.drawing) < 1000
    assert rig.drawing in rig._repr_html_()


@rig_by_rig
def test_the_table_of_the_document_has_each_rig(rig):
    (row,) = (
        line
        for line in PAGE.read_text(encoding="utf-8").splitlines()
        if line.startswith(f"| `{rig.name}`")
    )
    driven, predicted = row.split("|")[2:4]
    assert rig.input.name in driven
    assert rig.output.name in predicted


def test_only_the_suites_own_probe_runs_model_files_live():
    assert [rig for rig in RIGS.values() if rig.live is Live.models] == [OWN]
