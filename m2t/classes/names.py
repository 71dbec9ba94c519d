"""Names in the static classes: those of the metamodel, as far as Python allows them."""

import keyword
from typing import Any

from pyecore.ecore import EEnum, EObject

from mrsfi_runtime.errors import ModelError

_BODY_NAMES = frozenset(
    {"ClassVar", "EList", "Iterable", "annotated", "ecore", "bool", "float", "int", "str"}
)
"""What the body of a class or of its stub refers to, and no feature may hide."""

_HELPERS = frozenset(
    {"Any", "EEnumLiteral", "Element", "Values", "described", "elements"}
    | {"enumeration", "partial", "setattr"}
)
_PACKAGE_NAMES = frozenset(
    {"eClass", "eClassifiers", "eSubpackages", "eSuperPackage", "getEClassifier"}
    | {"name", "nsPrefix", "nsURI"}
)
_MODULE_NAMES = _BODY_NAMES | _HELPERS | _PACKAGE_NAMES
"""What a module or its stub uses, and no class may be called."""

_OBJECT_NAMES = frozenset({"dyn_inst", "listeners"})


def python_name(name: str) -> str:
    """Return the name of a feature in Python: a keyword gets an underscore at its end."""
    return f"{name}_" if keyword.iskeyword(name) or name == "self" else name


def global_name(element: Any) -> str:
    """Return the name of a class, an enumeration or a package, which becomes a global name."""
    name = str(element.name)
    if name in _MODULE_NAMES or keyword.iskeyword(name):
        raise reserved(f"'{name}'")
    return name


def reserved(what: str) -> ModelError:
    """Return the error that says that a name is taken."""
    return ModelError(f"{what} is a name that Python or another element uses; rename it")


def require_feature_names(metaclass: Any, names: list[str]) -> None:
    """Refuse features whose names collide, in Python, with each other or with something else."""
    classifiers = {entry.name for entry in metaclass.ePackage.eClassifiers}
    for name in names:
        is_used = name in _BODY_NAMES | _OBJECT_NAMES | classifiers or hasattr(EObject, name)
        if is_used or names.count(name) > 1:
            raise reserved(f"'{name}', a feature of '{metaclass.name}',")


def require_literal_name(enumeration: Any, name: str) -> None:
    """Refuse a literal whose name would hide something that every enumeration has."""
    if keyword.iskeyword(name) or hasattr(EEnum, name):
        raise reserved(f"literal '{name}' of '{enumeration.name}'")
