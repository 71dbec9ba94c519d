"""Tables: of all evaluations, patterns, trends, and what is said of goals and faults."""

import math
import tracemalloc
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.analysis.fronts import Columns, _merged
from mrsfi_runtime.analysis.summary import summarise
from mrsfi_runtime.analysis.tables import (
    MOST_LISTED,
    GenerationFitness,
    Table,
    Trend,
    as_csv,
    evaluations_table,
    every,
    find_patterns,
    find_trend,
    nearest_in_words,
    plain,
    to_markdown,
    to_page,
)
from mrsfi_runtime.analysis.weaknesses import (
    GoalVerdict,
    State,
    deed,
    detection,
    headline,
    owner_of,
    verdicts,
)
from mrsfi_runtime.causes.cause_set import Column
from mrsfi_runtime.causes.harvest import Harvest
from mrsfi_runtime.causes.mildest import goal_weaknesses
from mrsfi_runtime.causes.weakness import Detection, Known, Yardstick
from mrsfi_runtime.errors import RecordError, SpecificationError
from mrsfi_runtime.model.fault_types import Mode, Units
from mrsfi_runtime.model.faults import COSTS, Fault, FaultPool, Specification, TimedFault
from mrsfi_runtime.record.database import fault_texts, specification_text
from mrsfi_runtime.record.observers import named_faults
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore, Generation, Measure
from mrsfi_runtime.search.space import SearchSpace
from tests.support.campaigns import columns_of, evaluation, store_of
from tests.support.fault_types import FAULT_TYPES
from tests.support.measures import FLOWN_TWICE, GOALS, HIDING, MASKED, MEANS
from tests.support.search import outcome_of, paper_mission, pool_of
from tests.support.weaknesses import weakness
from tests.support.world import paper_code
from tests.tiers import slow

MISSION = paper_mission()
MEASURE = Measure.of(CampaignSettings(), MISSION)
ODD = ("f1", "f2", 'f"3', "f\\4", "f]],[5", '["f6,', "é")
TIMED = st.builds(
    TimedFault,
    st.sampled_from(ODD),
    st.integers(0, 2),
    st.integers(3, 4),
    st.lists(st.sampled_from([0.0, -0.0, -0.05, 1e-300, 200.0, 0.1]), max_size=2).map(tuple),
)
SPECIFICATIONS = st.lists(TIMED, max_size=4).map(tuple)
POOL = FaultPool(
    "fs",
    (
        Fault("f1", FAULT_TYPES["ZeroSpeed"], "m1"),
        Fault("f2", FAULT_TYPES["StopRobot"], "r1"),
        Fault("f3", FAULT_TYPES["ZeroSpeed"], "m2"),
        Fault("f4", FAULT_TYPES["StartRobot"], "r1"),
    ),
)
CODE = paper_code()


@given(SPECIFICATIONS, SPECIFICATIONS)
def test_the_texts_of_timed_faults_tell_specifications_apart(one, other):
    (faults, texts), (_, others) = (fault_texts(specification_text(each)) for each in (one, other))

    assert faults == [timed.fault for timed in one]
    assert (sorted(texts) == sorted(others)) == (sorted(one) == sorted(other))


@given(st.lists(SPECIFICATIONS, min_size=1, max_size=6), st.integers(1, 3))
def test_the_first_of_each_specification_is_distinct_and_its_faults_were_tried(found, n_rounds):
    flown = [*found, *[specification[::-1] for _ in range(n_rounds) for specification in found]]
    first: dict[Specification, int] = {}
    for index, specification in enumerate(flown):
        first.setdefault(tuple(sorted(specification)), index)

    columns = columns_of(
        [evaluation(i, (1,), specification=each) for i, each in enumerate(flown)], MEASURE
    )

    assert columns.distinct.tolist() == sorted(first.values())
    assert columns.tried == Counter(timed.fault for each in first for timed in each)


def test_the_first_of_a_specification_is_known_thousands_of_evaluations_later():
    found = [evaluation(i, (i % 7,)) for i in range(4_500)]
    again = replace(found[3], index=4_500)

    columns = columns_of([*found, again], MEASURE)

    assert len(columns) == 4_501
    assert columns.distinct.tolist() == list(range(4_500))
    assert columns.distinct_among([4_500, 9, 3, 9]).tolist() == [3, 9]


@pytest.mark.parametrize(
    ("settings", "found"),
    [(CampaignSettings(goals=GOALS), HIDING), (MASKED, HIDING), (MEANS, FLOWN_TWICE)],
)
def test_violations_are_those_that_the_measure_has(settings, found):
    measure = Measure.of(settings, MISSION)

    columns = columns_of(found, measure, ("g3", "g1"))

    expected = [[measure.by_goal(each)[goal] for goal in GOALS] for each in found]
    assert columns.of(GOALS).tolist() == expected


@pytest.mark.parametrize("minimised", ["faults", "fault_ticks"])
def test_costs_are_those_that_the_measure_has(minimised):
    measure = Measure.of(CampaignSettings(minimise=minimised), MISSION)
    sizes = [[TimedFault("f8", 9 * k, 9 * k + n, (1.0,)) for k in range(n)] for n in range(4)]
    found = [evaluation(n, (1,), specification=tuple(each)) for n, each in enumerate(sizes)]

    cost = COSTS[minimised]
    expected = [cost(each.specification, MISSION.duration) for each in found]
    assert columns_of(found, measure).costs.tolist() == expected


@pytest.mark.parametrize(
    "change",
    [
        "UPDATE evaluation SET specification = '[[\"f1\",1]]' WHERE idx = 1",
        "UPDATE evaluation SET fitness = '[null]' WHERE idx = 1",
        "UPDATE evaluation SET fitness = '[]' WHERE idx = 1",
        "UPDATE evaluation SET believed = '[1.5,0,0,0,0,0]' WHERE idx = 1",
        "UPDATE evaluation SET believed = '[1]' WHERE idx = 1",
        "DELETE FROM evaluation WHERE idx = 1",
    ],
)
def test_a_damaged_row_is_refused(change):
    with store_of([evaluation(i, (1,) * 6) for i in range(3)]) as store:
        store._connection.execute(change)

        with pytest.raises(RecordError):
            Columns.read(store, MEASURE, ("g1",))


def test_a_fault_that_the_pool_does_not_have_is_refused(refused):
    odd = evaluation(0, (1,) * 6, specification=(TimedFault("f99", 0, 1),))

    with store_of([odd]) as store, refused(SpecificationError):
        summarise(Path("run"), store, MISSION, pool_of(), None)


def peak(work: Callable[[], object]) -> int:
    """Return the most bytes that some work holds beyond what was held before."""
    tracemalloc.start()
    work()
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return most


@slow
def test_memory_grows_by_some_hundred_bytes_an_evaluation():
    sizes = (10_000, 40_000)  # of less, when garbage is collected decides
    peaks = []
    for n in sizes:
        found = (evaluation(i, (i % 9,) * 6) for i in range(n))
        with store_of(found, CampaignSettings(goals=GOALS)) as store:
            arguments = Path("run"), store, MISSION, pool_of(), "g1:g3=1:1"
            peaks.append(peak(partial(summarise, *arguments)))

    grown = (peaks[1] - peaks[0]) / (sizes[1] - sizes[0])
    assert grown < 300


def rows_of(store: CampaignStore, step: int) -> list[object]:
    return [row[0] for row in evaluations_table("", store.flown(step), MEASURE).rows]


def test_a_table_lists_every_so_manyth_evaluation_across_all_that_is_read_at_once():
    with store_of(evaluation(i, (1,) * 6) for i in range(4_100)) as store:
        assert rows_of(store, 1) == list(range(4_100))
        assert rows_of(store, 2) == list(range(0, 4_100, 2))
        assert rows_of(store, 7) == list(range(0, 4_100, 7))


@pytest.mark.parametrize(
    ("n_evaluations", "step"),
    [(0, 1), (9_999, 1), (100_000, 1), (100_001, 2), (200_000, 2), (1_000_000, 10)],
)
def test_at_most_a_hundred_thousand_are_listed(n_evaluations, step):
    assert every(n_evaluations, MOST_LISTED) == step


@pytest.mark.parametrize(
    ("known", "keys", "places"),
    [([], [4, 3, 3], [0, 1]), ([3], [4, 5], [0, 1]), ([3, 5], [5, 4, 4], [1]), ([7], [7], [])],
)
def test_keys_are_new_where_none_before_is_the_same(known, keys, places):
    known, keys = (np.array(each, np.uint64) for each in (known, keys))

    met, new = _merged(known, keys)

    assert new == places
    assert met.tolist() == sorted({*known.tolist(), *keys.tolist()})


def timed(*faults: str) -> tuple[TimedFault, ...]:
    return tuple(TimedFault(fault, 10 * i, 10 * i + 5) for i, fault in enumerate(faults))


def counted(specifications: list[Specification]) -> Counter[str]:
    return Counter(each.fault for specification in specifications for each in specification)


def test_occurrences_stand_beside_what_the_shares_would_give():
    top = [timed("f1", "f3", "f2"), timed("f1")]
    campaign = [*top, timed("f2", "f2", "f2", "f4")]

    zero, stop, start = find_patterns(top, counted(campaign), POOL)

    assert (zero.type, zero.n_occurrences, zero.n_specifications) == ("ZeroSpeed", 3, 2)
    assert (zero.share, zero.pool_share, zero.campaign_share) == (0.75, 0.5, 0.375)
    assert (zero.pool_expected, zero.campaign_expected) == (2.0, 1.5)
    assert (stop.type, stop.n_occurrences, stop.n_specifications) == ("StopRobot", 1, 1)
    assert (start.type, start.n_occurrences, start.campaign_expected) == ("StartRobot", 0, 0.5)


def test_expected_counts_add_up_to_the_occurrences():
    top = [timed("f1", "f3", "f2", "f2"), timed("f4", "f4", "f4")]

    patterns = find_patterns(top, counted(top), POOL)

    assert sum(pattern.n_occurrences for pattern in patterns) == 7
    assert sum(pattern.pool_expected for pattern in patterns) == pytest.approx(7)
    assert sum(pattern.campaign_expected for pattern in patterns) == pytest.approx(7)


def test_equal_occurrences_stand_by_name():
    patterns = find_patterns([timed("f4", "f2", "f1")], {}, POOL)

    assert [pattern.type for pattern in patterns] == ["StartRobot", "StopRobot", "ZeroSpeed"]


def test_no_specifications_give_zeros():
    patterns = find_patterns([], {}, POOL)

    assert {(p.n_occurrences, p.share, p.pool_expected) for p in patterns} == {(0, 0.0, 0.0)}


def test_no_name_is_a_formula_in_a_spreadsheet():
    names = ("=1+1", "+1", "-x", "@SUM(A1)", "\tx", "a=b", "", "–")

    rows = as_csv([(name, -1.5) for name in names]).decode()

    told = ("'=1+1", "'+1", "'-x", "'@SUM(A1)", "'\tx", "a=b", "", "–")
    assert rows == "".join(f"{name},-1.5\n" for name in told)


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("\x1b]0;title\x07a\x1b[31m", r"\x1b]0;title\x07a\x1b[31m"),
        ("a\u202eb\udcff", r"a\u202eb\udcff"),
        ("a\n# b\t|c<d", r"a # b \|c&lt;d"),
        ("Überwachung – grün", "Überwachung – grün"),
    ],
)
def test_no_name_steers_a_terminal_or_breaks_out_of_its_line(name, told):
    assert plain(name) == told


def test_people_read_rounded_numbers_dashes_and_all_lines_of_a_cell():
    table = Table("T", ("g|1", "two\nlines"), [(1.005, None), (0.03333, "a\nb"), (12, "c")])

    assert to_markdown(table).splitlines() == [
        "| g\\|1 | two / lines |",
        "| --- | --- |",
        "| 1.00 | – |",
        "| 0.0333 | a / b |",
        "| 12 | c |",
    ]


def test_the_page_and_a_spreadsheet_get_numbers_as_they_are():
    table = Table("T", ("a", "b"), [(0.1 + 0.2, None)])

    assert to_page(table) == {"title": "T", "header": ["a", "b"], "rows": [(0.1 + 0.2, None)]}
    assert as_csv(table.lines) == b"a,b\n0.30000000000000004,\n"


def trend_of(*means: float) -> Trend:
    return find_trend(
        [
            Generation(i, {"mean": m, "std": 1.0, "min": m - 1, "max": m + 2}, (), "[]")
            for i, m in enumerate(means)
        ]
    )


def test_each_generation_keeps_its_numbers():
    assert trend_of(4.0, 6.0).generations == (
        GenerationFitness(generation=0, mean=4.0, std=1.0, best=6.0, worst=3.0),
        GenerationFitness(generation=1, mean=6.0, std=1.0, best=8.0, worst=5.0),
    )


def test_a_line_is_found_again():
    trend = trend_of(*(3.0 + 0.5 * x for x in range(12)))

    assert trend.slope == pytest.approx(0.5)
    assert trend.intercept == pytest.approx(3.0)


@pytest.mark.parametrize("means", [(), (5.0,), (5.0, 5.0, 5.0)])
def test_without_any_change_there_is_no_trend(means):
    trend = trend_of(*means)

    assert trend.slope == 0.0
    assert trend.intercept == (means[0] if means else 0.0)


def said(fault, off=None):
    timed = TimedFault(fault, 10, 19, CODE.pool[fault].values)
    (named,) = named_faults(CODE.mission, CODE.pool, (timed,))
    return deed(CODE.mission, named, off)


@pytest.mark.parametrize(
    "fault", [f"f{number}" for number in (1, 2, 3, 4, 5, 8, 9, 10, 12, 15, 18, 20, 25, 26, 30)]
)
def test_what_a_fault_does_is_said_in_names(fault, approved):
    approved(said(fault))


def test_how_far_a_fixed_value_is_off_stands_in_the_place_of_the_value(approved):
    approved([said("f11"), said("f11", "51 off"), said("f11", "")])


def test_what_a_fault_does_is_said_in_the_units_of_the_model(approved):
    mission = replace(CODE.mission, distance_unit="m", time_unit="s", energy_unit="J")
    told = []
    for fault in ("f8", "f9", "f10", "f18"):
        timed = TimedFault(fault, 10, 19, CODE.pool[fault].values)
        (named,) = named_faults(mission, CODE.pool, (timed,))
        told.append(deed(mission, named))

    approved(told)


def test_every_mode_has_its_words():
    fault = CODE.pool["f11"]
    for mode in Mode:
        kind = replace(fault.kind, mode=mode)
        struck = replace(fault, kind=kind)
        assert owner_of(CODE.mission, struck)[0] == (2, "KAL (r3)")
        (named,) = named_faults(CODE.mission, CODE.pool, (TimedFault("f11", 1, 2, (1.0,) * 3),))
        words = deed(CODE.mission, replace(named, fault=struck))
        assert words.startswith(("KAL's position is ", "KAL's reported position is frozen"))


@pytest.mark.parametrize(
    ("fault", "changed", "told"),
    [
        ("f3", {}, ((2, "KAL (r3)"), "gps position off")),
        ("f26", {}, ((0, "LEN (r1)"), "stopped")),
        ("f19", {}, ((3, "map"), "o2 random")),
        ("f7", {"target": "m1"}, ((3, "map"), "too low")),  # a message that carries no speed
    ],
)
def test_a_fault_is_told_by_whom_it_strikes_and_what_it_does(fault, changed, told):
    assert owner_of(CODE.mission, replace(CODE.pool[fault], **changed)) == told


def test_a_goal_whose_name_others_have_is_told_by_its_robots():
    goals = CODE.mission.goals

    assert CODE.mission.name_of(goals[0]) == "AvoidCollision"
    assert CODE.mission.name_of(goals[3]) == "GatherSamples · JEN"
    assert CODE.mission.name_of(replace(goals[0], name="")) == "g1"


@pytest.mark.parametrize(
    ("measure", "late"),
    [
        ("missed", (0, 1)),
        ("true", (7, 60, 0)),
        ("true", (0,)),
        ("missed", (0, 0)),
        ("true", (0, 5, math.inf, math.inf)),
        ("true", ()),
        ("believed", ()),
    ],
)
def test_the_worst_of_all_variants_is_told_and_in_how_many_it_is_so(measure, late, approved):
    found = Detection.of(dict(enumerate(late)))

    (only,) = goal_weaknesses([weakness("g1", measure, "f11", detection=found)])

    approved(detection(only, Units()))


@pytest.mark.parametrize(
    ("without", "measure"),
    [(0, "believed"), (3, "believed"), (3, "true")],
)
def test_what_breaks_without_faults_is_not_told_to_break_falsely_by_one(without, measure, approved):
    found = (weakness("g3", measure, "f4"),)
    yardstick = Yardstick((Column("g3", "true"),), (without,))
    known = Harvest(Known(SearchSpace.of(CODE.mission, CODE.pool)), found, 0, {}, yardstick)

    told = verdicts(CODE.mission, CODE.pool, known)

    (said,) = (each.in_full for each in told if each.goal == "g3")
    approved(said)
    bounds = {each.bound for each in told}
    (bound,) = bounds  # nothing was drawn
    assert bound.startswith("no bound yet on other random specifications; one of 10 % needs at ")


def test_of_two_goals_in_the_same_state_the_more_severe_one_comes_first():
    severities = {"g3": 2, "g6": 9}
    goals = tuple(replace(goal, severity=severities.get(goal.id, 0)) for goal in CODE.mission.goals)
    known = Harvest(Known(SearchSpace.of(CODE.mission, CODE.pool)), (), 0, {}, None)

    told = verdicts(replace(CODE.mission, goals=goals), CODE.pool, known)

    assert [(each.goal, each.severity) for each in told[:3]] == [("g6", 9), ("g3", 2), ("g1", 0)]
    assert told[0].in_full == f"{told[0].label} {told[0].words}. Severity 9 of 10"


def verdict(goal, state, *faults):
    least = goal_weaknesses([weakness(goal, "true", *faults)])[0] if faults else None
    return GoalVerdict(goal, goal, goal, state, least, 0, "", "", (), "")


HOLDS = verdict("g9", State.HOLDS)


ALONE = verdict("g1", State.FAILS, "f1")


JOINTLY = verdict("g2", State.FAILS, "f1", "f2")


VIOLATED = verdict("g3", State.VIOLATED, "f3")


@pytest.mark.parametrize(
    "found",
    [
        [HOLDS],
        [ALONE, HOLDS],
        [ALONE] * 3,
        [ALONE, JOINTLY, HOLDS],
        [ALONE, VIOLATED, HOLDS],
        [JOINTLY, HOLDS],
        [HOLDS, replace(HOLDS, is_unexplained=True)],
    ],
)
def test_the_headline_says_how_many_goals_break_and_under_how_many_faults(found, approved):
    approved(headline(found))


def test_what_held_was_neither_violated_nor_missed_and_has_a_margin(approved):
    outcome = replace(
        outcome_of(*(0,) * 6),
        true=(0, 3, 0, 0, 0, 0),
        missed=(0, 0, 9, 0, 0, 0),
        margins=((1.5, 7), (-0.5, 8), (2.0, 9), None, (30.0, 99), None),
    )

    told = nearest_in_words(CODE.mission, outcome)

    approved(told)
    approved(nearest_in_words(CODE.mission, replace(outcome, margins=None)))
