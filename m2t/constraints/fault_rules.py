"""Constraints on faults that no metamodel can state.

References
----------
Source paper, section III-B b).
"""

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

from m2t.constraints.mission_rules import number
from m2t.diagnostics import Report
from m2t.metaclasses import is_kind, is_set, slots, values
from m2t.metamodel_contract import BOUNDS
from m2t.metamodels import meaning
from mrsfi_runtime.model.fault_types import OF_ROBOT, Field, Mode

Pairs: TypeAlias = list[tuple[str, str]]
"""Names of features of which the value of the first must not be above that of the second."""


def check_faults(specification: Any, duration: int, report: Report) -> None:
    """Check a fault specification whose structure is sound, for a mission's duration in ticks."""
    for fault in specification.faults:
        _check_window(fault, duration, report)
        kinds = fault_types(fault)
        if len(kinds) == 1:
            _check_parameters(kinds[0], report)
            _check_field(kinds[0], report)
            continue
        found = ", ".join(kind.eClass.name for kind in kinds) or "none"
        report.add(
            fault,
            "ExactlyOneFaultType",
            f"contains {len(kinds)} fault types ({found}); expected exactly one; "
            + ("delete the others" if kinds else "add one"),
        )
    for trigger in specification.triggers:
        _check_trigger(trigger, report)


def fault_types(fault: Any) -> tuple[Any, ...]:
    """Return the fault types that a fault contains; a sound fault contains one."""
    return tuple(
        kind
        for slot in slots(fault.eClass).values()
        if slot.is_contained and is_kind(slot.type, "FaultType") and fault.eIsSet(slot.feature)
        for kind in values(fault, slot)
    )


def exchanged_window(fault: Any) -> Pairs:
    """Return the names of start and finish if a fault finishes before it starts."""
    return _exchanged(fault, _given(fault, ("start", "finish")))


def exchanged_draw(kind: Any) -> Pairs:
    """Return the names of lowest and highest value that a fault type draws, if exchanged."""
    names = [parameter.name for parameter in meaning(kind).parameters]
    is_drawn = meaning(kind).mode is Mode.RANDOM and names
    return _exchanged(kind, [(names[0], names[1])] if is_drawn else [])


def exchanged_bounds(kind: Any) -> Pairs:
    """Return the names of the bounds of each parameter whose lowest is above its highest."""
    low, high = BOUNDS
    names = [parameter.name for parameter in meaning(kind).parameters]
    return _exchanged(kind, _given(kind, *((f"{name}{low}", f"{name}{high}") for name in names)))


def _given(element: Any, *pairs: tuple[str, str]) -> Pairs:
    return [pair for pair in pairs if all(is_set(element, name) for name in pair)]


def _exchanged(element: Any, pairs: Pairs) -> Pairs:
    return [pair for pair in pairs if getattr(element, pair[0]) > getattr(element, pair[1])]


def broken_ticks(kind: Any) -> list[str]:
    """Return the numbers of ticks of a fault type that are not whole."""
    return [
        name
        for name, slot in slots(kind.eClass).items()
        if slot.counts_ticks and is_set(kind, name) and getattr(kind, name) % 1
    ]


def _check_window(fault: Any, duration: int, report: Report) -> None:
    has_start, has_finish = is_set(fault, "start"), is_set(fault, "finish")
    if has_start != has_finish:
        given, missing = ("start", "finish") if has_start else ("finish", "start")
        finding = (
            f"has {given} but no {missing}; expected both, or neither in a pool; add {missing}"
        )
        report.add(fault, "WindowComplete", finding)
    if fault.trigger is not None and not has_start:
        finding = (
            f"waits for trigger '{fault.trigger.ID}' and has no window in which to act; expected "
            "start and finish, or no trigger in a pool; correct one of them"
        )
        report.add(fault, "TriggerInWindow", finding)
    if not (has_start and has_finish):
        return
    if exchanged_window(fault):
        finding = (
            f"starts at {fault.start} and finishes at {fault.finish}; expected start <= finish; "
            "exchange them"
        )
        report.add(fault, "WindowOrdered", finding)
    elif fault.start >= duration:
        finding = (
            f"starts at {fault.start} in a mission of {duration} ticks and never acts; expected "
            "an earlier start; correct one of them"
        )
        report.add(fault, "WindowInsideMission", finding)


_AREA = "area or at"
_EVENTS: Mapping[str, tuple[str, ...]] = {
    "VIOLATED": ("goal",),
    "REACHED": ("goal",),
    "ENTERED": ("robot", _AREA),
    "EFFECT": ("faults",),
}
"""What a trigger of each event refers to; one of an effect may be about no fault, but never is."""

_REACHABLE = ("GatherSamples", "Visit", "Track")


def fits_event(trigger: Any) -> bool:
    """Return whether a trigger refers to what its event is about, and to nothing else."""
    event, names = trigger.event.name, _given_to(trigger)
    given = tuple(_AREA if name in ("area", "at") else name for name in names)
    return given == _EVENTS.get(event) or (event == "EFFECT" and not given)


def _given_to(trigger: Any) -> tuple[str, ...]:
    known = ("goal", "robot", "area", "at", "faults")
    return tuple(name for name in known if getattr(trigger, name))


def _check_trigger(trigger: Any, report: Report) -> None:
    event = trigger.event.name
    if not fits_event(trigger):
        given, wanted = _given_to(trigger), _EVENTS.get(event, ())
        finding = (
            f"is {event} and has {' and '.join(given) or 'nothing'}; expected "
            f"{' and '.join(wanted) or 'another event'}, and nothing else; correct it"
        )
        report.add(trigger, "TriggerOfEvent", finding)
    elif event == "REACHED":
        task = trigger.goal.task.eClass
        if not any(is_kind(task, name) for name in _REACHABLE):
            finding = (
                f"waits until goal '{trigger.goal.ID}' is reached, and {task.name} has nothing to "
                f"reach; expected a goal of {', '.join(_REACHABLE)}; choose another"
            )
            report.add(trigger, "ReachableGoal", finding)
    elif event == "EFFECT" and all(fault.trigger is trigger for fault in trigger.faults):
        finding = (
            "waits for no fault but those that wait for it, and never happens; expected another "
            "fault; add one"
        )
        report.add(trigger, "TriggerCanHappen", finding)


def _check_parameters(kind: Any, report: Report) -> None:
    drawn = [("RandomBoundsOrdered", *pair) for pair in exchanged_draw(kind)]
    searched = [("SearchBoundsOrdered", *pair) for pair in exchanged_bounds(kind)]
    for constraint, low, high in drawn + searched:
        lowest, highest = number(getattr(kind, low)), number(getattr(kind, high))
        finding = (
            f"has {low} {lowest} above {high} {highest}; expected the lower one first; "
            "exchange them"
        )
        report.add(kind, constraint, finding)
    for name in broken_ticks(kind):
        finding = (
            f"has {name} {number(getattr(kind, name))}; expected a whole number of ticks; round it"
        )
        report.add(kind, "WholeTicks", finding)


def _check_field(kind: Any, report: Report) -> None:
    message = getattr(kind, "affectedMessage", None)
    if message is None:
        return
    carried = [entry.name for entry in message.body]
    for affected in meaning(kind).properties:
        if not _carries(carried, affected):
            wanted = affected.name
            finding = (
                f"falsifies {wanted}, but message '{message.ID}' carries {', '.join(carried)}, so "
                f"that the fault has no effect; expected a message with {wanted}; choose another"
            )
            report.add(kind, "FaultFieldCarried", finding)


def _carries(body: Sequence[str], affected: Field) -> bool:
    """Return whether a body carries a property; rates and costs need no message to do so."""
    if affected in OF_ROBOT:
        return affected.name in body
    reported = {known.name for known in OF_ROBOT}
    return affected is not Field.COUNT or any(name not in reported for name in body)
