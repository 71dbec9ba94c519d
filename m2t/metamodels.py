"""The two metamodels, loaded dynamically from their ``.ecore`` files."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from pyecore.ecore import EProxy, EReference
from pyecore.resources import URI, ResourceSet

from mrsfi_runtime.errors import ModelError

MISSION_FILE = "mission.ecore"
FAULTS_FILE = "faults.ecore"


@dataclass(frozen=True, slots=True)
class Metamodels:
    """The packages ``mission`` and ``faults`` as pyecore objects."""

    mission: Any
    faults: Any

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
    message = f"{MISSION_FILE} and {FAULTS_FILE} are missing in {places}; install mrsfi again"
    raise ModelError(message)


@cache
def load_metamodels() -> Metamodels:
    """Load both metamodels once per process; they are never changed afterwards.

    Raises
    ------
    ModelError
        If the files are missing.
    """
    folder = metamodel_folder()
    resources = ResourceSet()
    packages = []
    for name in (MISSION_FILE, FAULTS_FILE):
        package = resources.get_resource(URI(str(folder / name))).contents[0]
        resources.metamodel_registry[package.nsURI] = package
        packages.append(package)
    return Metamodels(*packages)


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


def reference_type(feature: Any) -> Any:
    """Return the metaclass that a reference or containment leads to."""
    return _resolved(feature.eType)


def conforms(metaclass: Any, wanted: Any) -> bool:
    """Return whether a metaclass is another one or one of its subclasses."""
    return any(known is wanted for known in lineage(metaclass))


def is_contained(feature: Any) -> bool:
    """Return whether a feature contains elements."""
    return isinstance(feature, EReference) and bool(feature.containment)


def is_reference(feature: Any) -> bool:
    """Return whether a feature refers to elements that something else contains."""
    return isinstance(feature, EReference) and not feature.containment


def _resolved(metaclass: Any) -> Any:
    """Return the metaclass behind the proxy of another metamodel file."""
    return metaclass.force_resolve() if isinstance(metaclass, EProxy) else metaclass
