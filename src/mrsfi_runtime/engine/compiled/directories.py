"""Where the parts of a record of lists lie in memory: a directory of addresses and lengths.

Compiled code knows a state, a plan or the verdicts by the address of such a directory, so that
sizes are data: one compiled flight serves every mission.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, get_args, get_type_hints

import numpy as np

from mrsfi_runtime.engine.recording import KINDS, record_type
from mrsfi_runtime.kernel.injections import OwnFault
from mrsfi_runtime.kernel.state import State

N_ALLOWED = 6
ALLOWED = " allowed"  # no name that a region could use
OWN = np.dtype([*record_type(OwnFault).descr, (ALLOWED, "<i8", (N_ALLOWED,))])
"""A fault of a team's own type, and which words of the belief it may change; all others follow."""

RECORDED, CALLS = " recorded", " calls"
"""Lists of a state that no region can name: words that are recorded, what its regions are."""

_HIDDEN: Mapping[type, tuple[str, ...]] = {State: (RECORDED, CALLS)}


@dataclass(frozen=True, slots=True)
class Entry:
    """A field of a record of lists: a list, a record, a number of one, or a directory within.

    ``place`` is the number of its entry in the directory, and ``layout`` that of an element.
    """

    kind: str
    place: int
    layout: np.dtype[Any]
    inner: type | None = None


@cache
def entries(kind: type) -> Mapping[str, Entry]:
    """Return the fields of a record of lists, by name; all its numbers are in one record."""
    hints = get_type_hints(kind)
    found: dict[str, Entry] = {}
    numbers = np.dtype([(name, KINDS[hint]) for name, hint in hints.items() if hint in KINDS])
    place = 1 if numbers.names else 0
    for name, hint in hints.items():
        if hint in KINDS:
            found[name] = Entry("number", 0, numbers)
            continue
        elements = (hint,) if hint is bytes else get_args(hint)
        if elements:
            found[name] = Entry("list", place, element_type(elements[0]))
        elif any(get_args(inner) and inner not in KINDS for inner in get_type_hints(hint).values()):
            found[name] = Entry("inner", place, np.dtype(np.int64), hint)
            place += n_entries(hint) - 1
        else:
            found[name] = Entry("record", place, record_type(hint))
        place += 1
    for name in _HIDDEN.get(kind, ()):
        found[name] = Entry("list", place, np.dtype(np.int64))
        place += 1
    return found


def n_entries(kind: type) -> int:
    """Return how many entries the directory of a record of lists has."""
    last = list(entries(kind).values())[-1]
    return last.place + (n_entries(last.inner) if last.inner else 1)


def element_type(element: Any) -> np.dtype[Any]:
    """Return the layout of an element of a list."""
    known = {OwnFault: OWN, bytes: np.dtype(np.uint8)}
    if element in known:
        return known[element]
    return np.dtype(KINDS[element]) if element in KINDS else record_type(element)
