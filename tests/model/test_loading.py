"""What loading accepts and refuses: references, encodings, namespaces, several files, attacks."""

import dataclasses
import os
import re
from pathlib import Path

import pytest

from m2t.generate import VISITORS, generate
from m2t.models.load import (
    LoadedFile,
    LoadedModels,
    inspect_folder,
    inspect_specification,
    load_mission_folder,
    load_specification,
    save,
    saved,
    write_specification,
)
from m2t.read import MAX_BYTES, MAX_ELEMENTS, Spelling
from mrsfi_runtime.errors import Diagnostic, ModelError
from mrsfi_runtime.model.faults import TimedFault
from tests.support.models.copies import FAULTS, MISSION, MODELS, copy_models, edit, line_of
from tests.support.models.split import PARTS, split_folder
from tests.support.world import paper_code

TEXT = (MODELS / MISSION).read_text(encoding="ascii")
BARE = re.sub(r"<(/?)mission:", r"<\1", TEXT).replace("xmlns:mission=", "xmlns=")
SPELLINGS = {
    "default namespace": BARE.replace('xsi:type="mission:', 'xsi:type="'),
    "xmi:type": TEXT.replace("xsi:type", "xmi:type"),
    "elements with the prefix": re.sub(r"<(/?)(robots|goals)", r"<\1mission:\2", TEXT),
}
HOSTILE_NAME = """x"); import os; os.system("touch owned")  #\n'{{ 7 * 7 }}{% raw %}'\t<&>"""
HOSTILE_XML = (
    HOSTILE_NAME.replace("&", "&amp;")
    .replace("<", "&lt;")
    .replace('"', "&quot;")
    .replace("\n", "&#xA;")
    .replace("\t", "&#x9;")
)
BILLION_LAUGHS = """<?xml version="1.0"?>
<!DOCTYPE lolz [<!ENTITY a "lol"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">
<!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;&b;&b;"><!ENTITY d "&c;&c;&c;&c;&c;&c;&c;&c;&c;&c;">]>
<mission:Mission xmlns:mission="http://mrsfi.org/mission/1.0" name="&d;&d;&d;&d;" duration="1"/>
"""
EXTERNAL_ENTITY = """<?xml version="1.0"?>
<!DOCTYPE m [<!ENTITY secret SYSTEM "secret.txt">]>
<mission:Mission xmlns:mission="http://mrsfi.org/mission/1.0" name="&secret;" duration="1"/>
"""
EXTERNAL_DTD = """<?xml version="1.0"?>
<!DOCTYPE m SYSTEM "http://example.org/m.dtd">
<mission:Mission xmlns:mission="http://mrsfi.org/mission/1.0" name="m" duration="1"/>
"""


def test_comments_and_processing_instructions_are_dropped(folder):
    edit(folder / MISSION, "<servers ", "<!-- one --><?two three?>\n<servers ")
    edit(folder / FAULTS, "<activateSensor>", "<!-- inside --><activateSensor>")

    assert inspect_folder(folder).diagnostics == ()


@pytest.mark.parametrize("target", ["s4", "//@robots.1/@sensors.1", "#s4", "_sensor"])
def test_references_inside_a_file_are_resolved(folder, target):
    edit(folder / MISSION, '<sensors ID="s4"', '<sensors xmi:id="_sensor" ID="s4"')
    edit(folder / MISSION, 'sensor="s4"', f'sensor="{target}"')

    mission = load_mission_folder(folder).mission

    assert mission.goals[3].task.sensor is mission.robots[1].sensors[1]


@pytest.mark.parametrize(
    "target", ["mission.xmi#m2", "mission.xmi#//@goals.0/@messages.1", "./mission.xmi#_message"]
)
def test_references_between_files_are_resolved(folder, target):
    edit(folder / MISSION, '<messages ID="m2"', '<messages xmi:id="_message" ID="m2"')
    edit(folder / FAULTS, "mission.xmi#m4", target)

    models = load_mission_folder(folder)

    expected = models.mission.goals[0].messages[1]
    assert models.faults.faults[1].blockMessage.affectedMessage is expected


def test_reference_between_files_may_be_an_attribute(folder):
    edit(
        folder / FAULTS,
        'DURATION="5.0">\n      <affectedMessage href="mission.xmi#m4"/>\n    </blockMessage>',
        'DURATION="5.0" affectedMessage="mission.xmi#m2"/>',
    )

    models = load_mission_folder(folder)

    assert models.faults.faults[1].blockMessage.affectedMessage.ID == "m2"


def test_folder_without_faults_has_none(folder):
    (folder / FAULTS).unlink()

    models = load_mission_folder(folder)

    assert models.faults is None


def test_specification_finds_the_mission_that_it_refers_to(tmp_path, folder):
    path = tmp_path / "elsewhere" / "mine.xmi"
    path.parent.mkdir()
    text = (folder / FAULTS).read_text(encoding="ascii")
    path.write_text(text.replace("mission.xmi#", "../models/uuv/mission.xmi#"), encoding="ascii")

    models = load_specification(path)

    assert models.mission_path.resolve() == (folder / MISSION).resolve()
    assert len(models.faults.faults) == 30


def test_specification_of_two_missions_is_an_error(folder, refused):
    edit(folder / FAULTS, "mission.xmi#m4", "other.xmi#m4")

    with refused(ModelError):
        load_specification(folder / FAULTS)


def test_mission_in_place_of_a_specification_is_an_error(folder, refused):

    with refused(ModelError):
        load_specification(folder / MISSION)


def test_every_object_knows_its_line(folder):
    models = load_mission_folder(folder)

    node = models.nodes[models.mission.goals[5]]

    assert (node.path, node.line) == (folder / MISSION, line_of(folder / MISSION, 'ID="g6"'))


def test_lines_stay_right_in_long_files(folder):
    edit(folder / MISSION, "<servers ", "\n" * 70_000 + "<servers ")
    edit(folder / MISSION, 'sensor="s4"', 'sensor="s9"')

    (found,) = inspect_folder(folder).diagnostics

    assert found.line == line_of(folder / MISSION, 'sensor="s9"') > 70_000


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_a_model_in_another_spelling_is_saved_in_the_usual_one(spelling, folder):
    (folder / MISSION).write_text(SPELLINGS[spelling], encoding="ascii")

    contents = saved(load_mission_folder(folder))

    assert contents[folder / MISSION].decode("ascii") == TEXT


def test_an_element_of_another_namespace_is_refused_with_it(folder, approved):
    text = TEXT.replace("<obstacles", '<x:obstacles xmlns:x="http://other"', 1)
    (folder / MISSION).write_text(text.replace("</obstacles", "</x:obstacles", 1), "ascii")

    found = inspect_folder(folder).diagnostics[0]

    assert found.constraint == "KnownFeature"
    approved(found.message)


def test_a_type_whose_prefix_is_not_declared_is_refused_with_what_would_be_found(folder, approved):
    (folder / MISSION).write_text(BARE, encoding="ascii")

    found = inspect_folder(folder).diagnostics[0]

    assert found.constraint == "ConcreteType"
    approved(found.message)


def whole(models: LoadedModels) -> list[bytes]:
    """Return a mission and its faults as they would stand in one file each."""
    roots = {MISSION: models.mission, FAULTS: models.faults}
    folder = models.mission_path.parent
    files = tuple(
        LoadedFile(folder / name, Spelling("ASCII"), (root,))
        for name, root in roots.items()
        if root is not None
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
    assert save(models) == ()


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

    pool = paper_code().pool
    timed = (TimedFault("f2", 3, 9, pool["f2"].values),)
    write_specification(folder, pool, timed, path, identifier="found")

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

    assert [file.path for file in loaded.files] == [loaded.mission_path] == [folder / MISSION]
    assert whole(loaded) == whole(original)
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


def _only(found: tuple[Diagnostic, ...]) -> Diagnostic:
    assert len(found) == 1, [str(entry) for entry in found]
    return found[0]


@pytest.mark.parametrize("text", [BILLION_LAUGHS, EXTERNAL_ENTITY, EXTERNAL_DTD])
def test_document_types_are_refused_before_their_content_is_read(tmp_path, text):
    (tmp_path / "secret.txt").write_text("swordfish", encoding="utf-8")
    (tmp_path / MISSION).write_text(text, encoding="utf-8")

    found = _only(inspect_folder(tmp_path).diagnostics)

    assert (found.constraint, found.line) == ("NoDocumentType", 2)
    assert "swordfish" not in str(found)


@pytest.mark.parametrize(
    "text",
    ["<a>" * 100_000 + "</a>" * 100_000, f"<a>{'<b/>' * MAX_ELEMENTS}</a>"],
    ids=["deep", "long"],
)
def test_too_many_elements_are_refused(tmp_path, text, approved):
    (tmp_path / MISSION).write_text(text, encoding="utf-8")

    found = _only(inspect_folder(tmp_path).diagnostics)

    assert found.constraint == "FileSize"
    approved(found.message)


def test_file_beyond_the_size_limit_is_refused(tmp_path, approved):
    with (tmp_path / MISSION).open("wb") as stream:
        stream.truncate(MAX_BYTES + 1)

    found = _only(inspect_folder(tmp_path).diagnostics)

    assert found.constraint == "FileSize"
    approved(found.message)


def test_name_of_ten_megabytes_is_a_short_error(folder, approved):
    edit(folder / MISSION, 'name="LEN"', f'name="{"L" * 10_000_000}"')

    found = _only(inspect_folder(folder).diagnostics)

    assert found.constraint == "StringLength"
    approved(found.message)
    assert len(str(found)) < 500 + len(str(folder))


def test_id_and_tag_of_a_megabyte_are_short_errors(folder):
    edit(folder / MISSION, 'ID="b1"', f'ID="{"b" * 1_000_000}"')
    edit(folder / MISSION, "<servers ", f"<{'t' * 1_000_000}/><servers ")

    for found in inspect_folder(folder).diagnostics:
        assert len(str(found)) < 1000 + len(str(folder))


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\x00\xff\xfe",
        b"not xml",
        b"<a>\xff</a>",
        b"<a b='1' b='2'/>",
        b"<a x:b='1'/>",
        b"<a/><b/>",
        b"<?xml version='1.0' encoding='UTF-7'?><a/>",
        b"<?xml version='1.0' encoding='rot13'?><a/>",
        b"<?xml version='1.0' encoding='gb18030'?><a/>",
        b"<a/>",
        b"<mission:Mission xmlns:mission='http://mrsfi.org/mission/1.0'/>",
        b"<mission:Robot xmlns:mission='http://mrsfi.org/mission/1.0' ID='r' name='n' speed='1'/>",
        b"<xmi:XMI xmlns:xmi='http://www.omg.org/XMI'/>",
    ],
)
def test_no_bytes_cause_anything_but_a_model_error(tmp_path, content):
    (tmp_path / MISSION).write_bytes(content)
    (tmp_path / FAULTS).write_bytes(content)

    assert inspect_folder(tmp_path).diagnostics
    assert inspect_specification(tmp_path / FAULTS).diagnostics
    with pytest.raises(ModelError):
        load_mission_folder(tmp_path)
    with pytest.raises(ModelError):
        load_specification(tmp_path / FAULTS)


@pytest.mark.parametrize(
    "value",
    ["", " ", "//", "//@robots.", "//@robots.99999999999", "//@x.0", "/1", "#", "##", "s4 "],
)
def test_no_reference_causes_anything_but_a_model_error(folder, value):
    edit(folder / MISSION, 'sensor="s6"', f'sensor="{value}"')

    with pytest.raises(ModelError, match="goals 'g5'"):
        load_mission_folder(folder)


@pytest.mark.parametrize(
    "href", ["", "#", "m4", "http://[", "file:///mission.xmi#m4", "//host/mission.xmi#m4", "%00#m4"]
)
def test_no_href_causes_anything_but_a_model_error(folder, href):
    edit(folder / FAULTS, "mission.xmi#m4", href)

    with pytest.raises(ModelError, match="faults 'f2'"):
        load_mission_folder(folder)
    with pytest.raises(ModelError, match="faults 'f2'"):
        load_specification(folder / FAULTS)


@pytest.mark.parametrize("make", [os.mkdir, os.mkfifo], ids=["folder", "pipe"])
def test_folder_or_pipe_in_place_of_a_model_is_an_error_at_once(tmp_path, make):
    make(tmp_path / MISSION)

    found = _only(inspect_folder(tmp_path).diagnostics)

    assert found.constraint == "ReadableFile"


def test_hostile_display_names_are_legal_texts(folder):
    edit(folder / MISSION, 'name="LEN"', f'name="{HOSTILE_XML}"')
    edit(folder / FAULTS, 'name="f1"', f'name="{HOSTILE_XML}"')

    models = load_mission_folder(folder)

    assert inspect_folder(folder).diagnostics == ()
    assert models.mission.robots[0].name == HOSTILE_NAME
    assert models.faults.faults[0].name == HOSTILE_NAME


def test_hostile_id_is_an_error_on_one_line(folder):
    edit(folder / MISSION, 'ID="b1"', f'ID="{HOSTILE_XML}"')

    found = _only(inspect_folder(folder).diagnostics)

    assert found.constraint == "IdSyntax"
    assert "\n" not in str(found)
