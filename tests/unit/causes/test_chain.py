"""What scripts get of a chain of first differences."""

import json

from mrsfi_runtime.causes.chain import (
    HEADING,
    Chain,
    Change,
    First,
    FirstVerdict,
    FirstVerdicts,
    chain_as_json,
)


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
