"""Visitor of ``fault_loader.py``: the fault pool, or any fault specification."""

from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any

from m2t.constraints.faults import fault_types
from m2t.environment import Call, Expression, Table
from m2t.metamodel_contract import BOUNDS, parameters
from m2t.metamodels import base_class, features
from m2t.visitors.base import ModelVisitor
from m2t.visitors.mission_loader import functions
from mrsfi_runtime.errors import ModelError

if TYPE_CHECKING:
    from m2t.load import LoadedModels

_NUMBERS = ("EInt", "EDouble")


class FaultLoaderVisitor(ModelVisitor):
    """Turn a fault specification into calls of the runtime's vocabulary.

    The thirty fault types are visited through their abstract supertypes, which say what a
    type refers to; its other features are its parameters.
    """

    template = "fault_loader.py.j2"
    target = PurePosixPath("fault_loader.py")

    def context(self, models: "LoadedModels") -> Mapping[str, Any]:
        """Return the template context; a mission without a fault model has an empty pool."""
        if models.faults is None:
            pool = Call("FaultPool", (("id", ""), ("faults", ())))
        else:
            pool = self.visit(models.faults)
        return {"imports": functions(pool), "result": pool}

    def visit_FaultSpecification(self, specification: Any) -> Call:
        """Return all faults of a specification in model order."""
        faults = tuple(self.visit(fault) for fault in specification.faults)
        return Call("FaultPool", (("id", specification.ID), ("faults", faults)))

    def visit_Fault(self, fault: Any) -> Call:
        """Return a fault: what it is, what it strikes, and its window if it has one."""
        fault_type = _fault_type(fault)
        window = [
            (name, getattr(fault, name)) for name in ("start", "finish") if _is_given(fault, name)
        ]
        values = _values(fault_type)
        bounds = _bounds(fault_type)
        return Call(
            "Fault",
            (
                ("id", fault.ID),
                ("name", fault.name),
                ("type", base_class(fault_type.eClass).name),
                ("target", self.visit(fault_type)),
                *((("values", values),) if values else ()),
                *((("bounds", bounds),) if bounds.entries else ()),
                *window,
            ),
        )

    def visit_MessageFault(self, fault_type: Any) -> str:
        """Return the ID of the affected message."""
        return str(fault_type.affectedMessage.ID)

    def visit_RobotFault(self, fault_type: Any) -> str:
        """Return the ID of the affected robot."""
        return str(fault_type.affectedRobot.ID)

    def visit_SensorFault(self, fault_type: Any) -> str:
        """Return the ID of the affected sensor."""
        return str(fault_type.affectedSensor.ID)

    def visit_ObstacleFault(self, fault_type: Any) -> str:
        """Return the ID of the affected obstacle."""
        return str(fault_type.affectedObstacle.ID)


def _fault_type(fault: Any) -> Any:
    """Return the one fault type that a fault contains."""
    contained = fault_types(fault)
    if len(contained) != 1:
        raise ModelError(
            f"fault '{fault.ID}' contains {len(contained)} fault types; expected exactly one"
        )
    return contained[0]


def _parameters(fault_type: Any) -> list[str]:
    """Return the names of the parameters; a team's own type has its numbers as parameters."""
    known = parameters(base_class(fault_type.eClass).name)
    if known is not None:
        return list(known)
    return [
        feature.name
        for feature in features(fault_type.eClass)
        if feature.eType.name in _NUMBERS and not feature.many and not feature.name.endswith(BOUNDS)
    ]


def _values(fault_type: Any) -> tuple[Expression, ...]:
    return tuple(float(getattr(fault_type, name)) for name in _parameters(fault_type))


def _bounds(fault_type: Any) -> Table:
    """Return the bounds that the model sets: parameter to (lowest, highest)."""
    pairs = {
        name: tuple(_bound(fault_type, f"{name}{suffix}") for suffix in BOUNDS)
        for name in _parameters(fault_type)
    }
    return Table(tuple((name, pair) for name, pair in pairs.items() if pair != (None, None)))


def _bound(fault_type: Any, name: str) -> float | None:
    return float(getattr(fault_type, name)) if _is_given(fault_type, name) else None


def _is_given(element: Any, name: str) -> bool:
    """Return whether the model sets an optional feature; some types have no such feature."""
    feature = element.eClass.findEStructuralFeature(name)
    return feature is not None and element.eIsSet(feature) and getattr(element, name) is not None
