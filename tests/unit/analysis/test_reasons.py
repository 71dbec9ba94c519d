"""Of all that a flight can show beside its twin, exactly one reason is true, and is told."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.analysis.reasons import (
    REASONS,
    Comparison,
    Differences,
    Twin,
    _at_least,
    in_words,
)
from mrsfi_runtime.api import AvoidCollision, SufficientEnergy
from mrsfi_runtime.kernel.flight import no_verdicts
from mrsfi_runtime.kernel.goal_tasks.table import OwnTask
from mrsfi_runtime.model.mission import GoalTask
from tests.support.world import MEMBERS, mission, state
from tests.tiers import law

NUMBERS = st.integers(0, 3)


@given(*[NUMBERS] * 6)
@law(300)
def test_exactly_one_reason_is_true_of_a_flight(n_targets, applied, true, believed, sent, verdicts):
    differs = true or believed or sent
    found = Differences(
        n_targets, applied, true, believed, sent, verdicts if differs else 0, {}, frozenset()
    )

    assert sum(reason.holds(found) for reason in REASONS.values()) == 1


@given(st.floats(1e-9, 1e9))
@law(300)
def test_what_is_left_is_never_said_to_be_more_and_hardly_less(left):
    said = Fraction(_at_least(left).replace(",", ""))

    assert said <= Fraction(left)
    assert said >= Fraction(left) * Fraction(99, 100)


def _told(task: GoalTask, *, is_violated: bool = False, **believed: float) -> str:
    """Return the reason of a tick in which robot a is believed otherwise than in the twin."""
    verdicts = no_verdicts(1)
    verdicts.is_believed[0] = int(is_violated)
    twin = Twin()
    twin(state(task), state(task), verdicts)
    belief = state(task)
    for name, value in believed.items():
        setattr(belief.robots[0], name, value)
    comparison = Comparison(twin)
    comparison(state(task), belief, verdicts)
    return in_words(mission(task), [comparison.differences(n_targets=1, applied=1)])


@pytest.mark.parametrize(
    ("task", "believed", "expected"),
    [
        (AvoidCollision(MEMBERS), {"x": 52.5}, "left to limits: g1 45.5 distance units"),
        (SufficientEnergy(), {"x": 52.5}, "no goal is nearer to a limit, or farther from it"),
        (
            SufficientEnergy(),
            {"energy": 7000.0},
            "left to limits: g1 3,832 energy units",
        ),  # 99 × 32
        (OwnTask("Escort"), {"x": 52.5}, "judged alike: g1"),
    ],
)
def test_a_reason_tells_what_was_left_to_limits_that_a_check_is_known_to_have(
    task, believed, expected
):
    assert _told(task, **believed) == f"belief differs at 1 tick, no command does; {expected}"


@pytest.mark.parametrize(("x", "is_violated"), [(99.0, False), (52.5, True), (99.0, True)])
def test_nothing_is_said_of_limits_that_the_check_did_not_judge_by_or_that_are_exceeded(
    x, is_violated
):
    assert _told(AvoidCollision(MEMBERS), is_violated=is_violated, x=x).endswith(
        "; judged alike: g1"
    )
