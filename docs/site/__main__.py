"""Builds the site of documents: ``python docs/site build/docs``.

The documents link to other files of the repository, and notebooks write files where they run. So
all of it is copied first, and pages that are made of code are written beside the copies.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from pathlib import Path

from reference import write_reference
from sphinx.cmd.build import main as sphinx

from tissue_probe.analysis.effect_pages import write_pages
from tissue_probe.physics.library import effects

ROOT = Path(__file__).parents[2]
#: The parts of the repository that documents show or link to.
SHOWN = (
    "CHANGELOG.md", "CONTRIBUTING.md", "LICENSE", "README.md", "config", "daq_server", "docs",
    "examples", "msg_defs", "pyproject.toml", "tissue_probe",
)  # fmt: skip
#: The front page lies in a folder: who opens the site's own folder is sent there.
FORWARD = '<!doctype html><meta http-equiv="refresh" content="0; url=docs/index.html">\n'


def copy(source: Path) -> None:
    """Copy the parts of the repository that documents show into an empty folder."""
    shutil.rmtree(source, ignore_errors=True)
    source.mkdir(parents=True)
    for name in SHOWN:
        if (ROOT / name).is_dir():
            hidden = shutil.ignore_patterns("__pycache__")
            shutil.copytree(ROOT / name, source / name, ignore=hidden)
        else:
            shutil.copy(ROOT / name, source)


def build(folder: Path) -> int:
    """Build the site into ``folder / "html"``; return 0, or another number where it has a flaw."""
    source, site = folder / "source", folder / "html"
    copy(source)
    write_pages(source / "docs" / "effects", effects())
    write_reference(source / "docs" / "reference")
    options = ["-b", "html", "-W", "--keep-going", "-q", "-j", "2", "-c", str(source / "docs")]
    failed = sphinx([*options, "-d", str(folder / "doctrees"), str(source), str(site)])
    (site / "index.html").write_text(FORWARD, encoding="utf-8")
    return failed


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Build the site of documents.")
    parser.add_argument("folder", type=Path, help="where to build; the site is its folder html")
    sys.exit(build(parser.parse_args().folder.resolve()))
