"""The metamodels: documented, edited, commented, broken, and how they name one another."""

import random
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from m2t.classes import class_files
from m2t.metaclasses import CONTRACT, SUPERTYPES, conforms, features, lineage
from m2t.metamodels import FAULTS_FILE, MISSION_FILE, load_metamodels, read_metamodels
from m2t.models.check import RANGES
from mrsfi_runtime.errors import ModelError
from tests.support.fault_types import FAULT_TYPES
from tests.support.features import is_contained, reference_type
from tests.support.models.copies import edit, line_of
from tests.support.models.shapes import TASKS
from tests.support.own_metamodels import ECORE_TYPE, a_class, add_classes, copy_metamodels
from tests.support.tables import rows

PACKAGES = load_metamodels().packages
CLASSES = [
    kind
    for package in PACKAGES
    for kind in package.eClassifiers
    if hasattr(kind, "eStructuralFeatures")
]
AFFECTED = {"message": "Message", "robot": "Robot", "sensor": "Sensor", "obstacle": "Obstacle"}
NEEDED = [
    (package, class_name, name)
    for package, classes in CONTRACT.items()
    for class_name, needs in classes.items()
    for name in needs
]
READ_CLASSES = [(package, name) for package, classes in CONTRACT.items() for name in classes]
ECORE = "http://www.eclipse.org/emf/2002/Ecore#//"
MISSION, FAULTS = "http://mrsfi.org/mission/1.0#//", "http://mrsfi.org/faults/1.0#//"
KNOWN = [ECORE[:-3], "Ecore.ecore", "mission.ecore", MISSION[:-3], "faults.ecore", FAULTS[:-3]]


def _documentation(element: Any) -> str:
    texts = [
        annotation.details.get("documentation", "")
        for annotation in element.eAnnotations
        if annotation.source == "http://www.eclipse.org/emf/2002/GenModel"
    ]
    return texts[0] if texts else ""


def _class(name: str) -> Any:
    return next(kind for kind in CLASSES if kind.name == name)


@pytest.mark.parametrize("kind", CLASSES, ids=lambda kind: kind.name)
def test_class_and_features_are_documented_in_sentences(kind):
    for element in (kind, *kind.eStructuralFeatures):
        text = _documentation(element)
        assert text[:1].isupper(), element.name
        assert text.endswith("."), element.name
        assert len(text.split()) >= 4, element.name


def test_there_are_nine_tasks():
    tasks = [kind.name for kind in CLASSES if conforms(kind, _class("GoalTask"))]

    assert tasks == ["GoalTask", *TASKS]


def test_a_fault_contains_each_fault_type_by_its_name():
    contained = {
        reference_type(feature).name: feature.name
        for feature in _class("Fault").eStructuralFeatures
        if getattr(feature, "containment", False)
    }

    assert contained == {name: name[0].lower() + name[1:] for name in FAULT_TYPES}


@pytest.mark.parametrize("name", FAULT_TYPES)
def test_fault_type_agrees_with_the_runtime(name):
    kind, fault_type = _class(name), FAULT_TYPES[name]
    references = [feature for feature in features(kind) if hasattr(feature, "containment")]
    own = [feature.name for feature in kind.eStructuralFeatures]
    expected = []
    for parameter in fault_type.parameters:
        bounds = [f"{parameter.name}_MIN", f"{parameter.name}_MAX"] if parameter.evolves else []
        expected += [parameter.name, *bounds]

    assert own == expected
    assert [reference_type(feature).name for feature in references] == [
        AFFECTED[fault_type.struck.value]
    ]


def test_required_numbers_can_be_told_from_absent_ones():
    for kind in CLASSES:
        for feature in kind.eStructuralFeatures:
            is_number = feature.eType.name in ("EInt", "EDouble", "SensorType")
            if is_number and feature.lowerBound:
                assert feature.unsettable, f"{kind.name}.{feature.name}"


def test_no_class_inherits_twice():
    for kind in CLASSES:
        assert len(kind.eSuperTypes) <= 1, kind.name


def test_ranges_speak_of_features_that_exist():
    names = {feature.name for kind in CLASSES for feature in kind.eStructuralFeatures}

    assert set(RANGES) <= names


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return copy_metamodels(tmp_path / "team" / "metamodels").parent


def _classifier(package: str, name: str) -> Any:
    return getattr(load_metamodels(), package).getEClassifier(name)


def _owner(package: str, class_name: str, name: str) -> str:
    """Return the class that declares a feature which another inherits."""
    classes = lineage(_classifier(package, class_name))
    return next(
        str(kind.name)
        for kind in classes
        if name in {feature.name for feature in kind.eStructuralFeatures}
    )


def _owned(owner: str, package: str) -> Path:
    """Return the name of the file that declares a class."""
    is_here = _classifier(package, owner) is not None
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
        assert parent in {kind.name for kind in lineage(_classifier(package, name))[:-1]}


@pytest.mark.parametrize(("package", "name"), READ_CLASSES)
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


def rewrite(path, old, new):
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        (FAULTS_FILE, "mission.ecore#//", MISSION),
        (FAULTS_FILE, "mission.ecore#//", "platform:/resource/team/metamodels/mission.ecore#//"),
        (FAULTS_FILE, "mission.ecore#//", "platform:/resource/elsewhere/model/mission.ecore#//"),
        (FAULTS_FILE, "mission.ecore#//", "platform:/plugin/org.mrsfi/model/mission.ecore#//"),
        (FAULTS_FILE, '"#//', f'"{FAULTS}'),
        (FAULTS_FILE, 'eType="#//', f'eType="ecore:EClass {FAULTS}'),
        (FAULTS_FILE, '"#//', '"faults.ecore#//'),
        (MISSION_FILE, '"#//', f'"{MISSION}'),
        (MISSION_FILE, ECORE, "platform:/plugin/org.eclipse.emf.ecore/model/Ecore.ecore#//"),
        (MISSION_FILE, ECORE, "platform:/resource/org.eclipse.emf.ecore/model/Ecore.ecore#//"),
    ],
)
def test_addresses_that_eclipse_writes_mean_the_same_metamodels(file, old, new, folder):
    rewrite(folder / file, old, new)

    both = read_metamodels(folder)

    assert class_files(both.packages) == class_files(load_metamodels().packages)


@pytest.mark.parametrize(
    ("file", "old", "uri"),
    [
        (FAULTS_FILE, "mission.ecore#//Goal", "http://mrsfi.org/mission/2.0"),
        (FAULTS_FILE, "mission.ecore#//Goal", "platform:/plugin/org.mrsfi/model/missions.ecore"),
        (FAULTS_FILE, "mission.ecore#//Goal", "other/mission.ecore"),
        (MISSION_FILE, f"{ECORE}EDouble", "http://www.eclipse.org/emf/2003/XMLType"),
        (MISSION_FILE, f"{ECORE}EDouble", "platform:/plugin/org.eclipse.emf.ecore/model/XML.ecore"),
    ],
)
def test_an_address_of_no_metamodel_is_named_as_the_cause(file, old, uri, folder, refused):
    edit(folder / file, old, f"{uri}#//{old.rpartition('/')[2]}")

    with refused(ModelError):
        read_metamodels(folder)


def test_a_name_that_no_metamodel_has_is_told_from_an_address(folder, refused):
    edit(folder / FAULTS_FILE, "mission.ecore#//Goal", f"{MISSION}Aim")

    with refused(ModelError):
        read_metamodels(folder)


@pytest.mark.parametrize(
    ("old", "new", "finding"),
    [
        ('name="Robot"', 'name="Ro bot"', "has name 'Ro bot'; expected a letter, .* [NameSyntax]"),
        ("<eLiterals name", '<eLiterals literal="dark red" name',
         "has literal 'dark red'; expected a letter, .* [NameSyntax]"),
        ('nsPrefix="mission"', 'nsPrefix="m-1"', "has nsPrefix 'm-1'; .* [NameSyntax]"),
        ('nsURI="http://mrsfi.org/mission/1.0"', 'nsURI=""', "has nsURI ''; .* [RequiredFeature]"),
        ('iD="true"', 'iD="yes"', "has iD 'yes'; expected true or false.* [EnumLiteral]"),
        ('lowerBound="1"', 'lowerBound="one"', "has lowerBound 'one'; .* [NumberSyntax]"),
    ],
)  # fmt: skip
def test_what_is_misspelt_is_told_by_a_rule_of_its_kind(old, new, finding, folder):
    edit(folder / MISSION_FILE, old, new)

    with pytest.raises(ModelError) as caught:
        read_metamodels(folder)

    start, _, end = finding.partition(".*")
    assert start in str(caught.value)
    assert end in str(caught.value)


def test_metamodels_with_comments_load(folder):
    edit(folder / MISSION_FILE, "  <eClassifiers", "  <!-- robots --><?p i?>\n  <eClassifiers")

    both = read_metamodels(folder)

    assert class_files(both.packages) == class_files(load_metamodels().packages)


BROKEN = """
name="Mission" | name="Missions" | <ecore:EPackage
name="mission" | name="m" | <ecore:EPackage
name="SensorType" | name="Kind" | #//SensorType
Ecore#//EDouble | Ecore#//EFloat | #//EFloat
lowerBound="1" | lowerBound="x" | lowerBound="x"
lowerBound="2" | lowerBound="-1" | lowerBound="-1"
containment="true" | contained="true" | missionArea
defaultValueLiteral="1.0" | defaultValueLiteral="?" | "radius" eT
ecore:EReference | ecore:EFeature | EFeature
name="DEPTH" | name="GPS_POSITION" | value="2"
name="servers" | name="eContents" | "eContents"
"robots" low | "robots" ordered="false" low | "robots"
name="center" | name="center" volatile="true" | "center"
name="center" | name="center" derived="true" | "center"
name="center" | name="the center" | "the center"
xsi:type="ecore:EEnum" | xsi:type="ecore:EDataType" | EDataType"
"#//Sensor" | "ecore:EClass faults.ecore#//Fault" | name="sensors"
name="Robot" | name="Größe" | "Größe"
abstract="true" | abstract="yes" | abstract="yes"
upperBound="-1" | upperBound="-2" | name="robots"
name="deadline" | name="deadline" defaultValueLiteral="1.5" | "deadline"
<eStructuralFeatures | <eOperations name="f"/><eStructuralFeatures | eOperations
<eClassifiers | <eSubpackages name="p"/><eClassifiers | eSubpackages
"""


@pytest.mark.parametrize(("old", "new", "place"), rows(BROKEN))
def test_broken_metamodel_is_refused_at_its_line(folder, old, new, place, refused):
    path = folder / MISSION_FILE
    edit(path, old, new)

    with refused(ModelError) as caught:
        read_metamodels(folder)

    assert f"{path}:{line_of(path, place)}: " in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('name="Stay" eSuperTypes="#//GoalTask"', 'name="Stay" eSuperTypes="#//Stay"'),
        ('name="GoalTask"', 'name="GoalTask" eSuperTypes="#//GoalTask"'),
    ],
)
def test_class_that_inherits_from_itself_is_refused(folder, old, new, refused):
    edit(folder / MISSION_FILE, old, new)

    with refused(ModelError):
        read_metamodels(folder)


def test_missing_metamodel_is_refused(tmp_path, refused):
    with refused(ModelError):
        read_metamodels(tmp_path)
