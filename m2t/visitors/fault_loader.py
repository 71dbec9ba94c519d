"""Visitor of ``fault_loader.py``: the fault pool, or any fault specification."""

from collections.abc import Container, Mapping
from typing import Any, TypeAlias

from m2t.constraints.fault_rules import fault_types
from m2t.environment import Call, Expression, Name, Table, literal
from m2t.load import LoadedModels
from m2t.metaclasses import is_set, slots
from m2t.metamodel_contract import BOUNDS, CONTRACT
from m2t.metamodels import load_metamodels, meaning
from m2t.visitors.mission_loader import call, functions, held
from mrsfi_runtime.model.fault_types import FaultType, Parameter

Entry: TypeAlias = tuple[str, Expression]

_OPTIONAL = ("start", "finish", "likelihood")


def visit(models: LoadedModels) -> Mapping[str, Any]:
    """Turn the fault specification into calls of the runtime's vocabulary.

    What its fault types mean stands in a table of its own, as the metamodel says it. A mission
    without a fault model has an empty pool.
    """
    own: tuple[Entry, ...] = ()
    triggers = () if models.faults is None else models.faults.triggers
    if models.faults is not None:
        own = _features(models.faults, CONTRACT["faults"]["FaultSpecification"])
    pool = Call(
        "FaultPool",
        (
            ("id", "" if models.faults is None else models.faults.ID),
            ("faults", tuple(_fault(fault) for fault in models.pool)),
            *_given("own", Table(own)),
            *_given("triggers", tuple(map(_trigger, triggers))),
        ),
    )
    types = tuple(_type(kind) for kind in types_in_use(models))
    return {"imports": functions((pool, *types)), "result": pool, "types": types}


def types_in_use(models: LoadedModels) -> tuple[FaultType, ...]:
    """Return the fault types of which the pool has a fault, in the order of the metamodel."""
    used = {kind.eClass.name for fault in models.pool for kind in fault_types(fault)}
    return tuple(kind for kind in load_metamodels().fault_types.values() if kind.name in used)


def _fault(fault: Any) -> Call:
    """Return a fault: what it is, what it strikes, its window and likelihood if it has them."""
    (fault_type,) = fault_types(fault)
    kind = meaning(fault_type)
    values = tuple(float(getattr(fault_type, known.name)) for known in kind.parameters)
    reference = f"affected{kind.struck.value.title()}"
    return Call(
        "Fault",
        (
            ("id", fault.ID),
            ("name", fault.name),
            ("kind", Name(f"TYPES[{literal(kind.name)}]")),
            ("target", str(getattr(fault_type, reference).ID)),
            *_given("values", values),
            *_given("bounds", _bounds(fault_type, kind)),
            *((name, getattr(fault, name)) for name in _OPTIONAL if is_set(fault, name)),
            *_given("own", _own(fault, fault_type, kind, reference)),
            *_given("trigger", "" if fault.trigger is None else str(fault.trigger.ID)),
        ),
    )


def _trigger(trigger: Any) -> Call:
    of = (trigger.goal, trigger.robot, *trigger.faults)
    area = trigger.at if trigger.area is None else trigger.area
    return Call(
        "Trigger",
        (
            ("id", trigger.ID),
            ("event", Name(f"Event.{trigger.event.name}")),
            ("of", tuple(str(each.ID) for each in of if each is not None)),
            *(() if area is None else (("area", call(area)),)),
            *(
                (name, getattr(trigger, name))
                for name in ("delay", "duration")
                if is_set(trigger, name)
            ),
        ),
    )


def _given(name: str, value: str | tuple[Expression, ...] | Table) -> tuple[Entry, ...]:
    return () if value in ("", (), Table(())) else ((name, value),)


def _type(kind: FaultType) -> Call:
    return Call(
        "FaultType",
        (
            ("", kind.name),
            ("", Name(f"Mode.{kind.mode.name}")),
            ("", Name(f"Struck.{kind.struck.name}")),
            *_given("", tuple(Name(f"Field.{known.name}") for known in kind.properties)),
            *_given("parameters", tuple(_parameter(known) for known in kind.parameters)),
            *((("effect", kind.effect),) if kind.effect >= 0 else ()),
        ),
        is_flat=True,
    )


def _parameter(parameter: Parameter) -> Call:
    return Call(
        "Parameter",
        (
            ("", parameter.name),
            ("", Name(f"Range.{parameter.range.name}")),
            *((("evolves", False),) if not parameter.evolves else ()),
            *((("is_integer", True),) if parameter.is_integer else ()),
        ),
        is_flat=True,
    )


def _bounds(fault_type: Any, kind: FaultType) -> Table:
    """Return the bounds that the model sets: parameter to (lowest, highest)."""
    pairs = {
        parameter.name: tuple(_bound(fault_type, f"{parameter.name}{end}") for end in BOUNDS)
        for parameter in kind.parameters
    }
    return Table(tuple((name, pair) for name, pair in pairs.items() if pair != (None, None)))


def _bound(fault_type: Any, name: str) -> float | None:
    return float(getattr(fault_type, name)) if is_set(fault_type, name) else None


def _own(fault: Any, fault_type: Any, kind: FaultType, reference: str) -> Table:
    parameters = {f"{known.name}{end}" for known in kind.parameters for end in ("", *BOUNDS)}
    holding = {fault_type.eContainmentFeature().name, *CONTRACT["faults"]["Fault"]}
    return Table((*_features(fault, holding), *_features(fault_type, {*parameters, reference})))


def _features(element: Any, known: Container[str] = ()) -> tuple[Entry, ...]:
    """Return what a model or a default gives an element in features but those known, by name."""
    return tuple(
        (name, held(element, slot, _part))
        for name, slot in slots(element.eClass).items()
        if name not in known
        and (
            element.eIsSet(slot.feature)
            or getattr(slot.feature, "defaultValueLiteral", None) is not None
        )
    )


def _part(part: Any) -> Table:
    """Return a part that a team added as a dictionary, with its class as ``eClass``."""
    return Table((("eClass", str(part.eClass.name)), *_features(part)))
