"""Tiers leave no test out: what one does not run, another does, today or on another day."""

from dataclasses import dataclass
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tiers import N_TURNS, TIERS, in_turn, seeds, slow


@slow
def kills():
    pass


@given(st.none())
def holds(_):
    pass


def adds():
    pass


@slow
@pytest.mark.turn(4)
def draws():
    pass


@dataclass(frozen=True)
class Item:
    obj: object
    callspec: object = None

    @property
    def nodeid(self):
        return self.obj.__name__

    def iter_markers(self, name):
        marks = getattr(self.obj, "pytestmark", [])
        return (mark for mark in marks if mark.name == name)

    def get_closest_marker(self, name):
        return next(self.iter_markers(name), None)


@pytest.mark.parametrize(
    ("test", "tiers"),
    [
        (adds, {"quick", "test", "due", "all"}),
        (kills, {"rest", "night", "due", "all"}),
        (draws, {"rest", "night", "due", "all"}),
        (holds, {"quick", "test", "rest", "night", "due", "all"}),
    ],
)
def test_a_test_runs_in_its_tiers(test, tiers):
    assert {name for name, tier in TIERS.items() if tier.takes(Item(test))} == tiers


def test_what_make_test_leaves_out_make_test_all_runs_in_every_room():
    assert TIERS["test"].rooms == TIERS["rest"].rooms == ()


@pytest.mark.parametrize(
    ("test", "n_days"), [(adds, N_TURNS), (kills, N_TURNS), (draws, 1), (holds, 1)]
)
def test_what_has_turns_is_left_on_all_days_but_one_and_never_at_night(test, n_days):
    days = range(N_TURNS)

    for name, tier in TIERS.items():
        n_taken = sum(not tier.leaves(Item(test), day) for day in days)
        assert n_taken == (n_days if name in ("rest", "due") else N_TURNS), name


@pytest.mark.parametrize(("places", "n_days"), [((0, 0), N_TURNS), ((0, 1), 1), ((2, 1), 1)])
def test_the_first_values_of_a_slow_test_are_taken_every_day_and_others_on_one(places, n_days):
    item = Item(kills, SimpleNamespace(indices=dict(enumerate(places))))

    assert sum(not TIERS["rest"].leaves(item, day) for day in range(N_TURNS)) == n_days
    assert not TIERS["night"].leaves(item, 0)


def test_seeds_beyond_the_first_are_slow_and_have_turns():
    first, *others = seeds("abc", 1)

    assert first == "a"
    assert others == in_turn("bc")
    assert [(param.values, [mark.name for mark in param.marks]) for param in others] == [
        (("b",), ["slow", "turn"]),
        (("c",), ["slow", "turn"]),
    ]
    assert [param.marks[1].args for param in others] == [(0,), (1,)]


def test_values_of_three_parameters_are_spread_over_all_days():
    """As pytest numbers a product: each parameter has the place of the whole."""
    items = [Item(kills, SimpleNamespace(indices=dict.fromkeys("abc", k))) for k in range(1, 7)]

    for day in range(N_TURNS):
        assert sum(not TIERS["rest"].leaves(item, day) for item in items) == 2
