"""Published files that cannot become a mission, and folders that an import does not touch."""

import random
from pathlib import Path

import pytest

from m2t.models.difference import difference
from m2t.models.importing import import_published
from m2t.models.load import load_mission_folder
from mrsfi_runtime.errors import ModelError, UsageError
from tests.support.models.copies import MODELS, edit
from tests.support.models.published import xmi_id
from tests.support.mutilation import MUTILATIONS

ERRORS = [
    ('sensor="', 'sensor="_nowhere', "ResolvedReference"),
    ('sensor="{s4}"', 'sensor="{r2}"', "ReferenceType"),
    ('sensor="{s4}"', 'sensor="{s4} {s2}"', "SingleValue"),
    ('sensor="{s4}"', 'sensor="{s2}"', "SensorOfMember"),
    ('sensor="{s4}"', "", "RequiredFeature"),
    ("<avoidCollision ", '<sufficientEnergy xmi:id="_e"/><avoidCollision ', "SingleValue"),
    ("<position ", '<position xmi:id="_p"/><position ', "SingleValue"),
    ("<stopRobot ", "<stopEverything ", "ExactlyOneFaultType"),
    ("<stopRobot ", '<startRobot affectedRobot="{r1}"/><stopRobot ', "ExactlyOneFaultType"),
    ('xmi:id="{r2}"', 'xmi:id="{r1}"', "UniqueId"),
    ('duration="1000.0"', 'duration="1000.5"', "NumberSyntax"),
    ('duration="1000.0"', 'duration="soon"', "NumberSyntax"),
    ('speed="5.0"', 'speed="-5.0"', "SpeedNotNegative"),
    ('samplesPerSecond="5"', "", "SamplesPerSecondPositive"),
    ('type="PRESSURE"', 'type="TASTE"', "EnumLiteral"),
    ('radius="4.0"', "", "RadiusPositive"),
    ("<mission ", "<mission><robots/></mission><mission ", "SingleValue"),
    ("acs_project_setup", "acs_project_other", "RootElement"),
    ("<setup:Setup", "<!DOCTYPE x [<!ENTITY e 'e'>]><setup:Setup", "NoDocumentType"),
    ("</setup:Setup>", "", "WellFormedXml"),
]


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
