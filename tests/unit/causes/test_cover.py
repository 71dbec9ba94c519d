from collections.abc import Iterator
from hashlib import sha256

import pytest

from mrsfi.evolving import ALGORITHMS
from mrsfi_runtime.causes.cause_set import Column
from mrsfi_runtime.causes.harvest import N_ALONE, Cover
from mrsfi_runtime.causes.weakness import faults_of
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import Outcome
from mrsfi_runtime.record.settings import ALGORITHM_NAMES, CampaignSettings
from mrsfi_runtime.search.fitness import Score
from tests.support.search import outcome_of, paper_space

PLANTED = {"g1": [{"f4"}], "g2": [{"f6", "f8"}], "g3": [{"f2"}, {"f10", "f15"}], "g4": []}
"""What breaks a goal, believed and in truth; g5 and g6 are not broken by anything."""


def flown(specification: Specification) -> Outcome:
    faults = faults_of(specification)
    counts = [any(each <= faults for each in sets) for sets in PLANTED.values()]
    return outcome_of(*map(int, counts), 0, 0)


def turns(search: Cover) -> Iterator[list[Specification]]:
    while not search.is_finished:
        asked = search.ask()
        search.tell([Score(0.0, (), flown(specification)) for specification in asked])
        yield asked


def cover(**settings: object) -> Cover:
    return Cover(paper_space(), CampaignSettings(**{"evaluations": 1500, "seed": 2} | settings))


def test_the_names_that_the_command_line_lists_are_those_of_the_algorithms():
    assert tuple(ALGORITHMS) == ALGORITHM_NAMES


@pytest.mark.parametrize("seed", range(5))
def test_planted_weaknesses_are_found_and_nothing_else(seed):
    search = cover(seed=seed)

    for _ in turns(search):
        pass

    for measure in ("believed", "true"):
        for goal in ("g1", "g2", "g3", "g4", "g5", "g6"):
            found = search.known.sets[Column(goal, measure)]
            assert {*found} == {*map(frozenset, PLANTED.get(goal, []))}
    assert not any(search.known.sets[Column(goal, "missed")] for goal in PLANTED)


def test_first_it_flies_without_faults_and_then_each_fault_alone_in_other_forms():
    search = cover()
    (without, *first), *others = (next(turns(search)) for _ in range(N_ALONE))

    alone = [specification for turn in (first, *others) for specification in turn]

    assert without == ()
    assert all(len(specification) == 1 for specification in alone)
    assert len({*alone}) == len(alone)
    for fault in paper_space().candidates:
        assert 1 <= sum(timed.fault == fault for (timed,) in alone) <= N_ALONE


def test_no_form_is_flown_twice_and_no_draw_holds_what_is_known():
    seen: set[Specification] = set()
    for turn in turns(cover()):
        forms = [tuple(sorted(specification)) for specification in turn]
        assert len({*forms}) == len(forms)
        assert seen.isdisjoint(forms)
        seen.update(forms)

    late = [form for form in [*seen] if len(form) > 15]
    assert late
    assert any("f4" not in faults_of(form) for form in late)


def test_it_ends_when_all_bounds_are_as_low_as_was_asked_for():
    search = cover(evaluations=100_000, until=0.1)

    for _ in turns(search):
        assert max(map(search.known.bound, search.known.sets)) > 0.1 or search.is_finished

    assert max(map(search.known.bound, search.known.sets)) <= 0.1
    assert sum(map(len, search.known.sets.values())) == 8


@pytest.mark.parametrize("n_evaluations", [1, 20, 137, 909])
def test_a_number_of_evaluations_is_met_exactly(n_evaluations):
    search = cover(evaluations=n_evaluations)
    summaries, n_asked = [], 0
    while not search.is_finished:
        asked = search.ask()
        summaries.append(search.tell([Score(1.0, (), flown(each)) for each in asked]))
        n_asked += len(asked)

    assert n_asked == n_evaluations
    numbers = [number for summary in summaries for number in summary.population]
    assert numbers == [*range(n_evaluations)]


@pytest.mark.parametrize(
    ("pool", "expected"),
    [(("f26",), [set(), {"f26"}]), (("f26", "f30"), [set(), {"f26"}, {"f30"}, {"f26", "f30"}])],
)
def test_faults_without_other_forms_are_flown_once_and_soon_together(pool, expected):
    search = Cover(paper_space(1, *pool), CampaignSettings(evaluations=50))

    asked = [faults_of(specification) for turn in turns(search) for specification in turn]

    assert asked == expected


def test_what_failed_breaks_nothing():
    search = cover(evaluations=200)
    while not search.is_finished:
        search.tell([Score(0.0, ()) for _ in search.ask()])

    assert not any(search.known.sets.values())


@pytest.mark.parametrize("key", ["population", "generations"])
def test_it_has_neither_populations_nor_generations(key, refused):
    named = f'[search]\nalgorithm = "cover"\n{key} = 3\n'
    with refused(UsageError):
        CampaignSettings.parse(named, "mine.toml")
    with refused(UsageError):
        CampaignSettings.parse("[search]", "mine.toml", algorithm="cover", **{key: 3})

    with refused(UsageError):
        CampaignSettings.parse('[search]\nalgorithm = "cover"\n', "mine.toml", **{key: 3})

    other = CampaignSettings.parse(f"[search]\n{key} = 3\n", "mine.toml", algorithm="cover")
    assert other.evaluations == 909


def test_a_bound_to_end_at_is_of_it_alone_and_lets_it_go_on_for_long(refused):
    told = CampaignSettings.parse('[search]\nalgorithm = "cover"\nuntil = 0.1\n', "mine.toml")

    assert (told.until, told.evaluations) == (0.1, 100_000)
    with refused(UsageError):
        CampaignSettings.parse("[search]\nuntil = 0.1\n", "mine.toml")
    with refused(UsageError):
        CampaignSettings.parse("[search]\n", "mine.toml", until=0.1)


def test_what_it_flies_for_a_seed_changes_with_intent_only():
    search = cover()
    summaries = []
    tell = search.tell
    search.tell = lambda scores: summaries.append(tell(scores))

    flown_again = [*turns(search)]

    text = repr(flown_again).replace(", trigger=''", "")
    assert sha256(text.encode()).hexdigest()[:16] == "7db93d206ab51bc6"
    assert [each.index for each in summaries] == [*range(len(flown_again))]
    assert [each.statistics["n_evaluations"] for each in summaries] == [*map(len, flown_again)]
