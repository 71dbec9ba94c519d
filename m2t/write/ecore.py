"""Write metamodels as Eclipse EMF writes ``.ecore`` files.

pyecore's own serializer is not used: it loses opposites, ``resolveProxies`` and
``serializable``, and breaks lines elsewhere.
"""

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

from pyecore.ecore import EAnnotation, EProxy, EReference

from m2t.read.nodes import ECORE, XMI, XSI
from m2t.write.xmi import attribute, document, element_lines
from mrsfi_runtime.errors import ModelError

_WIDTH = 80

_ATTRIBUTES: Mapping[str, object] = MappingProxyType(
    {
        **dict.fromkeys(("name", "nsURI", "nsPrefix", "source", "instanceClassName")),
        **dict.fromkeys(("abstract", "interface"), False),
        "value": 0,
        "literal": None,
        **dict.fromkeys(("ordered", "unique"), True),
        "lowerBound": 0,
        "upperBound": 1,
        "eType": None,
        **dict.fromkeys(("eSuperTypes", "eExceptions", "references")),
        "changeable": True,
        **dict.fromkeys(("volatile", "transient"), False),
        "defaultValueLiteral": None,
        **dict.fromkeys(("unsettable", "derived", "iD", "containment"), False),
        **dict.fromkeys(("serializable", "resolveProxies"), True),
        "eOpposite": None,
    }
)
"""Attributes in the order of Eclipse, each with its default, whatever element they belong to."""

_CHILDREN = (
    "eAnnotations",
    "eClassifiers",
    "eSubpackages",
    "eOperations",
    "eParameters",
    "eStructuralFeatures",
    "eLiterals",
)
"""Containments in the order of Eclipse."""

_TYPED = frozenset({"eClassifiers", "eStructuralFeatures"})
_ON = frozenset({"serializable", "resolveProxies"})
_GENERIC = ("eTypeParameters", "eGenericSuperTypes", "eGenericExceptions", "contents")


def dumps_metamodel(
    package: Any, encoding: str = "UTF-8", *, hrefs: Mapping[Any, str] = MappingProxyType({})
) -> bytes:
    """Return a metamodel as the bytes of an ``.ecore`` file, with LF line ends.

    ``hrefs`` are the relative addresses of the other metamodel files, by their root packages; a
    reference to another package, and a generic type, is a ``ModelError``. An attribute goes to a
    new line, indented by four more than its element, as soon as what stands before it ends beyond
    column 80. What equals Ecore's default is left out.
    """
    return document(_EcoreWriter(package, hrefs).lines(), encoding)


class _EcoreWriter:
    """Writes one metamodel."""

    def __init__(self, package: Any, hrefs: Mapping[Any, str]) -> None:
        self._root = package
        self._hrefs = hrefs

    def lines(self) -> Iterator[str]:
        """Return the lines of the root element."""
        name, lines = "ecore:EPackage", list(self._children(self._root, "  "))
        xsi = [("xmlns:xsi", XSI)] if any(" xsi:type=" in line for line in lines) else []
        head = [("xmi:version", "2.0"), ("xmlns:xmi", XMI), *xsi, ("xmlns:ecore", ECORE)]
        # Eclipse inserts the namespaces last, so that they do not count for what follows.
        own = [_broken("", name, each) for each in (head, self._attributes(self._root))]
        return element_lines("", name, "".join(own), lines)

    def _children(self, element: Any, indent: str) -> Iterator[str]:
        for name in (name for name in _CHILDREN if _feature(element, name) is not None):
            for child in getattr(element, name):
                kind = [("xsi:type", f"ecore:{_kind(child)}")] if name in _TYPED else []
                attributes = _broken(indent, name, kind + self._attributes(child))
                lines = list(self._children(child, indent + "  "))
                yield from element_lines(indent, name, attributes, lines)
        for key, value in element.details.items() if isinstance(element, EAnnotation) else ():
            entry = [("key", key)] + ([] if value is None else [("value", value)])
            yield from element_lines(indent, "details", _broken(indent, "details", entry), [])

    def _attributes(self, element: Any) -> list[tuple[str, str]]:
        """Return what an element says in attributes: all that is not the default."""
        _require_plain(element)
        found = []
        for name, usual in _ATTRIBUTES.items():
            feature = _feature(element, name)
            value = None if feature is None else getattr(element, name)
            if isinstance(feature, EReference):
                value = self._names(name, value if feature.many else [value])
            if name in _ON and feature not in element._isset:  # noqa: SLF001 # eIsSet asks the class
                value = None  # pyecore takes it for off by default
            if value is not None and value != usual:
                found.append((name, str(value).lower() if isinstance(value, bool) else str(value)))
        return found

    def _names(self, attribute: str, values: Any) -> str | None:
        """Return the names of what a reference leads to; that of a type with its kind."""
        targets = [_resolved(value) for value in values if value is not None]
        names = [self._name(target) for target in targets]
        if attribute == "eType" and names and not names[0].startswith("#"):
            names[0] = f"ecore:{_kind(targets[0])} {names[0]}"
        return " ".join(names) or None

    def _name(self, element: Any) -> str:
        """Return how references name an element, such as ``mission.ecore#//Robot/name``."""
        steps = []
        top = element
        while (container := _container(top)) is not None:
            steps.append(str(top.name))
            top = container
        fragment = "//" + "/".join(reversed(steps))
        if top is self._root:
            return f"#{fragment}"
        if top in self._hrefs:
            return f"{self._hrefs[top]}#{fragment}"
        if getattr(top, "nsURI", None) == ECORE:
            return f"{ECORE}#{fragment}"
        raise ModelError(
            f"metamodel '{self._root.name}' refers to '{fragment}' of another metamodel; expected "
            "one whose file is known; give its address"
        )


def _feature(element: Any, name: str) -> Any:
    """Return the feature of Ecore that an element has by a name, if there is one."""
    return type(element).eClass.findEStructuralFeature(name)


def _broken(indent: str, name: str, attributes: list[tuple[str, str]]) -> str:
    """Return the attributes of a start tag, with line breaks where Eclipse has them."""
    found = ""
    for key, value in attributes:
        line = f"{indent}<{name}{found}".rpartition("\n")[2]
        found += (f"\n{indent}   " if len(line) > _WIDTH else "") + attribute(key, value)
    return found


def _require_plain(element: Any) -> None:
    """Refuse what this writer would lose."""
    generic = _GENERIC if getattr(element, "eType", None) else (*_GENERIC, "eGenericType")
    for name in generic:
        if _feature(element, name) is not None and getattr(element, name):
            raise ModelError(
                f"metamodel element '{getattr(element, 'name', 'annotation')}' has {name}; "
                "expected plain classes and types; remove the generic part"
            )


def _kind(element: Any) -> str:
    """Return the Ecore class of an element."""
    return str(type(element).eClass.name)


def _container(element: Any) -> Any:
    """Return what contains an element; pyecore's own package is a module and nothing does."""
    return element.eContainer() if hasattr(element, "eContainer") else None


def _resolved(element: Any) -> Any:
    if not isinstance(element, EProxy):
        return element
    element.force_resolve()
    return element._wrapped  # noqa: SLF001 # pyecore offers no other way to the element
