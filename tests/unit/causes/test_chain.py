"""Chains of first differences, in scripts and in sentences."""

import json

import pytest

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
from mrsfi_runtime.model.fault_types import Units


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
            "(3.00, 4.00, 0.00), not (3.00, 5.00, 0.00)",
        ),
        ("position", (3.0, 4.0, 0.0), (3.0, 4.001, 0.0), "(3.00, 4.00, 0.00), 1e-03 off"),
        (HEADING, (40.0,), (20.0,), "40.0 degrees, not 20.0 degrees"),
        (HEADING, (0.01,), (360.0,), "0.0 degrees, not 360.0 degrees"),
        (HEADING, (20.0,), (20.000004,), "20.0 degrees, 4e-06 off"),
        ("energy", (7.0,), (8.5,), "7, not 8.50"),
    ],
)
def test_a_change_is_told_so_that_it_can_be_seen(quantity, found, otherwise, said):
    first = First(3, (Change("r1", quantity, found, otherwise),))

    assert changed(first, Units()) == f"r1 {quantity} {said}"
