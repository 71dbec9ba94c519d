"""What the evaluation of one fault specification found."""

from dataclasses import dataclass
from typing import TypeAlias

COUNTED = ("believed", "true", "phantom", "masked", "missed")
"""What is counted in ticks for each goal, in the order of an outcome's attributes."""

TOLD = (*COUNTED, "missed_since")
"""What is told of each goal: what is counted, and since when it was certain to be missed."""


Margin: TypeAlias = tuple[float, int]
"""By how much a goal was not violated when it was nearest to it, and the tick of that."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """Violations per goal, each of shape ``(n_goals,)`` in model order, and what faults did.

    Attributes
    ----------
    believed
        Ticks at which the collective intelligence believed the goal violated: the paper's
        measure.
    true
        Ticks at which it truly was.
    phantom
        Believed, not true.
    masked
        True, not believed.
    missed
        Ticks from the one on at which it was certain, from the truth alone, that the goal's
        purpose is not met; 0 where it was met.
    samples
        Samples counted towards each goal, in truth; 0 for goals that gather none.
    applied
        For each timed fault, at how many ticks it was active.
    changed
        For each timed fault, at how many ticks it changed at least one value.
    digest
        SHA-256 over all of the above and the final true and believed states, as IEEE-754 bits.
    margins
        How far each goal was from being truly violated when it was nearest to it, in the unit of
        its task, and the tick of that; ``None`` for a goal of which that cannot be said. ``None``
        as a whole if not recorded.
    detection
        Ticks from the first one on at which each goal was truly violated or missed, and how many of
        these passed before the belief showed a violation. ``None`` as a whole if not recorded.
    """

    believed: tuple[int, ...]
    true: tuple[int, ...]
    phantom: tuple[int, ...]
    masked: tuple[int, ...]
    missed: tuple[int, ...]
    samples: tuple[int, ...]
    applied: tuple[int, ...]
    changed: tuple[int, ...]
    digest: str
    margins: tuple[Margin | None, ...] | None = None
    detection: tuple[tuple[int, int], ...] | None = None

    def missed_since(self, duration: int) -> tuple[int | None, ...]:
        """Return from which tick on each goal was certain to be missed, ``None`` if it was met."""
        return tuple(duration - ticks if ticks else None for ticks in self.missed)

    def told(self, duration: int) -> dict[str, tuple[int | None, ...]]:
        """Return what came of each goal by the names in ``TOLD``; None where there is nothing."""
        counts = [getattr(self, name) for name in COUNTED]
        return dict(zip(TOLD, (*counts, self.missed_since(duration)), strict=True))


@dataclass(frozen=True, slots=True)
class FailedFlight:
    """What comes of an evaluation whose mission code failed: the traceback as text."""

    traceback: str


Evaluated: TypeAlias = Outcome | FailedFlight
"""What comes of an evaluation."""
