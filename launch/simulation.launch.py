"""Start the whole suite on the simulated probe, ready to scan.

    ros2 launch tissue_probe simulation.launch.py estimators:=ekf,robust_ekf output:=run.mcap
    ros2 action send_goal --feedback /probe/scan_grid tissue_probe_msgs/action/ScanGrid \
        "{spacing: 0.01, rows: 5, columns: 5, dwell_time: 1.0}"

The stage stays at /stage in any namespace of the probe: driver and scan look for it there.
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
from launch.substitutions import EnvironmentVariable, LaunchConfiguration
from launch_ros.actions import LifecycleNode, Node
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events.lifecycle import ChangeState
from lifecycle_msgs.msg import Transition

STOCK_PARAMETERS = str(
    Path(get_package_share_directory("tissue_probe"), "config", "simulation.yaml")
)


def change_state(node: LifecycleNode, transition: int) -> EmitEvent:
    """Return the action that asks one node for a transition of its lifecycle."""
    return EmitEvent(
        event=ChangeState(lifecycle_node_matcher=matches_action(node), transition_id=transition)
    )


def generate_launch_description() -> LaunchDescription:
    """Declare the arguments, start the nodes, bring the driver up."""
    parameters = [STOCK_PARAMETERS, LaunchConfiguration("params_file")]
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
    return LaunchDescription(
        [
            # No one outside this host is to hear the probe or command its coil, unless asked for.
            SetEnvironmentVariable(
                "ROS_AUTOMATIC_DISCOVERY_RANGE",
                EnvironmentVariable("ROS_AUTOMATIC_DISCOVERY_RANGE", default_value="LOCALHOST"),
            ),
            DeclareLaunchArgument(
                "activate",
                default_value="true",
                choices=["true", "false"],
                description="whether the coil moves at once; if not, the driver is configured only",
            ),
            # The shared arguments are declared there; a plain path lets --show-args list them.
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(str(Path(__file__).with_name("estimation.launch.py")))
            ),
            Node(
                package="tissue_probe",
                executable="stage",
                name="stage",
                namespace="stage",
                parameters=parameters,
                ros_arguments=["--enclave", "/stage/stage"],
                output="screen",
            ),
            Node(
                executable="scan",
                name="scan",
                parameters=parameters,
                ros_arguments=["--enclave", "/probe/scan"],
                **common,
            ),
            RegisterEventHandler(
                OnProcessStart(
                    target_action=driver,
                    on_start=[change_state(driver, Transition.TRANSITION_CONFIGURE)],
                )
            ),
            # Once: a user who configures the driver again by hand also decides when the coil moves.
            RegisterEventHandler(
                OnStateTransition(
                    target_lifecycle_node=driver,
                    start_state="configuring",
                    goal_state="inactive",
                    entities=[change_state(driver, Transition.TRANSITION_ACTIVATE)],
                    handle_once=True,
                ),
                condition=IfCondition(LaunchConfiguration("activate")),
            ),
            driver,
        ]
    )
