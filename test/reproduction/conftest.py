"""The program, run in this process and in an empty folder."""

from __future__ import annotations

import sys

import pytest

from tissue_probe import cli


@pytest.fixture
def run(monkeypatch, capsys, tmp_path):
    """Run ``tissue_probe`` with arguments; return what it prints, or the error it ends with."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")

    def run(*arguments) -> str:
        monkeypatch.setattr(sys, "argv", ["tissue_probe", *arguments])
        with pytest.raises(SystemExit) as end:
            cli.main()
        return capsys.readouterr().out if end.value.code in (None, 0) else str(end.value.code)

    return run
