"""Starts the patrol: `ros2 launch patrol.launch.py`."""

import sys
from pathlib import Path

from launch import LaunchDescription
from launch.actions import ExecuteProcess


def generate_launch_description() -> LaunchDescription:
    """Return what is started: the node in the file beside this one."""
    patrol = Path(__file__).with_name("patrol.py")
    return LaunchDescription([ExecuteProcess(cmd=[sys.executable, str(patrol)], output="screen")])
