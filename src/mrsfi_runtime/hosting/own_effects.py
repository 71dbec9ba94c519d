"""Holds effects of a team's own to what their fault types name; anything else is an error."""

from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Any

from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.kernel.injections import OwnEffect, OwnFault
from mrsfi_runtime.kernel.packing import COLUMNS
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.fault_types import FaultType, Field

_COLUMNS: Mapping[Field, tuple[str, ...]] = {
    Field.POSITION: ("x", "y", "z"),
    Field.SPEED: ("speed",),
    Field.ENERGY: ("energy",),
    Field.COUNT: ("count",),
    Field.RATE: ("rate",),
    Field.COST: ("cost",),
    Field.OBSTACLE: ("x", "y"),
}
"""Where a property stands in the record of its owner."""

_LISTS = ("robots", "sensors", "obstacles")
"""Lists of a state that hold those owners, by ``OwnFault.kind``."""

Place = tuple[str, int, str]
"""A list of a state, the index of a record in it, and a column."""


def guarded(apply: OwnEffect, kinds: Mapping[int, FaultType]) -> OwnEffect:
    """Return an effect that fails when it changes what its fault type does not name.

    Parameters
    ----------
    apply
        That of the generated code.
    kinds
        Fault types by the number of their effect.
    """

    def apply_guarded(ci: State, inbox: State, fault: OwnFault) -> None:
        kind = kinds[fault.effect]
        allowed = {
            (_LISTS[fault.kind], fault.target, column)
            for affected in kind.properties
            for column in _COLUMNS[affected]
        }
        before = [dict(_values(ci)), dict(_values(inbox)), dict(_fixed(fault))]
        apply(ci, inbox, fault)
        _require_same(kind, "ci.", before[0], dict(_values(ci)), allowed)
        _require_same(kind, "inbox.", before[1], dict(_values(inbox)), set())
        _require_same(kind, "", before[2], dict(_fixed(fault)), set())

    return apply_guarded


def _values(state: State) -> Iterator[tuple[Place, Any]]:
    """Yield all that a flight changes of a state."""
    lists = {name: getattr(state, name) for name in COLUMNS}
    for name, records in {**lists, "mission": [state.mission], "map": [state.map]}.items():
        for index, record in enumerate(records):
            yield from _columns(name, index, record)


def _columns(name: str, index: int, record: Any) -> Iterator[tuple[Place, Any]]:
    for known in fields(record):
        value = getattr(record, known.name)
        is_number = isinstance(value, int | float)
        yield (name, index, known.name), value if is_number else tuple(value)


def _require_same(
    kind: FaultType,
    name: str,
    before: Mapping[Place, Any],
    after: Mapping[Place, Any],
    allowed: set[Place],
) -> None:
    for place, value in after.items():
        if value != before[place] and place not in allowed:
            records, index, column = place
            named = " and ".join(affected.name for affected in kind.properties)
            raise EvaluationError(
                f"region '{kind.name}.apply' of fault_effects.py changed {column} of "
                f"{name}{records}[{index}] from {before[place]} to {value}; expected it to change "
                f"{named} of its target alone, as faults.ecore says; correct either"
            )


def _fixed(fault: OwnFault) -> Iterator[tuple[Place, Any]]:
    """Yield all of a fault but its memory."""
    return (entry for entry in _columns("fault", 0, fault) if entry[0][2] != "memory")
