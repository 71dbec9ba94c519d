"""Holds effects of a team's own to what their fault types name; anything else is an error."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.kernel.injections import OwnEffect, OwnFault
from mrsfi_runtime.kernel.state import COLUMNS, PROPERTIES, State
from mrsfi_runtime.model.fault_types import FaultType

Place = tuple[str, int, str]
"""A list of a state, such as ``ci.robots``; the index of a record in it, and a column."""


def allowed_columns(kind: FaultType) -> tuple[str, list[str]]:
    """Return which list of a state a fault may change, and which columns of its target there."""
    places = [PROPERTIES[affected] for affected in kind.properties]
    return places[0][0], [column for _, columns in places for column in columns]


def guarded(apply: OwnEffect, kinds: Mapping[int, FaultType]) -> OwnEffect:
    """Return an effect that fails when it changes what its fault type does not name.

    ``kinds`` are the fault types by the number of their effect.
    """

    def apply_guarded(ci: State, inbox: State, fault: OwnFault) -> None:
        kind = kinds[fault.effect]
        listed, columns = allowed_columns(kind)
        allowed = {(f"ci.{listed}", fault.target, column) for column in columns}
        before = _snapshot(ci, inbox, fault)
        apply(ci, inbox, fault)
        for place, value in _snapshot(ci, inbox, fault).items():
            if value != before[place] and place not in allowed:
                raise _changed(kind, place, before[place], value)

    return apply_guarded


def _snapshot(ci: State, inbox: State, fault: OwnFault) -> Mapping[Place, Any]:
    """Return all that a flight changes of two states, and all of a fault but its memory."""
    records: dict[str, Sequence[Any]] = {"fault": [fault]}
    for side, state in (("ci", ci), ("inbox", inbox)):
        records |= {f"{side}.mission": [state.mission], f"{side}.map": [state.map]}
        records |= {f"{side}.{name}": getattr(state, name) for name in COLUMNS}
    found = {}
    for name, listed in records.items():
        for index, record in enumerate(listed):
            for known in fields(record):
                value = getattr(record, known.name)
                is_number = isinstance(value, int | float)
                found[name, index, known.name] = value if is_number else tuple(value)
    del found["fault", 0, "memory"]
    return found


def _changed(kind: FaultType, place: Place, before: Any, after: Any) -> EvaluationError:
    records, index, column = place
    named = " and ".join(affected.name for affected in kind.properties)
    return EvaluationError(
        f"region '{kind.name}.apply' of fault_effects.py changed {column} of "
        f"{records}[{index}] from {before} to {after}; expected it to change "
        f"{named} of its target alone, as faults.ecore says; correct either"
    )
