"""What features of a metamodel are, read from pyecore's own objects, not from our slots."""

from functools import cache
from typing import Any

from pyecore.ecore import EProxy, EReference


def is_contained(feature: Any) -> bool:
    """Return whether a feature contains elements."""
    return isinstance(feature, EReference) and bool(feature.containment)


def is_reference(feature: Any) -> bool:
    """Return whether a feature refers to elements that something else contains."""
    return isinstance(feature, EReference) and not feature.containment


@cache
def reference_type(feature: Any) -> Any:
    """Return the metaclass that a reference or containment leads to."""
    kind = feature.eType
    return kind.force_resolve() if isinstance(kind, EProxy) else kind
