"""Laws of the search operators, over missions of any length and pools of any size."""

from collections.abc import Callable
from itertools import combinations
from random import Random

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.targets import conflicts, require_no_overlap
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.specifications import random_specification
from mrsfi_runtime.search.variation import crossed, mutated
from support_search import PAPER_FAULTS, paper_mission, paper_space, pool_of, random_pair

FAULT_IDS = [fault.id for fault in PAPER_FAULTS]
LAW = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])

durations = st.one_of(st.integers(1, 12), st.integers(1, 10_000))
pools = st.lists(st.sampled_from(FAULT_IDS), min_size=1, max_size=30, unique=True)
sizes = st.integers(1, 25)
seeds = st.integers(0, 2**32)


def require_legal(
    mission: Mission, pool: FaultPool, space: SearchSpace, specification: Specification
) -> None:
    require_no_overlap(mission, pool, specification)
    assert list(specification) == list(space.ordered(specification))
    for timed in specification:
        candidate = space.candidates[timed.fault]
        assert 0 <= timed.start <= timed.finish < mission.duration
        for value, (low, high), is_integer in zip(
            timed.values, candidate.bounds, candidate.is_integer, strict=True
        ):
            assert low <= value <= high
            assert type(value) is float
            assert not is_integer or value.is_integer()


@LAW
@given(durations, pools, sizes, seeds)
def test_random_specifications_are_legal_and_as_large_as_there_is_room(
    duration: int, fault_ids: list[str], n_faults: int, seed: int
) -> None:
    mission, pool = paper_mission(duration), pool_of(*fault_ids)
    space = SearchSpace.of(mission, pool)

    specification = random_specification(space, n_faults, Random(seed))

    require_legal(mission, pool, space, specification)
    assert 1 <= len(specification) <= n_faults
    if len(specification) < n_faults:
        assert all(timed.start == timed.finish for timed in specification)
        assert not any(space.free_windows(fault, specification) for fault in fault_ids)


@LAW
@given(durations, pools, sizes, seeds)
def test_generations_of_crossover_and_mutation_stay_legal(
    duration: int, fault_ids: list[str], n_faults: int, seed: int
) -> None:
    mission, pool, rng = paper_mission(duration), pool_of(*fault_ids), Random(seed)
    space = SearchSpace.of(mission, pool)
    population = [random_specification(space, n_faults, rng) for _ in range(4)]
    largest = max(map(len, population))

    for _ in range(5):
        rng.shuffle(population)
        population = [
            *crossed(space, population[0], population[1], rng),
            *crossed(space, population[2], population[3], rng),
        ]
        for specification in population:
            require_legal(mission, pool, space, specification)
        population = [mutated(space, specification, rng) for specification in population]
        for specification in population:
            require_legal(mission, pool, space, specification)

    assert max(map(len, population)) <= largest


@LAW
@given(durations, pools, sizes, seeds)
def test_crossover_creates_and_loses_no_fault(
    duration: int, fault_ids: list[str], n_faults: int, seed: int
) -> None:
    space, rng = paper_space(duration, *fault_ids), Random(seed)
    first, second = random_pair(space, n_faults, rng)

    one, other = crossed(space, first, second, rng)

    assert sorted([*one, *other]) == sorted([*first, *second])
    half = min(len(first), len(second)) // 2
    assert len(set(first) - set(one)) <= half
    assert len(set(second) - set(other)) <= half
    if len(first) == len(second):
        assert len(one) == len(other) == len(first)


@LAW
@given(durations, pools, sizes, seeds)
def test_mutation_keeps_the_faults_and_the_values_that_do_not_evolve(
    duration: int, fault_ids: list[str], n_faults: int, seed: int
) -> None:
    space, rng = paper_space(duration, *fault_ids), Random(seed)
    specification = random_specification(space, n_faults, rng)

    mutant = mutated(space, specification, rng, share=1.0)

    assert sorted(timed.fault for timed in mutant) == sorted(t.fault for t in specification)
    for timed in mutant:
        candidate = space.candidates[timed.fault]
        for value, own, (low, high) in zip(
            timed.values, candidate.values, candidate.bounds, strict=True
        ):
            assert low < high or value == own


@LAW
@given(durations, pools, sizes, seeds)
def test_the_same_seed_repeats_every_operator(
    duration: int, fault_ids: list[str], n_faults: int, seed: int
) -> None:
    space = paper_space(duration, *fault_ids)

    def run() -> list[Specification]:
        rng = Random(seed)
        first, second = random_pair(space, n_faults, rng)
        return [first, second, *crossed(space, first, second, rng), mutated(space, first, rng)]

    assert run() == run()


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


@settings(LAW, max_examples=400)
@given(
    st.integers(1, 40),
    st.lists(st.sampled_from(FAULT_IDS), min_size=1, max_size=4, unique=True),
    st.integers(1, 6),
    st.integers(1, 6),
    st.booleans(),
    seeds,
)
def test_crossover_exchanges_whenever_some_exchange_is_allowed(
    duration: int, fault_ids: list[str], n_first: int, n_second: int, is_related: bool, seed: int
) -> None:
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
def test_crossover_of_the_papers_individuals_nearly_always_exchanges(
    duration: int, record_property: Callable[[str, object], None]
) -> None:
    space, rng, n_calls = paper_space(duration), Random(7), 1000

    n_exchanging = 0
    for _ in range(n_calls):
        first, second = random_pair(space, 20, rng)
        n_exchanging += crossed(space, first, second, rng) != (first, second)

    record_property("share_of_exchanging_crossovers", n_exchanging / n_calls)
    assert n_exchanging / n_calls > 0.99
