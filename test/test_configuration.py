"""The stock configuration is found from any working folder, in a source tree or installed."""

from __future__ import annotations

from pathlib import Path

import pytest

from tissue_probe import configuration
from tissue_probe.configuration import stock_configuration
from tissue_probe.physics.phantom import Phantom


@pytest.mark.parametrize("name", ["phantom.yaml", "simulation.yaml"])
def test_a_stock_file_is_found_from_any_working_folder(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = stock_configuration(name)
    assert found.is_absolute()
    assert found.is_file()
    assert found.name == name


def test_the_stock_phantom_is_sound():
    assert len(Phantom.load(stock_configuration("phantom.yaml")).nodules) == 3


def test_it_is_found_in_the_share_folder_of_an_installed_package(tmp_path, monkeypatch):
    package = tmp_path / "lib/python3.11/site-packages/tissue_probe"
    share = tmp_path / "share/tissue_probe/config"
    share.mkdir(parents=True)
    (share / "phantom.yaml").touch()
    monkeypatch.setattr(configuration, "__file__", str(package / "configuration.py"))
    assert stock_configuration("phantom.yaml") == share / "phantom.yaml"


def test_the_source_tree_goes_before_what_is_installed(tmp_path, monkeypatch):
    for folder in ("source/config", "share/tissue_probe/config"):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "phantom.yaml").touch()
    file = tmp_path / "source/tissue_probe/configuration.py"
    monkeypatch.setattr(configuration, "__file__", str(file))
    assert stock_configuration("phantom.yaml") == tmp_path / "source/config/phantom.yaml"


def test_a_file_that_is_not_there_is_named_with_where_it_was_looked_for():
    with pytest.raises(FileNotFoundError, match=r"no file none\.yaml in .*config") as raised:
        stock_configuration("none.yaml")
    assert str(Path(configuration.__file__).parents[1]) in str(raised.value)
