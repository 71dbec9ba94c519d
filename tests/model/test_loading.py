"""What loading accepts: comments, all kinds of references, other encodings."""

import pytest

from m2t.models.load import inspect_folder, load_mission_folder, load_specification
from mrsfi_runtime.errors import ModelError
from tests.support.models.copies import FAULTS, MISSION, edit, line_of


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


@pytest.mark.parametrize("encoding", ["UTF-8", "UTF-16", "ISO-8859-1"])
def test_encodings_are_read(folder, encoding):
    path = folder / MISSION
    text = path.read_text(encoding="ascii").replace('"ASCII"', f'"{encoding}"', 1)
    path.write_bytes(text.replace("LEN", "L\xe9n").encode(encoding))

    assert load_mission_folder(folder).mission.robots[0].name == "L\xe9n"


def test_folder_without_faults_has_none(folder):
    (folder / FAULTS).unlink()

    models = load_mission_folder(folder)

    assert (models.faults, models.faults_path) == (None, None)


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
