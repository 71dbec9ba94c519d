"""A law: what a team adds to its metamodels and uses in its models is never dropped.

Each of its values is found in generated code, or the addition is refused with file and line.
"""

import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from random import Random
from typing import Any

import pytest

from m2t.generate import generate
from m2t.metamodels import FAULTS_FILE, MISSION_FILE
from m2t.models.load import load_mission_folder
from m2t.models.write import dumps
from mrsfi_runtime.errors import ModelError
from tests.support.cli import MISSION, ROOT
from tests.support.own_metamodels import (
    a_class,
    add_classes,
    add_feature,
    attribute,
    copy_metamodels,
    meaning,
    metamodels_of,
)
from tests.tiers import seeds

KINDS: dict[str, Callable[[int], object]] = {
    "EString": lambda n: f"own text {n:03}",
    "EInt": lambda n: 70_000 + n,
    "EDouble": lambda n: 7_000.75 + n,
    "EBoolean": lambda _: True,
}
"""For each type of attribute, its value at the n-th element; all but truth tell elements apart."""

FILES = (MISSION_FILE, FAULTS_FILE)
ADDITION, PARTS, PART, KIND = "ownAddition", "ownParts", "OwnPart", "OwnKind"
_NAMES = "|".join((ADDITION, PARTS, PART, KIND))
_MANY = ("", 'upperBound="-1"')


def an_attribute(path: Path, name: str, kind: str, rng: Random) -> None:
    add_feature(path, name, attribute(ADDITION, kind, rng.choice(_MANY)))


def a_part(path: Path, name: str, kind: str, rng: Random) -> None:
    parents = "#//Identified" if path.name == MISSION_FILE and rng.random() < 0.5 else ""
    add_classes(path, a_class(PART, parents, attribute(ADDITION, kind)))
    add_feature(
        path,
        name,
        f'<eStructuralFeatures xsi:type="ecore:EReference" name="{PARTS}" eType="#//{PART}" '
        f'containment="true" {rng.choice(_MANY)}/>',
    )


def a_subclass(path: Path, name: str, kind: str, rng: Random) -> None:
    added = attribute(ADDITION, kind, rng.choice(_MANY))
    add_classes(path, a_class(KIND, f"#//{name}", added))


@pytest.mark.parametrize("seed", seeds(range(24), 2, 8))
@pytest.mark.parametrize("add", [an_attribute, a_part, a_subclass])
@pytest.mark.parametrize("file", FILES)
def test_what_a_team_adds_and_uses_is_generated_or_refused_by_line(tmp_path, file, add, seed):
    rng = Random(seed)
    metamodels = copy_metamodels(tmp_path / "metamodels").parent
    classes = _classes_in_use(file, is_replaced=add is a_subclass)
    name, kind = rng.choice(classes), rng.choice([*KINDS])
    add(metamodels / file, name, kind, rng)

    refusal, values = "", ()
    with metamodels_of(metamodels):
        try:
            models, values = _using(tmp_path, name, KINDS[kind])
            generate(models, tmp_path / "generated")
        except ModelError as error:
            refusal = str(error)

    if refusal:
        assert re.search(rf"\.(?:ecore|xmi):\d+: [^\n]*(?:{_NAMES})", refusal), refusal
        return
    text = _generated(tmp_path / "generated")
    assert re.search("ownAddition|OWN_ADDITION", text), (name, kind)
    assert values
    assert [value for value in values if str(value) not in text] == [], (name, kind)


DETAILS = (
    {"mode": "RANDOM"},
    {"mode": "ZERO", "property": "SPEED"},
    {"property": "ENERGY"},
    {"range": "SPEED"},
    {"range": "TICKS", "search": "false"},
    {"search": "false"},
    {"role": "LOWEST"},
    {"colour": "red"},
    {},
)


@pytest.mark.parametrize("seed", seeds(range(60), 3, 12))
def test_an_annotation_that_a_team_adds_changes_what_is_generated_or_is_refused_by_line(
    tmp_path, seed
):
    rng = Random(seed)
    path = copy_metamodels(tmp_path / "metamodels").with_name(rng.choice(FILES))
    text = path.read_text(encoding="utf-8")
    places = [
        match.end() for match in re.finditer(r"<(?:eClassifiers|eStruct\w+) [^>]*[^/]>", text)
    ]
    place = rng.choice(places)
    annotation = meaning(**rng.choice(DETAILS))
    path.write_text(text[:place] + annotation + text[place:], encoding="utf-8")

    _require_difference_or_line(path, tmp_path / "generated")


@pytest.mark.parametrize("seed", seeds(range(60), 3, 12))
def test_an_annotation_that_a_team_changes_changes_what_is_generated_or_is_refused_by_line(
    tmp_path, seed
):
    rng = Random(seed)
    path = copy_metamodels(tmp_path / "metamodels")
    text = path.read_text(encoding="utf-8")
    said = [*re.finditer(r'key="(?:mode|property|range|search|role)" value="(\w+)"', text)]
    word = rng.choice(said)
    others = sorted({other[1] for other in said if other[0].split()[0] == word[0].split()[0]})
    other = rng.choice([each for each in (*others, "odd") if each != word[1]])
    path.write_text(text[: word.start(1)] + other + text[word.end(1) :], encoding="utf-8")

    _require_difference_or_line(path, tmp_path / "generated")


def _require_difference_or_line(path: Path, folder: Path) -> None:
    """Generate from changed metamodels; require other code, or an error that names their line."""
    refusal = ""
    with metamodels_of(path.parent):
        try:
            generate(ROOT / "models" / MISSION, folder)
        except ModelError as error:
            refusal = str(error)

    if refusal:
        assert re.search(rf"{path.name}:\d+: ", refusal), refusal
    else:
        assert _generated(folder) != _generated(ROOT / "generated" / MISSION)


def _classes_in_use(file: str, *, is_replaced: bool) -> list[str]:
    """Return the classes of a metamodel that the paper's mission has elements of.

    With ``is_replaced`` those of contained elements alone, which may be of a subclass.
    """
    loaded = load_mission_folder(ROOT / "models" / MISSION)
    package = (loaded.mission if file == MISSION_FILE else loaded.faults).eClass.ePackage
    kinds = {
        kind
        for element in _elements(loaded)
        for kind in (element.eClass, *(() if is_replaced else element.eClass.eAllSuperTypes()))
        if element.eContainer() is not None or not is_replaced
    }
    return sorted(kind.name for kind in kinds if kind.ePackage is package)


def _elements(loaded: Any) -> Iterator[Any]:
    for root in (loaded.mission, loaded.faults):
        yield root
        yield from root.eAllContents()


def _using(
    folder: Path, name: str, value_of: Callable[[int], object]
) -> tuple[Path, tuple[object, ...]]:
    """Return a copy of the models with the addition wherever there is room, and its values."""
    models = folder / "models" / MISSION
    shutil.copytree(ROOT / "models" / MISSION, models, ignore=shutil.ignore_patterns("*.mrsfi-*"))
    loaded = load_mission_folder(models)
    package = loaded.mission.eClass.ePackage, loaded.faults.eClass.ePackage
    kind = next((found for each in package if (found := each.getEClassifier(KIND))), None)
    values: list[object] = []
    for element in tuple(_elements(loaded)):
        holder = element
        if kind is not None and element.eClass.name == name and element.eContainer() is not None:
            element.__class__ = kind.python_class
        elif (feature := element.eClass.findEStructuralFeature(PARTS)) is not None:
            holder = feature.eType()
            _put(element, feature, holder)
            if (identity := holder.eClass.findEStructuralFeature("ID")) is not None:
                holder.eSet(identity, f"part{len(values)}")
        feature = holder.eClass.findEStructuralFeature(ADDITION)
        if feature is not None:
            values.append(value_of(len(values)))
            _put(holder, feature, values[-1])
    (models / "mission.xmi").write_bytes(dumps(loaded.mission))
    faults = dumps(loaded.faults, hrefs={loaded.mission: "mission.xmi"})
    (models / "faults.xmi").write_bytes(faults)
    return models, tuple(values)


def _put(element: Any, feature: Any, value: object) -> None:
    element.eSet(feature, [value] if feature.many else value)


def _generated(folder: Path) -> str:
    return "".join(path.read_text(encoding="utf-8") for path in sorted(folder.glob("*.py")))
