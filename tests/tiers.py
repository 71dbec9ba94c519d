"""The tiers of the tests: what runs when, and with how many seeds and examples.

====================== ============== =================================================
``make quick``         --tier quick   units and laws, the rooms of ``QUICK``
``make test``          --tier test    all but what is marked slow; also without --tier
``make test-all``      --tier rest    what is marked slow, and each law on more examples
====================== ============== =================================================

A test that belongs to the rest is marked ``@slow``. One that takes seeds takes ``seeds(…)``,
and leaves all but the first few of them to the rest. Laws of hypothesis are multiplied by tier.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import pytest
from hypothesis import settings

QUICK = ("disk", "golden", "model", "property", "unit")
"""Rooms of tests that start no process, open no socket, draw and compile nothing."""

FILELESS = ("golden", "property", "unit")
"""Those of them that do not write files either; ``guard`` sees to all of it."""

N_SEEDS = 3
"""Seeds of each seeded test in ``make test``; the others follow in ``make test-all``."""


@dataclass(frozen=True, slots=True)
class Tier:
    """A part of the tests.

    Parameters
    ----------
    rooms
        Rooms that it goes through; empty for all.
    examples
        Share of the examples of a law, in per cent of those that it states.
    takes_slow, takes_fast
        Whether tests belong to it that are marked slow, and those that are not.
    """

    rooms: tuple[str, ...]
    examples: int
    takes_slow: bool
    takes_fast: bool

    def takes(self, item: pytest.Item) -> bool:
        """Return whether a test belongs to the tier; laws belong to every one."""
        is_slow = item.get_closest_marker("slow") is not None
        is_law = hasattr(getattr(item, "obj", None), "hypothesis")
        return self.takes_slow if is_slow else self.takes_fast or is_law


TIERS = {
    "quick": Tier(QUICK, 30, takes_slow=False, takes_fast=True),
    "test": Tier((), 100, takes_slow=False, takes_fast=True),
    "rest": Tier((), 400, takes_slow=True, takes_fast=False),
    "all": Tier((), 100, takes_slow=True, takes_fast=True),
}

slow = pytest.mark.slow


def seeds(values: Iterable[Any], n_fast: int = N_SEEDS) -> list[Any]:
    """Return the values of a parameter, all but the first few of them slow."""
    return [
        value if k < n_fast else pytest.param(value, marks=slow) for k, value in enumerate(values)
    ]


def n_examples(stated: int) -> int:
    """Return how many examples the tier that runs wants of a law that states a number."""
    return max(1, stated * settings().max_examples // 100)


def law(stated: int, **more: Any) -> Callable[[Any], Any]:
    """Return settings of hypothesis for a law: how many examples ``make test`` draws."""
    return settings(max_examples=n_examples(stated), deadline=None, **more)
