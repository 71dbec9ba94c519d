"""Laws of the search operators, over missions of any length and pools of any size."""

from contextlib import nullcontext
from dataclasses import replace
from itertools import combinations
from random import Random

import pytest
from hypothesis import HealthCheck, given
from hypothesis import strategies as st

from mrsfi_runtime.errors import SpecificationError
from mrsfi_runtime.model.faults import FaultPool, Gate, Specification, TimedFault, touched
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.search.algorithms import FaultModel
from mrsfi_runtime.search.fitness import Score
from mrsfi_runtime.search.loop import (
    MUTATIONS,
    STEPS,
    Individual,
    dropped,
    filled,
    resized,
    widened,
)
from mrsfi_runtime.search.space import (
    CROSSOVERS,
    Candidate,
    SearchSpace,
    crossed,
    freely_crossed,
    freely_mutated,
    mutated,
    random_specification,
    repaired,
    transformed,
)
from tests.support.search import PAPER_FAULTS, paper_mission, paper_space, pool_of, random_pair
from tests.support.triggers import drawn_triggers
from tests.tiers import law, slow

FAULT_IDS = [fault.id for fault in PAPER_FAULTS]
LAW = law(150, suppress_health_check=[HealthCheck.too_slow])

seeds = st.integers(0, 2**32)


class Drawn:
    """A mission of some duration, a pool, how many faults are wanted, and a generator."""

    def __init__(
        self, duration: int, fault_ids: list[str], n_faults: int, seed: int, n_triggers: int
    ) -> None:
        self.mission, pool = paper_mission(duration), pool_of(*fault_ids)
        triggers = drawn_triggers(Random(seed), self.mission, pool)
        self.pool = replace(pool, triggers=triggers[::3][:n_triggers])
        self.space = SearchSpace.of(self.mission, self.pool)
        self.fault_ids, self.n_faults, self.seed = fault_ids, n_faults, seed
        self.rng = Random(seed)

    def specification(self) -> Specification:
        return random_specification(self.space, self.n_faults, self.rng)

    def require_legal(self, specification: Specification) -> None:
        Gate(self.mission, self.pool).admitted(specification)
        assert list(specification) == list(self.space.ordered(specification))
        for timed in specification:
            candidate = self.space.candidates[timed.fault]
            require_within(candidate, timed, self.mission.duration)
            assert timed.trigger in candidate.triggers
            assert self.pool.triggers or not timed.trigger


DRAWN = st.builds(
    Drawn,
    st.one_of(st.integers(1, 12), st.integers(1, 10_000)),
    st.lists(st.sampled_from(FAULT_IDS), min_size=1, max_size=30, unique=True),
    st.integers(1, 25),
    seeds,
    st.sampled_from([0, 0, 1, 4]),
)


def require_within(candidate: Candidate, timed: TimedFault, duration: int) -> None:
    assert 0 <= timed.start <= timed.finish < duration
    for value, (low, high), is_integer in zip(
        timed.values, candidate.bounds, candidate.is_integer, strict=True
    ):
        assert low <= value <= high
        assert type(value) is float
        assert not is_integer or value.is_integer()


def conflicts(mission: Mission, pool: FaultPool) -> dict[str, set[str]]:
    """Return for every fault ID those of the faults that touch the same, by the definition."""
    keys = {fault.id: {fault.id, *touched(mission, fault)} for fault in pool}
    return {one: {other for other in keys if keys[one] & keys[other]} for one in keys}


@LAW
@given(
    st.lists(
        st.tuples(st.sampled_from(PAPER_FAULTS), st.integers(0, 300), st.integers(0, 40)),
        max_size=12,
    )
)
def test_what_is_refused_is_that_two_that_conflict_overlap(drawn):
    mission, pool = paper_mission(), pool_of(*FAULT_IDS)
    specification = [
        TimedFault(fault.id, start, start + length, fault.values) for fault, start, length in drawn
    ]
    excluded = conflicts(mission, pool)
    clashes = [
        (one, other)
        for one, other in combinations(specification, 2)
        if one.start <= other.finish and other.start <= one.finish
        if one.fault in excluded[other.fault]
    ]

    refused = pytest.raises(SpecificationError) if clashes else nullcontext()
    with refused as error:
        Gate(mission, pool).admitted(tuple(specification))

    named = [
        [f"'{each.fault}' ({each.start} … {each.finish})" for each in pair] for pair in clashes
    ]
    assert not clashes or any(all(name in str(error.value) for name in names) for names in named)


@LAW
@given(DRAWN)
def test_random_specifications_are_legal_and_as_large_as_there_is_room(drawn):
    specification = drawn.specification()

    drawn.require_legal(specification)
    assert 1 <= len(specification) <= drawn.n_faults
    if len(specification) < drawn.n_faults:
        assert all(timed.start == timed.finish for timed in specification)
        free = (drawn.space.free_windows(fault, specification) for fault in drawn.fault_ids)
        assert not any(free)


@pytest.mark.parametrize("crossover", CROSSOVERS.values())
@pytest.mark.parametrize("mutation", MUTATIONS.values())
@LAW
@given(DRAWN)
def test_generations_of_crossover_and_mutation_stay_legal(crossover, mutation, drawn):
    space, rng = drawn.space, drawn.rng
    population = [drawn.specification() for _ in range(4)]
    largest = max(map(len, population))

    for _ in range(5):
        rng.shuffle(population)
        population = [
            *crossover(space, population[0], population[1], rng),
            *crossover(space, population[2], population[3], rng),
        ]
        for specification in population:
            drawn.require_legal(specification)
        population = [mutation(space, specification, rng) for specification in population]
        for specification in population:
            drawn.require_legal(specification)

    assert max(map(len, population)) <= largest


@LAW
@given(DRAWN)
def test_crossover_creates_and_loses_no_fault(drawn):
    first, second = drawn.specification(), drawn.specification()

    one, other = crossed(drawn.space, first, second, drawn.rng)

    assert sorted([*one, *other]) == sorted([*first, *second])
    half = min(len(first), len(second)) // 2
    assert len(set(first) - set(one)) <= half
    assert len(set(second) - set(other)) <= half
    if len(first) == len(second):
        assert len(one) == len(other) == len(first)


@LAW
@given(DRAWN)
def test_free_crossover_keeps_sizes_and_the_faults_of_both_and_changes_no_values(drawn):
    first, second = drawn.specification(), drawn.specification()

    one, other = freely_crossed(drawn.space, first, second, drawn.rng)

    assert (len(one), len(other)) == (len(first), len(second))
    assert unplaced([*one, *other]) == unplaced([*first, *second])


def unplaced(faults: list[TimedFault]) -> list[tuple[str, tuple[float, ...]]]:
    """Return timed faults without their windows, in an order of their own."""
    return sorted((timed.fault, timed.values) for timed in faults)


@pytest.mark.parametrize("mutation", MUTATIONS.values())
@LAW
@given(DRAWN)
def test_mutation_keeps_the_size_and_the_values_that_do_not_evolve(mutation, drawn):
    specification = drawn.specification()

    mutant = mutation(drawn.space, specification, drawn.rng, share=1.0)

    assert len(mutant) == len(specification)
    if mutation is not transformed:
        assert sorted(timed.fault for timed in mutant) == sorted(t.fault for t in specification)
    for timed in mutant:
        candidate = drawn.space.candidates[timed.fault]
        for value, own, (low, high) in zip(
            timed.values, candidate.values, candidate.bounds, strict=True
        ):
            assert low < high or value == own


@LAW
@given(DRAWN, st.data())
def test_what_is_repaired_is_legal_and_cut_inside_its_window_where_that_has_room(drawn, data):
    faults = [window_of(data, drawn, fault) for fault in data.draw(several(drawn.fault_ids))]

    found = repaired(drawn.space, faults, drawn.rng)

    drawn.require_legal(found)
    excluded = conflicts(drawn.mission, drawn.pool)
    has_rivals = {
        each.fault: sum(other.fault in excluded[each.fault] for other in faults) for each in faults
    }
    if all(n <= drawn.mission.duration for n in has_rivals.values()):
        assert unplaced(list(found)) == unplaced(faults)
    if all(each.finish - each.start + 1 >= has_rivals[each.fault] for each in faults):
        assert all(any(is_inside(timed, each) for each in faults) for timed in found), (
            "a window that has a tick for each rival is cut, not moved"
        )


def several(fault_ids: list[str]) -> st.SearchStrategy[list[str]]:
    return st.lists(st.sampled_from(fault_ids), max_size=12)


def window_of(data: st.DataObject, drawn: Drawn, fault: str) -> TimedFault:
    ticks = st.integers(0, drawn.mission.duration - 1)
    start, finish = sorted((data.draw(ticks), data.draw(ticks)))
    return TimedFault(fault, start, finish, drawn.space.candidates[fault].values)


def is_inside(timed: TimedFault, other: TimedFault) -> bool:
    return timed.fault == other.fault and other.start <= timed.start <= timed.finish <= other.finish


@LAW
@given(DRAWN, st.data())
def test_repair_changes_nothing_that_clashes_with_nothing_unless_there_is_no_room(drawn, data):
    faults = [window_of(data, drawn, fault) for fault in data.draw(several(drawn.fault_ids))]
    excluded = conflicts(drawn.mission, drawn.pool)
    clashing = {
        place
        for pair in combinations(range(len(faults)), 2)
        if drawn.space.clash(faults[pair[0]], faults[pair[1]])
        for place in pair
    }
    n_ticks = [each.finish - each.start + 1 for each in faults]
    is_roomy = all(
        n_ticks[place] >= sum(other.fault in excluded[faults[place].fault] for other in faults)
        for place in clashing
    )

    found = repaired(drawn.space, faults, drawn.rng)

    if is_roomy:
        assert {each for place, each in enumerate(faults) if place not in clashing} <= {*found}
    assert repaired(drawn.space, found, drawn.rng) == found
    specification = drawn.specification()
    assert repaired(drawn.space, specification, drawn.rng) == specification


@pytest.mark.parametrize(
    ("windows", "expected"),
    [
        ([(2, 2), (2, 2)], [(1, 1), (2, 2)]),  # moved to the nearest tick that is free
        ([(0, 3)] * 4, [(0, 0), (1, 1), (2, 2), (3, 3)]),
        ([(0, 3)] * 5, [(0, 0), (1, 1), (2, 2), (3, 3)]),  # no room for five
        ([(0, 3), (2, 2)], None),
    ],
)
def test_repair_cuts_moves_and_leaves_out_only_what_has_no_room(windows, expected):
    space = paper_space(4)
    faults = [TimedFault("f26", *window) for window in windows]

    found = {repaired(space, faults, Random(seed)) for seed in range(20)}

    if expected is None:
        assert found == {
            (TimedFault("f26", 0, 1), TimedFault("f26", 2, 2)),
            (TimedFault("f26", 2, 2), TimedFault("f26", 3, 3)),
        }
    else:
        assert {tuple((each.start, each.finish) for each in one) for one in found} == {
            tuple(expected)
        }


@pytest.mark.parametrize("mutation", [freely_mutated, transformed])
def test_free_mutation_reaches_windows_that_the_restriction_takes_away(mutation):
    space = paper_space(10, "f26")
    specification = tuple(TimedFault("f26", tick, tick) for tick in range(10))

    restricted = {mutated(space, specification, Random(seed)) for seed in range(50)}
    free = {mutation(space, specification[:5], Random(seed)) for seed in range(50)}

    assert restricted == {specification}
    assert len({len(each) for each in free}) == 1
    assert any(timed.start >= 5 for each in free for timed in each)


@LAW
@given(DRAWN)
def test_the_same_seed_repeats_every_operator(drawn):
    space = drawn.space

    def run() -> list[Specification]:
        rng = Random(drawn.seed)
        first, second = random_pair(space, drawn.n_faults, rng)
        crosses = [one for cross in CROSSOVERS.values() for one in cross(space, first, second, rng)]
        mutants = [mutate(space, first, rng) for mutate in MUTATIONS.values()]
        return [first, second, *crosses, *mutants]

    assert run() == run()


@pytest.mark.parametrize("step", [*STEPS, *MUTATIONS.values()])
@LAW
@given(DRAWN)
def test_steps_stay_legal_and_never_grow(step, drawn):
    specification = drawn.specification()

    for _ in range(5):
        stepped = step(drawn.space, specification, drawn.rng)

        drawn.require_legal(stepped)
        assert 1 <= len(stepped) <= len(specification)
        specification = stepped


@pytest.mark.parametrize("step", STEPS)
def test_steps_repeat_from_their_seed_and_can_change_something(step):
    space = paper_space()
    specification = random_specification(space, 20, Random(1))

    first = [step(space, specification, Random(seed)) for seed in range(20)]

    assert first == [step(space, specification, Random(seed)) for seed in range(20)]
    assert any(stepped != specification for stepped in first)


@LAW
@given(DRAWN, st.integers(0, 5))
def test_resizing_adds_or_drops_one_fault_and_keeps_the_restriction(drawn, n_more):
    specification = drawn.specification()
    n_most = len(specification) + n_more

    for _ in range(5):
        resize = resized(
            drawn.space, specification, drawn.rng, 0.5, mutation=mutated, n_most=n_most
        )

        drawn.require_legal(resize)
        assert 1 <= len(resize) <= n_most
        assert abs(len(resize) - len(specification)) <= 1
        specification = resize


@slow
@LAW
@given(DRAWN, st.integers(1, 25))
def test_filling_adds_faults_up_to_the_number_wanted(drawn, n_wanted):
    specification = drawn.specification()

    more = filled(drawn.space, specification, n_wanted, drawn.rng)

    drawn.require_legal(more)
    assert set(specification) <= set(more)
    assert len(more) <= max(n_wanted, len(specification))


@pytest.mark.parametrize(("step", "windows"), [(widened, [(5, 9)]), (dropped, [(5, 9), (10, 20)])])
def test_a_widened_fault_and_one_whose_neighbour_is_dropped_fill_their_free_window(step, windows):
    specification = tuple(TimedFault("f26", *window) for window in windows)

    assert step(paper_space(), specification, Random(1)) == (TimedFault("f26", 0, 999),)


@LAW
@given(DRAWN)
def test_what_a_fault_model_generates_is_legal_also_after_learning(drawn):
    model = FaultModel(drawn.space, drawn.n_faults, drawn.rng)

    for _ in range(4):
        population = [Individual(model.generate()) for _ in range(8)]
        for place, individual in enumerate(population):
            drawn.require_legal(individual.specification)
            assert 1 <= len(individual) <= drawn.n_faults
            individual.assess(Score(float(place), ()))
        model.update(population)


@pytest.mark.parametrize("fault_id", FAULT_IDS)
def test_landmarks_lie_within_the_bounds_and_begin_with_the_pools_own_values(fault_id):
    candidate = paper_space(1000, fault_id).candidates[fault_id]

    assert candidate.landmarks[0] == candidate.values
    assert len(set(candidate.landmarks)) == len(candidate.landmarks)
    for values in candidate.landmarks:
        for value, (low, high) in zip(values, candidate.bounds, strict=True):
            assert low <= value <= high


def test_places_have_the_robots_the_obstacles_and_the_goal_areas_as_landmarks():
    places = {values[:2] for values in paper_space().candidates["f11"].landmarks}

    assert {(250.0, -250.0), (0.0, 500.0), (2400.0, 0.0)} <= places


def legal_exchanges(
    mission: Mission, pool: FaultPool, first: Specification, second: Specification
) -> bool:
    """Return, by trying all, whether some exchange is allowed and changes something."""
    excluded = conflicts(mission, pool)
    half, larger = min(len(first), len(second)) // 2, max(len(first), len(second))

    def is_valid(faults: list) -> bool:
        return len(faults) <= larger and not any(
            b.fault in excluded[a.fault] and a.start <= b.finish and b.start <= a.finish
            for a, b in combinations(faults, 2)
        )

    for n_leave in range(half + 1):
        for n_arrive in range(half + 1):
            for leave in combinations(first, n_leave):
                for arrive in combinations(second, n_arrive):
                    one = [*(t for t in first if t not in leave), *arrive]
                    other = [*(t for t in second if t not in arrive), *leave]
                    if sorted(one) != sorted(first) and is_valid(one) and is_valid(other):
                        return True
    return False


@law(400, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.integers(1, 40),
    st.lists(st.sampled_from(FAULT_IDS), min_size=1, max_size=4, unique=True),
    st.integers(1, 6),
    st.integers(1, 6),
    st.booleans(),
    seeds,
)
def test_crossover_exchanges_whenever_some_exchange_is_allowed(
    duration, fault_ids, n_first, n_second, is_related, seed
):
    mission, pool, rng = paper_mission(duration), pool_of(*fault_ids), Random(seed)
    space = SearchSpace.of(mission, pool)
    first = random_specification(space, n_first, rng)
    second = (
        mutated(space, first, rng) if is_related else random_specification(space, n_second, rng)
    )

    one, other = crossed(space, first, second, rng)

    is_exchanged = (one, other) != (first, second)
    assert is_exchanged == legal_exchanges(mission, pool, first, second)


@pytest.mark.parametrize("duration", [10, 100, 1000, 10_000])
def test_crossover_of_the_papers_individuals_nearly_always_exchanges(duration, record_property):
    space, rng, n_calls = paper_space(duration), Random(7), 1000

    n_exchanging = 0
    for _ in range(n_calls):
        first, second = random_pair(space, 20, rng)
        n_exchanging += crossed(space, first, second, rng) != (first, second)

    record_property("share_of_exchanging_crossovers", n_exchanging / n_calls)
    assert n_exchanging / n_calls > 0.99
