"""Edited metamodels: what mrsfi reads has to stay as it is."""

import random
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from m2t.metaclasses import CONTRACT, SUPERTYPES, features, lineage
from m2t.metamodels import FAULTS_FILE, MISSION_FILE, load_metamodels, read_metamodels
from mrsfi_runtime.errors import ModelError
from tests.support.features import is_contained, reference_type
from tests.support.own_metamodels import ECORE_TYPE, a_class, add_classes, copy_metamodels

NEEDED = [
    (package, class_name, name)
    for package, classes in CONTRACT.items()
    for class_name, needs in classes.items()
    for name in needs
]
CLASSES = [(package, name) for package, classes in CONTRACT.items() for name in classes]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with copies of both metamodels."""
    return copy_metamodels(tmp_path).parent


def _class(package: str, name: str) -> Any:
    return getattr(load_metamodels(), package).getEClassifier(name)


def _owner(package: str, class_name: str, name: str) -> str:
    """Return the class that declares a feature which another inherits."""
    classes = lineage(_class(package, class_name))
    return next(
        str(kind.name)
        for kind in classes
        if name in {feature.name for feature in kind.eStructuralFeatures}
    )


def _owned(owner: str, package: str) -> Path:
    """Return the name of the file that declares a class."""
    is_here = _class(package, owner) is not None
    return Path(f"{package if is_here else 'mission'}.ecore")


def _block(text: str, owner: str, name: str) -> re.Match[str]:
    """Return the start tag of a feature."""
    start = text.index(f'<eClassifiers xsi:type="ecore:EClass" name="{owner}"')
    pattern = re.compile(rf'<eStructuralFeatures [^>]*?name="{name}"[^>]*>')
    found = pattern.search(text, start)
    assert found, (owner, name)
    return found


def _error(folder: Path) -> str:
    with pytest.raises(ModelError) as caught:
        read_metamodels(folder)
    return str(caught.value)


def is_fault_type(feature: Any) -> bool:
    """Return whether a feature holds a fault type, whose meaning is read from annotations."""
    kinds = lineage(reference_type(feature)) if is_contained(feature) else ()
    return "FaultType" in {kind.name for kind in kinds}


def test_the_metamodels_have_what_is_read_and_little_else():
    read = {
        (class_name, name)
        for classes in CONTRACT.values()
        for class_name, needs in classes.items()
        for name in needs
    }

    declared = {
        (str(kind.name), str(feature.name))
        for package in load_metamodels().packages
        for kind in package.eClassifiers
        if hasattr(kind, "eStructuralFeatures") and kind.name in CONTRACT[package.name]
        for feature in features(kind)
        if not is_fault_type(feature)
    }

    assert declared == read


@pytest.mark.parametrize("package", SUPERTYPES)
def test_supertypes_are_those_of_the_metamodels(package):
    for name, parent in SUPERTYPES[package].items():
        assert parent in {kind.name for kind in lineage(_class(package, name))[:-1]}


@pytest.mark.parametrize(("package", "name"), CLASSES)
def test_renamed_class_is_named_with_its_file(folder, package, name):
    path = folder / f"{package}.ecore"
    text = path.read_text(encoding="utf-8")
    renamed = text.replace(f'"{name}"', f'"{name}X"').replace(f'//{name}"', f'//{name}X"')
    path.write_text(renamed, encoding="utf-8")

    message = _error(folder)

    assert re.search(rf"{re.escape(str(path))}:[1-9][0-9]*: .*class {name}\b", message)


def _retagged(
    folder: Path, package: str, class_name: str, name: str, change: Callable[[str], str]
) -> tuple[Path, int] | None:
    """Write another start tag for a feature; return its file and line, or None if it is the same.

    Of a class of ``faults.ecore`` nothing may refer to a class that ``mission.ecore`` declares.
    """
    owner = _owner(package, class_name, name)
    path = folder / _owned(owner, package)
    text = path.read_text(encoding="utf-8")
    found = _block(text, owner, name)
    tag = change(found[0])
    if tag == found[0] or ("#//Mission" in tag and path.name == FAULTS_FILE):
        return None
    path.write_text(text[: found.start()] + tag + text[found.end() :], encoding="utf-8")
    return path, text[: found.start()].count("\n") + 1


@pytest.mark.parametrize(("package", "class_name", "name"), NEEDED)
def test_renamed_feature_is_named_with_file_and_class(folder, package, class_name, name):
    renamed = _retagged(
        folder,
        package,
        class_name,
        name,
        lambda tag: tag.replace(f'name="{name}"', f'name="{name}X"'),
    )
    assert renamed
    path, _ = renamed

    message = _error(folder)

    # a class of mission.ecore is missed there, before faults.ecore is read
    assert re.search(rf"{re.escape(str(path))}:[1-9][0-9]*: .* has no feature {name};", message)
    if path.stem == package:
        assert f"'{class_name}' has no feature {name};" in message


RETYPED = {
    "many": (r' upperBound="-1"|(?=/?>$)', {"": ' upperBound="-1"'}),
    "optional": (r' lowerBound="[12]"', {}),
    "other type": (r'eType="[^"]*"', {}),
    "reference of containment": (r' containment="true"', {}),
    "no identity": (r'\s+iD="true"', {}),
    "transient": (r"(?=/?>$)", {"": ' transient="true"'}),
    "derived": (r"(?=/?>$)", {"": ' derived="true"'}),
}


def _mutated(tag: str, how: str) -> str:
    """Return another start tag of a feature; the same if the edit does not apply."""
    if how == "other type":
        kind = "EReference" if "EReference" in tag else "EAttribute"
        other = "#//Mission" if kind == "EReference" else f"{ECORE_TYPE}EString"
        other = f"{ECORE_TYPE}EInt" if "//EString" in tag else other
        return re.sub(r'eType="[^"]*"', f'eType="{other}"', tag)
    pattern, replacements = RETYPED[how]
    return re.sub(pattern, lambda found: replacements.get(found[0], ""), tag, count=1)


@pytest.mark.parametrize("how", RETYPED)
def test_feature_declared_otherwise_is_named_with_file_and_line(folder, how):
    draw = random.Random(f"contract {how}")
    originals = {path: path.read_bytes() for path in folder.iterdir()}
    n_edited = 0

    for package, class_name, name in draw.sample(NEEDED, len(NEEDED)):
        edited = _retagged(folder, package, class_name, name, lambda tag: _mutated(tag, how))
        if edited is None:
            continue
        path, line = edited

        assert f"{path}:" in (message := _error(folder))
        assert f":{line}: eStructuralFeatures '{name}'" in message

        path.write_bytes(originals[path])
        n_edited += 1
        if n_edited == 15:
            break

    assert n_edited


def test_ladder_of_diamonds_is_read_without_climbing_every_path(folder):
    rungs = ["", *(f"#//L{number} #//R{number}" for number in range(23))]
    classes = (
        a_class(f"{side}{number}", parents) for number, parents in enumerate(rungs) for side in "LR"
    )
    add_classes(folder / MISSION_FILE, *classes)

    both = read_metamodels(folder)

    assert both.mission.getEClassifier("R23") is not None


def test_text_within_an_element_is_named_with_its_line(folder, approved):
    path = folder / MISSION_FILE
    before, end, after = path.read_text(encoding="utf-8").partition("</eClassifiers>")
    path.write_text(f"{before}forgotten{end}{after}", encoding="utf-8")
    line = before[: before.rindex("<eClassifiers")].count("\n") + 1

    message = _error(folder)

    assert f"{path}:{line}: " in message
    approved(message)


@pytest.mark.parametrize("parent", ["#//Robot", "#//K999"])
def test_endless_lineage_is_an_error(folder, parent):
    parents = [parent, *(f"#//K{number}" for number in range(999))]
    classes = (a_class(f"K{number}", kind) for number, kind in enumerate(parents))
    add_classes(folder / MISSION_FILE, *classes)

    message = _error(folder)

    assert "'K999'" in message
