"""Which make target runs a test, and how many examples it draws of a law.

A test without a marker runs in make test, one marked ``slow`` in make test-all. make test-night
runs both, and what is marked ``night``. Laws of hypothesis state how many examples make test draws.
"""

from collections.abc import Callable, Iterable
from typing import Any

import pytest
from hypothesis import settings

QUICK = ("disk", "golden", "model", "property", "unit")
"""Rooms of make quick: their tests start no process and open no socket."""

EXAMPLES = {"quick": 30, "test": 100, "night": 400}
"""Profiles of hypothesis: examples of a law, in per cent of those that it states."""

slow = pytest.mark.slow
night = pytest.mark.night


def seeds(values: Iterable[Any], n_plain: int = 3, n_slow: int = 3) -> list[Any]:
    """Return the values of a parameter: the first few plain, the next few slow, others at night."""
    return [
        value
        if place < n_plain
        else pytest.param(value, marks=slow if place < n_plain + n_slow else night)
        for place, value in enumerate(values)
    ]


def law(stated: int, **more: Any) -> Callable[[Any], Any]:
    """Return settings of hypothesis for a law: how many examples make test draws."""
    n_examples = max(1, stated * settings().max_examples // 100)
    return settings(max_examples=n_examples, deadline=None, **more)
