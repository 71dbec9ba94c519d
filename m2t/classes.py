"""Generate the static Python classes of the metamodels, ``generated/metamodel``.

``package_view`` computes the templates' context of a package; ``class_files`` renders the files,
``write_classes`` writes them, and ``main`` is the command. Read them in this order. Loading the
metamodels has already refused features that classes cannot express. The tasks are those of
pyecoregen, without the defects of its generator:

- text follows the order of the ``.ecore`` file, not that of sets;
- modules import each other relatively, so they load from a folder of any name;
- enumerations keep their values; lower bounds, IDs, ``unsettable``, defaults and annotations
  are kept; a feature named like a keyword keeps its name in models and gets ``_`` in Python;
- pyecore is not patched while templates run, so a failed template cannot leave it patched;
- files are ASCII on every machine, replaced as a whole, and only if they change.

Examples
--------
``python -m m2t.classes generated/metamodel`` writes; ``--check`` only lists stale files.
"""

import keyword
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeAlias

import click
from jinja2 import Environment
from pyecore.ecore import EClass, EEnum, EObject
from pyecoregen.ecore import EcoreTask

from m2t.emit import literal, template_environment
from m2t.metaclasses import Slot, lineage, slots
from m2t.metamodels import load_metamodels
from mrsfi_runtime.errors import GenerationError, ModelError, MrsfiError
from mrsfi_runtime.files import changing

_BODY_NAMES = frozenset(
    {"ClassVar", "EList", "Iterable", "annotated", "ecore", "bool", "float", "int", "str"}
)
"""Names that the body of a class or its stub uses, and that no feature may hide."""

_MODULE_NAMES = _BODY_NAMES.union(
    ("Any", "EEnumLiteral", "Element", "Values", "described", "elements", "enumeration"),
    ("partial", "setattr", "eClass", "eClassifiers", "eSubpackages", "eSuperPackage"),
    ("getEClassifier", "name", "nsPrefix", "nsURI"),
)
"""Names that a module or its stub uses, and that no class may have."""

_GENMODEL = "http://www.eclipse.org/emf/2002/GenModel"
_PYTHON_TYPES = {"EString": "str", "EInt": "int", "EDouble": "float", "EBoolean": "bool"}
_FLAGS = {
    **dict.fromkeys(("containment", "iD", "unsettable", "transient"), False),
    **dict.fromkeys(("changeable", "ordered", "unique"), True),
}
"""Properties of features, with their default values."""

Details: TypeAlias = tuple[tuple[str, str], ...]
Imports: TypeAlias = tuple[tuple[str, tuple[str, ...]], ...]


@dataclass(frozen=True, slots=True)
class AnnotatedView:
    """A named element of a metamodel, with its name in Python.

    ``documentation`` is that of GenModel, ``annotations`` are the others: source and details.
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
    """A feature of a class; ``kind`` is ``EAttribute`` or ``EReference``.

    ``arguments`` are those of its constructor, as code. ``type`` is the type of its value in a
    stub, ``parameter`` the type and default of the parameter that sets it there.
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
    """Return the templates' context of a package, a pyecore object.

    A name that Python or the classes themselves use raises a ``ModelError``.
    """
    own = list(package.eClassifiers)
    for element in (package, *own):
        _global_name(element)
    classifiers = [entry for entry in own if isinstance(entry, EClass)]
    ordered = dict.fromkeys(known for entry in classifiers for known in lineage(entry))
    metaclasses = tuple(entry for entry in ordered if entry in own)  # after their supertypes
    enumerations = tuple(_enumeration(entry) for entry in own if isinstance(entry, EEnum))
    classes = tuple(_class(metaclass) for metaclass in metaclasses)
    others = _other_packages(package, metaclasses)
    has_roots = any(not entry.bases for entry in classes)
    features = [feature for entry in classes for feature in entry.features]
    helpers = _import_of(
        Element=has_roots,
        Values=any("derived_class=Values" in feature.arguments for feature in features),
        annotated=True,
        described=bool(classes),
        enumeration=bool(enumerations),
    )
    stub_helpers = _import_of(
        EEnumLiteral=bool(enumerations),
        Element=has_roots,
        EList=any(feature.type.startswith("EList") for feature in features),
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


def _other_packages(package: Any, metaclasses: tuple[Any, ...]) -> Imports:
    own = {entry.name for entry in package.eClassifiers}
    types = [slot.type for metaclass in metaclasses for slot in slots(metaclass).values()]
    types += [known for metaclass in metaclasses for known in lineage(metaclass)]
    names: dict[str, set[str]] = {}
    for known in types:
        if known.ePackage is package or known.ePackage.name == "ecore":
            continue
        if known.name in own:
            raise _reserved(f"'{known.name}' of package '{known.ePackage.name}', and also here,")
        names.setdefault(f".{_global_name(known.ePackage)}", set()).add(_global_name(known))
    return tuple((module, tuple(sorted(names[module]))) for module in sorted(names))


def _class(metaclass: Any) -> ClassView:
    parents = tuple(_global_name(lineage(parent)[-1]) for parent in metaclass.eSuperTypes)
    parameters = tuple(map(_feature, slots(metaclass).values()))
    names = [view.name for view in parameters]
    taken = {"dyn_inst", "listeners"}.union(
        _BODY_NAMES, (entry.name for entry in metaclass.ePackage.eClassifiers)
    )
    for name in names:  # which may collide with each other or with something else
        if name in taken or hasattr(EObject, name) or names.count(name) > 1:
            raise _reserved(f"'{name}', a feature of '{metaclass.name}',")
    return ClassView(
        *_annotated(metaclass),
        is_abstract=bool(metaclass.abstract),
        bases=parents,
        features=tuple(map(_feature, _own(metaclass))),
        parameters=parameters,
    )


def _own(metaclass: Any) -> Iterator[Slot]:
    return (slots(metaclass)[feature.name] for feature in metaclass.eStructuralFeatures)


def _enumeration(enumeration: Any) -> EnumerationView:
    literals = tuple(
        LiteralView(*_annotated(entry), value=int(entry.value)) for entry in enumeration.eLiterals
    )
    for entry in literals:
        if keyword.iskeyword(entry.name) or hasattr(EEnum, entry.name):  # every enumeration has it
            raise _reserved(f"literal '{entry.name}' of '{enumeration.name}'")
    return EnumerationView(*_annotated(enumeration), literals=literals)


def _feature(slot: Slot) -> FeatureView:
    name, documentation, annotations = _annotated(slot.feature)
    is_ours = slot.holds_elements or isinstance(slot.type, EEnum)
    python_type = _global_name(slot.type) if is_ours else _PYTHON_TYPES[slot.type.name]
    has_value = slot.lower_bound > 0 or slot.feature.defaultValueLiteral is not None
    is_never_none = has_value or python_type in {"int", "float", "bool"}
    value_type = python_type if is_never_none else f"{python_type} | None"
    return FeatureView(
        _python_name(name),
        documentation,
        annotations,
        kind="EReference" if slot.holds_elements else "EAttribute",
        arguments=tuple(_arguments(slot)),
        type=f"EList[{python_type}]" if slot.many else value_type,  # in a valid model
        parameter=f"Iterable[{python_type}] = ..." if slot.many else f"{python_type} | None = ...",
    )


def _arguments(slot: Slot) -> Iterator[str]:
    """Yield the arguments of a feature that differ from the defaults."""
    feature = slot.feature
    if _python_name(slot.name) != slot.name:
        yield f'name="{slot.name}"'
    if not slot.holds_elements:
        known = _PYTHON_TYPES.get(slot.type.name)
        yield f"eType={'ecore.' if known else ''}{slot.type.name}"
    bounds = {"lower": (slot.lower_bound, 0), "upper": (int(feature.upperBound), 1)}
    yield from (f"{name}={value}" for name, (value, usual) in bounds.items() if value != usual)
    if slot.many and feature.unique:
        yield "derived_class=Values"
    for flag, usual in _FLAGS.items():
        value = bool(getattr(feature, flag, usual))
        if value is not usual:
            yield f"{flag}={value}"
    if not slot.holds_elements and feature.defaultValueLiteral is not None:
        yield f"defaultValueLiteral={literal(str(feature.defaultValueLiteral))}"


def _links(metaclasses: Iterable[Any]) -> Iterator[str]:
    """Yield the statements that give references their types, and features their names in models."""
    own = [(metaclass.name, slot) for metaclass in metaclasses for slot in _own(metaclass)]
    for owner, slot in own:
        if slot.holds_elements:
            yield f"{owner}.{_python_name(slot.name)}.eType = {slot.type.name}.eClass"
    for owner, slot in own:
        if (name := _python_name(slot.name)) != slot.name:
            yield f'setattr({owner}, "{slot.name}", {owner}.{name})'


def _annotated(element: Any) -> tuple[str, str | None, tuple[tuple[str, Details], ...]]:
    documentation = None
    others = []
    for annotation in element.eAnnotations:
        details: dict[str, str] = dict(annotation.details)
        if annotation.source == _GENMODEL:
            documentation = details.pop("documentation", documentation)
            if not details:
                continue
        others.append((annotation.source, tuple(details.items())))
    return str(element.name), documentation, tuple(others)


def _python_name(name: str) -> str:
    """Return the name of a feature in Python: a keyword gets an underscore at its end."""
    return f"{name}_" if keyword.iskeyword(name) or name == "self" else name


def _global_name(element: Any) -> str:
    name = str(element.name)
    if name in _MODULE_NAMES or keyword.iskeyword(name):
        raise _reserved(f"'{name}'")
    return name


def _reserved(what: str) -> ModelError:
    return ModelError(f"{what} is a name that Python or another element uses; rename it")


HEADER = "# Generated by m2t.classes from the metamodels; edit those instead."


class PackageTask(EcoreTask):  # type: ignore[misc] # pyecoregen has no types
    """Writes one file of a package: the classes, suffix ``.py``, or their stub, ``.pyi``.

    The generator of pyecoregen renames keywords by patching pyecore, and leaves it patched if a
    template fails; ``views`` renames them instead.
    """

    def __init__(self, environment: Environment, suffix: str) -> None:
        super().__init__()
        self.environment = environment
        self.template_name = f"package{suffix}.j2"
        self._suffix = suffix

    def relative_path_for_element(self, element: Any) -> str:
        """Return the name of the file."""
        return f"{element.name}{self._suffix}"

    def create_template_context(self, element: Any, **_: Any) -> dict[str, Any]:
        """Return the view of the package: metamodel objects do not reach a template."""
        return {"header": HEADER, "package": package_view(element)}


def class_files(packages: tuple[Any, ...]) -> dict[str, str]:
    """Return the texts of all files by name; each package refers to those before it only.

    A name that Python or the classes themselves use raises a ``ModelError``.
    """
    environment = template_environment("templates/metamodel")
    tasks = [PackageTask(environment, suffix) for suffix in (".py", ".pyi")]
    files = {
        name: environment.get_template(f"{name}.j2").render(header=HEADER)
        for name in ("__init__.py", "elements.py", "elements.pyi")
    }
    with TemporaryDirectory() as folder:
        for package, task in product(packages, tasks):
            task.run(package, folder)
        files |= {path.name: path.read_text(encoding="ascii") for path in Path(folder).iterdir()}
    return dict(sorted(files.items()))


def write_classes(folder: Path, files: Mapping[str, str]) -> tuple[str, ...]:
    """Write the files that differ, all or none; return their names.

    An existing file that was not generated raises a ``GenerationError``.
    """
    stale = stale_files(folder, files)
    for name in stale:
        path = folder / name
        if path.exists() and not path.read_text(encoding="utf-8").startswith(HEADER):
            raise GenerationError(
                f"{path} was not generated by m2t.classes; expected a folder for generated "
                "classes only; move the file away"
            )
    if stale:
        with changing(folder) as change:
            change.replace({folder / name: files[name].encode("utf-8") for name in stale})
    return stale


def stale_files(folder: Path, files: Mapping[str, str]) -> tuple[str, ...]:
    """Return the names of files that are missing or have another text."""
    return tuple(
        name
        for name, text in files.items()
        if not (folder / name).is_file() or (folder / name).read_bytes() != text.encode("utf-8")
    )


@click.command(name="python -m m2t.classes")
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False))
@click.option("--check", is_flag=True, help="Write nothing; exit code 4 if a file is stale.")
def main(folder: Path, *, check: bool) -> None:
    """Generate the static Python classes of both metamodels into FOLDER."""
    try:
        files = class_files(load_metamodels().packages)
        if check and (stale := stale_files(folder, files)):
            raise GenerationError(
                f"{folder}: stale, because the metamodels or templates changed: "
                f"{', '.join(stale)}; run `python -m m2t.classes {folder}` and review the diff"
            )
        if check:
            click.echo(f"fresh: {folder}")
        else:
            written = write_classes(folder, files)
            for name in files:
                click.echo(f"{'written' if name in written else 'unchanged':<9}  {folder / name}")
    except MrsfiError as error:
        click.echo(f"error: {error}", err=True)
        sys.exit(error.exit_code)


if __name__ == "__main__":
    main()
