"""What the evaluation of one fault specification found."""

from dataclasses import dataclass


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
    samples
        Samples counted towards each goal, in truth; 0 for goals that gather none.
    applied
        For each timed fault, at how many ticks it was active.
    changed
        For each timed fault, at how many ticks it changed at least one value.
    digest
        SHA-256 over all of the above and the final true and believed states, as IEEE-754 bits.
    """

    believed: tuple[int, ...]
    true: tuple[int, ...]
    phantom: tuple[int, ...]
    masked: tuple[int, ...]
    samples: tuple[int, ...]
    applied: tuple[int, ...]
    changed: tuple[int, ...]
    digest: str
