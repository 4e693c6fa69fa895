"""Below the command line nothing knows a flag; parameters that it names are shown as options."""

import ast
import re
from pathlib import Path

import click
import pytest
import typer

import tissue_probe
from tissue_probe.cli import app
from tissue_probe.cli.options_named import with_options

PACKAGE = Path(tissue_probe.__file__).parent
BELOW = [path for path in PACKAGE.rglob("*.py") if "cli" not in path.relative_to(PACKAGE).parts]


def flags(command):
    """Yield the long options of a command and of those below it."""
    for each in getattr(command, "commands", {}).values():
        yield from flags(each)
    for parameter in command.params:
        if isinstance(parameter, click.Option) or getattr(parameter, "opts", None):
            yield from (name for name in parameter.opts if name.startswith("--"))


def strings(path):
    """Yield the strings of a module that are no docstrings, with their lines."""
    tree = ast.parse(path.read_text())
    documents = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
        and node.body
        and isinstance(node.body[0], ast.Expr)
    }
    for node in ast.walk(tree):
        text = getattr(node, "value", None) if isinstance(node, ast.Constant) else None
        if isinstance(text, str) and id(node) not in documents:
            yield node.lineno, text


def test_no_module_below_the_command_line_names_one_of_its_flags():
    known = set(flags(typer.main.get_command(app))) - {"--help"}
    assert {"--position-unit", "--lowpass", "--add", "--constant", "--rig"} <= known
    found = [
        f"{path.relative_to(PACKAGE)}:{line}: {flag}"
        for path in BELOW
        for line, text in strings(path)
        for flag in re.findall(r"--[a-z][a-z-]*", text)
        if flag in known
    ]
    assert not found


@pytest.mark.parametrize(
    ("written", "read"),
    [
        ("state `force_polarity`", "state --force-polarity"),
        ("held by `constant` stiffness=VALUE", "held by --constant stiffness=VALUE"),
        ("give `samples_topic`", "give --topic"),
    ],
)
def test_a_parameter_is_read_as_the_option_that_states_it(written, read):
    assert with_options(written) == read
