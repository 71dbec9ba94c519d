import pytest

from mrsfi_runtime.causes.cause_set import Question, floor
from mrsfi_runtime.causes.explanation import goal_causes
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
        (lambda flown: (10 * ("c" in flown), 0), ("bystander", "bystander", "sole", "bystander")),
        (
            lambda flown: (10 * ({"b", "d"} <= flown), 0),
            ("bystander", "joint", "bystander", "joint"),
        ),
        (
            lambda flown: (10 * bool({"a", "d"} & flown), 0),
            ("sole", "bystander", "bystander", "redundant"),
        ),
        (
            lambda flown: (10 * ("a" in flown and bool({"b", "c"} & flown)), 0),
            ("joint", "joint", "redundant", "bystander"),
        ),
        (
            lambda flown: (10 * ("a" in flown) + 90 * ({"a"} == flown - {"c", "d"}), 10),
            ("sole", "masking", "bystander", "bystander"),
        ),
        (
            lambda flown: (0, 100 * ("a" in flown) + 6 * ("a" in flown and "d" not in flown)),
            ("sole", "bystander", "bystander", "masking"),
        ),
        (
            lambda flown: (0, 100 * ("a" in flown) + 5 * ("a" in flown and "d" not in flown)),
            ("sole", "bystander", "bystander", "bystander"),
        ),
        (
            lambda flown: (10 * ("a" in flown and "b" not in flown), 0),
            ("lesser", "masking", "bystander", "bystander"),
        ),
        (
            lambda flown: (max(90 * ("a" in flown), 9 * ("b" in flown)), 4),
            ("sole", "lesser", "bystander", "bystander"),
        ),
        (lambda flown: (0, 0), ("bystander",) * 4),
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
