"""Visitor of ``fault_loader.py``: the fault pool, or any fault specification."""

from collections.abc import Iterable, Mapping
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any

from m2t.constraints.faults import fault_types, is_set
from m2t.environment import Call, Expression, Name, Table, literal
from m2t.metamodel_contract import BOUNDS, CONTRACT
from m2t.metamodels import load_metamodels, meaning
from m2t.visitors.base import ModelVisitor
from m2t.visitors.mission_loader import functions
from m2t.visitors.own_features import own_features
from mrsfi_runtime.errors import ModelError
from mrsfi_runtime.model.fault_types import FaultType, Parameter

if TYPE_CHECKING:
    from m2t.load import LoadedModels


class FaultLoaderVisitor(ModelVisitor):
    """Turn a fault specification into calls of the runtime's vocabulary.

    What its fault types mean stands in a table of its own, as the metamodel says it.
    """

    template = "fault_loader.py.j2"
    target = PurePosixPath("fault_loader.py")

    def context(self, models: "LoadedModels") -> Mapping[str, Any]:
        """Return the template context; a mission without a fault model has an empty pool."""
        faults = () if models.faults is None else tuple(models.faults.faults)
        if models.faults is None:
            pool = Call("FaultPool", (("id", ""), ("faults", ())))
        else:
            pool = self.visit(models.faults)
        types = tuple(_type(kind) for kind in types_in_use(faults))
        return {"imports": functions((pool, *types)), "result": pool, "types": types}

    def visit_FaultSpecification(self, specification: Any) -> Call:
        """Return all faults of a specification in model order."""
        own = own_features(specification, CONTRACT["faults"]["FaultSpecification"])
        return Call(
            "FaultPool",
            (
                ("id", specification.ID),
                ("faults", tuple(self.visit(fault) for fault in specification.faults)),
                *_given("own", own),
            ),
        )

    def visit_Fault(self, fault: Any) -> Call:
        """Return a fault: what it is, what it strikes, and its window if it has one."""
        fault_type = _fault_type(fault)
        kind = meaning(fault_type)
        reference = f"affected{kind.struck.value.title()}"
        return Call(
            "Fault",
            (
                ("id", fault.ID),
                ("name", fault.name),
                ("kind", Name(f"TYPES[{literal(kind.name)}]")),
                ("target", str(getattr(fault_type, reference).ID)),
                *_given("values", _values(fault_type, kind)),
                *_given("bounds", _bounds(fault_type, kind)),
                *(
                    (name, getattr(fault, name))
                    for name in ("start", "finish")
                    if is_set(fault, name)
                ),
                *_given("own", _own(fault, fault_type, kind, reference)),
            ),
        )


def types_in_use(faults: Iterable[Any]) -> tuple[FaultType, ...]:
    """Return the types of some faults, in the order of the metamodel."""
    used = {_fault_type(fault).eClass.name for fault in faults}
    return tuple(kind for kind in load_metamodels().fault_types.values() if kind.name in used)


def _given(name: str, value: tuple[Expression, ...] | Table) -> tuple[tuple[str, Expression], ...]:
    return () if value in ((), Table(())) else ((name, value),)


def _fault_type(fault: Any) -> Any:
    """Return the one fault type that a fault contains."""
    contained = fault_types(fault)
    if len(contained) != 1:
        raise ModelError(
            f"fault '{fault.ID}' contains {len(contained)} fault types; expected exactly one"
        )
    return contained[0]


def _type(kind: FaultType) -> Call:
    """Return a fault type, in as few lines as there is room for."""
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


def _values(fault_type: Any, kind: FaultType) -> tuple[Expression, ...]:
    return tuple(float(getattr(fault_type, parameter.name)) for parameter in kind.parameters)


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
    """Return what a team has added to faults, and to the type of this one."""
    parameters = {f"{known.name}{end}" for known in kind.parameters for end in ("", *BOUNDS)}
    holding = {fault_type.eContainmentFeature().name, *CONTRACT["faults"]["Fault"]}
    return Table(
        (
            *own_features(fault, holding).entries,
            *own_features(fault_type, {*parameters, reference}).entries,
        )
    )
