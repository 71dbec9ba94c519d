"""Metamodels that a team has added to, as text, and generation from them in this process."""

import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch

import pytest

from m2t.metaclasses import MEANING
from m2t.metamodels import FAULTS_FILE, MISSION_FILE, metamodel_folder, read_metamodels
from tests.support.cli import edit

ECORE_TYPE = "ecore:EDataType http://www.eclipse.org/emf/2002/Ecore#//"


def meaning(**details: str) -> str:
    """Return an annotation of ours."""
    entries = "".join(f'<details key="{key}" value="{value}"/>' for key, value in details.items())
    return f'<eAnnotations source="{MEANING}">{entries}</eAnnotations>'


def attribute(name: str, kind: str = "EString", more: str = "", content: str = "") -> str:
    """Return an attribute; ``kind`` is a type of Ecore, or an enumeration such as ``#//Mode``."""
    named = kind if kind.startswith("#") else ECORE_TYPE + kind
    return (
        f'<eStructuralFeatures xsi:type="ecore:EAttribute" name="{name}" '
        f'eType="{named}" {more}>{content}</eStructuralFeatures>'
    )


def parameter(name: str, kind: str = "EDouble", **details: str) -> str:
    """Return a parameter of a fault type."""
    return attribute(name, kind, 'lowerBound="1"', meaning(**details))


def a_class(name: str, parents: str = "", content: str = "") -> str:
    """Return a class."""
    supertypes = f' eSuperTypes="{parents}"' if parents else ""
    return (
        f'<eClassifiers xsi:type="ecore:EClass" name="{name}"{supertypes}>{content}</eClassifiers>'
    )


def reference(name: str, kind: str, more: str = "") -> str:
    """Return a reference to elements of a class."""
    return (
        f'<eStructuralFeatures xsi:type="ecore:EReference" name="{name}" eType="#//{kind}" {more}/>'
    )


def part(name: str, kind: str, more: str = "") -> str:
    """Return a containment of elements of a class."""
    return reference(name, kind, f'containment="true" {more}')


def many(number: int = -1) -> str:
    """Return what makes a feature hold many values."""
    return f'upperBound="{number}"'


def an_enumeration(name: str, *literals: str) -> str:
    """Return an enumeration."""
    listed = "".join(f'<eLiterals name="{one}" value="{n}"/>' for n, one in enumerate(literals))
    return f'<eClassifiers xsi:type="ecore:EEnum" name="{name}">{listed}</eClassifiers>'


def add_feature(path: Path, class_name: str, feature: str) -> None:
    """Add a feature to a class of a metamodel."""
    text = path.read_text(encoding="utf-8")
    start = text.index(f'<eClassifiers xsi:type="ecore:EClass" name="{class_name}"')
    end = text.index("</eClassifiers>", start)
    path.write_text(text[:end] + feature + text[end:], encoding="utf-8")


def add_classes(path: Path, *classes: str) -> None:
    """Add classes to a metamodel."""
    edit(path, "</ecore:EPackage>", f"{''.join(classes)}</ecore:EPackage>")


def add_fault_type(path: Path, name: str, parent: str, content: str) -> None:
    """Add a fault type to a metamodel, and its containment to the class of faults."""
    add_classes(path, a_class(name, f"#//{parent}", content))
    feature = (
        f'<eStructuralFeatures xsi:type="ecore:EReference" name="{name[0].lower()}{name[1:]}" '
        f'eType="#//{name}" containment="true"/>'
    )
    add_feature(path, "Fault", feature)


def copy_metamodels(folder: Path) -> Path:
    """Copy both metamodels into a folder; return the file of the faults."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in (MISSION_FILE, FAULTS_FILE):
        shutil.copy(metamodel_folder() / name, folder / name)
    return folder / FAULTS_FILE


@contextmanager
def metamodels_of(folder: Path) -> Iterator[None]:
    """Let everything in this process read the metamodels of a folder."""
    targets = ("m2t.metamodels.metamodel_folder", "m2t.generate.metamodel_folder")
    with patch(targets[0], lambda: folder), patch(targets[1], lambda: folder):
        read_metamodels.cache_clear()
        try:
            yield
        finally:
            read_metamodels.cache_clear()


def add_faults(path: Path, faults: Mapping[str, str]) -> None:
    """Add faults to the text of a pool: ID to the element of the fault's type."""
    text = "".join(
        f'  <faults ID="{name}" name="{name}">{kind}</faults>\n' for name, kind in faults.items()
    )
    edit(path, "</faults:FaultSpecification>", f"{text}</faults:FaultSpecification>")


class OwnMetamodels:
    """A copy of the metamodels that can be added to."""

    def __init__(self, folder: Path) -> None:
        self.folder = copy_metamodels(folder).parent

    def add(self, *classifiers: str, file: str = MISSION_FILE) -> None:
        """Add classes and enumerations."""
        add_classes(self.folder / file, *classifiers)
        read_metamodels.cache_clear()

    def extend(self, class_name: str, *features: str, file: str = MISSION_FILE) -> None:
        """Add features to a class of ours."""
        add_feature(self.folder / file, class_name, "".join(features))
        read_metamodels.cache_clear()


@pytest.fixture
def own_metamodels(tmp_path):
    """Return metamodels to add to, which are read in the place of ours."""
    own = OwnMetamodels(tmp_path / "metamodels")
    with metamodels_of(own.folder):
        yield own
