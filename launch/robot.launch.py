"""Start adapter, estimators and mapper on any robot that carries a force sensor.

    ros2 launch tissue_probe robot.launch.py params_file:=my_robot.yaml output:=run.mcap

Nothing here moves the robot: its own commander also stops it.
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    IncludeLaunchDescription,
    SetEnvironmentVariable,
)
from launch.conditions import IfCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import EnvironmentVariable, LaunchConfiguration
from launch_ros.actions import Node

STOCK_PARAMETERS = str(Path(get_package_share_directory("tissue_probe"), "config", "robot.yaml"))


def generate_launch_description() -> LaunchDescription:
    """Declare the arguments and start the nodes."""
    parameters = [STOCK_PARAMETERS, LaunchConfiguration("params_file")]
    common = {
        "package": "tissue_probe",
        "namespace": LaunchConfiguration("namespace"),
        "output": "screen",
    }
    return LaunchDescription(
        [
            # No one outside this host is to hear the probe or command its coil, unless asked for.
            SetEnvironmentVariable(
                "ROS_AUTOMATIC_DISCOVERY_RANGE",
                EnvironmentVariable("ROS_AUTOMATIC_DISCOVERY_RANGE", default_value="LOCALHOST"),
            ),
            DeclareLaunchArgument(
                "sensor",
                default_value="false",
                description="true to start the node that takes load, bias and drift off the wrench",
            ),
            # Before the shared declaration, which has another stock file: the first one counts.
            DeclareLaunchArgument(
                "params_file",
                default_value=STOCK_PARAMETERS,
                description="YAML file of parameters that go over those of the stock file",
            ),
            # The shared arguments are declared there; a plain path lets --show-args list them.
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(str(Path(__file__).with_name("estimation.launch.py")))
            ),
            Node(
                executable="adapter",
                name="adapter",
                parameters=parameters,
                ros_arguments=["--enclave", "/probe/adapter"],
                **common,
            ),
            Node(
                executable="sensor",
                name="sensor",
                parameters=parameters,
                ros_arguments=["--enclave", "/probe/sensor"],
                condition=IfCondition(LaunchConfiguration("sensor")),
                **common,
            ),
        ]
    )
