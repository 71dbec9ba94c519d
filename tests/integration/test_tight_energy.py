"""A mission whose robots have hardly more energy than they need."""

import pytest

from mrsfi_runtime.engine.reference import ReferenceEngine
from mrsfi_runtime.model.faults import TimedFault
from tests.support.world import ROOT, code_of

MODELS = ROOT / "models" / "tight_energy"
CODE = code_of("tight_energy")
ENERGY = CODE.mission.goal_ids.index("energy")


@pytest.mark.parametrize("kind", ["DecrementSpeed", "ZeroSpeed", "RandomSpeed"])
def test_a_false_report_of_speed_truly_costs_the_energy_that_is_needed(kind):
    (fault,) = [fault for fault in CODE.pool if fault.type == kind]
    timed = TimedFault(fault.id, 60, 340, fault.values)

    outcome = ReferenceEngine(CODE, 1).evaluate((timed,))

    assert outcome.true[ENERGY] > 100
