"""Replay a recorded run: its samples on the live topics, estimators and mapper running on them.

    ros2 launch tissue_probe replay.launch.py bag:=run.mcap rate:=2.0 estimators:=ekf,robust_ekf

It begins when the estimators listen. When the bag is over the map stays for viewers, until
Ctrl-C; ``paused:=true`` waits for the service ``replay/pause`` of the probe's namespace.
"""

from pathlib import Path

from launch import LaunchContext, LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    IncludeLaunchDescription,
    OpaqueFunction,
    SetEnvironmentVariable,
)
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import EnvironmentVariable, LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

#: The replay's parameters that are arguments here: type, default (None if it must be given), help.
REPLAY_ARGUMENTS = {
    "bag": (str, None, "MCAP file to replay"),
    "rate": (float, "1.0", "speed of the replay over that of the run"),
    "loop": (bool, "false", "whether to begin again at the end"),
    "start": (float, "0.0", "time after the bag's first message at which to begin [s]"),
    "paused": (bool, "false", "whether to wait for the service replay/pause"),
}


def replay_parameters() -> dict[str, ParameterValue]:
    """Return the replay's parameters, to be read from the arguments."""
    return {
        name: ParameterValue(LaunchConfiguration(name), value_type=kind)
        for name, (kind, *_) in REPLAY_ARGUMENTS.items()
    }


def refuse_wrong_values(context: LaunchContext) -> None:
    """Raise ValueError before anything starts: launch would leave its processes running."""
    for value in replay_parameters().values():
        value.evaluate(context)


def replay_node() -> Node:
    """Return the replay, which waits for the one process of all estimators."""
    return Node(
        package="tissue_probe",
        executable="replay",
        name="replay",
        namespace=LaunchConfiguration("namespace"),
        parameters=[
            LaunchConfiguration("params_file"),
            {**replay_parameters(), "subscribers": 1},
        ],
        ros_arguments=["--enclave", "/probe/replay"],
        output="screen",
    )


def generate_launch_description() -> LaunchDescription:
    """Declare the arguments and start the nodes."""
    return LaunchDescription(
        [
            # No one outside this host is to hear the probe or command its coil, unless asked for.
            SetEnvironmentVariable(
                "ROS_AUTOMATIC_DISCOVERY_RANGE",
                EnvironmentVariable("ROS_AUTOMATIC_DISCOVERY_RANGE", default_value="LOCALHOST"),
            ),
            *(
                DeclareLaunchArgument(name, default_value=default, description=description)
                for name, (_, default, description) in REPLAY_ARGUMENTS.items()
            ),
            OpaqueFunction(function=refuse_wrong_values),
            # The shared arguments are declared there; a plain path lets --show-args list them.
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(str(Path(__file__).with_name("estimation.launch.py")))
            ),
            replay_node(),
        ]
    )
