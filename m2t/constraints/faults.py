"""Constraints on faults that no metamodel can state.

References
----------
Source paper, section III-B b).
"""

from typing import Any

from m2t.constraints.findings import Findings, number
from m2t.metamodels import base_class, features, is_contained, lineage, reference_type, slots

_FIELD_OF_TYPE = {
    "RemainingEnergyCapacityReport": "ENERGY",
    "Speed": "SPEED",
    "RobotCoordinates": "POSITION",
}
"""What a fault type falsifies, by the end of its name; rates and costs travel in no message."""

_TICKS = ("DELAY", "BLOCK_DURATION")


def check_faults(specification: Any, duration: int, findings: Findings) -> None:
    """Check a fault specification whose structure is sound.

    Parameters
    ----------
    specification
        Root of the fault model.
    duration
        Duration of the mission in ticks.
    findings
        Takes the diagnostics.
    """
    for fault in specification.faults:
        _check_window(fault, duration, findings)
        kinds = fault_types(fault)
        if len(kinds) == 1:
            _check_parameters(kinds[0], findings)
            _check_field(kinds[0], findings)
            continue
        found = ", ".join(kind.eClass.name for kind in kinds) or "none"
        findings.add(
            fault,
            "ExactlyOneFaultType",
            f"contains {len(kinds)} fault types ({found}); expected exactly one; "
            + ("delete the others" if kinds else "add one"),
        )


def fault_types(fault: Any) -> tuple[Any, ...]:
    """Return the fault types that a fault contains; a sound fault contains one."""
    given = (feature for feature in features(fault.eClass) if fault.eIsSet(feature))
    values = (fault.eGet(feature) for feature in given if _holds_fault_type(feature))
    return tuple(value for value in values if value is not None)


def _holds_fault_type(feature: Any) -> bool:
    """Return whether a feature contains a fault type, not something that a team has added."""
    kinds = lineage(reference_type(feature)) if is_contained(feature) else ()
    return not feature.many and any(kind.name == "FaultType" for kind in kinds)


def is_set(element: Any, name: str) -> bool:
    """Return whether the model gives an optional feature that the element's class has."""
    slot = slots(element.eClass).get(name)
    return slot is not None and bool(element.eIsSet(slot.feature))


def disordered_parameters(kind: Any) -> list[str]:
    """Return the parameters of a fault type whose lowest value is above their highest."""
    return [
        feature.name
        for feature in features(kind.eClass)
        if _has_number(kind, f"{feature.name}_MIN")
        and _has_number(kind, f"{feature.name}_MAX")
        and getattr(kind, f"{feature.name}_MIN") > getattr(kind, f"{feature.name}_MAX")
    ]


def broken_ticks(kind: Any) -> list[str]:
    """Return the numbers of ticks of a fault type that are not whole."""
    names = (name + suffix for name in _TICKS for suffix in ("", "_MIN", "_MAX"))
    return [name for name in names if _has_number(kind, name) and getattr(kind, name) % 1]


def _has_number(kind: Any, name: str) -> bool:
    return is_set(kind, name) and isinstance(getattr(kind, name), int | float)


def _check_window(fault: Any, duration: int, findings: Findings) -> None:
    has_start, has_finish = is_set(fault, "start"), is_set(fault, "finish")
    if has_start != has_finish:
        given, missing = ("start", "finish") if has_start else ("finish", "start")
        findings.add(
            fault,
            "WindowComplete",
            f"has {given} but no {missing}; expected both, or neither in a pool; add {missing}",
        )
    if not (has_start and has_finish):
        return
    if fault.start > fault.finish:
        findings.add(
            fault,
            "WindowOrdered",
            f"starts at {fault.start} and finishes at {fault.finish}; expected start <= finish; "
            "exchange them",
        )
    elif fault.start >= duration:
        findings.add(
            fault,
            "WindowInsideMission",
            f"starts at {fault.start} in a mission of {duration} ticks and never acts; expected "
            "an earlier start; correct one of them",
        )


def _check_parameters(kind: Any, findings: Findings) -> None:
    has_bounds = all(_has_number(kind, name) for name in ("LOWER_BOUND", "UPPER_BOUND"))
    if has_bounds and kind.LOWER_BOUND > kind.UPPER_BOUND:
        findings.add(
            kind,
            "RandomBoundsOrdered",
            f"has LOWER_BOUND {number(kind.LOWER_BOUND)} above UPPER_BOUND "
            f"{number(kind.UPPER_BOUND)}; expected the lower one first; exchange them",
        )
    for name in disordered_parameters(kind):
        lowest, highest = getattr(kind, f"{name}_MIN"), getattr(kind, f"{name}_MAX")
        findings.add(
            kind,
            "SearchBoundsOrdered",
            f"has {name}_MIN {number(lowest)} above {name}_MAX {number(highest)}; expected the "
            "lower one first; exchange them",
        )
    for name in broken_ticks(kind):
        findings.add(
            kind,
            "WholeTicks",
            f"has {name} {number(getattr(kind, name))}; expected a whole number of ticks; round it",
        )


def _check_field(kind: Any, findings: Findings) -> None:
    """Check that the affected message carries what the fault falsifies."""
    type_name = base_class(kind.eClass).name
    wanted = next((name for end, name in _FIELD_OF_TYPE.items() if type_name.endswith(end)), None)
    message = getattr(kind, "affectedMessage", None)
    if wanted is None or message is None:
        return
    carried = [entry.name for entry in message.body]
    if wanted not in carried:
        findings.add(
            kind,
            "FaultFieldCarried",
            f"falsifies {wanted}, but message '{message.ID}' carries {', '.join(carried)}, so "
            f"that the fault has no effect; expected a message with {wanted}; choose another",
        )
