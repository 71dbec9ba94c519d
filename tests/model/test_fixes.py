"""Broken models: the right diagnostic for each, and the fix that mends only that."""

import itertools
import re
import sys
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import pytest

from m2t.generate import plan
from m2t.metamodels import load_metamodels
from m2t.models.fixes import FIXES, Mending, mend
from m2t.models.load import inspect_folder, inspect_specification, load_mission_folder
from mrsfi_runtime.errors import ModelError
from mrsfi_runtime.model.mission import Coordinates, Robot
from tests.support.broken_models import BROKEN, Broken
from tests.support.constraints import LISTED
from tests.support.models.copies import FAULTS, MISSION, copy_models, edit, line_of
from tests.support.models.shapes import shape, write_drawn
from tests.support.models.split import PARTS, write_split
from tests.support.tables import rows

BOUNDS = (
    '<fixedObstacleCoordinates NEW_X="200.0" NEW_X_MIN="{}.0" NEW_X_MAX="{}.0" NEW_Y="-450.0" '
    'NEW_Y_MIN="{}.0" NEW_Y_MAX="{}.0" NEW_Z="1.0">'
)


def _label(broken: Broken) -> str:
    return f"{broken.constraint}-{broken.element}"


@pytest.mark.parametrize("broken", BROKEN, ids=_label)
def test_broken_model_is_reported_at_its_line(folder, broken, approved):
    path = folder / broken.file
    edit(path, broken.old, broken.new)

    diagnostics = inspect_folder(folder).diagnostics

    found = [entry for entry in diagnostics if entry.constraint == broken.constraint]
    assert found, [str(entry) for entry in diagnostics]
    first = found[0]
    assert (first.path, first.line) == (path, line_of(path, broken.place))
    assert first.element.startswith(broken.element)
    approved(first.message)
    assert first.severity == LISTED[broken.constraint].severity
    assert str(first) == f"{path}:{first.line}: {first.message} [{broken.constraint}]"


def test_errors_stop_loading_with_all_of_them(folder):
    edit(folder / MISSION, 'x="250.0" y="-250.0"', 'x="2000.0" y="1.0"')
    edit(folder / MISSION, 'sensor="s4"', 'sensor="s6"')
    edit(folder / FAULTS, 'DELAY="200.0"', 'DELAY="2.5"')
    diagnostics = inspect_folder(folder).diagnostics

    with pytest.raises(ModelError) as caught:
        load_mission_folder(folder)

    errors = [str(entry) for entry in diagnostics if entry.severity == "error"]
    assert str(caught.value) == "\n".join(errors)
    assert [entry.constraint for entry in diagnostics] == [
        "RobotInsideMission",
        "SensorOfMember",
        "WholeTicks",
    ]


def test_warnings_do_not_stop_loading(folder):
    edit(folder / MISSION, 'x="250.0" y="-250.0"', 'x="2000.0" y="1.0"')

    assert load_mission_folder(folder).mission.robots[0].position.x == 2000.0


def test_missing_mission_is_reported(tmp_path, approved):
    (found,) = inspect_folder(tmp_path).diagnostics

    assert found.constraint == "ReadableFile"
    approved(found)


def test_every_constraint_has_a_broken_model():
    covered = {broken.constraint for broken in BROKEN} | {"ReadableFile", "NameSyntax"}

    assert covered == set(LISTED)


def test_all_defects_of_both_files_are_reported_at_once(folder):
    edit(folder / MISSION, 'speed="5.0"', 'speed="fast"')
    edit(folder / MISSION, 'type="DEPTH"', 'type="DEBTH"')
    edit(folder / FAULTS, "#m4", "#m44")

    found = [(entry.path.name, entry.constraint) for entry in inspect_folder(folder).diagnostics]

    assert found == [
        (MISSION, "NumberSyntax"),
        (MISSION, "EnumLiteral"),
        (FAULTS, "ResolvedReference"),
    ]


class Mended(NamedTuple):
    """An edit that breaks a constraint, and the line that its fix removes and adds, if any."""

    constraint: str
    file: str
    old: str
    new: str
    removed: str
    added: str


MENDED = [
    Mended(
        "SearchBoundsOrdered",
        FAULTS,
        'NEW_X="200.0" NEW_Y="-450.0"',
        'NEW_X="200.0" NEW_X_MIN="9.0" NEW_X_MAX="8.0" NEW_Y="-450.0" NEW_Y_MIN="1.0" '
        'NEW_Y_MAX="0.0"',
        BOUNDS.format(9, 8, 1, 0),
        BOUNDS.format(8, 9, 0, 1),
    ),
    *itertools.starmap(
        Mended,
        rows(r"""
UniqueReference | mission.xmi
    members="r2 r3 r1">\n    <area ID="a2" | members="r2 r3 r2 r2 r1">\n    <area ID="a2"
    <goals ID="g2" name="StayWithinMissionArea" members="r2 r3 r2 r2 r1">
    <goals ID="g2" name="StayWithinMissionArea" members="r2 r3 r1">
GoalDependsOnOthers | mission.xmi
    name="GatherSamples" members="r2" | name="GatherSamples" members="r2" dependentGoals="g1 g4"
    <goals ID="g4" name="GatherSamples" members="r2" dependentGoals="g1 g4">
    <goals ID="g4" name="GatherSamples" members="r2" dependentGoals="g1">
AvoidCollisionMembers | mission.xmi
    name="AvoidCollision" members="r2 r3 r1" | name="AvoidCollision" members="r3"
    <goals ID="g1" name="AvoidCollision" members="r3">
    <goals ID="g1" name="AvoidCollision" members="r3 r2 r1">
UniqueMessageField | mission.xmi | <body name="TEMPERATURE" type="Int"/>
    <body name="TEMPERATURE" type="Int"/>\n      <body name="TEMPERATURE" type="Double"/>
    <body name="TEMPERATURE" type="Double"/> | -
RandomBoundsOrdered | faults.xmi
    LOWER_BOUND="1" UPPER_BOUND="50" | LOWER_BOUND="51" UPPER_BOUND="50"
    <randomSampleRate LOWER_BOUND="51" UPPER_BOUND="50">
    <randomSampleRate LOWER_BOUND="50" UPPER_BOUND="51">
WholeTicks | faults.xmi | DELAY="200.0" | DELAY="2.5" DELAY_MAX="3.7"
    <delayMessage DELAY="2.5" DELAY_MAX="3.7"> | <delayMessage DELAY="2.0" DELAY_MAX="4.0">
WindowOrdered | faults.xmi
    <faults ID="f2" name="f2" | <faults ID="f2" name="f2" start="9" finish="8"
    <faults ID="f2" name="f2" start="9" finish="8">
    <faults ID="f2" name="f2" start="8" finish="9">
"""),
    ),
]


def _mended(folder: Path) -> Mending:
    mending = mend(inspect_folder(folder))
    assert mending is not None
    return mending


@pytest.mark.parametrize("case", MENDED, ids=lambda case: case.constraint)
def test_a_fix_changes_the_lines_that_are_wrong_and_no_other(folder, case):
    path = folder / case.file
    edit(path, case.old, case.new)
    found = [
        entry for entry in inspect_folder(folder).diagnostics if entry.constraint == case.constraint
    ]

    mending = _mended(folder)

    assert found
    assert mending.fixed == tuple((entry, FIXES[case.constraint].title) for entry in found)
    assert list(mending.contents) == [path]
    assert mending.respelt == ()
    lines = mending.difference[2:]
    assert [line[1:].strip() for line in lines if line.startswith("-")] == [case.removed]
    assert [line[1:].strip() for line in lines if line.startswith("+")] == (
        [case.added] if case.added else []
    )
    path.write_bytes(mending.contents[path])
    assert inspect_folder(folder).diagnostics == ()


def test_every_fix_is_tried():
    assert {case.constraint for case in MENDED} == set(FIXES)


@pytest.mark.parametrize("name", [*FIXES, "ResolvedReference"])
def test_a_fix_mends_every_broken_model_of_its_constraint(tmp_path, name):
    for number, broken in enumerate(entry for entry in BROKEN if entry.constraint == name):
        folder = copy_models(tmp_path / str(number))
        edit(folder / broken.file, broken.old, broken.new)

        for path, content in _mended(folder).contents.items():
            path.write_bytes(content)

        mended = inspect_folder(folder)
        assert mended.draft is not None
        assert name not in [found.constraint for found in mended.diagnostics]


def test_flawless_models_have_nothing_to_fix(tmp_path):
    assert mend(inspect_folder(copy_models(tmp_path))) is None


def test_errors_of_structure_come_first(folder):
    edit(folder / FAULTS, 'LOWER_BOUND="11.0"', 'LOWER_BOUND="31.0"')
    edit(folder / MISSION, 'speed="5.0"', 'speed="fast"')

    assert mend(inspect_folder(folder)) is None


@pytest.mark.parametrize(
    ("pattern", "deleted", "lost"),
    [
        (r'<robots ID="r1".*?</robots>', {"r1", "s1", "s2"}, {"g6", "a6", "m3", "m6", "m9", "m12"}),
        (r'<sensors ID="s4"[^>]*/>', {"s4"}, {"g4", "a4", "m10"}),
        (r'<servers ID="sv1"[^>]*/>', {"sv1"}, {f"m{k}" for k in range(1, 13)}),
        (r'<obstacles ID="o1">.*?</obstacles>', {"o1"}, set()),
    ],
    ids=["robot", "sensor", "server", "obstacle"],
)
def test_what_is_incomplete_without_a_deleted_element_is_deleted(folder, pattern, deleted, lost):
    path = folder / MISSION
    text = path.read_text(encoding="ascii")
    path.write_text(re.sub(rf" *{pattern}\n", "", text, count=1, flags=re.DOTALL), "ascii")
    before = _targets(folder)
    ids = _ids(path)
    found = inspect_folder(folder).diagnostics

    mending = _mended(folder)

    assert {each.constraint for each in found} == {"ResolvedReference"}
    assert [each for each, _ in mending.fixed] == [*found]
    for file, content in mending.contents.items():
        file.write_bytes(content)
    assert inspect_folder(folder).draft is not None
    assert ids - _ids(path) == lost
    gone = deleted | lost
    assert _targets(folder) == {
        fault: target for fault, target in before.items() if target not in gone
    }


def test_a_trigger_goes_with_its_goal_and_what_waits_for_it_too(folder):
    goal = '<goal href="mission.xmi#g{}"/>'.format
    declared = (
        f'<triggers ID="full" event="REACHED">{goal(4)}</triggers>'
        f'<triggers ID="low" event="VIOLATED">{goal(3)}</triggers>'
    )
    edit(folder / FAULTS, "</faults:F", f"{declared}</faults:F")
    edit(folder / FAULTS, 'ID="f30"', 'ID="f30" start="1" finish="2" trigger="full"')
    edit(folder / FAULTS, 'ID="f28"', 'ID="f28" start="1" finish="2" trigger="low"')
    path = folder / MISSION
    text = path.read_text(encoding="ascii")
    path.write_text(re.sub(r' *<sensors ID="s4"[^>]*/>\n', "", text), "ascii")
    before = _ids(folder / FAULTS)

    for file, content in _mended(folder).contents.items():
        file.write_bytes(content)

    assert inspect_folder(folder).draft is not None
    assert before - _ids(folder / FAULTS) >= {"full", "f30"}
    assert {"low", "f28"} <= _ids(folder / FAULTS)


def _ids(path: Path) -> set[str]:
    return {*re.findall(r'\bID="([^"]*)"', path.read_text(encoding="ascii"))}


def _targets(folder: Path) -> dict[str, str]:
    """Return what each fault of the pool is of, by their IDs."""
    text = (folder / FAULTS).read_text(encoding="ascii")
    return dict(re.findall(r'<faults ID="([^"]*)".*?#([^"]*)"', text, re.DOTALL))


def test_all_fixes_of_both_files_are_made_at_once(folder):
    edit(folder / FAULTS, 'LOWER_BOUND="11.0"', 'LOWER_BOUND="31.0"')
    edit(folder / FAULTS, 'ID="f2" name="f2"', 'ID="f2" name="f2" start="5" finish="4"')
    edit(folder / MISSION, 'ID="g2" name', 'ID="g2" dependentGoals="g2" name')

    mending = _mended(folder)

    assert [found.constraint for found, _ in mending.fixed] == [
        "GoalDependsOnOthers",
        "WindowOrdered",
        "RandomBoundsOrdered",
    ]
    assert list(mending.contents) == [folder / MISSION, folder / FAULTS]


def test_two_repeated_fields_in_one_line_leave_the_first(folder):
    body = '<body name="TEMPERATURE" type="{}"/>'
    edit(
        folder / MISSION,
        body.format("Int"),
        body.format("Int") + body.format("Double") + body.format("String"),
    )
    found = [one.constraint for one in inspect_folder(folder).diagnostics]
    assert found.count("UniqueMessageField") == 2

    mending = _mended(folder)

    assert mending.respelt == (folder / MISSION,)
    assert mending.contents[folder / MISSION].count(b'"TEMPERATURE"') == 2  # sensor and field
    assert body.format("Int").encode() in mending.contents[folder / MISSION]


@pytest.mark.parametrize(
    "changes",
    [
        {'"ASCII"': '"UTF-8"', 'name="LEN"': 'name="Löwe"'},
        {' name="': ' xsi:schemaLocation="http://mrsfi.org/mission/1.0 mission.ecore" name="'},
    ],
    ids=["encoding", "where the schemas are"],
)
def test_a_fix_keeps_how_the_file_is_written(folder, changes):
    path = folder / MISSION
    for old, new in changes.items():
        edit(path, old, new)
    before = path.read_bytes()
    edit(path, 'ID="g2"', 'ID="g2" dependentGoals="g2"')

    assert _mended(folder).contents[path] == before


@pytest.mark.parametrize("encoding", ["ASCII", "UTF-16"])
def test_a_fix_keeps_the_line_ends_of_the_file(folder, encoding):
    path = folder / MISSION
    text = path.read_text(encoding="ascii").replace("ASCII", encoding).replace("\n", "\r\n")
    head = b"\xfe\xff" if encoding == "UTF-16" else b""
    before, broken = (
        head + each.encode("UTF-16-BE" if head else encoding)
        for each in (text, text.replace('ID="g2"', 'ID="g2" dependentGoals="g2"'))
    )
    path.write_bytes(broken)

    mending = _mended(folder)

    assert mending.contents[path] == before
    assert len(mending.difference) < 20


def test_a_fix_changes_another_part_of_the_mission_than_the_one_that_has_the_defect(folder):
    edit(folder / MISSION, 'Collision" members="r2 r3 r1"', 'Collision" members="r2 r3"')
    models = load_mission_folder(folder)
    write_split(folder, models, PARTS["goals_and_tasks"](models))

    mending = _mended(folder)

    assert [found.path for found, _ in mending.fixed] == [folder / "tasks.xmi"]
    assert list(mending.contents) == [folder / "goals.xmi"]
    assert '+    <members href="mission.xmi#r1"/>' in mending.difference


def test_a_specification_is_mended_without_touching_its_mission(folder):
    path = folder / FAULTS
    before = path.read_bytes()
    edit(path, 'LOWER_BOUND="11.0" UPPER_BOUND="30.0"', 'LOWER_BOUND="30.0" UPPER_BOUND="11.0"')

    mending = mend(inspect_specification(path))

    assert mending is not None
    assert mending.contents == {path: before}


def test_a_file_without_a_fix_is_left_as_it_is_spelt(folder):
    edit(folder / MISSION, "<servers ", "<!-- ashore -->\n  <servers ")
    edit(folder / FAULTS, 'LOWER_BOUND="11.0"', 'LOWER_BOUND="31.0"')

    assert list(_mended(folder).contents) == [folder / FAULTS]


def _n_calls(work: Callable[[], Any]) -> int:
    """Return how many functions of Python are called."""
    count = 0

    def counted(frame: Any, event: str, argument: Any) -> None:
        nonlocal count
        count += event == "call"

    before = sys.getprofile()
    sys.setprofile(counted)
    try:
        work()
    finally:
        sys.setprofile(before)
    return count


def _with_faults(folder: Path, n_faults: int) -> Path:
    """Return a mission folder whose faults all finish before they start."""
    models = copy_models(folder)
    path = models / FAULTS
    text = path.read_text(encoding="utf-8")
    fault = re.search(r'  <faults ID="f2".*?</faults>\n', text, re.DOTALL)
    assert fault is not None
    one = fault[0].replace('name="f2"', 'name="f2" start="9" finish="8"')
    many = "".join(one.replace('ID="f2"', f'ID="more{n}"') for n in range(n_faults))
    path.write_text(text.replace(fault[0], fault[0] + many), encoding="utf-8")
    return models


def test_a_plan_of_generation_grows_as_the_fleet(tmp_path):
    calls = []
    for n_robots in (15, 15, 60):  # the first fills caches
        rng, of = Random(1), shape(n_robots, 3)
        folder = tmp_path / str(len(calls))
        models = write_drawn(folder, rng, of, 100)
        calls.append(_n_calls(lambda at=models: plan(at, at / "fresh")))

    assert calls[2] < 4.5 * calls[1]


def test_mending_grows_as_the_defects(tmp_path):
    calls = []
    for n_faults in (100, 100, 400):
        inspection = inspect_folder(_with_faults(tmp_path / str(len(calls)), n_faults))
        calls.append(_n_calls(lambda found=inspection: mend(found)))
        assert len(inspection.diagnostics) == n_faults

    assert calls[2] < 4.5 * calls[1]


def test_a_robot_is_as_wide_for_constraints_as_in_flight():
    robot = load_metamodels().mission.getEClassifier("Robot")()
    flown = Robot("r1", "", Coordinates(), 1.0)

    assert robot.radius == flown.radius
