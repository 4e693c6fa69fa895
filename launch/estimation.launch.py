"""Start estimators, and the mapper on their estimates; included by the other launch files.

Alone it runs on the samples of any driver in the same namespace::

    ros2 launch tissue_probe estimation.launch.py estimators:=ekf,robust_ekf
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, SetEnvironmentVariable
from launch.substitutions import EnvironmentVariable, LaunchConfiguration
from launch_ros.actions import Node

from tissue_probe.estimation import ESTIMATORS

STOCK_PARAMETERS = str(
    Path(get_package_share_directory("tissue_probe"), "config", "simulation.yaml")
)


def estimation_nodes(context: LaunchContext) -> list[Node]:
    """Return the process of all estimators, and the mapper that hears them."""
    listed = LaunchConfiguration("estimators").perform(context)
    estimators = [name.strip() for name in listed.split(",") if name.strip()]
    # Before anything starts: launch leaves its processes running when an error comes later.
    if unknown := set(estimators) - set(ESTIMATORS):
        raise ValueError(f"no estimator {', '.join(unknown)}; there are {', '.join(ESTIMATORS)}")
    common = {
        "package": "tissue_probe",
        "namespace": LaunchConfiguration("namespace"),
        "output": "screen",
    }
    parameters = [STOCK_PARAMETERS, LaunchConfiguration("params_file")]
    return [
        # One process takes and decodes each block once. No name: it would go to every node in it.
        Node(
            executable="estimators",
            parameters=[*parameters, {"estimators": estimators}],
            ros_arguments=["--enclave", "/probe/estimators"],
            **common,
        ),
        Node(
            executable="mapper",
            name="mapper",
            parameters=[*parameters, {"estimators": estimators}],
            ros_arguments=["--enclave", "/probe/mapper"],
            **common,
        ),
    ]


def generate_launch_description() -> LaunchDescription:
    """Declare the arguments and start the nodes."""
    return LaunchDescription(
        [
            # No one outside this host is to hear the probe or command its coil, unless asked for.
            SetEnvironmentVariable(
                "ROS_AUTOMATIC_DISCOVERY_RANGE",
                EnvironmentVariable("ROS_AUTOMATIC_DISCOVERY_RANGE", default_value="LOCALHOST"),
            ),
            DeclareLaunchArgument(
                "estimators",
                default_value="robust_ekf,ekf,ukf,afekf",
                description="filters to run, separated by commas: `tissue_probe estimators`",
            ),
            DeclareLaunchArgument(
                "namespace", default_value="probe", description="namespace of the probe's nodes"
            ),
            DeclareLaunchArgument(
                "params_file",
                default_value=STOCK_PARAMETERS,
                description="YAML file of parameters that go over those of the stock file",
            ),
            OpaqueFunction(function=estimation_nodes),
        ]
    )
