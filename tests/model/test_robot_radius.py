"""EVL knows nothing of Python: both mean the same robot."""

import re

from mrsfi_runtime.model.mission import ROBOT_RADIUS
from tests.support.tree import ROOT


def test_a_robot_is_as_wide_for_constraints_as_in_flight():
    text = (ROOT / "metamodels" / "constraints" / "limits.evl").read_text(encoding="utf-8")
    (in_evl,) = re.findall(r"var ROBOT_RADIUS = (\S+)d;", text)

    assert float(in_evl) == ROBOT_RADIUS
