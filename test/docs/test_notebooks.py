"""The notebooks of the examples are kept without outputs; ``make docs`` runs them."""

import json
from pathlib import Path

NOTEBOOKS = sorted((Path(__file__).parents[2] / "examples").glob("*.ipynb"))


def test_every_notebook_is_kept_without_outputs_and_is_a_tutorial():
    tutorials = (Path(__file__).parents[2] / "docs" / "tutorials.md").read_text(encoding="utf-8")
    assert len(NOTEBOOKS) == 4
    for path in NOTEBOOKS:
        cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
        assert not any(cell.get("outputs") for cell in cells)
        assert f"../examples/{path.stem}\n" in tutorials
