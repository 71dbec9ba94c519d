from dataclasses import replace

import pytest

from mrsfi_runtime.analysis.tables import goal_table, in_words
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import Measure, ticks
from tests.support.measures import MEANS
from tests.support.search import outcome_of, paper_mission


@pytest.mark.parametrize(
    ("settings", "goals"),
    [(CampaignSettings(), ("g1", "g9")), (MEANS, ("g1", "g2"))],
)
def test_goals_that_a_record_says_nothing_of_are_refused(settings, goals, refused):
    with refused(UsageError):
        Measure.of(settings, paper_mission()).require(goals)


@pytest.mark.parametrize(
    "settings",
    [
        CampaignSettings(),
        CampaignSettings(violations="missed"),
        replace(MEANS, violations="true"),
    ],
)
def test_a_measure_says_what_it_counts(settings, approved):
    approved(Measure.of(settings, paper_mission()))


@pytest.mark.parametrize(("missed", "told"), [((0, 3), ("–", "7")), ((10, 1), ("0", "9"))])
def test_a_goal_is_missed_from_a_tick_on_or_not(missed, told):
    mission = replace(paper_mission(), duration=10, goals=paper_mission().goals[:2])

    table = goal_table("", mission, replace(outcome_of(0, 0), missed=missed))

    place = table.columns.index("missed from")
    assert tuple(in_words(row[place]) for row in table.rows) == told


def test_a_count_is_whole_and_a_mean_of_counts_is_not():
    assert (ticks(3), ticks(2.5)) == ("3", "2.50")
