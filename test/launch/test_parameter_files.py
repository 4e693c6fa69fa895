"""A misspelt node, parameter or type in config/*.yaml would be ignored, or stop a node, unseen."""

from __future__ import annotations

import pytest
import yaml
from declared import ROOT, SETTINGS, parameters_of

from tissue_probe.settings import build


def parameter_sets():
    """Return (file, node, parameters) of every node in every parameter file of config/."""
    for path in sorted((ROOT / "config").glob("*.yaml")):
        for node, content in (yaml.safe_load(path.read_text()) or {}).items():
            if isinstance(content, dict) and "ros__parameters" in content:
                yield pytest.param(node, content["ros__parameters"], id=f"{path.name}:{node}")


PARAMETER_SETS = list(parameter_sets())


def test_the_stock_file_sets_parameters_of_the_driver_and_the_mapper():
    ids = [each.id for each in PARAMETER_SETS]
    assert "simulation.yaml:/**/driver" in ids
    assert "simulation.yaml:/**/mapper" in ids


@pytest.mark.parametrize(("node", "parameters"), PARAMETER_SETS)
def test_they_hold_in_any_namespace(node, parameters):
    assert node.rpartition("/")[0] == "/**"


@pytest.mark.parametrize(("node", "parameters"), PARAMETER_SETS)
def test_every_node_and_every_parameter_exists(node, parameters):
    name = node.rpartition("/")[2]
    assert name in SETTINGS
    assert parameters.keys() <= parameters_of(name).keys()


@pytest.mark.parametrize(("node", "parameters"), PARAMETER_SETS)
def test_every_value_has_the_type_that_ros_insists_on(node, parameters):
    defaults = parameters_of(node.rpartition("/")[2])
    for name, value in parameters.items():
        assert type(value) is type(defaults[name]), f"{node} {name}: {value!r}"


@pytest.mark.parametrize(("node", "parameters"), PARAMETER_SETS)
def test_every_value_is_in_its_range(node, parameters):
    name = node.rpartition("/")[2]
    values = {**parameters_of(name), **parameters}
    for prefix, settings in SETTINGS[name]:
        build(settings, {field: values[prefix + field] for field in settings.model_fields}, prefix)
