"""The lock of a campaign among processes."""

import subprocess
import sys

from mrsfi_runtime.record.database import CampaignFolder, only_writer


def test_a_child_process_does_not_keep_the_lock(tmp_path):
    folder = CampaignFolder(tmp_path)
    sleeper = [sys.executable, "-c", "import sys; sys.stdin.read()"]

    with only_writer(folder):
        child = subprocess.Popen(sleeper, stdin=subprocess.PIPE)
    with child, only_writer(folder):
        is_running = child.poll() is None

    assert is_running
