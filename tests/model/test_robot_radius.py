"""Models to text must not know the runtime, and EVL knows neither: all mean the same robot."""

import re

from m2t.constraints import mission as constraints
from mrsfi_runtime.model.mission import ROBOT_RADIUS
from tests.support.tree import ROOT


def test_a_robot_is_as_wide_for_constraints_as_in_flight():
    text = (ROOT / "metamodels" / "constraints" / "limits.evl").read_text(encoding="utf-8")
    (in_evl,) = re.findall(r"var ROBOT_RADIUS = (\S+)d;", text)

    assert constraints.ROBOT_RADIUS == float(in_evl) == ROBOT_RADIUS
