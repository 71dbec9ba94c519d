"""The result of a requirement: the gravest of the goals that stand for it."""

from dataclasses import replace

import pytest

from mrsfi.explaining import results
from mrsfi_runtime.causes.cause_set import Column
from mrsfi_runtime.causes.harvest import Harvest
from mrsfi_runtime.causes.mildest import goal_weaknesses
from mrsfi_runtime.causes.weakness import Detection, Known, Yardstick
from mrsfi_runtime.search.space import SearchSpace
from tests.support.weaknesses import weakness
from tests.support.world import paper_code

CODE = paper_code()
SPACE = SearchSpace.of(CODE.mission, CODE.pool)


def detection(worst):
    return Detection(worst, 2, 2 * (worst == "never"), 2 * (worst == "late"), 5)


def of(*found, required=None, yardstick=None):
    """Return the results if goals g2 and g5 stand for R1, g5 alone for R2, none for others."""
    required = required or {"g2": ("R1",), "g5": ("R1", "R2")}
    goals = (replace(each, requirements=required.get(each.id, ())) for each in CODE.mission.goals)
    mission = replace(CODE.mission, goals=tuple(goals))
    return results(mission, CODE.pool, Harvest(Known(SPACE), found, 0, {}, yardstick))


def test_without_a_true_break_none_was_found():
    assert of(weakness("g2", "believed", "f1"), weakness("g1", "true", "f2")) == {
        "R1": "none found",
        "R2": "none found",
    }


@pytest.mark.parametrize(
    ("worst", "told"), [("never", "undetected"), ("late", "late"), ("in time", "in time")]
)
def test_a_break_counts_by_the_detection_of_the_campaign(worst, told):
    found = weakness("g5", "true", "f1", detection=detection(worst))

    assert of(found) == {"R1": told, "R2": told}


def test_the_gravest_of_all_weaknesses_of_all_goals_counts():
    found = [
        weakness("g2", "missed", "f1", detection=detection("never")),
        weakness("g5", "true", "f2", detection=detection("in time")),
        weakness("g5", "missed", "f3", detection=detection("late")),
    ]

    assert len(goal_weaknesses(found)) == 3
    assert of(*found) == {"R1": "undetected", "R2": "late"}


def test_a_break_whose_detection_is_not_recorded_is_said_to_be_one():
    assert of(weakness("g5", "true", "f1")) == dict.fromkeys(("R1", "R2"), "detection not recorded")


def test_a_goal_that_is_violated_without_faults_is_no_clean_one():
    yardstick = Yardstick((Column("g5", "true"),), (3.0,))

    assert of(yardstick=yardstick) == dict.fromkeys(("R1", "R2"), "violated without faults")
