"""Files as they come: other encodings, xmi:id, several files, several roots; and EMF's limits."""

import re
from collections.abc import Mapping
from pathlib import Path

import pytest

from m2t.models.load import inspect_folder, load_mission_folder, saved
from m2t.models.write import dumps
from tests.interop.eclipse import Saved, require_same, resave
from tests.support.models.copies import FAULTS, MISSION, MODELS

MISSION_TEXT = (MODELS / MISSION).read_text(encoding="ascii")
FAULTS_TEXT = (MODELS / FAULTS).read_text(encoding="ascii")
XMI_HEAD = """<?xml version="1.0" encoding="ASCII"?>
<xmi:XMI xmi:version="2.0" xmlns:xmi="http://www.omg.org/XMI" \
xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" \
xmlns:faults="http://mrsfi.org/faults/1.0" xmlns:mission="http://mrsfi.org/mission/1.0">
"""


def _edited(old: str, new: str, encoding: str = "ASCII") -> str:
    """Return the paper's mission with one place changed, in another encoding."""
    assert old in MISSION_TEXT
    return MISSION_TEXT.replace(old, new, 1).replace('"ASCII"', f'"{encoding}"', 1)


def _named(name: str, encoding: str) -> bytes:
    return _edited('name="LEN"', f'name="{name}"', encoding).encode(encoding)


def _with_xmi_ids() -> bytes:
    text = _edited('<robots ID="r1"', '<robots xmi:id="_r1" ID="r1"')
    return text.replace('<position x="250.0"', '<position xmi:id="_p1" x="250.0"', 1).encode()


def _in_one_file() -> bytes:
    bodies = [
        re.sub(r' xm\w+:\w+="http[^"]*"| xmi:version="2.0"', "", text.partition("\n")[2])
        for text in (MISSION_TEXT, FAULTS_TEXT.replace("mission.xmi#", "#"))
    ]
    return f"{XMI_HEAD}{''.join(bodies)}</xmi:XMI>\n".encode()


def _in_default_namespace(prefix: str) -> str:
    """Return the paper's mission without a prefix at its elements, and with one before types."""
    text = re.sub(r"<(/?)mission:", r"<\1", MISSION_TEXT).replace("xmlns:mission=", "xmlns=")
    declared = ' xmlns:mission="http://mrsfi.org/mission/1.0"' if prefix else ""
    text = text.replace('xsi:type="mission:', f'xsi:type="{prefix}')
    return text.replace(" name=", f"{declared} name=", 1)


TYPE = 'xsi:type="mission:StayWithinMissionArea"'
FORMS: Mapping[str, Mapping[str, bytes]] = {
    "UTF-16": {MISSION: _named("Lé 中", "UTF-16")},
    "UTF-16BE": {MISSION: _named("Lé 中", "UTF-16BE")},
    "UTF-16LE": {MISSION: _named("Lé 中", "UTF-16LE")},
    "US-ASCII": {MISSION: _named("L&#xe9;", "US-ASCII")},
    "ISO-8859-15": {MISSION: _named("L€", "ISO-8859-15")},
    "lower case": {MISSION: _named("Lé 中", "utf-8")},
    "byte order mark": {MISSION: b"\xef\xbb\xbf" + _named("Lé 中", "UTF-8")},
    "no encoding": {MISSION: _named("Lé 中", "UTF-8").replace(b' encoding="UTF-8"', b"", 1)},
    "no declaration": {MISSION: _named("Lé 中", "UTF-8").partition(b"\n")[2]},
    "xmi:id": {MISSION: _with_xmi_ids(), FAULTS: FAULTS_TEXT.encode()},
    "one file": {MISSION: _in_one_file()},
    "default namespace": {MISSION: _in_default_namespace("").encode()},
    "default namespace, and its prefix": {MISSION: _in_default_namespace("mission:").encode()},
    "xmi:type": {MISSION: MISSION_TEXT.replace("xsi:type", "xmi:type").encode()},
    "xmi:type beside xsi:type": {
        MISSION: _edited(TYPE, f'{TYPE} xmi:type="mission:SufficientEnergy"').encode()
    },
    "elements with the prefix": {
        MISSION: re.sub(r"<(/?)robots", r"<\1mission:robots", MISSION_TEXT).encode()
    },
    "negative zero": {MISSION: _edited('y="500.0" z="1.0"', 'y="500.0" z="-0.0"').encode()},
    "detour": {
        MISSION: MISSION_TEXT.encode(),
        FAULTS: FAULTS_TEXT.replace("mission.xmi#", "../detour/mission.xmi#").encode(),
    },
}


def test_a_file_keeps_its_form_as_eclipse_keeps_it(tmp_path, note):
    for form, files in FORMS.items():
        folder = tmp_path / "models" / form
        folder.mkdir(parents=True)
        for name, content in files.items():
            (folder / name).write_bytes(content)

    emf = resave(sorted((tmp_path / "models").glob("*/*.xmi")), tmp_path / "out")

    ours = {
        path: content
        for folder in (tmp_path / "models").iterdir()
        for path, content in saved(load_mission_folder(folder)).items()
    }
    require_same("(b) files in other forms", emf, _of(emf, ours), note)


def _of(emf: list[Saved], ours: Mapping[Path, bytes]) -> list[bytes]:
    """Return our contents in the order of Eclipse's."""
    return [ours.get(file.path, b"") for file in emf]


def test_a_type_that_eclipse_does_not_find_is_refused_by_name(tmp_path):
    texts = {
        "none": MISSION_TEXT.replace(f" {TYPE}", "", 1),
        "abstract": _edited(TYPE, 'xsi:type="mission:GoalTask"'),
        "no prefix": _edited(TYPE, 'xsi:type="StayWithinMissionArea"'),
        "prefix without a namespace": re.sub(r"<(/?)mission:", r"<\1", MISSION_TEXT).replace(
            "xmlns:mission=", "xmlns="
        ),
    }
    for name, text in texts.items():
        (tmp_path / name).mkdir()
        (tmp_path / name / MISSION).write_text(text, encoding="ascii")

    emf = resave([tmp_path / name / MISSION for name in texts], tmp_path / "out")

    for file in emf:
        assert any(problem.startswith("load: ") for problem in file.problems), file.path
        found = inspect_folder(file.path.parent).diagnostics
        assert {each.constraint for each in found} == {"ConcreteType"}, file.path
    (first, *_) = inspect_folder(tmp_path / "prefix without a namespace").diagnostics
    assert "has xsi:type 'mission:AvoidCollision'; expected one of AvoidCollision," in first.message


def test_a_split_mission_keeps_its_files_as_eclipse_keeps_them(tmp_path, note):
    """Eclipse follows a containment to another file only where the metamodel lets it."""
    folder = tmp_path / "split"
    (folder / "parts").mkdir(parents=True)
    models = load_mission_folder(MODELS)
    robot, goal = models.mission.robots[0], models.mission.goals[2]
    mission = {models.mission: "mission.xmi"}
    parts = {robot: "parts/r%201.xmi", goal: "goal.xmi"}
    robot_bytes = dumps(robot, hrefs={models.mission: "../mission.xmi", goal: "../goal.xmi"})
    (folder / "mission.xmi").write_bytes(dumps(models.mission, hrefs=parts))
    (folder / "parts" / "r 1.xmi").write_bytes(robot_bytes)
    (folder / "goal.xmi").write_bytes(dumps(goal, "UTF-8", hrefs={**mission, robot: parts[robot]}))
    (folder / "faults.xmi").write_bytes(dumps(models.faults, hrefs={**mission, **parts}))

    emf = resave(sorted(folder.rglob("*.xmi")), tmp_path / "out")

    ours = saved(load_mission_folder(folder))
    require_same("(b) split mission", emf, _of(emf, ours), note)


def test_addresses_of_a_workspace_are_read_and_written_as_eclipse_does(tmp_path, note):
    project, folder = tmp_path / "checkout", tmp_path / "checkout" / "models" / "uuv"
    (project / "shared").mkdir(parents=True)
    folder.mkdir(parents=True)
    (project / ".project").write_text(
        "<projectDescription><name>Survey</name></projectDescription>", encoding="ascii"
    )
    models = load_mission_folder(MODELS)
    robot, goal = models.mission.robots[0], models.mission.goals[2]
    places = {
        models.mission: "models/uuv/mission.xmi",
        robot: "shared/robot%201.xmi",
        goal: "shared/goal.xmi",
        models.faults: "models/uuv/faults.xmi",
    }
    hrefs = {root: f"platform:/resource/Survey/{place}" for root, place in places.items()}
    for root, place in places.items():
        others = {other: href for other, href in hrefs.items() if other is not root}
        (project / place.replace("%20", " ")).write_bytes(dumps(root, hrefs=others))

    emf = resave(sorted(project.rglob("*.xmi")), tmp_path / "out", projects={"Survey": project})

    ours = saved(load_mission_folder(folder))
    referring = [file.path.name for file in emf if b"platform:/resource/Survey" in file.original]
    assert referring == ["faults.xmi", "mission.xmi", "goal.xmi"]
    assert b"platform:" not in b"".join(ours.values())
    assert b'href="../../shared/robot%201.xmi#r1"' in ours[folder / "mission.xmi"]
    require_same(
        "(b) addresses of a workspace", emf, [ours.get(file.path, b"") for file in emf], note
    )


def test_java_before_19_writes_some_doubles_longer_than_needed(tmp_path):
    """Java 19 mended ``Double.toString``, so that such values differ by Eclipse's own Java."""
    path = tmp_path / MISSION
    path.write_text(_edited('speed="5.0"', 'speed="5.684341886080802E-14"'), encoding="ascii")

    (file,) = resave([path], tmp_path / "out")

    (spelling,) = set(re.findall(rb'speed="([^"]*E[^"]*)"', file.content))
    assert spelling in (b"5.6843418860808015E-14", b"5.684341886080802E-14")
    assert float(spelling) == 2.0**-44
    assert saved(load_mission_folder(tmp_path))[path] == path.read_bytes()


def test_emf_loses_characters_that_an_encoding_lacks_unless_it_is_ascii_or_latin_1(tmp_path):
    path = tmp_path / MISSION
    path.write_bytes(_named("L€ &#x4e2d;", "WINDOWS-1252"))

    (file,) = resave([path], tmp_path / "out")

    assert b'name="L\x80 ?"' in file.content
    assert b'name="L\x80 &#x4e2d;"' in saved(load_mission_folder(tmp_path))[path]


def test_emf_cannot_read_its_own_list_of_references_to_an_id_with_a_space(tmp_path):
    text = MISSION_TEXT.replace("</robots>", "</robots>\n  <robots ID='r 9' name='' speed='1'/>", 1)
    path = tmp_path / MISSION
    path.write_text(text.replace('members="', 'members="//@robots.1 ', 1), encoding="ascii")

    (first,) = resave([path], tmp_path / "out")
    again = tmp_path / "again.xmi"
    again.write_bytes(first.content)
    (second,) = resave([again], tmp_path / "out")

    assert b'members="r 9 ' in first.content
    assert any("Unresolved reference 'r'" in problem for problem in second.problems)
    assert b'members="//@robots.1 ' in saved(load_mission_folder(tmp_path))[path]


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (_edited("</missionArea>", '</missionArea>\n  <missionArea ID="a99" radius="9"/>'), ""),
        (MISSION_TEXT.replace("xsi:", "x:").replace(":xsi=", ":x="), "Class 'GoalTask'"),
    ],
    ids=["two elements in a place for one are one too many for us only", "prefix other than xsi"],
)
def test_emf_and_we_read_differently(content, complaint, tmp_path):
    path = tmp_path / MISSION
    path.write_text(content, encoding="ascii")

    (file,) = resave([path], tmp_path / "out")

    is_sound = not any(found.severity == "error" for found in inspect_folder(tmp_path).diagnostics)
    assert is_sound is bool(complaint)
    assert any(complaint in problem for problem in file.problems) is bool(complaint)
