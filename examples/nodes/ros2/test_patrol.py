"""Flies every kept weakness against the launch file: `pytest ros2/test_patrol.py`."""

import shlex
import subprocess
from pathlib import Path

PROJECT = Path(__file__).parents[1]
NODE = "ros2 launch ros2/patrol.launch.py"
CHECK = f"mrsfi check yard --engine ros2 --node '{NODE}' --node-reset service"


def test_kept_weaknesses_are_within_their_limits() -> None:
    """Fail with what each fault did if a goal exceeds its limit."""
    words = shlex.split(CHECK)
    checked = subprocess.run(words, cwd=PROJECT, check=False, capture_output=True, text=True)

    assert checked.returncode == 0, checked.stdout + checked.stderr
