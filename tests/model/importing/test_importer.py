"""Models published for the paper's prototype become mission folders, or are refused."""

import random
from pathlib import Path

import pytest

from m2t.models.difference import difference
from m2t.models.importing import Imported, import_published
from m2t.models.load import LoadedModels, load_mission_folder, load_specification
from mrsfi_runtime.errors import ModelError, UsageError
from tests.support.models.copies import MODELS, edit
from tests.support.models.generation import ALL_TASKS, write_mission
from tests.support.models.published import published, xmi_id
from tests.support.mutilation import MUTILATIONS

POND = """<?xml version="1.0" encoding="UTF-8"?>
<Setup xmi:version="2.0" xmlns:xmi="http://www.omg.org/XMI"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xmlns="acs_project_setup">
  <mission name="Pond" duration="100.0">
    <robots xmi:id="_a" ID="ra" name="Alder" speed="2"><position x="0"/></robots>
    <robots xmi:id="_b" ID="rb" name="Birch" speed="2"><position x="40"/></robots>
    <servers xmi:id="_s" ID="sv" name="shore"/>
    <obstacles xmi:id="_o" ID="oa"><area ID="oaa" radius="2"><center x="9"/></area></obstacles>
    <goals xmi:id="_g" ID="g1" name="Stay"><members goalMembers="_a _b"/>
      <area><goalArea xmi:id="_ga" ID="ga" radius="90"><center x="5"/></goalArea></area>
      <task><stayWithinMissionArea/></task></goals>
    <missionArea ID="ma" radius="100"><center xmi:id="_c" x="0"/></missionArea>
  </mission>
  <specification ID="fs">
    <faults name="f1"><stopRobot affectedRobot="_b"/></faults>
    <faults name="f2"><fixedObstacleCoordinates affectedObstacle="_o" NEW_X="2" NEW_Y="1"/></faults>
  </specification>
</Setup>
"""
STRUCK = 'affectedRobot="_b"'
TASK = "<stayWithinMissionArea/>"
NAMED = 'name="Alder" speed="2">'
PATH = "//@mission/@robots.1"
ERRORS = [
    ('sensor="{s4}"', 'sensor="{s2}"', "SensorOfMember"),
    ('sensor="{s4}"', "", "RequiredFeature"),
    ("<stopRobot ", "<stopEverything ", "ExactlyOneFaultType"),
    ("<stopRobot ", '<startRobot affectedRobot="{r1}"/><stopRobot ', "ExactlyOneFaultType"),
    ('duration="1000.0"', 'duration="1000.5"', "NumberSyntax"),
    ('speed="5.0"', 'speed="-5.0"', "SpeedNotNegative"),
    ('samplesPerSecond="5"', "", "SamplesPerSecondPositive"),
    ('type="PRESSURE"', 'type="TASTE"', "EnumLiteral"),
    ('radius="4.0"', "", "AreaShape"),
    ("<mission ", "<mission><robots/></mission><mission ", "SingleValue"),
    ("acs_project_setup", "acs_project_other", "RootElement"),
    ("<setup:Setup", "<!DOCTYPE x [<!ENTITY e 'e'>]><setup:Setup", "NoDocumentType"),
    ("</setup:Setup>", "", "WellFormedXml"),
]


@pytest.fixture(scope="module")
def paper() -> LoadedModels:
    return load_mission_folder(MODELS)


@pytest.fixture(scope="module")
def text(paper: LoadedModels) -> str:
    return published(paper)


@pytest.fixture
def file(text: str, tmp_path: Path) -> Path:
    path = tmp_path / "published.xmi"
    path.write_text(text, encoding="ascii")
    return path


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "models" / "imported"


def lines_of(file: Path, fragment: str) -> set[int]:
    lines = file.read_text(encoding="ascii").splitlines()
    return {number for number, line in enumerate(lines, 1) if fragment in line}


def notes(imported: Imported, kind: str) -> list[tuple[str, str]]:
    return [(note.element, note.feature) for note in imported.notes if note.kind == kind]


def test_the_files_of_the_paper_equal_the_committed_ones(file, folder):
    imported = import_published(file, folder)

    for name in ("mission.xmi", "faults.xmi"):
        assert (folder / name).read_bytes() == (MODELS / name).read_bytes()
    assert imported.files == ("mission.xmi", "faults.xmi", "case_a.toml", "case_b.toml")
    assert dict(imported.counts) == {
        "robots": 3,
        "servers": 1,
        "obstacles": 8,
        "goals": 6,
        "messages": 12,
        "faults": 30,
    }


def test_a_consistent_file_has_nothing_inconsistent_and_loses_back_references_only(file, folder):
    imported = import_published(file, folder)

    assert notes(imported, "inconsistent") == []
    assert {feature for _, feature in notes(imported, "dropped")} == {"parentID", "goal_ID"}
    assert {feature for _, feature in notes(imported, "default")} == {"type", "x", "y", "z"}
    assert notes(imported, "renamed") == [(f"faults 'f{n}'", "ID") for n in range(1, 31)]


def test_all_tasks_and_properties_import_and_what_the_format_lacks_gets_its_default(
    tmp_path, folder, approved
):
    original = write_mission(tmp_path, "all_tasks", ALL_TASKS)
    file = tmp_path / "published.xmi"
    file.write_text(published(load_mission_folder(original)), encoding="ascii")

    imported = import_published(file, folder)

    approved([change.text for change in difference(original, folder)])
    assert {"period", "deadline", "tolerance"} <= {
        feature for _, feature in notes(imported, "default")
    }
    assert imported.files[:3] == ("mission.xmi", "faults.xmi", "case_a.toml")


@pytest.mark.parametrize(
    ("old", "new", "element", "feature"),
    [
        ('ID="s2" parentID="r1"', 'ID="s2" parentID="r3"', "sensors 's2'", "parentID"),
        ('ID="m4" goal_ID="g2"', 'ID="m4" goal_ID="g5"', "messages 'm4'", "goal_ID"),
        ("<zeroSpeed ", '<zeroSpeed VAL="5" ', "zeroSpeed of faults 'f30'", "VAL"),
        (
            "<zeroRemainingEnergyCapacityReport ",
            '<zeroRemainingEnergyCapacityReport CAPACITY="1.0" ',
            "zeroRemainingEnergyCapacityReport of faults 'f27'",
            "CAPACITY",
        ),
        ('ID="o2"', 'ID="o1"', "obstacles 'o1'", "ID"),
        (
            'ID="m10" goal_ID="g4" header="h" from="{r2}"',
            'ID="m10" goal_ID="g4" header="h" from="{r3}"',
            "messages 'm10'",
            "SenderIsMember",
        ),
    ],
)
def test_what_contradicts_the_rest_is_listed_with_its_line(
    old, new, element, feature, file, folder, paper
):
    ids = {robot.ID: xmi_id(robot) for robot in paper.mission.robots}
    edit(file, old.format(**ids), new.format(**ids))
    lines = lines_of(file, new.format(**ids))

    imported = import_published(file, folder)

    found = [note for note in imported.notes if note.kind == "inconsistent"]
    assert (element, feature) in [(note.element, note.feature) for note in found]
    assert all({note.line, note.line + 1} & lines for note in found if note.feature == feature)
    assert load_mission_folder(folder).faults is not None


@pytest.mark.parametrize("zero", ["0", "0.0", "-0"])
def test_a_zero_of_a_zero_type_is_dropped_without_more(zero, file, folder):
    edit(file, "<zeroSpeed ", f'<zeroSpeed VAL="{zero}" ')

    imported = import_published(file, folder)

    assert ("zeroSpeed of faults 'f30'", "VAL") in notes(imported, "dropped")
    assert notes(imported, "inconsistent") == []


@pytest.mark.parametrize(
    ("old", "new", "place"),
    [
        ('ID="a1" ', "", "g1_area"),
        ('ID="a15" ', "", "mission_area"),
        ('ID="b2" ', "", "r1_battery_2"),
        ('ID="ms1" ', "", "r1_motion_source_1"),
        ('ID="o1"', "", "obstacle_1"),
        ('ID="s2" ', 'ID="2" ', "sensor_2"),
        ('ID="s2" ', 'ID="sonar (aft)" ', "sonar_aft"),
        ('ID="s2" ', 'ID="&#xe9;" ', "r1_sensor_2"),
        ('ID="s2" ', 'ID="class" ', "class_2"),
        ('ID="s2" ', 'ID="R1" ', "R1_2"),
        ('ID="s2" ', 'ID="r1" ', "r1_2"),
        ('ID="s2" ', 'ID="topics" ', "topics_2"),
        ('ID="fs"', "", "fault_specification"),
        ('name="f3"', 'name="Sonar is dead"', "Sonar_is_dead"),
        ('name="f3"', 'name="f2"', "f2_2"),
        ('name="f3"', "", "fault_3"),
    ],
)
def test_missing_unusable_and_taken_ids_are_replaced(old, new, place, file, folder):
    edit(file, old, new)

    imported = import_published(file, folder)

    models = load_mission_folder(folder)
    known = {
        element.ID
        for root in (models.mission, models.faults)
        for element in [root, *root.eAllContents()]
        if element.eClass.findEStructuralFeature("ID") is not None
    }
    assert place in known
    assert any(place in note.message for note in imported.notes if note.kind == "renamed")


def test_a_missing_name_is_the_id(file, folder):
    edit(file, ' name="KAL"', "")

    imported = import_published(file, folder)

    assert load_mission_folder(folder).mission.robots[2].name == "r3"
    assert ("robots 'r3'", "name") in notes(imported, "default")


@pytest.mark.parametrize(
    ("old", "new", "element", "feature"),
    [
        ("<robots ", '<robots colour="red" ', "robots 'r1'", "colour"),
        ("</robots>", "<wheels/></robots>", "wheels of robots 'r1'", "wheels"),
        ("<robots ", '<robots xmlns:q="urn:q" q:x="1" ', "robots 'r1'", "x"),
        ("</robots>", '<q:x xmlns:q="urn:q"/></robots>', "x of robots 'r1'", "x"),
        ("</robots>", "good boat</robots>", "robots 'r1'", "text"),
        ("<mission ", "<author/><mission ", "author of Setup", "author"),
    ],
)
def test_what_is_not_known_is_dropped_and_listed(old, new, element, feature, file, folder):
    edit(file, old, new)

    imported = import_published(file, folder)

    assert (element, feature) in notes(imported, "dropped")
    assert (folder / "mission.xmi").read_bytes() == (MODELS / "mission.xmi").read_bytes()


@pytest.mark.parametrize(
    "root",
    ['p:Setup xmlns:p="acs_project_setup"', 'Setup xmlns="acs_project_setup"'],
    ids=["prefix", "no prefix"],
)
def test_any_prefix_will_do(root, text, file, folder):
    end = root.split(maxsplit=1)[0]
    changed = text.replace("setup:Setup ", f"{root} ")
    file.write_text(changed.replace("</setup:Setup>", f"</{end}>"), encoding="ascii")

    import_published(file, folder)

    assert difference(MODELS, folder) == ()


def test_every_further_specification_gets_a_file(file, folder):
    edit(
        file,
        "</setup:Setup>",
        '<specification xmi:id="_2" ID="more"><faults xmi:id="_f" name="f1"><stopRobot '
        'affectedRobot="r2"/></faults></specification></setup:Setup>',
    )

    imported = import_published(file, folder)

    assert "faults_more.xmi" in imported.files
    more = load_specification(folder / "faults_more.xmi")
    assert more.faults.faults[0].stopRobot.affectedRobot.ID == "r2"


def test_a_file_without_specification_gets_an_empty_pool_and_says_so(file, folder, approved):
    text = file.read_text(encoding="ascii")
    begin, end = text.index("<specification"), text.index("</setup:Setup>")
    file.write_text(text[:begin] + text[end:], encoding="ascii")

    imported = import_published(file, folder)

    assert imported.files == ("mission.xmi", "faults.xmi", "case_a.toml", "case_b.toml")
    approved([note.message for note in imported.notes if note.feature == "specification"])
    pool = load_mission_folder(folder).faults
    assert (pool.ID, list(pool.faults)) == ("faults", [])


def test_without_collision_or_energy_goal_there_is_no_case_b(file, folder):
    edit(file, "<sufficientEnergy ", "<stayWithinMissionArea ")
    edit(file, "</sufficientEnergy>", "</stayWithinMissionArea>")

    imported = import_published(file, folder)

    assert imported.files == ("mission.xmi", "faults.xmi", "case_a.toml")


@pytest.fixture
def pond(tmp_path):
    path = tmp_path / "pond.model"
    path.write_text(POND, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("old", "new", "constraint"),
    [
        (NAMED, 'speed="2"><name>Alder</name><name>Ash</name>', "SingleValue"),
        (NAMED, 'name="Alder" speed="2"><name>Ash</name>', "SingleValue"),
        (NAMED, 'name="A" speed="2"><ID>rc</ID>', "SingleValue"),
        ('<position x="0"/>', "<position/><position/>", "SingleValue"),
        ("<goalArea ", '<goalArea radius="1"/><goalArea ', "SingleValue"),
        ("<area><goalArea ", '<area goalArea="_ga"/><area><goalArea ', "SingleValue"),
        (TASK, f"{TASK}<sufficientEnergy/>", "SingleValue"),
        ('<faults name="f1">', '<faults name="f1" likelihood="0" probability="1">', "SingleValue"),
        (STRUCK, 'affectedRobot="_a _b"', "SingleValue"),
        (f"<stopRobot {STRUCK}/>", f'<stopRobot {STRUCK}><affectedRobot href="#_a"/></stopRobot>',
         "SingleValue"),
        ('goalMembers="_a _b"', 'goalMembers="_a _b _a"', "UniqueReference"),
        (STRUCK, f'affectedRobot="fleet.model#{PATH}"', "LocalReference"),
        (STRUCK, 'affectedRobot="fleet.model#_b"', "LocalReference"),
        (STRUCK, 'affectedRobot="fleet.model#rb"', "LocalReference"),
        (STRUCK, f'affectedRobot="../pond.model#{PATH}"', "LocalReference"),
        (STRUCK, f'affectedRobot="platform:/resource/fleet/pond.model#{PATH}"', "LocalReference"),
        (STRUCK, f'affectedRobot="http://fleet.org/pond.model#{PATH}"', "LocalReference"),
        (f"{STRUCK}/>", '><affectedRobot href="fleet.model#_b"/></stopRobot>', "LocalReference"),
        ('goalMembers="_a _b"', 'goalMembers="_a fleet.model#_b"', "LocalReference"),
        (TASK, '<stay area="fleet.model#_ga"/>', "LocalReference"),
        (TASK, '<stay><area href="fleet.model#c"/></stay>', "LocalReference"),
        ('<robots xmi:id="_a"', '<robots href="fleet.model#_d"/><robots xmi:id="_a"',
         "LocalReference"),
        ('<robots xmi:id="_a"', '<robots href="#_b"/><robots xmi:id="_a"', "ContainedElement"),
        (f"<task>{TASK}</task>", '<task href="fleet.model#_t"/>', "LocalReference"),
        (STRUCK, 'affectedRobot="_nobody"', "ResolvedReference"),
        (STRUCK, 'affectedRobot="//@mission/@robots.7"', "ResolvedReference"),
        (STRUCK, 'affectedRobot="_s"', "ReferenceType"),
        (TASK, '<stay area="_s"/>', "ReferenceType"),
        ('<position x="0"/>', '<position xsi:type="Server" x="0"/>', "ConcreteType"),
        (f"<task>{TASK}</task>", "<task/>", "ConcreteType"),
        (f"<task>{TASK}</task>", '<task xsi:type="Dance"/>', "ConcreteType"),
        ('xmi:id="_a"', 'xmi:id="_b"', "UniqueId"),
        ('<faults name="f1">', '<faults xmi:id="_b" name="f1">', "UniqueId"),
        ('x="40"', 'x="NaN"', "FiniteNumber"),
        ('x="40"', 'x="1.0E13"', "NumberMagnitude"),
        ('x="40"', 'x="forty"', "NumberSyntax"),
        ('duration="100.0"', 'duration="1.5E-3"', "NumberSyntax"),
        ('duration="100.0"', 'duration="1.0E8"', "DurationInRange"),
        ('duration="100.0"', 'duration="1.0E400"', "NumberSyntax"),
        ('<robots xmi:id="_a"', '<robots sensors="_a" xmi:id="_a"', "ContainedElement"),
    ],
)  # fmt: skip
def test_what_validate_refuses_is_refused_by_the_same_rule(old, new, constraint, pond, tmp_path):
    edit(pond, old, new)

    with pytest.raises(ModelError) as caught:
        import_published(pond, tmp_path / "imported")

    lines = str(caught.value).splitlines()
    assert any(line.endswith(f"[{constraint}]") for line in lines), lines
    assert not (tmp_path / "imported").exists()


@pytest.mark.parametrize(
    "reference",
    [
        'affectedRobot="rb"/>',
        f'affectedRobot="{PATH}"/>',
        'affectedRobot="pond.model#_b"/>',
        f'affectedRobot="./pond.model#{PATH}"/>',
        'affectedRobot="platform:/resource/pool/pond.model#rb"/>',
        f'><affectedRobot href="pond.model#{PATH}"/></stopRobot>',
        '><affectedRobot xsi:type="Robot" href="#_b"/></stopRobot>',
        "><affectedRobot>_b</affectedRobot></stopRobot>",
    ],
)
def test_what_a_file_calls_its_own_is_found_in_it(reference, pond, tmp_path):
    (tmp_path / "pool").mkdir()
    file = pond.rename(tmp_path / "pool" / "pond.model")
    edit(file, f"{STRUCK}/>", reference)

    import_published(file, tmp_path / "imported")

    fault = load_mission_folder(tmp_path / "imported").faults.faults[0]
    assert fault.stopRobot.affectedRobot.ID == "rb"


@pytest.mark.parametrize(
    ("old", "new", "attribute", "value"),
    [
        ('duration="100.0"', 'duration="1.0E7"', "mission.duration", 10_000_000),
        ('duration="100.0"', 'duration="+.5e2"', "mission.duration", 50),
        ('duration="100.0"', 'duration="12.0"', "mission.duration", 12),
        ('name="Birch" speed="2"', 'name="Birch" speed="2.5E-1"', "mission.robots[1].speed", 0.25),
        ('name="f1"', 'name="f1" start="1.0E1" finish="2E1"', "faults.faults[0].finish", 20),
        ('NEW_X="2"', 'NEW_X="1.0E3"', "faults.faults[1].fixedObstacleCoordinates.NEW_X", 1000.0),
        ('name="f1"', 'name="f1" probability="0.25"', "faults.faults[0].likelihood", 0.25),
        (
            'name="Alder" speed="2">',
            'speed="2"><name> Ash </name>',
            "mission.robots[0].name",
            "Ash",
        ),
    ],
)
def test_what_java_writes_otherwise_keeps_its_value(old, new, attribute, value, pond, tmp_path):
    edit(pond, old, new)

    import_published(pond, tmp_path / "imported")

    found = load_mission_folder(tmp_path / "imported")
    for name in attribute.replace("[", ".").replace("]", "").split("."):
        found = found[int(name)] if name.isdigit() else getattr(found, name)
    assert found == value


def test_a_copied_area_takes_the_center_that_it_refers_to_itself(pond, tmp_path):
    edit(pond, '<goalArea xmi:id="_ga" ID="ga" radius="90"><center x="5"/></goalArea>',
         '<goalArea xmi:id="_ga" ID="ga" radius="90" center="_c"/>')  # fmt: skip
    edit(pond, TASK, '<stay area="_ga"/>')
    edit(pond, 'xmi:id="_c" x="0"', 'xmi:id="_c" x="7"')

    import_published(pond, tmp_path / "imported")

    (goal,) = load_mission_folder(tmp_path / "imported").mission.goals
    assert goal.task.area.ID == "g1_task_area"
    assert (goal.task.area.center.x, goal.area.center.x, goal.task.area.radius) == (7.0, 7.0, 90.0)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('affectedObstacle="_o"', 'affectedMessage="_o"'),
        (' affectedObstacle="_o" NEW_X="2" NEW_Y="1"/>',
         ' NEW_X="2" NEW_Y="1"><affectedMessage href="#_o"/></fixedObstacleCoordinates>'),
    ],
    ids=["attribute", "element"],
)  # fmt: skip
def test_a_file_of_an_older_metamodel_is_called_that(old, new, pond, tmp_path, refused):
    edit(pond, old, new)

    with refused(ModelError):
        import_published(pond, tmp_path / "imported")


@pytest.mark.parametrize(("old", "new", "constraint"), ERRORS)
def test_what_cannot_be_a_model_is_refused_and_nothing_written(
    old, new, constraint, file, folder, paper
):
    elements = [*paper.mission.robots, *(s for r in paper.mission.robots for s in r.sensors)]
    ids = {element.ID: xmi_id(element) for element in elements}
    place = old.format(**ids)
    edit(file, place, new.format(**ids))

    with pytest.raises(ModelError) as caught:
        import_published(file, folder)

    lines = str(caught.value).splitlines()
    assert any(f"[{constraint}]" in line for line in lines)
    assert all(line.startswith(f"{file}:") for line in lines)
    assert list(file.parent.iterdir()) == [file]


def test_an_error_of_the_result_names_the_line_of_the_published_file(file, folder, refused):
    edit(file, 'ID="o5"', 'ID="o5" colour="grey"')
    edit(file, 'radius="30.0"', 'radius="-30.0"')

    with refused(ModelError):
        import_published(file, folder)


def test_an_existing_folder_is_refused(file, folder, refused):
    import_published(file, folder)
    edit(folder / "mission.xmi", 'speed="5.0"', 'speed="6.0"')
    before = (folder / "mission.xmi").read_bytes()

    with refused(UsageError):
        import_published(file, folder)

    assert (folder / "mission.xmi").read_bytes() == before


def test_force_replaces_the_models_and_keeps_all_else(file, folder):
    import_published(file, folder)
    edit(folder / "mission.xmi", 'speed="5.0"', 'speed="6.0"')
    edit(folder / "case_a.toml", "seed = 1", "seed = 7")
    (folder / "notes.md").write_text("mine")

    imported = import_published(file, folder, is_forced=True)

    assert difference(MODELS, folder) == ()
    assert "seed = 7" in (folder / "case_a.toml").read_text()
    assert (folder / "notes.md").read_text() == "mine"
    assert imported.files == ("mission.xmi", "faults.xmi")
    assert [path.name for path in folder.parent.iterdir()] == [folder.name]


def test_force_with_a_broken_file_leaves_the_folder_as_it_was(file, folder):
    import_published(file, folder)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    edit(file, 'speed="5.0"', 'speed="-5.0"')

    with pytest.raises(ModelError):
        import_published(file, folder, is_forced=True)

    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    assert [path.name for path in folder.parent.iterdir()] == [folder.name]


def test_force_never_touches_a_folder_that_is_no_mission(file, tmp_path, refused):
    place = tmp_path / "home"
    place.mkdir()
    (place / "letter.txt").write_text("dear")

    with refused(UsageError):
        import_published(file, place, is_forced=True)

    assert [path.name for path in place.iterdir()] == ["letter.txt"]


DAMAGES = ("drop_span", "double_line", "drop_line", "exchange_values", "rename_element")


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_file_imports_as_a_valid_mission_or_is_refused(damage, text, file, folder):
    draw = random.Random(7)
    for number in range(12):
        file.write_bytes(MUTILATIONS[damage](text.encode("ascii"), draw))
        place = folder.with_name(f"imported_{number}")
        refusal = _refusal(file, place)
        if refusal is None:
            load_mission_folder(place)
        else:
            assert refusal.startswith(f"{file}:")
            assert not place.exists()


def _refusal(file: Path, folder: Path) -> str | None:
    try:
        import_published(file, folder)
    except ModelError as refused:
        return str(refused)
    return None
