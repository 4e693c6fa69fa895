"""Start driver, estimators and mapper on a real probe; the coil does not move until it is told.

    ros2 launch tissue_probe bench.launch.py params_file:=my_bench.yaml output:=run.mcap
    ros2 lifecycle set /probe/driver activate

With a robot that speaks CRTK, give its namespace, `robot:=/psm1`, and the scan node starts too.
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    IncludeLaunchDescription,
    RegisterEventHandler,
    SetEnvironmentVariable,
)
from launch.conditions import IfCondition
from launch.event_handlers import OnProcessStart
from launch.events import matches_action
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import (
    EnvironmentVariable,
    LaunchConfiguration,
    NotEqualsSubstitution,
)
from launch_ros.actions import LifecycleNode, Node
from launch_ros.events.lifecycle import ChangeState
from launch_ros.parameter_descriptions import ParameterValue
from lifecycle_msgs.msg import Transition

STOCK_PARAMETERS = str(Path(get_package_share_directory("tissue_probe"), "config", "bench.yaml"))


def generate_launch_description() -> LaunchDescription:
    """Declare the arguments, start the nodes, configure the driver."""
    parameters = [STOCK_PARAMETERS, LaunchConfiguration("params_file")]
    robot = LaunchConfiguration("robot")
    common = {
        "package": "tissue_probe",
        "namespace": LaunchConfiguration("namespace"),
        "output": "screen",
    }
    driver = LifecycleNode(
        executable="driver",
        name="driver",
        parameters=parameters,
        ros_arguments=["--enclave", "/probe/driver"],
        **common,
    )
    configure = EmitEvent(
        event=ChangeState(
            lifecycle_node_matcher=matches_action(driver),
            transition_id=Transition.TRANSITION_CONFIGURE,
        )
    )
    return LaunchDescription(
        [
            # No one outside this host is to hear the probe or command its coil, unless asked for.
            SetEnvironmentVariable(
                "ROS_AUTOMATIC_DISCOVERY_RANGE",
                EnvironmentVariable("ROS_AUTOMATIC_DISCOVERY_RANGE", default_value="LOCALHOST"),
            ),
            DeclareLaunchArgument(
                "robot",
                default_value="",
                description="namespace of the robot that carries the probe; empty for none",
            ),
            # The shared arguments are declared there; a plain path lets --show-args list them.
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(str(Path(__file__).with_name("estimation.launch.py")))
            ),
            Node(
                executable="scan",
                name="scan",
                parameters=[*parameters, {"robot": ParameterValue(robot, value_type=str)}],
                ros_arguments=["--enclave", "/probe/scan"],
                condition=IfCondition(NotEqualsSubstitution(robot, "")),
                **common,
            ),
            RegisterEventHandler(OnProcessStart(target_action=driver, on_start=[configure])),
            driver,
        ]
    )
