"""Models published for the paper's prototype become mission folders, with every figure."""

from pathlib import Path

import pytest

from m2t.models.difference import difference
from m2t.models.importing import Imported, import_published
from m2t.models.load import load_mission_folder, load_specification
from tests.support.models.copies import MODELS, edit
from tests.support.models.generation import ALL_TASKS, write_mission
from tests.support.models.published import published, xmi_id


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

    approved([str(change) for change in difference(original, folder)])
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


@pytest.mark.parametrize(
    "sensor",
    [
        '<sensor href="#{s4}"/>',
        '<sensor href="//@mission/@robots.1/@sensors.1"/>',
        "<sensor>{s4}</sensor>",
        "<sensor>s4</sensor>",
    ],
)
def test_references_may_be_written_in_other_ways(sensor, file, folder, paper):
    s4 = xmi_id(paper.mission.robots[1].sensors[1])
    edit(file, f' sensor="{s4}"/>', f">{sensor.format(s4=s4)}</gatherSamples>")

    import_published(file, folder)

    assert difference(MODELS, folder) == ()


def test_an_area_that_is_referred_to_is_copied(file, folder, paper):
    area = paper.mission.goals[3].area
    edit(file, "<stayWithinMissionArea ", f'<stay area="{xmi_id(area)}" ')
    edit(file, "</stayWithinMissionArea>", "</stay>")

    import_published(file, folder)

    copied = load_mission_folder(folder).mission.goals[1].task.area
    assert (copied.ID, copied.radius, copied.center.x) == ("g2_task_area", 150.0, -250.0)


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
