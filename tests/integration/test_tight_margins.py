"""Missions with little to waste: each fault of a pool harms one, false speeds the other."""

import pytest

from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.model.faults import TimedFault
from tests.support.fault_types import FAULT_TYPES
from tests.support.world import code_of


def test_every_fault_type_alone_violates_a_goal():
    code = code_of("tight_margins")
    engine = ReferenceEngine(code, 1)

    outcomes = {
        fault.type: engine.evaluate((TimedFault(fault.id, 60, 180, fault.values),))
        for fault in code.pool
    }

    assert {*outcomes} == {*FAULT_TYPES}
    assert [kind for kind, each in outcomes.items() if not any(each.believed + each.true)] == []


@pytest.mark.parametrize("kind", ["DecrementSpeed", "ZeroSpeed", "RandomSpeed"])
def test_a_false_report_of_speed_truly_costs_the_energy_that_is_needed(kind):
    code = code_of("tight_energy")
    (fault,) = [fault for fault in code.pool if fault.type == kind]
    timed = TimedFault(fault.id, 60, 340, fault.values)

    outcome = ReferenceEngine(code, 1).evaluate((timed,))

    assert outcome.true[code.mission.goal_ids.index("energy")] > 100
