"""Every fault type alone, on the paper's mission and on one with tight margins."""

import pytest

from mrsfi_runtime.analysis.effects import audit
from mrsfi_runtime.engine.reference import ReferenceEngine
from tests.support.fault_types import FAULT_TYPES
from tests.support.world import code_of, paper_code
from tests.tiers import seeds, slow


@pytest.fixture(scope="module")
def paper():
    return audit(ReferenceEngine(paper_code(), 1), 100, 900)


@pytest.fixture(scope="module")
def tight():
    return audit(ReferenceEngine(code_of("tight_margins"), 1), 60, 180)


@slow
def test_every_fault_type_is_applied(paper, tight):
    for rows in (paper, tight):
        assert {row.fault.type for row in rows} == set(FAULT_TYPES)
        assert all(row.outcome.applied[0] > 0 for row in rows)


@slow
def test_on_the_paper_mission_a_type_that_changes_no_goal_has_a_reason(paper):
    assert all(any((*row.outcome.believed, *row.outcome.true)) != bool(row.reason) for row in paper)


def test_with_tight_margins_every_type_changes_a_goal(tight):
    assert [row.fault.type for row in tight if row.reason] == []


@pytest.mark.parametrize("seed", seeds(range(20)))
@pytest.mark.parametrize("mission", ["tight_margins", "tight_energy"])
def test_without_faults_a_mission_with_tight_margins_violates_no_goal(mission, seed):
    outcome = ReferenceEngine(code_of(mission), seed).evaluate(())

    assert not any((*outcome.believed, *outcome.true))
