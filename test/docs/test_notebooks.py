"""The notebooks of the examples run from top to end, and tell the story that they promise."""

import ast
import json
import shutil
from pathlib import Path

import pytest
from matplotlib.figure import Figure

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "examples").glob("*.ipynb"))

pytestmark = pytest.mark.timeout(600)


def run(path: Path) -> list[object]:
    """Run the cells as a notebook does; return the value of each last expression."""
    names: dict[str, object] = {}
    shown = []
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        if cell["cell_type"] != "code":
            continue
        *before, last = ast.parse("".join(cell["source"])).body
        if not isinstance(last, ast.Expr):
            before, last = [*before, last], None
        exec(compile(ast.Module(before, []), path.name, "exec"), names)
        if last is not None:
            shown.append(eval(compile(ast.Expression(last.value), path.name, "eval"), names))
    return shown


@pytest.mark.parametrize(
    ("notebook", "told"),
    [
        ("1_my_first_stiffness.ipynb", "converged"),
        ("2_what_is_my_model_missing.ipynb", "Missing: hertz_contact (probability "),
        ("3_an_effect_of_my_own.ipynb", "Missing: hunt_crossley (probability "),
        ("4_from_bag_to_map.ipynb", "16 of 16 sites measured"),
    ],
)
def test_a_notebook_runs_to_its_end_and_shows_its_result(notebook, told, tmp_path, monkeypatch):
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    (tmp_path / "docs").mkdir()
    shutil.copy(ROOT / "docs" / "my_effect.py", tmp_path / "docs")
    monkeypatch.chdir(tmp_path / "examples")
    shown = run(Path(notebook))
    assert any(told in repr(each) for each in shown)
    for each in shown:
        if isinstance(each, Figure):
            assert each._repr_png_().startswith(b"\x89PNG")
        elif hasattr(each, "_repr_html_"):
            assert each._repr_html_()


def test_every_notebook_is_run_and_kept_without_outputs():
    assert len(NOTEBOOKS) == 4
    for path in NOTEBOOKS:
        cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
        assert not any(cell.get("outputs") for cell in cells)
