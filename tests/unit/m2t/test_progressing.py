"""Models to text must not know the kernel: both mean the same tasks that remember something."""

import sys

from m2t.metaclasses import PROGRESSING
from mrsfi_runtime.kernel.goal_tasks.table import TASKS


def test_a_progress_region_is_generated_for_tasks_whose_module_has_progress():
    remembering = {
        task.__name__ for task in TASKS if hasattr(sys.modules[task.__module__], "progress")
    }

    assert remembering == PROGRESSING
