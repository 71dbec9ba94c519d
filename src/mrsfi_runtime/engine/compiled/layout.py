"""Lays states and fault plans out as structured arrays, field by field as their records say.

A state becomes one record that holds arrays of records; the kernel reads and writes it with
the same attributes, indices and loops as the plain objects.
"""

from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass
from functools import lru_cache
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np
import numpy.typing as npt

from mrsfi_runtime.engine.recording import KINDS, Records, record_type
from mrsfi_runtime.kernel.injections import FaultTally, InjectionState, OwnFault, PlanRows
from mrsfi_runtime.kernel.packing import COLUMNS
from mrsfi_runtime.kernel.randomness import PURPOSE_SAMPLES, draw
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.kernel.weather import reached

NEVER = 2**62
"""Start of the sentinel behind the last injection of a list."""

TABLES = tuple(name for name, hint in get_type_hints(State).items() if get_origin(hint) is tuple)
"""Parts of a state that no flight may change, so that they need not be laid out anew for each."""


@dataclass(frozen=True, slots=True)
class PlanSize:
    """How much a compiled plan has room for; a larger specification is compiled for anew.

    ``faults`` counts timed faults, ``injections`` those of one list with the sentinel behind
    the last, ``own`` faults of a team's own types likewise, ``held`` numbers that delays hold back.
    """

    faults: int = 64
    injections: int = 256
    held: int = 65_536
    own: int = 8

    def for_plans(self, plans: Sequence[PlanRows]) -> "PlanSize":
        """Return room for all of some plans, in few sizes."""
        return PlanSize(
            _grown(self.faults, max(one.n_faults for one in plans)),
            _grown(self.injections, 1 + max(max(map(len, one.lists)) for one in plans)),
            _grown(self.held, max(one.n_held for one in plans)),
            _grown(self.own, 1 + max(len(one.own) for one in plans)),
        )


N_ALLOWED = 6
ALLOWED = " allowed"  # no name that a region could use
OWN = np.dtype([*record_type(OwnFault).descr, (ALLOWED, "<i8", (N_ALLOWED,))])
"""A fault of a team's own type, and which words of the belief it may change; all others follow."""


def allowed_words(
    layout: np.dtype[Any], listed: str, target: int, columns: Sequence[str]
) -> list[int]:
    """Return the words of some columns of a record of a state, in order; then one beyond them."""
    words = np.arange(layout.itemsize // 8).view(layout)[0][listed][target]
    found = sorted(int(words[column].view(np.int64)) for column in columns)
    return found + [recorded_words(layout)] * (N_ALLOWED - len(found))


def recorded_words(layout: np.dtype[Any]) -> int:
    """Return how many words of a state are recorded; they come first."""
    fields: Mapping[str, Any] = layout.fields or {}
    return int(min(about[1] for name, about in fields.items() if name not in COLUMNS) // 8)


def _grown(room: int, needed: int) -> int:
    while room < needed:
        room *= 8
    return room


def state_type(state: State) -> np.dtype[Any]:
    """Return the layout of a state: what is recorded, what else changes, tables."""
    hints = get_type_hints(State)
    names = sorted(hints, key=lambda name: (name in TABLES, name not in COLUMNS))
    return np.dtype([_member(name, hints[name], getattr(state, name)) for name in names])


def split(states: Records) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return what changes in some states, and what never does, as words of 8 bytes.

    Both have shape ``(n_states, n_words)``.
    """
    layout: Mapping[str, Any] = states.dtype.fields or {}
    n_words = min(layout[name][1] for name in TABLES) // 8
    words = states.view(np.int64).reshape(len(states), -1)
    return words[:, :n_words], words[:, n_words:]


def _member(name: str, hint: Any, value: Any) -> tuple[Any, ...]:
    """Return the layout of a record's field: a number, a record, or a list of either."""
    if hint in KINDS:
        return name, KINDS[hint]
    elements = get_args(hint)
    if elements:
        return name, KINDS.get(elements[0]) or record_type(elements[0]), (len(value),)
    members = get_type_hints(hint).items()
    return name, np.dtype([_member(inner, kind, getattr(value, inner)) for inner, kind in members])


def write_state(row: Any, state: Any) -> None:
    """Copy a state, or a record in it, into a record of its layout."""
    for name, hint in get_type_hints(type(state)).items():
        elements = get_args(hint)
        value = getattr(state, name)
        if hint in KINDS:
            row[name] = value
        elif not elements:
            write_state(row[name], value)
        elif value:
            row[name] = value if elements[0] is int else [astuple(record) for record in value]


@lru_cache(maxsize=16)
def plan_type(room: PlanSize) -> np.dtype[Any]:
    """Return the layout of a plan."""
    injection = record_type(InjectionState)
    return np.dtype(
        [
            ("messages", injection, (room.injections,)),
            ("reports", injection, (room.injections,)),
            ("commands", injection, (room.injections,)),
            ("held", "<f8", (room.held,)),
            ("tallies", record_type(FaultTally), (room.faults,)),
            ("own", OWN, (room.own,)),
        ]
    )


def weather_table(state: State) -> npt.NDArray[np.uint8]:
    """Return what ``kernel.weather.weather`` does, shape ``(n_ticks, n_sensors)``, read-only."""
    ticks: Any = np.arange(state.mission.duration, dtype=np.uint64)  # drawn all at once
    table = np.empty((len(ticks), len(state.sensors)), np.uint8)
    for sensor, chances in enumerate(reached(state)):
        draws = draw(state.mission.seed, ticks, sensor, PURPOSE_SAMPLES)
        table[:, sensor] = np.searchsorted(np.array(chances, np.uint64), draws, side="right")
    table.flags.writeable = False
    return table


def words_type(moment: np.dtype[Any]) -> np.dtype[Any]:
    """Return the layout of a tick with its states as words, which compiled code copies."""
    return np.dtype(
        [
            (name, "<i8", moment[name].shape or (moment[name].itemsize // 8,))
            for name in moment.names or ()
        ]
    )


def packed(states: Records) -> list[memoryview]:
    """Return what ``kernel.packing.state_bytes`` returns of states, as recorded."""
    places, is_float, end = _packing(states.dtype)
    as_words = np.dtype([("words", "<i8", (states.dtype.itemsize // 8,))])
    words = states.view(as_words)["words"].take(places, axis=1)
    rows = np.where(is_float, words.view(np.float64), words) + 0.0
    remember: Any = rows[:, end:].any(axis=1)
    return [(row if has else row[:end]).data for row, has in zip(rows, remember, strict=True)]


@lru_cache(maxsize=16)
def _packing(
    recorded: np.dtype[Any],
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.bool_], int]:
    """Return which words of a state are packed, which are floats, and where memory begins."""
    numbers = np.arange(recorded.itemsize // 8).view(recorded)[0]
    memory = numbers["goals"]["memory"].view(np.int64).ravel()
    places, is_float = [], []
    for name, columns in COLUMNS.items():
        listed = numbers[name]
        places.append(np.stack([listed[column].view(np.int64) for column in columns], -1).ravel())
        kinds = [listed.dtype[column].kind == "f" for column in columns]
        is_float.append(np.tile(kinds, len(listed)))
    packed_words = np.concatenate([*places, memory])
    are_floats = np.concatenate([*is_float, np.ones(len(memory), np.bool_)])
    return packed_words, are_floats, len(packed_words) - len(memory)


def read_recorded(state: State, recorded: Any) -> None:
    """Bring a state up to what was recorded of one."""
    for name in COLUMNS:
        columns = recorded[name].dtype.names
        for record, values in zip(getattr(state, name), recorded[name].tolist(), strict=True):
            for column, value in zip(columns, values, strict=True):
                setattr(record, column, value)
