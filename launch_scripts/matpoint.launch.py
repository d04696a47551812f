"""Starts matpoint-node, and RViz and the example controller if asked for.

    ros2 launch launch_scripts/matpoint.launch.py scene:=SCENE rate:=0.5 record:=run.mcap paused:=true namespace:=/lab

The node is no ROS package: MATPOINT_NODE or the argument `node` say where it is, else PATH does, else target/release.
"""

import os
import pathlib
import shutil

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, Shutdown
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration

HERE = pathlib.Path(__file__).resolve().parent
NODE = os.environ.get("MATPOINT_NODE") or shutil.which("matpoint-node") or str(HERE.parent / "target" / "release" / "matpoint-node")
ARGUMENTS = {
    "scene": (str(HERE / "scenes" / "controlled_cantilever.toml"), "scene file"),
    "node": (NODE, "the program matpoint-node"),
    "namespace": ("/", "namespace of the node"),
    "name": ("matpoint", "name of the node"),
    "params": (str(HERE / "params" / "matpoint.yaml"), "parameter file"),
    "rate": ("1.0", "real-time factor; 0: as fast as it can"),
    "record": ("''", "recording: FILE.mcap, .rrd or .pvd, or a folder for CSV; '' for none"),
    "paused": ("false", "wait for simulation_interfaces before the first step"),
    "rviz": ("false", "start RViz"),
    "controller": ("false", "start the example controller, which damps the tip"),
}


def generate_launch_description():
    argument = {name: LaunchConfiguration(name) for name in ARGUMENTS}
    node = [argument["node"], argument["scene"], "--ros-args"]
    node += ["-r", ["__ns:=", argument["namespace"]], "-r", ["__node:=", argument["name"]], "--params-file", argument["params"]]
    node += ["-p", ["real_time_factor:=", argument["rate"]], "-p", ["record:=", argument["record"]], "-p", ["paused:=", argument["paused"]]]
    controller = ["python3", str(HERE / "controllers" / "damp_tip.py"), "--ros-args", "-r", ["__ns:=", argument["namespace"]]]
    controller += ["-p", ["node:=", argument["name"]]]
    return LaunchDescription(
        [DeclareLaunchArgument(name, default_value=default, description=text) for name, (default, text) in ARGUMENTS.items()]
        + [
            ExecuteProcess(cmd=node, output="screen", on_exit=Shutdown()),
            ExecuteProcess(cmd=["rviz2", "-d", str(HERE / "matpoint.rviz")], condition=IfCondition(argument["rviz"])),
            ExecuteProcess(cmd=controller, output="screen", condition=IfCondition(argument["controller"])),
        ]
    )
