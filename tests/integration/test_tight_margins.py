"""A mission in which nothing goes to waste: it just flies, and each fault of its pool harms it."""

import pytest

from mrsfi_runtime.engine.reference import ReferenceEngine
from mrsfi_runtime.model.faults import TimedFault
from tests.support.fault_types import FAULT_TYPES
from tests.support.world import code_of
from tests.tiers import seeds


def test_every_fault_type_alone_violates_a_goal():
    code = code_of("tight_margins")
    engine = ReferenceEngine(code, 1)

    outcomes = {
        fault.type: engine.evaluate((TimedFault(fault.id, 60, 180, fault.values),))
        for fault in code.pool
    }

    assert {*outcomes} == {*FAULT_TYPES}
    assert [kind for kind, each in outcomes.items() if not any(each.believed + each.true)] == []


@pytest.mark.parametrize("seed", seeds(range(20)))
@pytest.mark.parametrize("mission", ["tight_margins", "tight_energy"])
def test_without_faults_no_goal_is_violated(mission, seed):
    outcome = ReferenceEngine(code_of(mission), seed).evaluate(())

    assert not any(outcome.believed + outcome.true)
