import pytest

from mrsfi_runtime.causes.cause_set import Question, floor
from mrsfi_runtime.causes.labels import (
    BYSTANDER,
    JOINT,
    LESSER,
    MASKING,
    REDUNDANT,
    SOLE,
    goal_causes,
)
from tests.support.planted import faults, flights


def labels(violations, names="abcd", *, goal="g1"):
    """Return what each fault is to goal g1, beside a goal that every fault alone violates."""
    flown = flights({"g1": violations, "g2": lambda flown: (5 * len(flown), 5)})
    specification = faults(names)
    counts = flown.counts(specification)
    columns = [k for k, column in enumerate(flown.columns) if column.goal == goal]
    asked = Question(flown, specification, floor(counts, 0.95, columns))
    return goal_causes(asked, goal).labels


@pytest.mark.parametrize(
    ("violations", "expected"),
    [
        (lambda flown: (10 * ("c" in flown), 0), (BYSTANDER, BYSTANDER, SOLE, BYSTANDER)),
        (lambda flown: (10 * ({"b", "d"} <= flown), 0), (BYSTANDER, JOINT, BYSTANDER, JOINT)),
        (lambda flown: (10 * bool({"a", "d"} & flown), 0), (SOLE, BYSTANDER, BYSTANDER, REDUNDANT)),
        (
            lambda flown: (10 * ("a" in flown and bool({"b", "c"} & flown)), 0),
            (JOINT, JOINT, REDUNDANT, BYSTANDER),
        ),
        (
            lambda flown: (10 * ("a" in flown) + 90 * ({"a"} == flown - {"c", "d"}), 10),
            (SOLE, MASKING, BYSTANDER, BYSTANDER),
        ),
        (
            lambda flown: (0, 100 * ("a" in flown) + 6 * ("a" in flown and "d" not in flown)),
            (SOLE, BYSTANDER, BYSTANDER, MASKING),
        ),
        (
            lambda flown: (0, 100 * ("a" in flown) + 5 * ("a" in flown and "d" not in flown)),
            (SOLE, BYSTANDER, BYSTANDER, BYSTANDER),
        ),
        (
            lambda flown: (10 * ("a" in flown and "b" not in flown), 0),
            (LESSER, MASKING, BYSTANDER, BYSTANDER),
        ),
        (
            lambda flown: (max(90 * ("a" in flown), 9 * ("b" in flown)), 4),
            (SOLE, LESSER, BYSTANDER, BYSTANDER),
        ),
        (lambda flown: (0, 0), (BYSTANDER,) * 4),
    ],
    ids=[
        "one alone",
        "two together",
        "either of two",
        "one with either of two",
        "one hides what another does",
        "of true violations",
        "a rise of a twentieth is none",
        "one hides all that another does",
        "one does less than another",
        "nothing",
    ],
)
def test_a_fault_is_labelled_by_what_it_does_to_the_goal(violations, expected):
    assert labels(violations) == expected
