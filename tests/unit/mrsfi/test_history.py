"""The course of a weakness over campaigns, by hand."""

import pytest

from mrsfi.history import Course, Sight, listed, sentence
from mrsfi_runtime.causes.mildest import GoalWeakness
from tests.support.weaknesses import weakness


def found(measure="true", *faults):
    faults = faults or ("f1",)
    return GoalWeakness(1, "g1", faults, (weakness("g1", measure, *faults),))


HAS, LIE = Sight(found()), Sight(found("believed"))
BREAKS, NOT, FEW, LOST = (
    Sight(None, *each) for each in ((True,), (False,), (False, "few"), (None, "no fault f1"))
)


def course(*sights):
    first = next((each.found for each in sights if each.found), found())
    return Course("Avoid (g1)", "KAL stops", first, sights)


@pytest.mark.parametrize(
    ("sights", "verdict", "marks", "remark"),
    [
        ((HAS, HAS), "stayed", "●●", ""),
        ((HAS, Sight(found(), breaks=False)), "stayed", "●●", "by other variants"),
        ((HAS, BREAKS), "stayed", "●○", "not found again, but its variant still has this effect"),
        ((BREAKS, HAS), "stayed", "○●", "found only now, but its variant had the effect before"),
        ((HAS, NOT), "went", "●–", ""),
        ((HAS, FEW), "went", "●~", "few"),
        ((NOT, HAS), "came", "–●", ""),
        ((HAS, LOST), "cannot be flown", "●?", "no fault f1"),
        ((HAS, LIE), "went", "●●", "a false alarm remains"),
        ((LIE, HAS), "came", "●●", "was only a false alarm before"),
        ((LIE, Sight(found(), breaks=True)), "stayed", "●●", ""),
        ((HAS, NOT, BREAKS), "stayed", "●–○", None),
        ((NOT, HAS, FEW), "came and went", "–●~", "few"),
    ],
)
def test_a_weakness_went_came_or_stayed_between_the_first_and_the_last_campaign(
    sights, verdict, marks, remark
):
    told = course(*sights)

    assert (told.verdict, told.marks) == (verdict, marks)
    assert remark is None or told.remark == remark
    assert told.as_json()["verdict"] == verdict
    assert told.is_constant == (not set(marks) - set("●○"))
    assert sights[told.since].found


def test_weaknesses_are_counted_by_verdict_and_listed_by_goal():
    pair = Course("Avoid (g1)", "", found("true", "f1", "f2"), (HAS, HAS))
    every = [course(HAS, NOT), pair, course(HAS, LOST), course(NOT, HAS, NOT)]

    assert sentence([course(HAS, HAS)]) == "Weaknesses: none went, none came, 1 stayed"
    assert sentence(every) == (
        "Weaknesses: 1 went, none came, 1 stayed; 1 came and went; "
        "1 weakness can no longer be flown"
    )
    assert listed(every[:2]) == "Avoid (g1): f1, f1 and f2"
