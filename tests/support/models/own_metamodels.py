"""Metamodels that a team has added to, in the place of ours for as long as a test takes."""

from pathlib import Path

import pytest

from m2t import generate, metamodels
from m2t.metamodels import load_metamodels
from tests.support.own_metamodels import add_classes, add_feature, copy_metamodels


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
        self.folder = copy_metamodels(folder / "metamodels").parent
        monkeypatch.setattr(metamodels, "metamodel_folder", lambda: self.folder)
        monkeypatch.setattr(generate, "metamodel_folder", lambda: self.folder)
        load_metamodels.cache_clear()

    def add(self, *classifiers: str, file: str = "mission.ecore") -> None:
        """Add classes and enumerations."""
        add_classes(self.folder / file, *classifiers)
        load_metamodels.cache_clear()

    def extend(self, class_name: str, *features: str, file: str = "mission.ecore") -> None:
        """Add features to a class of ours."""
        add_feature(self.folder / file, class_name, "".join(features))
        load_metamodels.cache_clear()


@pytest.fixture
def own_metamodels(tmp_path, monkeypatch):
    """Return metamodels to add to; ours are back afterwards."""
    with monkeypatch.context() as patched:
        yield OwnMetamodels(tmp_path, patched)
    load_metamodels.cache_clear()
