"""What code asks of metaclasses and of their elements, features in the order of the metamodel."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from pyecore.ecore import EClass, EEnum, EProxy, EReference

from m2t.metamodel_contract import BOUNDS, CONTRACT, MEANING
from mrsfi_runtime.model.fault_types import Range


@cache
def lineage(metaclass: Any) -> tuple[Any, ...]:
    """Return a metaclass after all its supertypes, the most general one first."""
    parents = [
        ancestor for parent in metaclass.eSuperTypes for ancestor in lineage(_resolved(parent))
    ]
    return (*dict.fromkeys(parents), metaclass)


@cache
def features(metaclass: Any) -> tuple[Any, ...]:
    """Return all features of a metaclass in the order of Eclipse: inherited ones first.

    pyecore's own order is the other way round for some collections and none for others.
    """
    return tuple(feature for known in lineage(metaclass) for feature in known.eStructuralFeatures)


@dataclass(frozen=True, slots=True, eq=False)
class Slot:
    """What loading asks of a feature, in plain attributes: pyecore's own are slow to read.

    ``counts_ticks`` is true of a parameter of a fault type in ticks, and of its bounds.
    """

    feature: Any
    name: str
    type: Any
    many: bool
    lower_bound: int
    is_contained: bool
    is_reference: bool
    is_id: bool
    counts_ticks: bool

    @property
    def holds_elements(self) -> bool:
        """Whether its values are elements, contained or referred to."""
        return self.is_contained or self.is_reference


@cache
def slots(metaclass: Any) -> Mapping[str, Slot]:
    """Return the slots of all features of a metaclass by name, inherited ones first."""
    in_ticks = {feature.name for feature in features(metaclass) if _counts_ticks(feature)}
    return {
        str(feature.name): Slot(
            feature,
            str(feature.name),
            _resolved(feature.eType),
            bool(feature.many),
            int(feature.lowerBound),
            isinstance(feature, EReference) and bool(feature.containment),
            isinstance(feature, EReference) and not feature.containment,
            bool(getattr(feature, "iD", False)),
            any(f"{name}{end}" == feature.name for name in in_ticks for end in ("", *BOUNDS)),
        )
        for feature in features(metaclass)
    }


def _counts_ticks(feature: Any) -> bool:
    return any(
        annotation.source == MEANING and annotation.details.get("range") == Range.TICKS.name
        for annotation in feature.eAnnotations
    )


@cache
def conforms(metaclass: Any, wanted: Any) -> bool:
    """Return whether a metaclass is another one or one of its subclasses."""
    return any(known is wanted for known in lineage(metaclass))


@cache
def concrete_classes(package: Any, declared: Any) -> Mapping[str, Any]:
    """Return the classes of a package whose objects a feature of a declared class may hold."""
    return {
        str(kind.name): kind
        for kind in package.eClassifiers
        if isinstance(kind, EClass) and not kind.abstract and conforms(kind, declared)
    }


@cache
def base_class(metaclass: Any) -> Any:
    """Return what code knows an element as: the nearest class of its lineage that mrsfi reads.

    A team's own subclass of such a class only adds to it; a class that is all its own is known
    as itself.
    """
    read = (known for known in reversed(lineage(metaclass)) if is_read(known))
    return next((known for known in read if not known.abstract), metaclass)


@cache
def is_read(metaclass: Any, feature: str = "") -> bool:
    """Return whether code reads a class of the metamodel, or a feature that elements of it have."""
    needs = CONTRACT.get(metaclass.ePackage.name, {}).get(metaclass.name)
    return needs is not None and (not feature or feature in needs)


@cache
def is_kind(metaclass: Any, name: str) -> bool:
    """Return whether a metaclass is that of a name, or inherits from it."""
    return any(known.name == name for known in lineage(metaclass))


def _resolved(metaclass: Any) -> Any:
    """Return the metaclass behind the proxy of another metamodel file."""
    return metaclass.force_resolve() if isinstance(metaclass, EProxy) else metaclass


def values(element: Any, slot: Slot) -> list[Any]:
    """Return what an element holds in a feature, be it one value, many, or none."""
    value = getattr(element, slot.name)
    if slot.many:
        return list(value)
    return [] if value is None else [value]


def is_set(element: Any, name: str) -> bool:
    """Return whether the model gives an optional feature that the element's class has."""
    slot = slots(element.eClass).get(name)
    return slot is not None and bool(element.eIsSet(slot.feature))


def put(element: Any, slot: Slot, value: Any) -> None:
    """Set a feature of an element, or add to its values if it holds many."""
    if slot.many:
        getattr(element, slot.name).append(value)
    else:
        setattr(element, slot.name, value)


def contained(element: Any) -> Iterator[Any]:
    """Yield an element and all that it contains, in the order in which they are written."""
    yield element
    for slot in slots(element.eClass).values():
        if slot.is_contained:
            for child in values(element, slot):
                yield from contained(child)


def copies(roots: Iterable[Any], known: Callable[[Any], Any] = lambda kind: kind) -> dict[Any, Any]:
    """Return copies of elements and all that they contain, by their originals.

    What they refer to beyond themselves stays the same, and what is unset stays unset. ``known``
    gives the class of the copies for a class, and the enumeration for an enumeration. All copies
    are made before any gets its values, which may refer to any of them.
    """
    made = {element: known(element.eClass)() for root in roots for element in contained(root)}
    for element, copy in made.items():
        for slot in slots(element.eClass).values():
            if slot.many or element.eIsSet(slot.feature):
                for value in values(element, slot):
                    is_literal = isinstance(slot.type, EEnum)
                    same = known(slot.type).getEEnumLiteral(value.name) if is_literal else value
                    put(copy, slot, made.get(same, same))
    return made
