"""Tiers leave no test out: what one does not run, another does."""

from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tiers import TIERS, seeds, slow


@slow
def kills():
    pass


@given(st.none())
def holds(_):
    pass


def adds():
    pass


@dataclass
class Item:
    obj: object

    def get_closest_marker(self, name):
        marks = getattr(self.obj, "pytestmark", [])
        return next((mark for mark in marks if mark.name == name), None)


@pytest.mark.parametrize(
    ("test", "tiers"),
    [
        (adds, {"quick", "test", "all"}),
        (kills, {"rest", "all"}),
        (holds, {"quick", "test", "rest", "all"}),
    ],
)
def test_a_test_runs_in_its_tiers(test, tiers):
    assert {name for name, tier in TIERS.items() if tier.takes(Item(test))} == tiers


def test_what_make_test_leaves_out_make_test_all_runs():
    fast, rest, every = (TIERS[name] for name in ("test", "rest", "all"))

    for test in (adds, kills, holds):
        assert every.takes(Item(test))
        assert fast.takes(Item(test)) or rest.takes(Item(test))
    assert fast.rooms == rest.rooms == ()


def test_seeds_beyond_the_first_are_slow():
    first, second, third = seeds("abc", 1)

    assert first == "a"
    assert [(param.values, param.marks) for param in (second, third)] == [
        (("b",), (slow,)),
        (("c",), (slow,)),
    ]
