"""What an import reads keeps the rules of structure of every model, by the same names."""

import pytest

from m2t.models.importing import import_published
from m2t.models.load import load_mission_folder
from mrsfi_runtime.errors import ModelError
from tests.support.models.copies import edit

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
