"""Cause sets: which faults break a goal, their shares, labels, simplest forms and chains."""

import json
from collections.abc import Callable, Mapping, Sequence
from itertools import combinations, permutations
from random import Random

import pytest

from mrsfi_runtime.causes.cause_set import Column, Flights, Question, floor
from mrsfi_runtime.causes.chain import (
    HEADING,
    Chain,
    Change,
    First,
    FirstVerdict,
    FirstVerdicts,
    Robustness,
    chain_as_json,
    changed,
    robustness,
)
from mrsfi_runtime.causes.explanation import (
    N_EXACT,
    N_PERMUTATIONS,
    attribute,
    goal_causes,
    simplest,
)
from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.model.faults import Specification, TimedFault, value_bounds
from mrsfi_runtime.model.mission import FailedFlight, Outcome
from mrsfi_runtime.record.store import Measure
from tests.support.campaigns import outcome
from tests.support.search import paper_mission, pool_of
from tests.tiers import seeds

Planted = Mapping[str, Callable[[frozenset[str]], tuple[int, int]]]
"""Believed and true violations of each goal, from the IDs of the faults that are flown."""
MISSION, POOL = paper_mission(), pool_of()
SPEED = next(fault for fault in POOL if fault.type == "FixedSpeed")
(OWN,), ((LOW, HIGH),) = SPEED.values, value_bounds(MISSION, SPEED)
ODD = 17.123


def faults(names: str) -> Specification:
    """Return a timed fault for each letter."""
    return tuple(TimedFault(name, 0, 9) for name in names)


def flights(planted: Planted, kind: str = "believed") -> Flights:
    """Return flights that find what is planted."""
    goals = tuple(planted)
    return Flights(evaluator(planted), Measure(kind, 1, goals, goals, 100), (1,))


def evaluator(planted: Planted) -> Callable[[Sequence[Specification], int], list[Outcome]]:
    """Return what evaluates specifications as is planted."""

    def evaluate_many(specifications: Sequence[Specification], _seed: int) -> list[Outcome]:
        return [_outcome(planted, each) for each in specifications]

    return evaluate_many


def _outcome(planted: Planted, specification: Specification) -> Outcome:
    flown = frozenset(timed.fault for timed in specification)
    found = [violations(flown) for violations in planted.values()]
    none = tuple(0 for _ in found)
    pairs = [(max(b - t, 0), max(t - b, 0)) for b, t in found]
    ones = tuple(1 for _ in specification)
    return Outcome(
        believed=tuple(believed for believed, _ in found),
        true=tuple(true for _, true in found),
        phantom=tuple(phantom for phantom, _ in pairs),
        masked=tuple(masked for _, masked in pairs),
        missed=none,
        samples=none,
        applied=ones,
        changed=ones,
        digest="",
    )


def minimum(planted, names, keep=0.95, columns=None):
    return question(planted, names, keep, columns).minimum()


def question(planted, names, keep=0.95, columns=None):
    flown = flights(planted)
    counts = flown.counts(faults(names))
    asked = range(len(counts)) if columns is None else columns
    return Question(flown, faults(names), floor(counts, keep, asked))


def test_of_two_of_which_either_is_enough_only_one_is_in_it():
    planted = {"g1": lambda flown: (10, 0) if {"b", "f"} & flown else (0, 0)}

    asked = question(planted, "abcdefg")

    assert asked.minimum() == (1,)
    assert {*asked.minima()} == {(1,), (5,)}


def test_it_keeps_the_true_violations_as_well_as_those_of_the_measure():
    planted = {"g1": lambda flown: (10 * ("a" in flown), 10 * ("c" in flown))}

    assert minimum(planted, "abcd") == (0, 2)


def test_it_keeps_a_share_of_every_violated_goal():
    planted = {
        "g1": lambda flown: (100, 0) if "a" in flown else (0, 0),
        "g2": lambda flown: (94 * ("b" in flown) + 5 * ("c" in flown) + ("d" in flown), 0),
        "g3": lambda flown: (0, 0),
    }

    assert minimum(planted, "abcd") == (0, 1, 2)
    assert minimum(planted, "abcd", keep=0.94) == (0, 1)
    assert minimum(planted, "abcd", keep=1.0) == (0, 1, 2, 3)


def test_a_share_is_what_is_written_not_the_nearest_binary_number():
    counts = tuple(range(2000))

    kept = floor(counts, 0.95, range(2000))

    assert all(
        20 * least >= 19 * count > 20 * (least - 1) for count, least in kept.items() if least
    )
    assert kept[20] == 19
    assert kept[1900] == 1805
    assert 0 not in kept


def test_what_is_violated_without_any_fault_has_no_cause():
    planted = {"g1": lambda flown: (7, 7)}

    assert minimum(planted, "abc") == ()


@pytest.mark.parametrize("seed", seeds(range(40), 12, 9))
def test_it_is_one_minimal_whatever_the_faults_do_together(seed):
    random = Random(seed)
    names = "abcdefgh"
    table = {
        frozenset(some): tuple(random.choice((0, 5, 90, 100)) for _ in range(4))
        for n in range(len(names) + 1)
        for some in combinations(names, n)
    }
    table[frozenset()] = (0, 0, 0, 0)
    planted = {"g1": lambda flown: table[flown][:2], "g2": lambda flown: table[flown][2:]}
    asked = question(planted, names)

    for found in (asked.minimum(), *asked.minima()):
        assert asked.is_kept_by(found)
        assert not any(asked.is_kept_by({*found} - {place}) for place in found)


def test_every_specification_is_flown_once():
    planted = {"g1": lambda flown: (10, 0) if {"b", "f"} <= flown else (0, 0)}
    asked = question(planted, "abcdefg")
    asked.minimum()
    n_flown = asked.flights.n_flown.total()

    asked.minimum()

    assert asked.flights.n_flown.total() == n_flown < 2**7


def test_counts_are_those_of_the_measure_and_the_true_ones_over_all_mission_seeds():
    planted = {"g1": lambda flown: (3, 8), "g2": lambda flown: (4, 1)}

    flown = flights(planted, "masked")

    assert flown.columns == (
        Column("g1", "masked"),
        Column("g1", "true"),
        Column("g2", "masked"),
        Column("g2", "true"),
    )
    assert flown.counts(faults("a")) == (5, 8, 0, 1)
    assert flights(planted, "true").counts(faults("a")) == (8, 1)


def test_a_flight_that_fails_is_told_with_its_faults(monkeypatch, refused):
    flown = flights({"g1": lambda flown: (1, 1)})
    failed = FailedFlight("Traceback …\nmrsfi_runtime.errors.EvaluationError: a.py:7: division\n")
    monkeypatch.setattr(flown, "_evaluate_many", lambda many, _: [failed for _ in many])

    with refused(EvaluationError):
        flown.counts(faults("ab"))


def shares(violations, names):
    return attribute(flights({"g1": violations}), faults(names))


def random_violations(names, seed):
    weights = dict(zip(names, Random(seed).sample(range(1000), len(names)), strict=True))

    def violations(flown):
        believed = 3 + sum(weights[name] for name in flown) % 97
        return believed, 1 + sum(weights[name] ** 2 for name in flown) % 89

    return violations


def added(violations, names, column):
    whole, none = violations(frozenset(names)), violations(frozenset())
    return whole[column] - none[column]


@pytest.mark.parametrize("seed", range(5))
def test_exact_shares_are_the_mean_over_all_orders(seed):
    names = "abcde"
    violations = random_violations(names, seed)
    sums = dict.fromkeys(names, 0)
    orders = [*permutations(names)]
    for order in orders:
        for place, name in enumerate(order):
            before = frozenset(order[:place])
            sums[name] += violations(before | {name})[0] - violations(before)[0]

    found = shares(violations, names)

    assert [share[0] * len(orders) for share in found.shares] == [*sums.values()]
    assert found.margins is None


@pytest.mark.parametrize("names", ["", "a", "abcdef", "abcdefghijklm"])
def test_shares_sum_to_what_the_faults_add_to_the_count_without_them(names):
    violations = random_violations(names, 1)

    found = shares(violations, names).shares

    for column in (0, 1):
        assert sum(share[column] for share in found) == added(violations, names, column)


@pytest.mark.parametrize("names", ["abcd", "abcdefghijklm"])
def test_a_fault_that_changes_nothing_gets_nothing(names):
    weighted = random_violations(names[1:], 2)

    found = shares(lambda flown: weighted(flown - {"a"}), names)

    assert found.shares[0] == (0, 0)
    assert found.margins is None or found.margins[0] == (0.0, 0.0)


def test_beyond_ten_faults_shares_are_sampled_and_their_intervals_hold_the_exact_ones():
    names = "abcdefghijklmnop"
    exact = [10 * place for place in range(len(names))]
    pairs = frozenset("ab")

    def violations(flown):
        return sum(exact[names.index(name)] for name in flown) + 100 * (pairs <= flown), 0

    flown = flights({"g1": violations})
    found = attribute(flown, faults(names))

    assert found == attribute(flights({"g1": violations}), faults(names))
    assert found.margins is not None
    expected = [value + 50 * (place < 2) for place, value in enumerate(exact)]
    within = [
        abs(share[0] - value) <= margin[0]
        for share, margin, value in zip(found.shares, found.margins, expected, strict=True)
    ]
    assert len(names) > N_EXACT
    assert all(within[2:])
    assert abs(found.shares[0][0] - 50) < 3 * found.margins[0][0] / 1.96 + 1e-9
    assert flown.n_flown.total() <= N_PERMUTATIONS * (len(names) + 1)


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


def simplified(violations, *drawn):
    """Return the simplest form of faults whose believed violations are given."""

    def evaluate_many(specifications, _seed):
        return [outcome([violations(each)], len(each)) for each in specifications]

    flights = Flights(evaluate_many, Measure("believed", 1, ("g1",), ("g1",), 1000), (1,))
    return simplest(flights, MISSION, POOL, drawn)


def timed(start, finish, value=ODD):
    return TimedFault(SPEED.id, start, finish, (value,))


def during(low, high):
    """Return violations: the ticks of a window that a fault covers, some hundred to one."""
    return lambda drawn: sum(
        100 * max(0, min(each.finish, high) - max(each.start, low) + 1) for each in drawn
    )


def test_a_window_is_cut_from_both_ends_to_where_it_counts():
    (found,) = simplified(during(300, 309), timed(7, 912))

    assert (found.start, found.finish) == (300, 309)


def test_what_follows_the_mission_is_cut():
    (found,) = simplified(during(990, 2000), timed(990, 5000))

    assert (found.start, found.finish) == (990, 999)


def test_a_fault_that_needs_one_tick_keeps_one():
    (found,) = simplified(lambda drawn: 10, timed(100, 200))

    assert found.start == found.finish


@pytest.mark.parametrize(
    ("least", "most", "expected"),
    [
        (LOW, HIGH, OWN),
        (OWN + 1e-9, HIGH, HIGH),
        (15, 25, 20),
        (16.5, 17.5, 17),
        (17.05, 17.2, 17.1),
        (ODD, ODD, ODD),
    ],
    ids=["the pool's own", "a bound", "tens", "ones", "tenths", "none but itself"],
)
def test_of_the_values_that_do_the_plainest_is_found(least, most, expected):
    def violations(drawn):
        return 10 * (least <= drawn[0].values[0] <= most)

    (found,) = simplified(violations, timed(100, 100))

    assert LOW <= ODD <= HIGH
    assert found.values == (expected,)


def test_a_hundredth_may_be_lost_but_not_more():
    def violations(drawn):
        return 1000 - 3 * (drawn[0].finish < 200) - 18 * (drawn[0].start > 50)

    (found,) = simplified(violations, timed(50, 200))

    assert found.start == 50
    assert found.finish < 200


def test_a_chain_is_told_as_plain_values_and_what_makes_no_difference_as_none():
    turned = Change("r1", HEADING, (350.0,), (10.0,))
    moved = Change("r1", "position", (3.0, 4.0, 0.0), (0.0, 0.0, 0.0))
    verdicts = (FirstVerdicts("g1", FirstVerdict(7, True), None, FirstVerdict(9, False)),)

    told = chain_as_json(Chain(None, First(5, (turned,)), First(6, (turned, moved)), verdicts))

    heading = {"owner": "r1", "quantity": "heading", "found": [350.0], "otherwise": [10.0]}
    assert json.loads(json.dumps(told)) == {
        "belief": None,
        "command": {"tick": 5, "changes": [heading | {"size": 20.0}]},
        "truth": {
            "tick": 6,
            "changes": [
                heading | {"size": 20.0},
                {
                    "owner": "r1",
                    "quantity": "position",
                    "found": [3.0, 4.0, 0.0],
                    "otherwise": [0.0, 0.0, 0.0],
                    "size": 5.0,
                },
            ],
        },
        "verdicts": {
            "g1": {
                "believed": {"tick": 7, "is_so": True},
                "true": None,
                "missed": {"tick": 9, "is_so": False},
            }
        },
    }


def test_it_is_median_range_and_in_how_many_seeds_a_goal_is_violated():
    by_seed = [(0, 5), (0, 1), (7, 3), (9, 2)]

    assert robustness(by_seed) == (Robustness(3.5, 0, 9, 2), Robustness(2.5, 1, 5, 4))


@pytest.mark.parametrize(
    ("quantity", "found", "otherwise", "said"),
    [
        (
            "position",
            (3.0, 4.0, 0.0),
            (3.0, 5.0, 0.0),
            "(3, 4, 0) instead of (3, 5, 0)",
        ),
        ("position", (3.0, 4.0, 0.0), (3.0, 4.001, 0.0), "(3, 4, 0) instead of (3, 4.001, 0)"),
        (HEADING, (40.0,), (20.0,), "40 degrees instead of 20 degrees"),
        (HEADING, (0.01,), (360.0,), "0.01 degrees instead of 360 degrees"),
        (HEADING, (20.0,), (20.000004,), "20 degrees, which is 4e-06 off"),
        ("energy", (7.0,), (8.5,), "7 instead of 8.5"),
    ],
)
def test_a_change_is_told_so_that_it_can_be_seen(quantity, found, otherwise, said):
    first = First(3, (Change("r1", quantity, found, otherwise),))

    words = changed(paper_mission(), first, "true")

    assert words == f"the true {quantity} of LEN (r1) was {said}"
