"""What the templates of the static classes need to know about a metamodel.

Everything is read in the order of the ``.ecore`` file. What the classes could not express is
refused: an incomplete class would write incomplete models.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, TypeAlias

from pyecore.ecore import EClass, EEnum

from m2t.classes.names import (
    global_name,
    identifier_of,
    python_name,
    require_feature_names,
    require_literal_name,
    reserved,
)
from m2t.environment import literal
from m2t.metamodels import features, is_contained, is_reference, lineage, reference_type
from mrsfi_runtime.errors import ModelError

_GENMODEL = "http://www.eclipse.org/emf/2002/GenModel"
_PYTHON_TYPES: Mapping[str, str] = MappingProxyType(
    {"EString": "str", "EInt": "int", "EDouble": "float", "EBoolean": "bool"}
)
_FLAGS: Mapping[str, bool] = MappingProxyType(
    dict.fromkeys(("containment", "iD", "unsettable", "transient"), False)
    | dict.fromkeys(("changeable", "ordered", "unique"), True)
)
"""Properties of features, with the values that they have unless something else is said."""

Details: TypeAlias = tuple[tuple[str, str], ...]
Imports: TypeAlias = tuple[tuple[str, tuple[str, ...]], ...]


@dataclass(frozen=True, slots=True)
class AnnotatedView:
    """A named element of a metamodel with its annotations.

    Attributes
    ----------
    name
        Its name in Python.
    documentation
        Text of its GenModel documentation, if it has one.
    annotations
        The other annotations: source and details.
    """

    name: str
    documentation: str | None
    annotations: tuple[tuple[str, Details], ...]

    @property
    def notes(self) -> tuple[object, ...]:
        """Arguments of the generated ``annotated`` and ``described``."""
        return (self.documentation, *self.annotations)


@dataclass(frozen=True, slots=True)
class LiteralView(AnnotatedView):
    """A literal of an enumeration."""

    value: int


@dataclass(frozen=True, slots=True)
class EnumerationView(AnnotatedView):
    """An enumeration."""

    literals: tuple[LiteralView, ...]


@dataclass(frozen=True, slots=True)
class FeatureView(AnnotatedView):
    """A feature of a class.

    Attributes
    ----------
    kind
        ``EAttribute`` or ``EReference``.
    arguments
        Arguments of its constructor, as code.
    type
        Type of its value in a stub.
    parameter
        Type and default of the constructor's parameter that sets it, in a stub.
    """

    kind: str
    arguments: tuple[str, ...]
    type: str
    parameter: str


@dataclass(frozen=True, slots=True)
class ClassView(AnnotatedView):
    """A class; ``parameters`` are its features and the inherited ones, which come first."""

    is_abstract: bool
    bases: tuple[str, ...]
    stub_bases: tuple[str, ...]
    features: tuple[FeatureView, ...]
    parameters: tuple[FeatureView, ...]


@dataclass(frozen=True, slots=True)
class PackageView(AnnotatedView):
    """A package; ``links`` are statements that need all classes, such as types of references."""

    uri: str
    prefix: str
    imports: Imports
    stub_imports: Imports
    enumerations: tuple[EnumerationView, ...]
    classes: tuple[ClassView, ...]
    links: tuple[str, ...]


def package_view(package: Any) -> PackageView:
    """Return what the templates need to know about a package.

    Parameters
    ----------
    package
        Package of a metamodel, a pyecore object.

    Raises
    ------
    ModelError
        If the package holds something that static classes cannot express, or a name that
        Python or the classes themselves use.
    """
    _require_supported(package)
    own = list(package.eClassifiers)
    metaclasses = _bases_first(entry for entry in own if isinstance(entry, EClass))
    enumerations = tuple(_enumeration(entry) for entry in own if isinstance(entry, EEnum))
    classes = tuple(_class(metaclass) for metaclass in metaclasses)
    others = _other_packages(package, metaclasses)
    has_roots = any("Element" in entry.stub_bases for entry in classes)
    helpers = _import_of(
        Element=has_roots,
        Values=any(map(_has_sets, classes)),
        annotated=True,
        described=bool(classes),
        enumeration=bool(enumerations),
    )
    stub_helpers = _import_of(
        EEnumLiteral=bool(enumerations), Element=has_roots, EList=any(map(_has_lists, classes))
    )
    return PackageView(
        *_annotated(package),
        uri=package.nsURI,
        prefix=package.nsPrefix,
        imports=(helpers, *others),
        stub_imports=(stub_helpers, *others),
        enumerations=enumerations,
        classes=classes,
        links=tuple(_links(metaclasses)),
    )


def _import_of(**names: bool) -> tuple[str, tuple[str, ...]]:
    return ".elements", tuple(name for name, is_used in names.items() if is_used)


def _has_lists(view: ClassView) -> bool:
    return any(feature.type.startswith("EList") for feature in view.features)


def _has_sets(view: ClassView) -> bool:
    return any("derived_class=Values" in feature.arguments for feature in view.features)


def _bases_first(metaclasses: Iterable[Any]) -> tuple[Any, ...]:
    """Return classes in order of the file, except that a class follows its supertypes."""
    wanted = list(metaclasses)
    ordered = dict.fromkeys(known for entry in wanted for known in lineage(entry))
    return tuple(entry for entry in ordered if entry in wanted)


def _other_packages(package: Any, metaclasses: Iterable[Any]) -> Imports:
    """Return the classes of other packages that this one refers to, by module."""
    own = {entry.name for entry in package.eClassifiers}
    names: dict[str, set[str]] = {}
    for metaclass in metaclasses:
        types = (_resolved_type(feature) for feature in features(metaclass))
        for known in (*lineage(metaclass), *types):
            if known.ePackage is package or known.ePackage.name == "ecore":
                continue
            if known.name in own:
                raise reserved(f"'{known.name}' of package '{known.ePackage.name}', and also here,")
            names.setdefault(f".{global_name(known.ePackage)}", set()).add(global_name(known))
    return tuple((module, tuple(sorted(names[module]))) for module in sorted(names))


def _resolved_type(feature: Any) -> Any:
    return feature.eType if _is_attribute(feature) else reference_type(feature)


def _class(metaclass: Any) -> ClassView:
    parents = tuple(global_name(parent) for parent in _supertypes(metaclass))
    parameters = tuple(_feature(feature) for feature in features(metaclass))
    require_feature_names(metaclass, [view.name for view in parameters])
    return ClassView(
        *_annotated(metaclass),
        is_abstract=bool(metaclass.abstract),
        bases=parents or ("Element", "ecore.EObject", "metaclass=ecore.MetaEClass"),
        stub_bases=parents or ("Element",),
        features=tuple(_feature(feature) for feature in metaclass.eStructuralFeatures),
        parameters=parameters,
    )


def _supertypes(metaclass: Any) -> tuple[Any, ...]:
    return tuple(lineage(parent)[-1] for parent in metaclass.eSuperTypes)


def _enumeration(enumeration: Any) -> EnumerationView:
    literals = tuple(
        LiteralView(*_annotated(entry), value=int(entry.value)) for entry in enumeration.eLiterals
    )
    for entry in literals:
        require_literal_name(enumeration, entry.name)
    return EnumerationView(*_annotated(enumeration), literals=literals)


def _feature(feature: Any) -> FeatureView:
    name, documentation, annotations = _annotated(feature)
    kind, python_type = _type(feature)
    return FeatureView(
        python_name(name),
        documentation,
        annotations,
        kind=kind,
        arguments=tuple(_arguments(feature)),
        type=_value_type(feature, python_type),
        parameter=f"Iterable[{python_type}] = ..."
        if feature.many
        else f"{python_type} | None = ...",
    )


def _type(feature: Any) -> tuple[str, str]:
    """Return the kind of a feature and the Python type of one value."""
    if not _is_attribute(feature):
        return "EReference", global_name(reference_type(feature))
    if isinstance(feature.eType, EEnum):
        return "EAttribute", global_name(feature.eType)
    if feature.eType.name not in _PYTHON_TYPES:
        raise ModelError(
            f"attribute '{feature.name}' has type {feature.eType.name}; static classes know "
            f"{', '.join(_PYTHON_TYPES)} and enumerations; use one of these"
        )
    return "EAttribute", _PYTHON_TYPES[feature.eType.name]


def _value_type(feature: Any, python_type: str) -> str:
    """Return the type of a feature in a valid model: only what is optional may be ``None``."""
    if feature.many:
        return f"EList[{python_type}]"
    is_number = python_type in {"int", "float", "bool"}
    is_never_none = is_number or feature.lowerBound > 0 or feature.defaultValueLiteral is not None
    return python_type if is_never_none else f"{python_type} | None"


def _arguments(feature: Any) -> Iterator[str]:
    """Yield what distinguishes a feature from one with all defaults."""
    if python_name(feature.name) != feature.name:
        yield f'name="{feature.name}"'
    if _is_attribute(feature):
        known = _PYTHON_TYPES.get(feature.eType.name)
        yield f"eType={'ecore.' if known else ''}{feature.eType.name}"
    yield from _bounds(feature)
    for flag, usual in _FLAGS.items():
        value = bool(getattr(feature, flag, usual))
        if value is not usual:
            yield f"{flag}={value}"
    if _is_attribute(feature) and feature.defaultValueLiteral is not None:
        yield f"defaultValueLiteral={literal(str(feature.defaultValueLiteral))}"


def _bounds(feature: Any) -> Iterator[str]:
    if feature.lowerBound != 0:
        yield f"lower={int(feature.lowerBound)}"
    if feature.upperBound != 1:
        yield f"upper={int(feature.upperBound)}"
    if feature.many and feature.unique:
        yield "derived_class=Values"


def _links(metaclasses: Iterable[Any]) -> Iterator[str]:
    """Yield the statements that give references their types and opposites."""
    for metaclass in metaclasses:
        for feature in metaclass.eStructuralFeatures:
            if _is_attribute(feature):
                continue
            here = f"{metaclass.name}.{python_name(feature.name)}"
            yield f"{here}.eType = {reference_type(feature).name}.eClass"
            if feature.eOpposite is not None:
                there = feature.eOpposite
                owner = there.eContainingClass.name
                yield f"{here}.eOpposite = {owner}.{python_name(there.name)}"
    for metaclass in metaclasses:
        for feature in metaclass.eStructuralFeatures:
            if python_name(feature.name) != feature.name:
                alias = f"{metaclass.name}.{python_name(feature.name)}"
                yield f'setattr({metaclass.name}, "{feature.name}", {alias})'


def _is_attribute(feature: Any) -> bool:
    return not is_contained(feature) and not is_reference(feature)


def _annotated(element: Any) -> tuple[str, str | None, tuple[tuple[str, Details], ...]]:
    """Return the name and annotations of an element."""
    documentation = None
    others = []
    for annotation in element.eAnnotations:
        details: dict[str, str] = dict(annotation.details)
        if annotation.source == _GENMODEL:
            documentation = details.pop("documentation", documentation)
            if not details:
                continue
        others.append((annotation.source, tuple(details.items())))
    return identifier_of(element), documentation, tuple(others)


def _require_supported(package: Any) -> None:
    """Refuse what the classes cannot express."""
    if list(package.eSubpackages):
        raise ModelError(f"package '{package.name}' has subpackages; expected none; use two files")
    global_name(package)
    for classifier in package.eClassifiers:
        global_name(classifier)
        if isinstance(classifier, EClass):
            _require_plain(classifier)
        elif not isinstance(classifier, EEnum):
            raise ModelError(
                f"data type '{classifier.name}' is not known to static classes; expected classes "
                "and enumerations only; use a type of Ecore"
            )


def _require_plain(metaclass: Any) -> None:
    unknown = [
        *(f"operation '{entry.name}'" for entry in metaclass.eOperations),
        *(f"type parameter '{entry.name}'" for entry in metaclass.eTypeParameters),
        *(
            f"derived or volatile feature '{entry.name}'"
            for entry in metaclass.eStructuralFeatures
            if entry.derived or entry.volatile
        ),
    ]
    if unknown:
        raise ModelError(
            f"class '{metaclass.name}' has {unknown[0]}, which static classes cannot express; "
            "expected plain features; delete it"
        )
