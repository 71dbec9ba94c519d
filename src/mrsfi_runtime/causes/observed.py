"""What is compared of two flights at a tick: what is known, and what is sent."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import TypeAlias

POSITION, HEADING, PROGRESS, MEMORY = "position", "heading", "progress", "memory"

Quantities: TypeAlias = Mapping[str, tuple[str, ...]]
"""Fields of a record, by what they say together."""

KNOWN: Mapping[str, Quantities] = MappingProxyType(
    {
        "robots": {POSITION: ("x", "y", "z"), "speed": ("speed",), "energy": ("energy",)},
        "sensors": {
            "samples": ("count",),
            "activation": ("active",),
            "rate": ("rate",),
            "cost": ("cost",),
        },
        "obstacles": {POSITION: ("x", "y")},
        "goals": {PROGRESS: ("count", "seen", "sampled_x", "sampled_y"), MEMORY: ("memory",)},
        "members": {PROGRESS: ("since", "reached", "waypoint")},
    }
)
"""Quantities of a true or local state, by the list whose records have them."""

SENT: Mapping[str, Quantities] = MappingProxyType(
    {
        "commands": {HEADING: ("heading_x", "heading_y"), "speed": ("sent_speed",)},
        "switches": {"activation": ("active",)},
    }
)
"""Those of the local state that say what was sent."""

FORGED: Mapping[str, Quantities] = MappingProxyType({"sensors": {"activation": ("active",)}})
"""Those of the true state that do: a forged activation shows in these only, a tick later."""
