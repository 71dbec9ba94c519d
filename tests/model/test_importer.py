"""Models published for the paper's prototype become mission folders, with every figure."""

import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from m2t.difference import difference
from m2t.importing.importer import Imported, import_published
from m2t.load import LoadedModels, load_mission_folder, load_specification
from m2t.metamodels import features, is_contained, is_reference
from m2t.validate import validate_folder
from mrsfi_runtime.errors import ModelError, UsageError
from support_generation import ALL_TASKS, write_mission
from support_model import MODELS, edit, line_of
from support_published import published, xmi_id


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


def figures(root: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """Yield every value and every reference of a model with its place."""
    for feature in features(root.eClass):
        value = root.eGet(feature)
        values = list(value) if feature.many else [value]
        for index, entry in enumerate(values):
            here = f"{place}/{feature.name}.{index}"
            if is_contained(feature) and entry is not None:
                yield here, entry.eClass.name
                yield from figures(entry, here)
            elif is_reference(feature):
                yield here, entry.ID
            else:
                yield here, getattr(entry, "name", entry)


def lines_of(file: Path, fragment: str) -> set[int]:
    lines = file.read_text(encoding="ascii").splitlines()
    return {number for number, line in enumerate(lines, 1) if fragment in line}


def notes(imported: Imported, kind: str) -> list[tuple[str, str]]:
    return [(note.element, note.feature) for note in imported.notes if note.kind == kind]


def test_every_figure_and_reference_of_the_paper_is_kept(
    paper: LoadedModels, file: Path, folder: Path
) -> None:
    imported = import_published(file, folder)

    models = load_mission_folder(folder)
    assert list(figures(models.mission)) == list(figures(paper.mission))
    assert list(figures(models.faults)) == list(figures(paper.faults))
    assert sum(1 for _ in figures(models.mission)) > 300
    assert imported.files == ("mission.xmi", "faults.xmi", "case_a.toml", "case_b.toml")
    assert dict(imported.counts) == {
        "robots": 3,
        "servers": 1,
        "obstacles": 8,
        "goals": 6,
        "messages": 12,
        "faults": 30,
    }


def test_the_files_equal_the_committed_ones(file: Path, folder: Path) -> None:
    import_published(file, folder)

    for name in ("mission.xmi", "faults.xmi"):
        assert (folder / name).read_bytes() == (MODELS / name).read_bytes()
    assert difference(MODELS, folder) == ()
    assert validate_folder(folder) == ()


def test_a_consistent_file_has_nothing_inconsistent_and_loses_back_references_only(
    file: Path, folder: Path
) -> None:
    imported = import_published(file, folder)

    assert notes(imported, "inconsistent") == []
    assert {feature for _, feature in notes(imported, "dropped")} == {"parentID", "goal_ID"}
    assert {feature for _, feature in notes(imported, "default")} == {"type", "x", "y", "z"}
    assert notes(imported, "renamed") == [(f"faults 'f{n}'", "ID") for n in range(1, 31)]


def test_all_tasks_and_properties_import_and_what_the_format_lacks_gets_its_default(
    tmp_path: Path, folder: Path
) -> None:
    original = write_mission(tmp_path, "all_tasks", ALL_TASKS)
    file = tmp_path / "published.xmi"
    file.write_text(published(load_mission_folder(original)), encoding="ascii")

    imported = import_published(file, folder)

    assert [str(change) for change in difference(original, folder)] == [
        "goal patrol: task.period 50 → 10",
        "goal visit: task.deadline 90 → 99",
        "goal track: task.tolerance 500.0 → 10.0",
        "goal distance: task.tolerance 5.0 → 1.0",
    ]
    assert {"period", "deadline", "tolerance"} <= {
        feature for _, feature in notes(imported, "default")
    }
    assert imported.files == ("mission.xmi",)


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
        ('goalMembers="', 'goalMembers="{r2} ', "goals 'g1'", "members"),
        (
            'ID="m10" goal_ID="g4" header="h" from="{r2}"',
            'ID="m10" goal_ID="g4" header="h" from="{r3}"',
            "messages 'm10'",
            "SenderIsMember",
        ),
    ],
)
def test_what_contradicts_the_rest_is_listed_with_its_line(
    old: str, new: str, element: str, feature: str, file: Path, folder: Path, paper: LoadedModels
) -> None:
    ids = {robot.ID: xmi_id(robot) for robot in paper.mission.robots}
    edit(file, old.format(**ids), new.format(**ids))
    lines = lines_of(file, new.format(**ids))

    imported = import_published(file, folder)

    found = [note for note in imported.notes if note.kind == "inconsistent"]
    assert (element, feature) in [(note.element, note.feature) for note in found]
    assert all({note.line, note.line + 1} & lines for note in found if note.feature == feature)
    assert load_mission_folder(folder).faults is not None


@pytest.mark.parametrize("zero", ["0", "0.0", "-0"])
def test_a_zero_of_a_zero_type_is_dropped_without_more(zero: str, file: Path, folder: Path) -> None:
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
def test_missing_unusable_and_taken_ids_are_replaced(
    old: str, new: str, place: str, file: Path, folder: Path
) -> None:
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


def test_a_missing_name_is_the_id(file: Path, folder: Path) -> None:
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
def test_what_is_not_known_is_dropped_and_listed(
    old: str, new: str, element: str, feature: str, file: Path, folder: Path
) -> None:
    edit(file, old, new)

    imported = import_published(file, folder)

    assert (element, feature) in notes(imported, "dropped")
    assert (folder / "mission.xmi").read_bytes() == (MODELS / "mission.xmi").read_bytes()


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
    old: str, new: str, constraint: str, file: Path, folder: Path, paper: LoadedModels
) -> None:
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


def test_an_error_of_the_result_names_the_line_of_the_published_file(
    file: Path, folder: Path
) -> None:
    edit(file, 'ID="o5"', 'ID="o5" colour="grey"')
    edit(file, 'radius="30.0"', 'radius="-30.0"')

    with pytest.raises(ModelError) as caught:
        import_published(file, folder)

    line = line_of(file, 'radius="-30.0"')
    assert str(caught.value).startswith(f"{file}:{line}: area 'a11' has radius '-30.0'")


@pytest.mark.parametrize(
    "root",
    ['p:Setup xmlns:p="acs_project_setup"', 'Setup xmlns="acs_project_setup"'],
    ids=["prefix", "no prefix"],
)
def test_any_prefix_will_do(root: str, text: str, file: Path, folder: Path) -> None:
    end = root.split(maxsplit=1)[0]
    changed = text.replace('setup:Setup xmi:version="2.0"', f'{root} xmi:version="2.0"')
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
def test_references_may_be_written_in_other_ways(
    sensor: str, file: Path, folder: Path, paper: LoadedModels
) -> None:
    s4 = xmi_id(paper.mission.robots[1].sensors[1])
    edit(file, f' sensor="{s4}"/>', f">{sensor.format(s4=s4)}</gatherSamples>")

    import_published(file, folder)

    assert difference(MODELS, folder) == ()


def test_an_area_that_is_referred_to_is_copied(
    file: Path, folder: Path, paper: LoadedModels
) -> None:
    area = paper.mission.goals[3].area
    edit(file, "<stayWithinMissionArea ", f'<stay area="{xmi_id(area)}" ')
    edit(file, "</stayWithinMissionArea>", "</stay>")

    import_published(file, folder)

    copied = load_mission_folder(folder).mission.goals[1].task.area
    assert (copied.ID, copied.radius, copied.center.x) == ("g2_task_area", 150.0, -250.0)


def test_every_further_specification_gets_a_file(file: Path, folder: Path) -> None:
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


def test_without_collision_or_energy_goal_there_is_no_case_b(file: Path, folder: Path) -> None:
    edit(file, "<sufficientEnergy ", "<stayWithinMissionArea ")
    edit(file, "</sufficientEnergy>", "</stayWithinMissionArea>")

    imported = import_published(file, folder)

    assert imported.files == ("mission.xmi", "faults.xmi", "case_a.toml")


def test_an_existing_folder_is_refused(file: Path, folder: Path) -> None:
    import_published(file, folder)
    edit(folder / "mission.xmi", 'speed="5.0"', 'speed="6.0"')
    before = (folder / "mission.xmi").read_bytes()

    with pytest.raises(UsageError, match="--force"):
        import_published(file, folder)

    assert (folder / "mission.xmi").read_bytes() == before


def test_force_replaces_the_models_and_keeps_all_else(file: Path, folder: Path) -> None:
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


def test_force_with_a_broken_file_leaves_the_folder_as_it_was(file: Path, folder: Path) -> None:
    import_published(file, folder)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    edit(file, 'speed="5.0"', 'speed="-5.0"')

    with pytest.raises(ModelError):
        import_published(file, folder, is_forced=True)

    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    assert [path.name for path in folder.parent.iterdir()] == [folder.name]


def test_force_never_touches_a_folder_that_is_no_mission(file: Path, tmp_path: Path) -> None:
    place = tmp_path / "home"
    place.mkdir()
    (place / "letter.txt").write_text("dear")

    with pytest.raises(UsageError, match=r"holds no mission\.xmi"):
        import_published(file, place, is_forced=True)

    assert [path.name for path in place.iterdir()] == ["letter.txt"]


def _cut(text: str, draw: random.Random) -> str:
    start = draw.randrange(len(text))
    return text[:start] + text[start + draw.randrange(1, 200) :]


def _double_a_line(text: str, draw: random.Random) -> str:
    lines = text.splitlines(keepends=True)
    at = draw.randrange(len(lines))
    return "".join([*lines[:at], lines[at], *lines[at:]])


def _lose_a_line(text: str, draw: random.Random) -> str:
    lines = text.splitlines(keepends=True)
    del lines[draw.randrange(len(lines))]
    return "".join(lines)


def _exchange_values(text: str, draw: random.Random) -> str:
    pieces = text.split('"')
    one, two = (draw.randrange(1, len(pieces), 2) for _ in range(2))
    pieces[one], pieces[two] = pieces[two], pieces[one]
    return '"'.join(pieces)


def _exchange_tags(text: str, draw: random.Random) -> str:
    tags = ("robots", "area", "goals", "center", "task", "sensors", "faults", "goalArea", "members")
    one, two = draw.sample(tags, 2)
    return text.replace(f"<{one} ", f"<{two} ").replace(f"</{one}>", f"</{two}>")


@pytest.mark.parametrize(
    "damage", [_cut, _double_a_line, _lose_a_line, _exchange_values, _exchange_tags]
)
def test_a_damaged_file_imports_as_a_valid_mission_or_is_refused(
    damage: Callable[[str, random.Random], str], text: str, file: Path, folder: Path
) -> None:
    draw = random.Random(7)
    for number in range(12):
        file.write_text(damage(text, draw), encoding="ascii")
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
