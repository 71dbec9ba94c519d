"""Ways to break a goal: its least sets of faults, numbered, and the one that is told first."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any, Self

from mrsfi_runtime.causes.mildest import Mildest
from mrsfi_runtime.causes.weakness import MEASURES, Weakness


@dataclass(frozen=True, slots=True)
class Way:
    """A way to break a goal: a least set of the pool's faults that does, numbered from 1.

    ``by`` has a weakness for each measure by which they break it, in the order of ``MEASURES``;
    ``mildest`` is the mildest form, by the gravest measure, where one was looked for.
    """

    number: int
    goal: str
    faults: tuple[str, ...]
    by: tuple[Weakness, ...]
    mildest: Mildest | None = None

    @property
    def shown(self) -> Weakness:
        """That of the gravest measure: missed before true, true before believed."""
        return self.by[-1]

    @property
    def is_undetected(self) -> bool:
        """Whether the collective intelligence does not detect at least one of the variants."""
        return self.shown.detection is not None and self.shown.detection.n_never > 0

    @property
    def is_mildest(self) -> bool:
        """Whether the mildest form is the one that is shown."""
        return self.mildest is not None and self.mildest.weakness == self.shown

    @property
    def at_least(self) -> Self:
        """The same in its mildest form, if one is known."""
        if self.mildest is None:
            return self
        return replace(self, by=(*self.by[:-1], self.mildest.weakness))

    def as_json(self) -> list[dict[str, Any]]:
        """Return the weaknesses as plain values."""
        return [{"number": self.number, **each.as_json()} for each in self.by]


def ways(found: Iterable[Weakness], mildest: Iterable[Mildest] = ()) -> tuple[Way, ...]:
    """Return weaknesses, in the order in which they are known, as ways to break goals."""
    grouped = groupby(found, key=_way)
    least_of = {_way(each.weakness): each for each in mildest}
    return tuple(
        Way(number, *way, tuple(each), least_of.get(way))
        for number, (way, each) in enumerate(grouped, 1)
    )


def _way(weakness: Weakness) -> tuple[str, tuple[str, ...]]:
    return weakness.column.goal, weakness.faults


def least(found: Iterable[Way]) -> tuple[Way, ...]:
    """Return a way for each goal: of fewest faults, in truth, in most mission seeds and forms."""

    def size(each: Way) -> tuple[int, bool, int, float]:
        shown = each.shown
        n_lost = shown.n_seeds - shown.n_held
        return len(each.faults), shown.column.kind == MEASURES[0], n_lost, -shown.share

    by_goal = groupby(found, key=lambda each: each.goal)
    return tuple(min(some, key=size).at_least for _, some in by_goal)
