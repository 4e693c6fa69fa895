"""Write the pages: ``python -m tissue_probe.analysis.effect_pages FOLDER [my_effect.py ...]``."""

from __future__ import annotations

import argparse
from pathlib import Path

from tissue_probe.analysis.effect_pages.page import write_pages
from tissue_probe.physics.library import effects

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Write a page for each effect of the library.")
    parser.add_argument("folder", type=Path, help="where the pages go")
    parser.add_argument("files", type=Path, nargs="*", help="Python files with further effects")
    given = parser.parse_args()
    write_pages(given.folder, effects(given.files))
