"""The site that ``make docs`` builds: pages of the code, notebooks with their results."""

from __future__ import annotations

import html
import re
from pathlib import Path

import pytest
import typer
from pydantic import BaseModel

import tissue_probe
from tissue_probe.cli import app
from tissue_probe.nodes import adapter, driver, estimators, mapper, recorder, replay, scan, stage
from tissue_probe.physics.effects import EFFECTS

ROOT = Path(__file__).parents[2]
SITE = ROOT / "build" / "docs" / "html"
NODES = adapter, driver, estimators, mapper, recorder, replay, scan, stage

pytestmark = pytest.mark.skipif(not SITE.is_dir(), reason="`make docs` builds the site")


def page(name: str) -> str:
    """Return a page's text, without marks."""
    text = (SITE / f"{name}.html").read_text(encoding="utf-8")
    return html.unescape(re.sub(r"<[^>]+>", "", text))


@pytest.mark.parametrize(
    ("notebook", "told"),
    [
        ("1_my_first_stiffness", "converged"),
        ("2_what_is_my_model_missing", "Missing: hertz_contact (probability "),
        ("3_an_effect_of_my_own", "Missing: hunt_crossley (probability "),
        ("4_from_bag_to_map", "16 of 16 sites measured"),
    ],
)
def test_a_notebook_was_run_to_its_end_and_shows_its_result(notebook, told):
    text = page(f"examples/{notebook}")
    assert told in text
    assert "Traceback" not in text


def test_notebooks_show_their_pictures():
    for name, least in (
        ("examples/2_what_is_my_model_missing", 3),
        ("examples/4_from_bag_to_map", 1),
        ("docs/gallery", 6),
    ):
        text = (SITE / f"{name}.html").read_text(encoding="utf-8")
        shown = re.findall(r'src="\.\./(_images/\w+\.png)"', text)
        assert len(shown) >= least
        assert all((SITE / each).is_file() for each in shown)


@pytest.mark.parametrize("name", EFFECTS)
def test_every_effect_of_the_library_has_a_page_with_a_picture(name):
    text = (SITE / "docs" / "effects" / f"{name}.html").read_text(encoding="utf-8")
    (picture,) = re.findall(rf'src="\.\./\.\./(_images/{name}\w*\.png)"', text)
    assert (SITE / picture).is_file()
    assert f'href="{name}.html"' in (SITE / "docs" / "effects" / "index.html").read_text("utf-8")


def test_every_public_name_is_in_the_reference():
    text = page("docs/reference/interface")
    for name in tissue_probe.__all__:
        assert name.startswith("__") or f"tissue_probe.{name}" in text


def test_every_option_of_every_command_is_in_the_reference():
    text = page("docs/reference/commands")

    def check(command, path):
        for name, each in getattr(command, "commands", {}).items():
            check(each, f"{path} {name}")
        if not hasattr(command, "commands"):
            assert path in text
            for option in command.params:
                assert all(name in text for name in option.opts if name.startswith("--"))

    check(typer.main.get_command(app), "tissue_probe")


def test_every_parameter_of_a_node_is_in_the_reference():
    text = page("docs/reference/parameters")
    settings = {
        each
        for module in NODES
        for each in vars(module).values()
        if isinstance(each, type) and issubclass(each, BaseModel) and "Settings" in each.__name__
    }
    assert len(settings) >= len(NODES)
    for each in settings:
        assert all(name in text for name in each.model_fields)


def test_every_message_and_action_is_in_the_reference():
    text = page("docs/reference/messages")
    definitions = [*ROOT.glob("msg_defs/*/*.msg"), *ROOT.glob("msg_defs/*/*.action")]
    assert definitions
    for path in definitions:
        assert path.read_text(encoding="utf-8").strip() in text


def test_the_pages_load_nothing_from_the_network():
    for path in SITE.rglob("*.html"):
        text = path.read_text(encoding="utf-8")
        loaded = re.findall(r'<(?:script|img|iframe)[^>]* src="([^"]+)"', text)
        loaded += re.findall(r'<link[^>]* rel="stylesheet"[^>]* href="([^"]+)"', text)
        assert not [each for each in loaded if "//" in each], path.name
