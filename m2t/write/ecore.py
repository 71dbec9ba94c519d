"""Write metamodels as Eclipse EMF writes ``.ecore`` files.

pyecore's own serializer is not used: it loses opposites, ``resolveProxies`` and
``serializable``, and breaks lines elsewhere.
"""

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

from pyecore.ecore import EAttribute, EClass, EEnum, EOperation, EProxy, EReference

from m2t.namespaces import ECORE, XMI, XSI
from m2t.write.xmi import ATTRIBUTE_ESCAPES, encoded, escaped
from mrsfi_runtime.errors import ModelError

_WIDTH = 80
_NO_HREFS: Mapping[Any, str] = MappingProxyType({})


def dumps_metamodel(
    package: Any, encoding: str = "UTF-8", *, hrefs: Mapping[Any, str] = _NO_HREFS
) -> bytes:
    """Return a metamodel as the bytes of an ``.ecore`` file.

    Parameters
    ----------
    package
        Root package, as pyecore loaded it or a script made it.
    encoding
        Encoding that the file declares.
    hrefs
        Relative addresses of the other metamodel files, by their root packages.

    Returns
    -------
    bytes
        The file, with LF line ends.

    Raises
    ------
    ModelError
        If the metamodel refers to a package that ``hrefs`` does not know, or uses generic types.

    Notes
    -----
    An attribute goes to a new line, indented by four more than its element, as soon as what
    stands before it ends beyond column 80. What equals Ecore's default is left out.
    """
    writer = _EcoreWriter(package, hrefs)
    body = "".join(line + "\n" for line in writer.document())
    return encoded(f'<?xml version="1.0" encoding="{encoding}"?>\n{body}', encoding)


class _EcoreWriter:
    """Writes one metamodel."""

    def __init__(self, package: Any, hrefs: Mapping[Any, str]) -> None:
        self._root = package
        self._hrefs = hrefs

    def document(self) -> Iterator[str]:
        """Return the lines of the root element."""
        lines = list(self._package_content(self._root, "  "))
        head = [("xmi:version", "2.0"), ("xmlns:xmi", XMI)]
        if any(" xsi:type=" in line for line in lines):
            head.append(("xmlns:xsi", XSI))
        head.append(("xmlns:ecore", ECORE))
        tag = "<ecore:EPackage"
        # Eclipse inserts the namespaces last, so that they do not count for what follows.
        own = _broken(tag, "", self._package_attributes(self._root)).removeprefix(tag)
        yield from _closed(_broken(tag, "", head) + own, "", "ecore:EPackage", lines)

    def _package_attributes(self, package: Any) -> list[tuple[str, str]]:
        return _given(package, ("name", "nsURI", "nsPrefix"))

    def _package_content(self, package: Any, indent: str) -> Iterator[str]:
        yield from self._annotations(package, indent)
        for classifier in package.eClassifiers:
            yield from self._classifier(classifier, indent)
        for inner in package.eSubpackages:
            lines = list(self._package_content(inner, indent + "  "))
            yield from _element(indent, "eSubpackages", self._package_attributes(inner), lines)

    def _classifier(self, classifier: Any, indent: str) -> Iterator[str]:
        _require_plain(classifier, ("eTypeParameters", "eGenericSuperTypes"))
        attributes = [("xsi:type", f"ecore:{_kind(classifier)}")]
        attributes += _given(classifier, ("name", "instanceClassName"))
        lines = list(self._annotations(classifier, indent + "  "))
        if isinstance(classifier, EClass):
            attributes += _switched(classifier, ("abstract", "interface"), default=False)
            attributes += self._names("eSuperTypes", classifier.eSuperTypes)
            for operation in classifier.eOperations:
                lines += self._operation(operation, indent + "  ")
            for feature in classifier.eStructuralFeatures:
                lines += self._feature(feature, indent + "  ")
        else:
            attributes += _switched_if_set(classifier, "serializable")
        if isinstance(classifier, EEnum):
            for literal in classifier.eLiterals:
                lines += self._literal(literal, indent + "  ")
        yield from _element(indent, "eClassifiers", attributes, lines)

    def _literal(self, literal: Any, indent: str) -> Iterator[str]:
        attributes = _given(literal, ("name",))
        if literal.value:
            attributes.append(("value", str(literal.value)))
        if literal.literal is not None:
            attributes.append(("literal", literal.literal))
        lines = list(self._annotations(literal, indent + "  "))
        yield from _element(indent, "eLiterals", attributes, lines)

    def _operation(self, operation: Any, indent: str) -> Iterator[str]:
        _require_plain(operation, ("eTypeParameters", "eGenericExceptions"))
        attributes = self._typed(operation) + self._names("eExceptions", operation.eExceptions)
        lines = list(self._annotations(operation, indent + "  "))
        for parameter in operation.eParameters:
            inner = list(self._annotations(parameter, indent + "    "))
            lines += _element(indent + "  ", "eParameters", self._typed(parameter), inner)
        yield from _element(indent, "eOperations", attributes, lines)

    def _feature(self, feature: Any, indent: str) -> Iterator[str]:
        attributes = [("xsi:type", f"ecore:{_kind(feature)}"), *self._typed(feature)]
        attributes += _switched(feature, ("changeable",), default=True)
        attributes += _switched(feature, ("volatile", "transient"), default=False)
        attributes += _given(feature, ("defaultValueLiteral",))
        attributes += _switched(feature, ("unsettable", "derived"), default=False)
        if isinstance(feature, EAttribute):
            attributes += _switched(feature, ("iD",), default=False)
        else:
            attributes += _switched(feature, ("containment",), default=False)
            attributes += _switched_if_set(feature, "resolveProxies")
            opposite = [] if feature.eOpposite is None else [feature.eOpposite]
            attributes += self._names("eOpposite", opposite)
        lines = list(self._annotations(feature, indent + "  "))
        yield from _element(indent, "eStructuralFeatures", attributes, lines)

    def _typed(self, element: Any) -> list[tuple[str, str]]:
        attributes = _given(element, ("name",))
        attributes += _switched(element, ("ordered", "unique"), default=True)
        if element.lowerBound:
            attributes.append(("lowerBound", str(element.lowerBound)))
        if element.upperBound != 1:
            attributes.append(("upperBound", str(element.upperBound)))
        kind = _resolved(element.eType)
        if kind is None:
            _require_plain(element, ("eGenericType",))
            return attributes
        target = self._name(kind)
        prefix = "" if target.startswith("#") else f"ecore:{_kind(kind)} "
        return [*attributes, ("eType", prefix + target)]

    def _names(self, attribute: str, values: Any) -> list[tuple[str, str]]:
        names = [self._name(_resolved(value)) for value in values]
        return [(attribute, " ".join(names))] if names else []

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

    def _annotations(self, element: Any, indent: str) -> Iterator[str]:
        for annotation in element.eAnnotations:
            _require_plain(annotation, ("contents",))
            attributes = _given(annotation, ("source",))
            attributes += self._names("references", annotation.references)
            lines = list(self._annotations(annotation, indent + "  "))
            for key, value in annotation.details.items():
                entry = [("key", key)] + ([] if value is None else [("value", value)])
                lines += _element(indent + "  ", "details", entry, [])
            yield from _element(indent, "eAnnotations", attributes, lines)


def _element(
    indent: str, name: str, attributes: list[tuple[str, str]], lines: list[str]
) -> Iterator[str]:
    """Yield the lines of an element."""
    yield from _closed(_broken(f"{indent}<{name}", indent, attributes), indent, name, lines)


def _broken(start: str, indent: str, attributes: list[tuple[str, str]]) -> str:
    """Return the beginning of a start tag, broken as Eclipse breaks it."""
    done, line = "", start
    for key, value in attributes:
        text = f'{key}="{escaped(value, ATTRIBUTE_ESCAPES)}"'
        if len(line) > _WIDTH:
            done += f"{line}\n"
            line = f"{indent}    {text}"
        else:
            line = f"{line} {text}"
    return done + line


def _closed(start: str, indent: str, name: str, lines: list[str]) -> Iterator[str]:
    if not lines:
        yield f"{start}/>"
        return
    yield f"{start}>"
    yield from lines
    yield f"{indent}</{name}>"


def _given(element: Any, names: tuple[str, ...]) -> list[tuple[str, str]]:
    """Return the texts that an element has, by name."""
    found = ((name, getattr(element, name)) for name in names)
    return [(name, str(value)) for name, value in found if value is not None]


def _switched(element: Any, names: tuple[str, ...], *, default: bool) -> list[tuple[str, str]]:
    """Return the switches of an element that differ from their default."""
    found = ((name, bool(getattr(element, name))) for name in names)
    return [(name, str(value).lower()) for name, value in found if value is not default]


def _switched_if_set(element: Any, name: str) -> list[tuple[str, str]]:
    """Return a switch that is on unless it was set: pyecore takes it for off by default."""
    feature = type(element).eClass.findEStructuralFeature(name)
    is_off = feature in element._isset and not getattr(element, name)  # noqa: SLF001 # eIsSet asks the class
    return [(name, "false")] if is_off else []


def _require_plain(element: Any, names: tuple[str, ...]) -> None:
    """Refuse what this writer would lose."""
    for name in names:
        if getattr(element, name, None):
            raise ModelError(
                f"metamodel element '{getattr(element, 'name', 'annotation')}' has {name}; "
                "expected plain classes and types; remove the generic part"
            )


def _kind(element: Any) -> str:
    """Return the Ecore class of an element."""
    for kind in (EClass, EEnum, EReference, EAttribute, EOperation):
        if isinstance(element, kind):
            return str(kind.__name__)
    return "EDataType"


def _container(element: Any) -> Any:
    """Return what contains an element; pyecore's own package is a module and nothing does."""
    return element.eContainer() if hasattr(element, "eContainer") else None


def _resolved(element: Any) -> Any:
    if not isinstance(element, EProxy):
        return element
    element.force_resolve()
    return element._wrapped  # noqa: SLF001 # pyecore offers no other way to the element
