"""The difference of two models reads like the model."""

import re
import shutil
from dataclasses import asdict
from pathlib import Path

import pytest

from m2t.models.difference import difference
from mrsfi_runtime.errors import ModelError
from tests.support.models.copies import FAULTS, MISSION, copy_models, edit
from tests.support.models.generation import ALL_TASKS, write_mission
from tests.support.tables import rows

ROBOT = """<robots ID="r4" name="Max" speed="1.0">
    <sensors ID="s7" name="s" type="DEPTH" samplesPerSecond="1"/>
  </robots>
  <servers ID="sv1\""""
GOAL = """<goals ID="g7" name="p" members="r1">
    <task xsi:type="mission:Patrol" period="9">
      <area ID="a16" radius="5.0"/>
    </task>
  </goals>
</mission:Mission>"""


@pytest.fixture
def old(tmp_path: Path) -> Path:
    return copy_models(tmp_path / "old")


@pytest.fixture
def new(tmp_path: Path) -> Path:
    return copy_models(tmp_path / "new")


def lines(old: Path, new: Path) -> list[str]:
    return [change.text for change in difference(old, new)]


CHANGES = [
    ("mission.xmi", "</mission:Mission>", GOAL, "goal g7 added (Patrol)"),
    ("mission.xmi", '<servers ID="sv1"', ROBOT, "robot r4 added ('Max')"),
    *rows("""
mission.xmi | name="JEN" speed="4.0" | name="JEN" speed="6" | robot r2: speed 4.0 → 6.0
mission.xmi | name="JEN" speed="4.0" | name="JEN" speed="4.0" maxSpeed="9"
    robot r2: maxSpeed none → 9.0
mission.xmi | duration="1000" | duration="900" | mission: duration 1000 → 900
mission.xmi | name="LEN" | name="L&#xE9;N" | robot r1: name 'LEN' → 'LéN'
mission.xmi | name="SufficientEnergy" members="r2 r3 r1" | name="SufficientEnergy" members="r2 r3"
    goal g3: members r2 r3 r1 → r2 r3
mission.xmi | <position x="250.0" y="-250.0" z="1.0"/> | <position x="251.0"/>
    robot r1: position (250.0, -250.0, 1.0) → (251.0, 0.0, 0.0)
mission.xmi | <center y="500.0" z="1.0"/> | -
    area a7: center (0.0, 500.0, 1.0) → (0.0, 0.0, 0.0)
mission.xmi | radius="2000.0" | radius="1500.0" | area a15: radius 2000.0 → 1500.0
mission.xmi | totalEnergy="80000.0" | totalEnergy="1.0" | battery b2: totalEnergy 80000.0 → 1.0
mission.xmi | energyPerDistanceUnit="5.0" | energyPerDistanceUnit="4.0"
    motion source ms1: energyPerDistanceUnit 5.0 → 4.0
mission.xmi | Number="250" | Number="300" | goal g4: task.targetSampleNumber 250 → 300
mission.xmi | sensor="s4" | sensor="s2" | goal g4: task.sensor s4 → s2
mission.xmi | mission:SufficientEnergy | mission:StayWithinMissionArea
    goal g3: task SufficientEnergy → StayWithinMissionArea
mission.xmi | <body name="SPEED" type="Int"/> | -
    message m7: body POSITION:Coordinates SPEED:Int ENERGY:Double → \
POSITION:Coordinates ENERGY:Double
mission.xmi | ID="m1" header="h" | ID="m1" | message m1: header 'h' → none
mission.xmi | name="Offshore server"/>
    name="Offshore server"><intProperties name="port" value="9"/></servers>
    server sv1: intProperties none → 'port'=9
mission.xmi | <robots ID="r1" | <robots colour="red" ID="r1" | robot r1: colour none → 'red'
faults.xmi | NEW_X="200.0" | NEW_X="250.0" | fault f9: NEW_X 200.0 → 250.0
faults.xmi | mission.xmi#m4 | mission.xmi#m5 | fault f2: affectedMessage m4 → m5
faults.xmi | DELAY="200.0" | DELAY="200.0" DELAY_MIN="9" | fault f8: DELAY_MIN none → 9.0
faults.xmi | ID="f1" name="f1" | ID="f1" name="f1" start="3" | fault f1: start none → 3
faults.xmi | ID="fs" | ID="pool" | fault specification pool: ID fs → pool
"""),
]


@pytest.mark.parametrize(
    ("file", "before", "after", "line"), CHANGES, ids=[change[3][:30] for change in CHANGES]
)
def test_one_change_is_one_line(file, before, after, line, old, new):
    edit(new / file, before, after)

    assert lines(old, new) == [line]


def test_an_added_element_is_removed_the_other_way_round(old, new):
    edit(new / MISSION, "</mission:Mission>", GOAL)
    edit(new / MISSION, '<servers ID="sv1"', ROBOT)

    assert lines(new, old) == ["robot r4 removed", "goal g7 removed"]


def test_what_is_added_inside_of_an_element_names_it(old, new, approved):
    edit(
        new / MISSION,
        '<sensors ID="s1"',
        '<sensors ID="s9" name="x" type="DEPTH" samplesPerSecond="1"/>\n<sensors ID="s1"',
    )

    approved(lines(old, new))
    approved(lines(new, old))


def test_an_element_that_moved_is_neither_added_nor_removed(old, new, approved):
    text = (old / MISSION).read_text()
    sensor = next(line for line in text.splitlines(keepends=True) if 'ID="s4"' in line)
    edit(new / MISSION, sensor, "")
    edit(new / MISSION, '    <sensors ID="s1"', f'{sensor}    <sensors ID="s1"')
    edit(new / MISSION, 'sensors ID="s4" name="Temperature sensor', 'sensors ID="s4" name="Sensor')

    approved(lines(old, new))


def test_an_element_that_moved_into_a_new_one_is_told(old, new, approved):
    text = (old / MISSION).read_text()
    sensor = next(line for line in text.splitlines(keepends=True) if 'ID="s4"' in line)
    edit(new / MISSION, sensor, "")
    edit(new / MISSION, '<servers ID="sv1"', ROBOT)
    edit(new / MISSION, '    <sensors ID="s7"', f'{sensor}    <sensors ID="s7"')

    approved(lines(old, new))


def test_another_order_is_told_in_one_line(old, new):
    obstacles = [
        line for line in (old / MISSION).read_text().split("\n  <obstacles ") if 'ID="o' in line[:5]
    ]
    swapped = f"{obstacles[1]}\n  <obstacles {obstacles[0]}"
    edit(new / MISSION, f"{obstacles[0]}\n  <obstacles {obstacles[1]}", swapped)

    assert lines(old, new) == [
        "obstacles reordered: o1 o2 o3 o4 o5 o6 o7 o8 → o2 o1 o3 o4 o5 o6 o7 o8"
    ]


def test_a_changed_fault_type_shows_the_type_and_what_went_with_it(old, new, approved):
    edit(new / FAULTS, '<fixedSpeed FIXED_VAL="50">', "<zeroSpeed>")
    edit(new / FAULTS, "</fixedSpeed>", "</zeroSpeed>")

    approved(lines(old, new))


def test_a_task_that_became_another_shows_its_area_and_points(tmp_path, approved):
    old = write_mission(tmp_path / "old", "all", ALL_TASKS)
    new = write_mission(tmp_path / "new", "all", ALL_TASKS)
    edit(new / MISSION, '<trajectory x="10.0"/>', '<trajectory x="11.0"/>\n<trajectory/>')
    edit(new / MISSION, '<area ID="a3" radius="20.0"/>', '<area ID="a3" radius="21.0"/>')

    approved(lines(old, new))


def test_spelling_is_no_difference(old, new):
    edit(new / MISSION, 'speed="5.0"', 'speed="5"')
    edit(new / MISSION, "<servers ", "<!-- ashore -->\n\n<servers ")
    edit(new / MISSION, 'ID="r1" name="LEN"', 'name="LEN" ID="r1"')
    edit(new / MISSION, 'ID="s4"', 'xmi:id="_4" ID="s4"')
    edit(new / MISSION, 'sensor="s4"', 'sensor="_4"')
    edit(new / MISSION, 'sensor="s6"', 'sensor="//@robots.2/@sensors.1"')
    edit(new / FAULTS, "mission.xmi#m2", "mission.xmi#//@goals.0/@messages.1")

    assert lines(old, new) == []


def test_a_mission_that_is_split_equals_the_whole(old, new):
    text = (old / MISSION).read_text()
    start, end = text.index('  <robots ID="r2"'), text.index('  <robots ID="r3"')
    robot = text[start:end].strip()
    edit(new / MISSION, text[start:end], '  <robots href="jen.xmi#r2"/>\n')
    head = (
        '<mission:Robot xmi:version="2.0" xmlns:xmi="http://www.omg.org/XMI" '
        'xmlns:mission="http://mrsfi.org/mission/1.0"'
    )
    part = robot.replace("<robots", head, 1).replace("</robots>", "</mission:Robot>")
    (new / "jen.xmi").write_text(part)

    assert lines(old, new) == []

    edit(new / "jen.xmi", 'speed="4.0"', 'speed="6.0"')

    assert lines(old, new) == ["robot r2: speed 4.0 → 6.0"]


def test_a_file_is_compared_with_its_like_in_a_folder(old, new, tmp_path):
    edit(new / MISSION, 'speed="5.0"', 'speed="6.0"')
    edit(new / FAULTS, 'VAL="2"', 'VAL="3"')
    kept = tmp_path / "kept.xmi"
    shutil.copy(old / FAULTS, kept)

    assert lines(kept, new) == ["fault f5: VAL 2 → 3"]
    assert lines(old / MISSION, new / MISSION) == ["robot r1: speed 5.0 → 6.0"]


def test_faults_that_came_or_went_are_one_line(old, new, approved):
    (old / FAULTS).unlink()

    approved(lines(old, new))
    approved(lines(new, old))


def test_invalid_models_are_compared_too(old, new, approved):
    edit(new / MISSION, 'speed="5.0"', 'speed="fast"')
    edit(new / MISSION, 'sensor="s4"', 'sensor="s99"')
    edit(new / MISSION, 'ID="o2"', 'ID="o1"')

    approved(lines(old, new))


def test_long_texts_are_compared_to_their_end(old, new):
    for folder, end in ((old, "a"), (new, "b")):
        edit(folder / MISSION, 'name="LEN"', f'name="{"L" * 100}{end}"')

    assert lines(old, new) == [f"robot r1: name '{'L' * 100}a' → '{'L' * 100}b'"]


def test_a_change_tells_a_script_what_happened(old, new):
    edit(new / MISSION, 'name="JEN" speed="4.0"', 'name="JEN" speed="6.0"')

    (change,) = difference(old, new)

    assert asdict(change) == {
        "what": "changed",
        "element": "robot r2",
        "feature": "speed",
        "old": "4.0",
        "new": "6.0",
        "text": "robot r2: speed 4.0 → 6.0",
    }


@pytest.mark.parametrize(
    "content",
    ["no XML", "<a/>", '<!DOCTYPE a><a xmlns="urn:x"/>'],
)
def test_what_is_no_model_is_refused(content, old, tmp_path, refused):
    path = tmp_path / "old.xmi"
    path.write_text(content)

    with refused(ModelError):
        difference(path, old)


def test_models_of_different_kinds_are_refused(old, refused):
    with refused(ModelError):
        difference(old / MISSION, old / FAULTS)


def test_an_empty_folder_is_refused(old, tmp_path, refused):
    (tmp_path / "empty").mkdir()

    with refused(ModelError):
        difference(old, tmp_path / "empty")


def _rename(folder: Path, *names: tuple[str, str]) -> None:
    """Rename elements in both files, wherever they stand."""
    for file in (MISSION, FAULTS):
        text = (folder / file).read_text()
        for before, after in names:
            text = re.sub(rf'(?<=["# ]){before}(?=[" ])', after, text)
        (folder / file).write_text(text)


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        ("r1 scout", ["robot r1 renamed scout"]),
        (
            "r1 a, r2 b, r3 c",
            ["robot r1 renamed a", "robot r2 renamed b", "robot r3 renamed c"],
        ),
        (
            "a7 reef, m7 state, s4 heat, g4 dive, f9 lure",
            [
                "sensor s4 renamed heat",
                "area a7 renamed reef",
                "message m7 renamed state",
                "goal g4 renamed dive",
                "fault f9 renamed lure",
                "fault lure: name 'f9' → 'lure'",
            ],
        ),
    ],
    ids=["one robot", "a team", "other elements"],
)
def test_a_rename_is_one_line_in_the_order_of_the_model_whoever_refers_to_it(
    names, expected, old, new
):
    _rename(new, *(name.split() for name in names.split(", ")))

    assert lines(old, new) == expected
    change = difference(old, new)[0]
    assert (change.what, change.feature) == ("renamed", "ID")
    assert expected[0].endswith(f" {change.old} renamed {change.new}")


def test_what_else_has_changed_is_told_beside_it(old, new, approved):
    _rename(new, ("r1", "scout"))
    edit(new / MISSION, 'name="SufficientEnergy" members="r2 r3 scout"', 'name="X" members="r2 r3"')

    approved(lines(old, new))


def test_what_is_renamed_and_changed_is_another_element(old, new, approved):
    _rename(new, ("r1", "scout"))
    edit(new / MISSION, 'name="LEN" speed="5.0"', 'name="LEN" speed="6.0"')

    found = lines(old, new)

    assert "robot r1 removed" in found
    approved(found)
