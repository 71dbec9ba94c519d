"""The paper's mission as generated, flown by the reference engine."""

import pytest

from mrsfi_runtime.engine.reference import ReferenceEngine
from tests.support.world import paper_code
from tests.tiers import seeds

TARGETS = {"g4": 250, "g5": 400, "g6": 500}


@pytest.mark.parametrize("seed", seeds(range(20)))
def test_without_faults_no_goal_is_violated_and_every_sample_target_reached(seed):
    code = paper_code()

    outcome = ReferenceEngine(code, seed).evaluate(())

    assert outcome.believed == (0,) * 6
    assert outcome.true == (0,) * 6
    samples = dict(zip(code.mission.goal_ids, outcome.samples, strict=True))
    assert all(samples[goal] >= target for goal, target in TARGETS.items())


def test_another_mission_seed_flies_another_flight():
    code = paper_code()

    digests = {ReferenceEngine(code, seed).evaluate(()).digest for seed in range(5)}

    assert len(digests) == 5
