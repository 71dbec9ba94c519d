"""Digests as the second version of the semantics makes them, whatever states look like since.

Nothing here asks the product how it encodes: names and order of the fields are spelt out. Where a
field has moved since, ``MOVED`` says where it stands now; the order of the bytes never changes.
"""

import hashlib
import struct
from collections.abc import Callable

from mrsfi_runtime.kernel.flight import Verdicts
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.mission import Outcome

FIELDS = {
    "robots": (
        "x y z speed energy nominal_speed max_speed energy_per_distance first_sensor n_sensors gps"
    ),
    "sensors": "robot count active rate cost nominal_rate nominal_cost first_chance n_chances",
    "obstacles": "x y radius model_x model_y",
    "goals": (
        "task x y radius first_member n_members first_hazard n_hazards first_waypoint n_waypoints "
        "sensor target tolerance distance period deadline count seen sampled_x sampled_y"
    ),
    "members": "robot since reached waypoint",
    "commands": "heading_x heading_y speed sent_speed heading_claimed speed_claimed",
    "switches": "active claimed",
}
"""Lists of a state, and the fields of their records, in the order of the bytes."""

MOVED: dict[str, Callable[[State, int], float]] = {}
"""Where ``list.field`` of a record's index is found today, if no longer under its old name."""


def state_bytes(state: State) -> bytes:
    """Return a state as little-endian doubles, record after record, −0 as 0."""
    return b"".join(
        struct.pack("<d", float(_value(state, name, index, field)) + 0.0)
        for name, fields in FIELDS.items()
        for index in range(len(getattr(state, name)))
        for field in fields.split()
    )


def _value(state: State, name: str, index: int, field: str) -> float:
    moved = MOVED.get(f"{name}.{field}")
    if moved is not None:
        return moved(state, index)
    value: float = getattr(getattr(state, name)[index], field)
    return value


class FrozenTrace:
    """Observer that digests belief and truth at every tick."""

    def __init__(self) -> None:
        self._sha = hashlib.sha256()

    def __call__(self, world: State, belief: State, verdicts: Verdicts) -> None:
        """Add one tick."""
        self._sha.update(state_bytes(world))
        self._sha.update(state_bytes(belief))
        self._sha.update(bytes([*verdicts.is_true, *verdicts.is_believed]))

    def hexdigest(self) -> str:
        """Return the SHA-256 of all ticks so far."""
        return self._sha.hexdigest()


def outcome_digest(outcome: Outcome, world: State, belief: State) -> str:
    """Return the digest of an outcome whose flight ended with these states."""
    counts = (
        outcome.believed,
        outcome.true,
        outcome.phantom,
        outcome.masked,
        outcome.missed,
        outcome.samples,
        outcome.applied,
        outcome.changed,
    )
    last = state_bytes(world) + state_bytes(belief)
    return hashlib.sha256(repr(counts).encode() + last).hexdigest()
