"""What the evaluation of one fault specification found."""

from dataclasses import dataclass
from typing import TypeAlias

COUNTED = ("believed", "true", "phantom", "masked", "missed")
"""What is counted in ticks for each goal, in the order of an outcome's attributes."""

TOLD = (*COUNTED, "missed_since")
"""What is told of each goal: what is counted, and since when it was certain to be missed."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """Violations per goal, each of shape ``(n_goals,)`` in model order, and what faults did.

    The collective intelligence ``believed`` a goal violated at so many ticks, the paper's measure;
    at so many it was ``true``. ``phantom`` ticks were believed and not true, ``masked`` ones true
    and not believed. ``missed`` are those from the one on at which it was certain, from the truth
    alone, that the goal's purpose is not met, 0 where it was met; ``None`` in a record of semantics
    1, which does not say. ``samples`` were counted towards each goal, in truth, 0 for goals that
    gather none. Each timed fault was active at ``applied`` ticks, and at ``changed`` ones changed
    at least one value. ``digest`` is the SHA-256 over all of this and the final true and believed
    states, as IEEE-754 bits.
    """

    believed: tuple[int, ...]
    true: tuple[int, ...]
    phantom: tuple[int, ...]
    masked: tuple[int, ...]
    missed: tuple[int, ...] | None
    samples: tuple[int, ...]
    applied: tuple[int, ...]
    changed: tuple[int, ...]
    digest: str

    def missed_since(self, duration: int) -> tuple[int | None, ...] | None:
        """Return from which tick on each goal was certain to be missed, ``None`` if it was met.

        ``None`` as a whole if that is not known.
        """
        if self.missed is None:
            return None
        return tuple(duration - ticks if ticks else None for ticks in self.missed)

    def told(self, duration: int) -> dict[str, tuple[int | None, ...]]:
        """Return what came of each goal by the names in ``TOLD``; None where there is nothing."""
        unknown = (None,) * len(self.true)
        counts = [getattr(self, name) for name in COUNTED]
        found = (count or unknown for count in (*counts, self.missed_since(duration)))
        return dict(zip(TOLD, found, strict=True))


@dataclass(frozen=True, slots=True)
class FailedFlight:
    """What comes of an evaluation whose mission code failed: the traceback as text."""

    traceback: str


Evaluated: TypeAlias = Outcome | FailedFlight
"""What comes of an evaluation."""
