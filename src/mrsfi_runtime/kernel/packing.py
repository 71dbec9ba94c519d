"""What changes in a state, as named columns: the order of a digest, and of a recorded moment."""

import struct
from collections.abc import Mapping

from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.fault_types import Field

_COLUMNS = {
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
COLUMNS: Mapping[str, tuple[str, ...]] = {
    name: tuple(columns.split()) for name, columns in _COLUMNS.items()
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
