"""A mission may stand in several files, or in one with its faults; it means the same."""

import dataclasses
from pathlib import Path

import pytest

from m2t.generate import VISITORS, generate
from m2t.models.load import (
    LoadedFile,
    LoadedModels,
    inspect_folder,
    load_mission_folder,
    load_specification,
    save,
    saved,
    write_specification,
)
from m2t.read import Spelling
from mrsfi_runtime.errors import ModelError
from tests.support.models.copies import FAULTS, MISSION, copy_models, edit, line_of
from tests.support.models.split import PARTS, split_folder


def whole(models: LoadedModels) -> list[bytes]:
    """Return a mission and its faults as they would stand in one file each."""
    roots = ((models.mission_path, models.mission), (models.faults_path, models.faults))
    files = tuple(
        LoadedFile(path, Spelling("ASCII"), (root,)) for path, root in roots if path is not None
    )
    return list(saved(dataclasses.replace(models, files=files)).values())


@pytest.mark.parametrize("parts", PARTS.values(), ids=PARTS)
def test_split_mission_is_the_mission_in_one_file(tmp_path, parts):
    original = load_mission_folder(copy_models(tmp_path / "whole"))
    folder = split_folder(tmp_path / "split", parts)

    models = load_mission_folder(folder)

    assert inspect_folder(folder).diagnostics == ()
    assert whole(models) == whole(original)
    assert len(models.files) > 2


@pytest.mark.parametrize("parts", PARTS.values(), ids=PARTS)
def test_saving_a_split_mission_changes_nothing(tmp_path, parts):
    assert save(load_mission_folder(split_folder(tmp_path, parts))) == ()


def test_part_is_written_as_eclipse_writes_it(tmp_path):
    folder = split_folder(tmp_path, PARTS["goals_and_tasks"])

    mission = (folder / MISSION).read_text(encoding="ascii").splitlines()
    tasks = (folder / "tasks.xmi").read_text(encoding="ascii").splitlines()

    assert mission[2] == '  <missionArea href="area.xmi#a15"/>'
    assert '  <goals href="goals.xmi#g4"/>' in mission
    assert (folder / "area.xmi").read_text(encoding="ascii").splitlines()[1:] == [
        f'<mission:Area xmi:version="2.0" {NAMESPACES} ID="a15" radius="2000.0">',
        '  <center href="center.xmi#/"/>',
        "</mission:Area>",
    ]
    assert tasks[1] == f'<xmi:XMI xmi:version="2.0" {NAMESPACES}>'
    assert '  <mission:GatherSamples targetSampleNumber="250">' in tasks
    assert '    <sensor href="mission.xmi#s4"/>' in tasks
    assert '    <task xsi:type="mission:GatherSamples" href="tasks.xmi#/3"/>' in (
        folder / "goals.xmi"
    ).read_text(encoding="ascii")


def test_editing_a_part_changes_one_line_of_one_file(tmp_path):
    folder = split_folder(tmp_path, PARTS["robots"])
    before = (folder / "robots.xmi").read_text(encoding="ascii").splitlines()
    models = load_mission_folder(folder)

    models.mission.robots[1].speed = 6.0
    written = save(models)

    after = (folder / "robots.xmi").read_text(encoding="ascii").splitlines()
    assert written == (folder / "robots.xmi",)
    assert [new for old, new in zip(before, after, strict=True) if old != new] == [
        '  <mission:Robot ID="r2" name="JEN" speed="6.0">'
    ]


def test_code_generated_from_a_split_mission_is_the_same(tmp_path):
    folder = split_folder(tmp_path / "split", PARTS["two_levels"])

    generate(copy_models(tmp_path / "whole"), tmp_path / "one")
    generate(folder, tmp_path / "many")

    names = [path.name for path in (tmp_path / "one").iterdir() if path.suffix == ".py"]
    assert len(names) == len(VISITORS)
    for name in names:
        assert (tmp_path / "many" / name).read_bytes() == (tmp_path / "one" / name).read_bytes()
    manifest = (tmp_path / "many" / "manifest.json").read_text(encoding="utf-8")
    assert '"robots/sensors/sensors.xmi"' in manifest


def test_defect_of_a_part_is_reported_at_its_own_file_and_line(tmp_path):
    folder = split_folder(tmp_path, PARTS["two_levels"])
    part = folder / "robots" / "sensors" / "sensors.xmi"
    edit(part, 'type="DEPTH"', 'type="DEBTH"')
    edit(folder / "robots" / "robots.xmi", 'speed="5.0"', 'speed="-5.0"')

    found = inspect_folder(folder).diagnostics

    assert [(entry.path.resolve(), entry.line, entry.constraint) for entry in found] == [
        (
            (folder / "robots" / "robots.xmi").resolve(),
            line_of(folder / "robots" / "robots.xmi", "-5.0"),
            "SpeedNotNegative",
        ),
        (part.resolve(), line_of(part, "DEBTH"), "EnumLiteral"),
    ]
    assert found[1].element == "sensors 's6'"


def test_same_id_in_two_parts_is_reported(tmp_path, approved):
    folder = split_folder(tmp_path, PARTS["one_robot"])
    edit(folder / "parts" / "r2.xmi", 'ID="b3"', 'ID="b1"')

    (found,) = inspect_folder(folder).diagnostics

    assert (found.path.name, found.constraint) == ("r2.xmi", "UniqueId")
    approved(found.message)
    assert "mission.xmi" in found.message


def test_specification_found_by_search_refers_into_the_parts(tmp_path):
    folder = split_folder(tmp_path, PARTS["goals_and_tasks"])
    path = tmp_path / "found.xmi"

    write_specification(folder, [("f2", 3, 9, {})], path, identifier="found")

    models = load_specification(path)
    assert b"goals.xmi#m4" in path.read_bytes()
    assert models.mission_path.resolve() == folder / MISSION
    assert (
        models.faults.faults[0].blockMessage.affectedMessage
        is (models.mission.goals[1].messages[0])
    )


def write_both(folder: Path) -> bytes:
    """Write a mission and its faults into one file, and return what is in it."""
    models = load_mission_folder(folder)
    both = LoadedFile(folder / MISSION, Spelling("ASCII"), (models.mission, models.faults))
    (content,) = saved(dataclasses.replace(models, files=(both,))).values()
    (folder / MISSION).write_bytes(content)
    return content


def test_mission_and_faults_in_one_file(tmp_path):
    original = load_mission_folder(copy_models(tmp_path / "two"))
    folder = copy_models(tmp_path / "one")
    content = write_both(folder)
    (folder / FAULTS).unlink()

    loaded = load_mission_folder(folder)

    assert (loaded.mission_path, loaded.faults_path) == (folder / MISSION, folder / MISSION)
    assert whole(dataclasses.replace(loaded, faults_path=folder / FAULTS)) == whole(original)
    assert save(loaded) == ()
    assert load_specification(folder / MISSION).faults.ID == original.faults.ID
    assert b'<affectedMessage href="' not in content


@pytest.mark.parametrize("target", ["/0/@goals.1/@messages.0", "m4", "#/0/@goals.1/@messages.0"])
def test_references_between_two_roots_of_a_file(folder, target):
    write_both(folder)
    (folder / FAULTS).unlink()
    edit(folder / MISSION, 'affectedMessage="m4"', f'affectedMessage="{target}"')

    loaded = load_mission_folder(folder)

    kind = loaded.faults.faults[1].blockMessage
    assert kind.affectedMessage is loaded.mission.goals[1].messages[0]


def test_faults_beside_those_in_the_mission_file_are_an_error(folder, refused):
    write_both(folder)

    with refused(ModelError):
        load_mission_folder(folder)


NAMESPACES = 'xmlns:xmi="http://www.omg.org/XMI" xmlns:mission="http://mrsfi.org/mission/1.0"'

PROJECT = """<?xml version="1.0" encoding="UTF-8"?>
<projectDescription><name>Survey</name></projectDescription>
"""


def test_platform_addresses_lead_into_the_project(tmp_path):
    folder = split_folder(tmp_path, PARTS["robots"])
    (tmp_path / ".project").write_text(PROJECT, encoding="utf-8")
    (tmp_path / "shared").mkdir()
    (folder / "robots.xmi").rename(tmp_path / "shared" / "robots.xmi")
    for path in folder.glob("*.xmi"):
        text = path.read_text(encoding="ascii")
        text = text.replace('"robots.xmi#', '"platform:/resource/Survey/shared/robots.xmi#')
        text = text.replace('"mission.xmi#', '"platform:/resource/uuv/mission.xmi#')
        path.write_text(text, encoding="ascii")

    models = load_mission_folder(folder)

    assert [robot.ID for robot in models.mission.robots] == ["r1", "r2", "r3"]
    assert inspect_folder(folder).diagnostics == ()


@pytest.mark.parametrize(
    ("href", "constraint"),
    [
        ("/etc/passwd#r1", "LocalReference"),
        ("file:///etc/passwd#r1", "LocalReference"),
        ("http://example.org/r.xmi#r1", "LocalReference"),
        ("//host/r.xmi#r1", "LocalReference"),
        ("../outside.xmi#r1", "LocalReference"),
        ("link.xmi#r1", "LocalReference"),
        ("platform:/resource/Nowhere/r.xmi#r1", "LocalReference"),
        ("platform:/resource/uuv/../../outside.xmi#r1", "LocalReference"),
        ("platform:/plugin/uuv/r.xmi#r1", "LocalReference"),
        ("missing.xmi#r1", "ReadableFile"),
        ("robots.xmi#r9", "ContainedElement"),
        ("robots.xmi#", "ContainedElement"),
        ("robots.xmi#/7", "ContainedElement"),
        ("robots.xmi#r2", "ContainedElement"),
        ("mission.xmi#/", "ContainedElement"),
        ("area.xmi#/", "ConcreteType"),
        ("r1", "ContainedElement"),
        ("", "ContainedElement"),
    ],
)
def test_part_that_cannot_be_used_is_an_error(tmp_path, href, constraint, approved):
    folder = split_folder(tmp_path, PARTS["robots"])
    (folder / "area.xmi").write_text(
        '<mission:Area xmlns:mission="http://mrsfi.org/mission/1.0" radius="1"/>', encoding="ascii"
    )
    (folder.parent / "outside.xmi").write_bytes((folder / "robots.xmi").read_bytes())
    (folder / "link.xmi").symlink_to(folder.parent / "outside.xmi")
    edit(folder / MISSION, "robots.xmi#r1", href)

    found = [
        entry for entry in inspect_folder(folder).diagnostics if entry.constraint == constraint
    ]

    assert found
    approved(found[0].message)


def test_circle_of_files_is_an_error(tmp_path, approved):
    folder = split_folder(tmp_path, PARTS["two_levels"])
    edit(folder / "robots" / "robots.xmi", "sensors/sensors.xmi#s1", "../mission.xmi#/")

    found = [entry for entry in inspect_folder(folder).diagnostics if "circle" in entry.message]

    assert [(entry.path.name, entry.constraint) for entry in found] == [
        ("robots.xmi", "ContainedElement")
    ]
    approved(found[0].message)


def test_root_that_no_model_contains_is_an_error(tmp_path, approved):
    folder = split_folder(tmp_path, PARTS["robots"])
    edit(
        folder / "robots.xmi", "</xmi:XMI>", '  <mission:Server ID="sv9" name="spare"/>\n</xmi:XMI>'
    )

    (found,) = inspect_folder(folder).diagnostics

    assert (found.path.name, found.constraint) == ("robots.xmi", "ContainedElement")
    approved(found.message)
