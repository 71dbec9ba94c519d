"""One broken model per constraint: the right file, line, element and words."""

import pytest

from m2t.diagnostics import CONSTRAINTS
from m2t.models.load import inspect_folder, load_mission_folder
from mrsfi_runtime.errors import ModelError
from tests.support.broken_models import BROKEN, Broken
from tests.support.models.copies import FAULTS, MISSION, edit, line_of


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
    assert first.severity == CONSTRAINTS[broken.constraint].severity
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

    assert covered == set(CONSTRAINTS)


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
