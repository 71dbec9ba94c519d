"""What is compared of two flights at a tick: what is known, and what is sent."""

from collections.abc import Callable, Mapping
from operator import attrgetter
from types import MappingProxyType
from typing import Any, TypeAlias

from mrsfi_runtime.kernel.state import State

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

Read: TypeAlias = list[tuple[float, ...]]
"""The fields of each record, list by list."""

_Reader: TypeAlias = Callable[[Any], tuple[float, ...]]


def _reader(quantities: Quantities) -> _Reader:
    names = [name for fields in quantities.values() for name in fields if name != MEMORY]
    get: Any = attrgetter(*names)
    if MEMORY in quantities:
        return lambda record: (*get(record), *record.memory)
    return get if len(names) > 1 else lambda record: (get(record),)  # of one, no tuple


_KNOWN, _SENT, _FORGED = (
    {name: _reader(quantities) for name, quantities in lists.items()}
    for lists in (KNOWN, SENT, FORGED)
)


def _read(state: State, columns: Mapping[str, _Reader]) -> Read:
    return [get(record) for name, get in columns.items() for record in getattr(state, name)]


def known(state: State) -> Read:
    """Return what the simulation or the collective intelligence knows."""
    return _read(state, _KNOWN)


def sent(world: State, belief: State) -> Read:
    """Return headings, speeds and activations as sent, then the true activations."""
    return _read(belief, _SENT) + _read(world, _FORGED)
