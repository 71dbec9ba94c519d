"""The course of a weakness over campaigns, by hand."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from mrsfi.history import Course, History, Searched, Sight, counting, listed, page, sentence
from mrsfi_runtime.causes.mildest import GoalWeakness
from mrsfi_runtime.record.decisions import Cause
from mrsfi_runtime.record.engine_settings import Manifest
from mrsfi_runtime.record.settings import CampaignSettings
from tests.support.search import paper_mission
from tests.support.weaknesses import weakness


def found(measure="true", *faults):
    faults = faults or ("f1",)
    return GoalWeakness(1, "g1", faults, (weakness("g1", measure, *faults),))


HAS, LIE = Sight("●", 1), Sight("–", remark="only a false alarm in b")
BREAKS, NOT, LOST = Sight("○"), Sight("–"), Sight("?", remark="no fault f1")


def course(*sights):
    return Course("Avoid (g1)", "KAL stops", found(), sights)


@pytest.mark.parametrize(
    ("sights", "verdict", "marks", "remark"),
    [
        ((HAS, HAS), "stayed", "●●", ""),
        ((HAS, BREAKS), "stayed", "●○", ""),
        ((BREAKS, HAS), "stayed", "○●", ""),
        ((HAS, NOT), "went", "●–", ""),
        ((NOT, HAS), "came", "–●", ""),
        ((HAS, LOST), "cannot be flown", "●?", "no fault f1"),
        ((HAS, LIE), "went", "●–", "only a false alarm in b"),
        ((LIE, HAS), "came", "–●", "only a false alarm in b"),
        ((HAS, NOT, BREAKS), "stayed", "●–○", ""),
        ((NOT, HAS, NOT), "came and went", "–●–", ""),
    ],
)
def test_a_weakness_went_came_or_stayed_between_the_first_and_the_last_campaign(
    sights, verdict, marks, remark
):
    told = course(*sights)

    assert (told.verdict, told.marks, told.remark) == (verdict, marks, remark)
    assert told.as_json()["verdict"] == verdict
    assert told.is_constant == (not set(marks) - set("●○"))


def test_a_false_alarm_does_not_count_where_another_campaign_found_a_true_violation():
    here, there = Cause("g1", ("f1",)), Cause("g2", ("f1",))
    true, alarm = found(), found("believed")

    assert counting([{here: true, there: alarm}, {here: alarm, there: alarm}]) == [
        {here: true, there: alarm},
        {there: alarm},
    ]


def test_weaknesses_are_counted_by_verdict_and_listed_by_goal():
    pair = Course("Avoid (g1)", "", found("true", "f1", "f2"), (HAS, HAS))
    every = [course(HAS, NOT), pair, course(HAS, LOST), course(NOT, HAS, NOT)]

    assert sentence([course(HAS, HAS)]) == "Weaknesses: none went, none came, 1 stayed"
    assert sentence(every) == (
        "Weaknesses: 1 went, none came, 1 stayed; 1 came and went; "
        "1 weakness can no longer be flown"
    )
    assert listed(every[:2]) == "Avoid (g1): f1, f1 and f2"


def searched(name, setup, seed, *sets):
    store = SimpleNamespace(settings=CampaignSettings(seed=seed))
    known = [found("true", *faults) for faults in sets]
    return Searched(
        Path(name),
        Manifest(created="2026-11-28T09:00:00+00:00", commit="3f2a1c9d" * 5, is_edited=True),
        SimpleNamespace(mission=paper_mission(), store=store),
        setup,
        100,
        {Cause(each.goal, each.faults): each for each in known},
        tuple(each.shown for each in known),
    )


def test_numbers_are_estimated_from_campaigns_that_differ_only_in_the_search_seed():
    runs = (
        searched("a", "first", 1, ("f1",), ("f2",)),
        searched("b", "first", 2, ("f1",), ("f3",)),
        searched("c", "second", 1, ("f1",)),
        searched("d", "second", 1, ("f2",)),
    )

    counts = History("m", runs, ()).goals["g1"]

    assert [n for n, _ in counts] == [2, 2, 1, 1]
    assert [each and (each.n_campaigns, each.total.n_found) for _, each in counts] == [
        (2, 3),
        (2, 3),
        None,
        None,
    ]


def test_a_page_has_a_line_for_each_campaign_and_a_column_for_each_weakness():
    runs = searched("runs/a", "", 1, ("f1",)), searched("runs/b", "", 1)

    matrix, campaigns, *_ = page(History("m", runs, (course(HAS, NOT),)))["tables"]
    (empty, *_) = page(History("m", runs[1:], ()))["tables"]

    assert matrix["header"] == ["campaign", "g1: f1"]
    assert matrix["rows"] == [("a", "●"), ("b", "–")]
    assert empty["rows"] == [("b",)]
    assert campaigns["rows"][1] == ("2", "b", "2026-11-28", "3f2a1c9d3f2a, edited", 100, 0, 1, 0)
