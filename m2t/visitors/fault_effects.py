"""Visitor of ``fault_effects.py``: a region for each own effect of a type that the pool uses."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from m2t.load import LoadedModels
from m2t.naming import snake_case
from m2t.visitors.fault_loader import types_in_use
from mrsfi_runtime.errors import GenerationError
from mrsfi_runtime.model.fault_types import OF_ROBOT, OF_SENSOR, FaultType, Mode


@dataclass(frozen=True, slots=True)
class EffectView:
    """An effect: its fault type, number, what it may change of what, and its parameters.

    Its region is named after the type, so that other types may come and go.
    """

    type: str
    number: int
    function: str
    properties: str
    element: str
    constants: tuple[str, ...]


def visit(models: LoadedModels) -> Mapping[str, Any]:
    """Collect the fault types of mode OWN of which the pool has a fault."""
    types = types_in_use(models)
    effects = tuple(_effect(kind) for kind in types if kind.mode is Mode.OWN)
    names = [name for effect in effects for name in (effect.function, *effect.constants)]
    for name in names:
        if names.count(name) > 1:
            raise GenerationError(
                f"fault types {' and '.join(effect.type for effect in effects)} of mode OWN: "
                f"two of their names become {name} in Python; rename one"
            )
    return {"effects": effects}


def _effect(kind: FaultType) -> EffectView:
    stem = snake_case(kind.name)
    affected = kind.properties[0]
    of_robot = "robot" if affected in OF_ROBOT else "obstacle"
    return EffectView(
        type=kind.name,
        number=kind.effect,
        function=f"apply_{stem}",
        properties=" and ".join(known.name for known in kind.properties),
        element="sensor" if affected in OF_SENSOR else of_robot,
        constants=tuple(f"{stem}_{parameter.name}".upper() for parameter in kind.parameters),
    )
