"""What to protect first: greedy cover against brute force, and the ladder of a campaign."""

from fractions import Fraction
from itertools import combinations

from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.causes.consequences import closing, confirmed, cover, ladder
from mrsfi_runtime.causes.mildest import goal_weaknesses
from mrsfi_runtime.causes.weakness import Known
from tests.support.search import paper_mission, paper_space, pool_of
from tests.support.weaknesses import weakness

SOME = st.frozensets(st.sampled_from("abcdefgh"), min_size=1, max_size=4)


@given(st.lists(SOME, min_size=1, max_size=6), st.data())
def test_each_step_closes_most_and_all_take_at_most_a_harmonic_number_times_the_fewest(some, data):
    elements = dict(zip("uvwxyz", some, strict=False))
    struck = st.sampled_from(sorted(frozenset.union(*some)))
    sets = data.draw(st.lists(st.frozensets(struck, min_size=1, max_size=3), max_size=8))

    chosen = cover(elements, sets)

    def left(without):
        return [each for each in sets if not any(elements[name] & each for name in without)]

    for place, name in enumerate(chosen):
        before = chosen[:place]
        ranked = [(len(left([*before, each])), len(elements[each]), each) for each in elements]
        assert name == min(ranked)[2]  # the names are in order
    assert not left(chosen)
    fewest = next(n for n in range(7) if any(not left(c) for c in combinations(elements, n)))
    most = max((len(sets) - len(left([each])) for each in elements), default=0)
    assert len(chosen) <= fewest * sum(Fraction(1, n) for n in range(1, most + 1))


def test_false_alarms_do_not_count_and_each_weakness_flies_without_the_faults_so_far():
    found = goal_weaknesses(
        [
            weakness("g1", "true", "f11"),  # of m2
            weakness("g2", "true", "f2", "f11"),  # of m4 and m2
            weakness("g3", "believed", "f26"),
            weakness("g4", "true", "f2"),
        ]
    )

    steps = ladder(paper_mission(), pool_of(), found)
    flights = [*closing(steps)]

    names = [(step.element, [each.number for each in step.closed]) for step in steps]
    assert names == [("m2", [1, 2]), ("m4", [4])]  # their senders have more faults
    assert [[timed.fault for timed in rest] for _, rest in flights] == [[], ["f2"], []]
    known = Known(paper_space())
    known.learn((), frozenset())
    assert confirmed(steps, known) == (1, {1: True, 4: True})
    second, without_m2 = flights[1]
    known.learn(without_m2, frozenset([second.shown.column]))
    assert confirmed(steps, known) == (2, {1: True, 2: False, 4: True})
