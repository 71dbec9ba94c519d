"""Metamodels that a team has added to, in the place of ours for as long as a test takes."""

import shutil
from pathlib import Path

import pytest

from m2t import generate, metamodels
from m2t.metamodels import load_metamodels
from tests.support.tree import ROOT

_TYPE = "ecore:EDataType http://www.eclipse.org/emf/2002/Ecore#//"


def attribute(name: str, kind: str = "EString", more: str = "") -> str:
    """Return an attribute; ``kind`` is a type of Ecore, or a reference such as ``#//Mode``."""
    named = kind if kind.startswith("#") else _TYPE + kind
    return (
        f'<eStructuralFeatures xsi:type="ecore:EAttribute" name="{name}" eType="{named}" {more}/>'
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


def a_class(name: str, parents: str = "", content: str = "") -> str:
    """Return a class."""
    supertypes = f' eSuperTypes="{parents}"' if parents else ""
    return (
        f'<eClassifiers xsi:type="ecore:EClass" name="{name}"{supertypes}>{content}</eClassifiers>'
    )


def an_enumeration(name: str, *literals: str) -> str:
    """Return an enumeration."""
    listed = "".join(f'<eLiterals name="{one}" value="{n}"/>' for n, one in enumerate(literals))
    return f'<eClassifiers xsi:type="ecore:EEnum" name="{name}">{listed}</eClassifiers>'


class OwnMetamodels:
    """A copy of the metamodels that can be added to.

    Parameters
    ----------
    folder
        Takes the copy.
    monkeypatch
        Puts the copy in the place of ours.
    """

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.folder = folder / "metamodels"
        shutil.copytree(ROOT / "metamodels", self.folder)
        monkeypatch.setattr(metamodels, "metamodel_folder", lambda: self.folder)
        monkeypatch.setattr(generate, "metamodel_folder", lambda: self.folder)
        load_metamodels.cache_clear()

    def add(self, *classifiers: str, file: str = "mission.ecore") -> None:
        """Add classes and enumerations."""
        self._insert(file, "</ecore:EPackage>", 0, "".join(classifiers))

    def extend(self, class_name: str, *features: str, file: str = "mission.ecore") -> None:
        """Add features to a class of ours."""
        text = (self.folder / file).read_text(encoding="utf-8")
        start = text.index(f'<eClassifiers xsi:type="ecore:EClass" name="{class_name}"')
        self._insert(file, "</eClassifiers>", start, "".join(features))

    def _insert(self, file: str, before: str, start: int, addition: str) -> None:
        path = self.folder / file
        text = path.read_text(encoding="utf-8")
        place = text.index(before, start)
        path.write_text(f"{text[:place]}{addition}\n{text[place:]}", encoding="utf-8")
        load_metamodels.cache_clear()


@pytest.fixture
def own_metamodels(tmp_path, monkeypatch):
    """Return metamodels to add to; ours are back afterwards."""
    with monkeypatch.context() as patched:
        yield OwnMetamodels(tmp_path, patched)
    load_metamodels.cache_clear()
