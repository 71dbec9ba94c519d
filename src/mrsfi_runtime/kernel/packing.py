"""What changes in a state, as named columns: the order of a digest, and of a recorded moment."""

import struct
from collections.abc import Mapping
from typing import get_args, get_type_hints

from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.fault_types import Field

_CHANGING = ("robots", "sensors", "obstacles", "goals", "members", "commands", "switches")
_HINTS = get_type_hints(State)
COLUMNS: Mapping[str, tuple[str, ...]] = {
    name: tuple(hint for hint in get_type_hints(get_args(_HINTS[name])[0]) if hint != "memory")
    for name in _CHANGING
}
"""Columns of the lists of a state whose records change in a flight, list after list."""

PROPERTIES: Mapping[Field, tuple[str, tuple[str, ...]]] = {
    Field.POSITION: ("robots", ("x", "y", "z")),
    Field.SPEED: ("robots", ("speed",)),
    Field.ENERGY: ("robots", ("energy",)),
    Field.COUNT: ("sensors", ("count",)),
    Field.RATE: ("sensors", ("rate",)),
    Field.COST: ("sensors", ("cost",)),
    Field.OBSTACLE: ("obstacles", ("x", "y")),
}
"""Where a state has what may be believed otherwise than it is: the list, and the columns there."""


def state_bytes(state: State) -> bytes:
    """Return all that changes in a state as bytes: IEEE-754 doubles, record after record, −0 as 0.

    Last comes what goals remember, unless it is all 0, as in missions that do without. Compiled
    flights are packed alike (``engine.compiled.layout.packed``).
    """
    values = [
        float(getattr(record, column)) + 0.0
        for name, columns in COLUMNS.items()
        for record in getattr(state, name)
        for column in columns
    ]
    memory = [number + 0.0 for goal in state.goals for number in goal.memory]
    if any(memory):
        values += memory
    return struct.pack(f"<{len(values)}d", *values)
