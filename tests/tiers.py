"""The tiers of the tests: what runs when, and with how many seeds and examples.

====================== ============== =================================================
``make quick``         --tier quick   units and laws, the rooms of ``QUICK``
``make test``          --tier test    all but what is marked slow; also without --tier
``make test-all``      --tier rest    what is marked slow, and laws on more examples: of
                                      what is drawn, the third whose turn it is
``make test-night``    --tier night   the same, all of it
``.ci/run``            --tier due     what is never left to a night, and that third; for
                                      rooms that ``make test`` leaves out
====================== ============== =================================================

A test that belongs to the rest is marked ``@slow``. One that takes seeds takes ``seeds(…)``,
and leaves all but the first few of them to the rest; one that is slow for each of its values
takes ``in_turn(…)``, and what draws inside of a test asks ``is_due(…)``. One that takes more than
five seconds of work is marked ``@pytest.mark.turn(…)``, too. Of any other slow test with several
values, the first runs every day and the others have turns. Laws of hypothesis are
multiplied by tier. Whose turn it is follows from the date of the commit, so that three days run
all of it and one commit always the same.
"""

import subprocess
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from datetime import date
from functools import cache
from pathlib import Path
from typing import Any
from zlib import crc32

import pytest
from hypothesis import settings

QUICK = ("disk", "golden", "model", "property", "unit")
"""Rooms of tests that start no process, open no socket, draw and compile nothing."""

FILELESS = ("golden", "property", "unit")
"""Those of them that do not write files either; ``guard`` sees to all of it."""

N_SEEDS = 3
"""Seeds of each seeded test in ``make test``; the others follow in ``make test-all``."""

N_TURNS = 3
"""Days after which every seed, value and law had its turn in ``make test-all``."""


def turn(n_turns: int = N_TURNS) -> int:
    """Return whose turn it is of so many: it follows from the day."""
    return _day() % n_turns


@cache
def _day() -> int:
    """Return the day of the commit, today's without git, as a number."""
    try:
        told = subprocess.run(
            ["git", "log", "-1", "--format=%cs"],
            cwd=Path(__file__).parent,
            capture_output=True,
            text=True,
            check=True,
        ).stdout.strip()
        day = date.fromisoformat(told)
    except (OSError, subprocess.CalledProcessError, ValueError):
        day = date.today()
    return day.toordinal()


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
    takes_turns
        Whether what has turns belongs to it only in its turn.
    """

    rooms: tuple[str, ...]
    examples: int
    takes_slow: bool
    takes_fast: bool
    takes_turns: bool = False

    def takes(self, item: pytest.Item) -> bool:
        """Return whether a test belongs to the tier; laws belong to every one."""
        is_slow = item.get_closest_marker("slow") is not None
        return self.takes_slow if is_slow else self.takes_fast or _is_law(item)

    def leaves(self, item: pytest.Item, today: int) -> bool:
        """Return whether a test that belongs to the tier has its turn on another day."""
        turns = [mark.args[0] for mark in item.iter_markers("turn")]
        if _is_law(item):
            turns.append(crc32(item.nodeid.encode()))
        elif not turns and item.get_closest_marker("slow") is not None:
            place = sum({*_places(item)})  # pytest gives parameters of one product one place
            turns = [place] if place else []
        return self.takes_turns and bool(turns) and sum(turns) % N_TURNS != today


def _places(item: pytest.Item) -> Iterable[int]:
    """Return the places of a test's values among those of its parameters."""
    callspec = getattr(item, "callspec", None)
    return () if callspec is None else callspec.indices.values()


def _is_law(item: pytest.Item) -> bool:
    return hasattr(getattr(item, "obj", None), "hypothesis")


TIERS = {
    "quick": Tier(QUICK, 30, takes_slow=False, takes_fast=True),
    "test": Tier((), 100, takes_slow=False, takes_fast=True),
    "rest": Tier((), 400, takes_slow=True, takes_fast=False, takes_turns=True),
    "night": Tier((), 400, takes_slow=True, takes_fast=False),
    "due": Tier((), 100, takes_slow=True, takes_fast=True, takes_turns=True),
    "all": Tier((), 100, takes_slow=True, takes_fast=True),
}

slow = pytest.mark.slow


def seeds(values: Iterable[Any], n_fast: int = N_SEEDS) -> list[Any]:
    """Return the values of a parameter, all but the first few of them slow, and in turn."""
    values = list(values)
    return values[:n_fast] + in_turn(values[n_fast:])


def in_turn(values: Iterable[Any], first: int = 0) -> list[Any]:
    """Return the values of a parameter, all slow, each with a turn, one after the other."""
    return [
        pytest.param(value, marks=(slow, pytest.mark.turn(k)))
        for k, value in enumerate(values, first)
    ]


def is_due(place: int, n_turns: int = N_TURNS) -> bool:
    """Return whether a place among what has turns inside of a test is due in the tier that runs."""
    takes_turns = TIERS[settings.get_current_profile_name()].takes_turns
    return not takes_turns or place % n_turns == turn(n_turns)


def n_examples(stated: int) -> int:
    """Return how many examples the tier that runs wants of a law that states a number."""
    return max(1, stated * settings().max_examples // 100)


def law(stated: int, **more: Any) -> Callable[[Any], Any]:
    """Return settings of hypothesis for a law: how many examples ``make test`` draws."""
    return settings(max_examples=n_examples(stated), deadline=None, **more)
