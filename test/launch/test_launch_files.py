"""The launch files start what the package installs, with parameters that the nodes have.

The wheels bring no ``launch``: a stand-in records what the files ask of it. Where a ROS 2 install
is sourced the real one reads them too.
"""

from __future__ import annotations

import runpy
import sys
from importlib.util import find_spec
from unittest.mock import MagicMock

import pytest
from declared import ROOT, parameters_of
from security_policy import read_policy

LAUNCH_FILES = sorted((ROOT / "launch").glob("*.launch.py"))
ARGUMENTS = {
    "bench": {"output", "robot", "estimators", "namespace", "params_file"},
    "estimation": {"output", "estimators", "namespace", "params_file"},
    "replay": {
        *("bag", "rate", "loop", "start", "paused"),
        *("output", "estimators", "namespace", "params_file"),
    },
    "robot": {"output", "estimators", "namespace", "params_file"},
    "simulation": {"activate", "output", "estimators", "namespace", "params_file"},
}
STAND_INS = [
    "ament_index_python",
    "ament_index_python.packages",
    "launch",
    "launch.actions",
    "launch.conditions",
    "launch.event_handlers",
    "launch.events",
    "launch.launch_description_sources",
    "launch.substitutions",
    "launch_ros",
    "launch_ros.actions",
    "launch_ros.event_handlers",
    "launch_ros.events",
    "launch_ros.events.lifecycle",
    "launch_ros.parameter_descriptions",
]
each_file = pytest.mark.parametrize("path", LAUNCH_FILES, ids=lambda path: path.name)


def name_in(node) -> str:
    """What the node that a launch file starts is called; by default as its executable."""
    return node.get("name", node["executable"])


def name_of(path):
    return path.name.removesuffix(".launch.py")


@pytest.fixture
def recorded(monkeypatch):
    """Run a launch file on stand-ins; return what it made nodes of and which files it included."""
    modules = {name: MagicMock(name=name) for name in STAND_INS}
    for name, module in modules.items():
        monkeypatch.setitem(sys.modules, name, module)
    share = modules["ament_index_python.packages"].get_package_share_directory
    share.return_value = str(ROOT)
    configuration = modules["launch.substitutions"].LaunchConfiguration
    configuration.return_value.perform.return_value = "ekf, robust_ekf"

    def run(path):
        runpy.run_path(str(path))["generate_launch_description"]()
        for call in modules["launch.actions"].OpaqueFunction.call_args_list:
            call.kwargs["function"](MagicMock())
        actions = modules["launch_ros.actions"]
        nodes = [*actions.Node.call_args_list, *actions.LifecycleNode.call_args_list]
        source = modules["launch.launch_description_sources"].PythonLaunchDescriptionSource
        return [call.kwargs for call in nodes], [call.args[0] for call in source.call_args_list]

    return run


def test_there_is_a_launch_file_for_each_purpose():
    assert {name_of(path) for path in LAUNCH_FILES} == ARGUMENTS.keys()


@each_file
def test_every_node_is_an_executable_of_this_package_under_its_own_name(
    path, recorded, executables
):
    nodes, _ = recorded(path)
    for node in nodes:
        assert node["package"] == "tissue_probe"
        assert node["executable"] in executables
        assert name_in(node) == node["executable"]


@each_file
def test_every_parameter_exists(path, recorded):
    nodes, _ = recorded(path)
    for node in nodes:
        given = {name for each in node["parameters"] if isinstance(each, dict) for name in each}
        assert given <= parameters_of(node["executable"]).keys()


@each_file
def test_every_included_file_exists(path, recorded):
    _, included = recorded(path)
    assert set(included) <= {str(path) for path in LAUNCH_FILES}


@each_file
def test_every_node_runs_in_an_enclave_of_the_security_policy(path, recorded):
    nodes, _ = recorded(path)
    enclaves = {(enclave, name) for enclave, _, name in read_policy()}  # of the default namespaces
    for node in nodes:
        option, enclave = node["ros_arguments"]
        assert option == "--enclave"
        assert (enclave, name_in(node)) in enclaves


@each_file
def test_discovery_stays_on_this_host_unless_the_user_says_otherwise(path, recorded):
    recorded(path)
    environment = sys.modules["launch.substitutions"].EnvironmentVariable
    setting = sys.modules["launch.actions"].SetEnvironmentVariable
    name = "ROS_AUTOMATIC_DISCOVERY_RANGE"
    environment.assert_called_with(name, default_value="LOCALHOST")
    setting.assert_called_with(name, environment.return_value)
    (actions,), _ = sys.modules["launch"].LaunchDescription.call_args
    assert actions[0] is setting.return_value, "set before anything starts"


@pytest.mark.parametrize("name", ["estimation", "simulation"])
def test_parameters_given_go_over_those_of_the_stock_file(name, recorded):
    nodes, _ = recorded(ROOT / "launch" / f"{name}.launch.py")
    given = sys.modules["launch.substitutions"].LaunchConfiguration.return_value
    for node in nodes:
        stock, over, *_ = node["parameters"]
        assert stock == str(ROOT / "config" / "simulation.yaml")
        assert over is given


def test_the_estimators_named_are_started_and_mapped(recorded):
    nodes, _ = recorded(ROOT / "launch" / "estimation.launch.py")
    heard = [node for node in nodes if node["executable"] in ("estimators", "mapper")]
    assert len(heard) == 2
    for node in heard:
        assert {"estimators": ["ekf", "robust_ekf"]} in node["parameters"]


def test_the_estimators_keep_their_names_in_their_process(recorded):
    nodes, _ = recorded(ROOT / "launch" / "estimation.launch.py")
    (process,) = (node for node in nodes if node["executable"] == "estimators")
    assert "name" not in process, "it would rename every node in the process"


def test_the_simulation_starts_what_the_shared_file_does_not(recorded):
    nodes, included = recorded(ROOT / "launch" / "simulation.launch.py")
    assert {node["name"] for node in nodes} == {"driver", "scan", "stage"}
    assert [name.rpartition("/")[2] for name in included] == ["estimation.launch.py"]


def test_launch_files_and_configuration_are_installed(package):
    installed = {name for _, names in package["data_files"] for name in names}
    shipped = [*LAUNCH_FILES, *(path for path in (ROOT / "config").iterdir() if path.is_file())]
    assert {str(path.relative_to(ROOT)) for path in shipped} <= installed


@pytest.mark.skipif(find_spec("launch_ros") is None, reason="no full ROS 2 install is sourced")
@each_file
def test_the_real_launch_reads_the_file_and_finds_the_arguments(path):
    from launch.launch_description_sources import get_launch_description_from_python_launch_file

    description = get_launch_description_from_python_launch_file(str(path))
    assert {argument.name for argument in description.get_launch_arguments()} == ARGUMENTS[
        name_of(path)
    ]
