import pytest

from mrsfi_runtime.analysis.fronts import FrontPoint, find_front
from mrsfi_runtime.analysis.summary import fitness_label
from mrsfi_runtime.analysis.tables import critical_table
from mrsfi_runtime.model.mission import COUNTED
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import Measure
from tests.support.campaigns import columns_of
from tests.support.measures import FLOWN_TWICE, GOALS, HIDING, MASKED, MEANS, missing
from tests.support.search import paper_mission, pool_of


@pytest.mark.parametrize("kind", COUNTED)
def test_a_front_is_over_the_counts_that_the_campaign_chose(kind):
    measure = Measure.of(CampaignSettings(violations=kind, goals=GOALS), paper_mission())
    counts = {getattr(each.outcome, kind)[:3:2]: each.index for each in reversed(HIDING)}

    front = find_front(measure, columns_of(HIDING, measure, GOALS), GOALS)

    names = {"missed": "time after failure", "masked": "undetected violations"}
    assert front.counts == names.get(kind, f"{kind} violations")
    assert {counts[point.violations] for point in front.points} == {
        point.evaluation for point in front.points
    }


def test_a_front_is_over_the_means_of_all_mission_seeds():
    measure = Measure.of(MEANS, paper_mission())
    front = find_front(measure, columns_of(FLOWN_TWICE, measure, GOALS), GOALS)

    assert front.counts == "believed violations, mean of 2 mission seeds"
    assert front.points == (FrontPoint(0, (450.0, 451.5)), FrontPoint(1, (500.5, 12.0)))


def test_the_printed_table_shows_the_measure_before_belief_and_truth():
    table = critical_table(Measure.of(MEANS, paper_mission()), pool_of(), FLOWN_TWICE[:1], 1)

    (row,) = table.rows
    goals = dict(zip(table.columns, row, strict=True))
    assert goals["violations"] == "mean believed\nbelieved\ntrue\nfailed from"
    assert goals["g1"] == "450.00\n900\n450\n775"
    assert goals["g2"] == "–\n0\n0\n–"


def test_the_printed_table_shows_the_time_missed_and_from_when_on():
    settings = CampaignSettings(violations="missed")
    measure = Measure.of(settings, paper_mission())

    table = critical_table(measure, pool_of(), [missing(0, (288, 0, 1000, 0, 0, 0))], 1)

    (row,) = table.rows
    goals = dict(zip(table.columns, row, strict=True))
    assert goals["violations"] == "missed\nbelieved\ntrue\nfailed from"
    assert goals["g1"] == "288\n0\n0\n712"
    assert goals["g2"] == "0\n0\n0\n–"
    assert goals["g3"] == "1000\n0\n0\n0"


@pytest.mark.parametrize(
    "settings",
    [
        MASKED,
        CampaignSettings(replications=3),
        CampaignSettings(violations="missed", goals=GOALS, fitness="focused"),
        CampaignSettings(fitness="mine:own", violations="true"),
    ],
)
def test_the_axis_of_fitness_says_what_is_counted(settings, approved):
    approved(fitness_label(settings, Measure.of(settings, paper_mission())))
