"""The two metamodels, loaded dynamically from their ``.ecore`` files."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any

from lxml import etree
from pyecore.ecore import EClass, EProxy, EReference
from pyecore.resources import URI, ResourceSet

from m2t.diagnostics import Report
from m2t.metamodel_check import MetamodelCheck
from m2t.metamodel_contract import BOUNDS, CONTRACT, MEANING
from m2t.read.nodes import Node, read_xml
from mrsfi_runtime.errors import ModelError
from mrsfi_runtime.model.fault_types import FaultType, Range

MISSION_FILE = "mission.ecore"
FAULTS_FILE = "faults.ecore"
MISSION_ROOT = "Mission"
FAULTS_ROOT = "FaultSpecification"


@dataclass(frozen=True, slots=True)
class Metamodels:
    """The packages ``mission`` and ``faults`` as pyecore objects, and the fault types by name."""

    mission: Any
    faults: Any
    fault_types: Mapping[str, FaultType]

    @property
    def mission_class(self) -> Any:
        """Class of the root of a mission model."""
        return self.mission.getEClassifier(MISSION_ROOT)

    @property
    def faults_class(self) -> Any:
        """Class of the root of a fault model."""
        return self.faults.getEClassifier(FAULTS_ROOT)

    @property
    def packages(self) -> tuple[Any, Any]:
        """Both packages, the one that the other refers to first."""
        return (self.mission, self.faults)


def metamodel_folder() -> Path:
    """Return the folder of the metamodels: inside the installed package or in the source tree.

    Raises
    ------
    ModelError
        If neither place has them.
    """
    here = Path(__file__).resolve().parent
    candidates = (here / "metamodels", here.parent / "metamodels")
    for folder in candidates:
        if (folder / MISSION_FILE).is_file() and (folder / FAULTS_FILE).is_file():
            return folder
    places = " and ".join(str(folder) for folder in candidates)
    raise ModelError(
        f"{MISSION_FILE} and {FAULTS_FILE} are missing in {places}; install mrsfi again"
    )


@cache
def load_metamodels() -> Metamodels:
    """Load both metamodels once per process; they are never changed afterwards.

    Raises
    ------
    ModelError
        If the files are missing or cannot be used.
    """
    return read_metamodels(metamodel_folder())


def read_metamodels(folder: Path) -> Metamodels:
    """Read both metamodels from a folder.

    Parameters
    ----------
    folder
        Folder with ``mission.ecore`` and ``faults.ecore``.

    Raises
    ------
    ModelError
        With all that is wrong with the files, one defect a line.
    """
    report = Report()
    check = MetamodelCheck(report)
    resources = ResourceSet()
    packages = []
    for name, root_class in ((MISSION_FILE, MISSION_ROOT), (FAULTS_FILE, FAULTS_ROOT)):
        path = folder / name
        xml = read_xml(path, report)
        if xml is not None:
            check.check(xml.root, path.stem, root_class)
            report.require_no_errors()
            packages.append(_package(xml.root, path, resources))
        report.require_no_errors()
    mission, faults = packages
    return Metamodels(mission, faults, check.fault_types)


class _CheckedFile(URI):  # type: ignore[misc] # pyecore has no types
    """A file that pyecore reads from memory."""

    def __init__(self, name: str, content: bytes) -> None:
        super().__init__(name)
        self._content = content

    def create_instream(self) -> BytesIO:
        """Return the content."""
        return BytesIO(self._content)

    def close_stream(self) -> None:
        """Do nothing: there is no file."""


def _package(root: Node, path: Path, resources: Any) -> Any:
    """Let pyecore load a checked metamodel, without comments, which it cannot read."""
    parser = etree.XMLParser(remove_comments=True, remove_pis=True, resolve_entities=False)
    try:
        content = etree.tostring(etree.parse(path, parser))
        resource = resources.get_resource(_CheckedFile(path.name, content))
        package = resource.contents[0]
        for classifier in package.eClassifiers:
            slots(classifier) if isinstance(classifier, EClass) else None
    except Exception as error:  # pyecore raises anything
        raise ModelError(
            f"{path}:{root.line}: {path.name} cannot be loaded ({type(error).__name__}: {error}); "
            "expected a metamodel of classes and enumerations; restore the file"
        ) from error
    resources.resources[path.name] = resource
    resources.metamodel_registry[package.nsURI] = package
    return package


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

    Notes
    -----
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


def meaning(fault_type: Any) -> FaultType:
    """Return what the metamodel says of the class of a fault type."""
    return load_metamodels().fault_types[fault_type.eClass.name]


def _resolved(metaclass: Any) -> Any:
    """Return the metaclass behind the proxy of another metamodel file."""
    return metaclass.force_resolve() if isinstance(metaclass, EProxy) else metaclass
