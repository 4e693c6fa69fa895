"""Start estimators, the mapper on their estimates, monitor, identify and recorder if asked for.

The other launch files include it.

Alone it runs on the samples of any driver in the same namespace::

    ros2 launch tissue_probe estimation.launch.py estimators:=ekf,robust_ekf
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, SetEnvironmentVariable
from launch.conditions import IfCondition
from launch.substitutions import EnvironmentVariable, LaunchConfiguration, NotEqualsSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from tissue_probe.estimation import ESTIMATORS

STOCK_PARAMETERS = str(
    Path(get_package_share_directory("tissue_probe"), "config", "simulation.yaml")
)
COMMON = {
    "package": "tissue_probe",
    "namespace": LaunchConfiguration("namespace"),
    "output": "screen",
}
PARAMETERS = [STOCK_PARAMETERS, LaunchConfiguration("params_file")]


def estimation_nodes(context: LaunchContext) -> list[Node]:
    """Return the process of all estimators, and the mapper that hears them."""
    listed = LaunchConfiguration("estimators").perform(context)
    estimators = [name.strip() for name in listed.split(",") if name.strip()]
    # Before anything starts: launch leaves its processes running when an error comes later.
    if unknown := set(estimators) - set(ESTIMATORS):
        raise ValueError(f"no estimator {', '.join(unknown)}; there are {', '.join(ESTIMATORS)}")
    return [
        # One process takes and decodes each block once. No name: it would go to every node in it.
        Node(
            executable="estimators",
            parameters=[*PARAMETERS, {"estimators": estimators}],
            ros_arguments=["--enclave", "/probe/estimators"],
            **COMMON,
        ),
        Node(
            executable="mapper",
            name="mapper",
            parameters=[*PARAMETERS, {"estimators": estimators}],
            ros_arguments=["--enclave", "/probe/mapper"],
            **COMMON,
        ),
    ]


def generate_launch_description() -> LaunchDescription:
    """Declare the arguments and start the nodes."""
    output = LaunchConfiguration("output")
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
            DeclareLaunchArgument(
                "output",
                default_value="",
                description="MCAP file to record, never overwritten; empty to record nothing",
            ),
            DeclareLaunchArgument(
                "monitor",
                default_value="false",
                description="true to test the model on all samples, and diagnose where it fails",
            ),
            DeclareLaunchArgument(
                "identify",
                default_value="false",
                description="true to take goals of the action identify, which commands the driver",
            ),
            OpaqueFunction(function=estimation_nodes),
            Node(
                executable="monitor",
                name="monitor",
                parameters=PARAMETERS,
                ros_arguments=["--enclave", "/probe/monitor"],
                condition=IfCondition(LaunchConfiguration("monitor")),
                **COMMON,
            ),
            Node(
                executable="identify",
                name="identify",
                parameters=PARAMETERS,
                ros_arguments=["--enclave", "/probe/identify"],
                condition=IfCondition(LaunchConfiguration("identify")),
                **COMMON,
            ),
            Node(
                executable="recorder",
                name="recorder",
                parameters=[*PARAMETERS, {"output": ParameterValue(output, value_type=str)}],
                ros_arguments=["--enclave", "/probe/recorder"],
                condition=IfCondition(NotEqualsSubstitution(output, "")),
                **COMMON,
            ),
        ]
    )
