"""What is compared of two flights at a tick: what is known, and what is sent."""

from collections.abc import Callable, Mapping
from operator import attrgetter
from types import MappingProxyType
from typing import Any, TypeAlias

from mrsfi_runtime.kernel.state import State

KNOWN: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "robots": ("x", "y", "z", "speed", "energy"),
        "sensors": ("count", "active", "rate", "cost"),
        "obstacles": ("x", "y"),
        "goals": ("count", "seen", "sampled_x", "sampled_y"),
        "members": ("since", "reached", "waypoint"),
    }
)
"""Fields of the records of a true or local state, by the name of their list."""

SENT: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"commands": ("heading_x", "heading_y", "sent_speed"), "switches": ("active",)}
)
"""Those of the local state that say what was sent."""

Read: TypeAlias = list[tuple[float, ...]]
"""The fields of each record, list by list."""

_Reader: TypeAlias = Callable[[Any], tuple[float, ...]]


def _reader(fields: tuple[str, ...]) -> _Reader:
    get: Any = attrgetter(*fields)
    return get if len(fields) > 1 else lambda record: (get(record),)  # of one, no tuple


_KNOWN = {name: _reader(fields) for name, fields in KNOWN.items()}
_SENT = {name: _reader(fields) for name, fields in SENT.items()}
_FORGED = {"sensors": _reader(("active",))}


def _read(state: State, columns: Mapping[str, _Reader]) -> Read:
    return [get(record) for name, get in columns.items() for record in getattr(state, name)]


def known(state: State) -> Read:
    """Return what the simulation or the collective intelligence knows."""
    return _read(state, _KNOWN)


def sent(world: State, belief: State) -> Read:
    """Return headings, speeds and activations as sent, then the true activations.

    A forged activation shows in these only, a tick later.
    """
    return _read(belief, _SENT) + _read(world, _FORGED)
