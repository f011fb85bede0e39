# SPDX-License-Identifier: Apache-2.0
"""Starts the estimator beside a robot: ros2 launch palpate_ros2 estimate.launch.py object:=mug"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration

OPTIONS = {
    "object": "mug",
    "hand": "shadow",
    "joint_states": "/joint_states",
    "contacts": "/contacts",
    "world_frame": "world",
    "mount_frame": "mount",
}


def generate_launch_description():
    command = ["palpate", "ros2", "estimate"]
    for name in OPTIONS:
        command += ["--" + name.replace("_", "-"), LaunchConfiguration(name)]
    declared = [DeclareLaunchArgument(name, default_value=value) for name, value in OPTIONS.items()]
    return LaunchDescription([*declared, ExecuteProcess(cmd=command, output="screen")])
