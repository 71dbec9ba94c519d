"""Programs of Epsilon set up as docs/epsilon.md says: models by their files, and stored."""

import re
from pathlib import Path
from typing import Any

from m2t.models.load import load_mission_folder, saved
from tests.interop.eclipse import ROOT, harness
from tests.support.models.copies import FAULTS, MISSION, copy_models, edit

PROGRAMS = Path(__file__).parent / "epsilon"
EVL = ROOT / "metamodels"
PAGE = ROOT / "docs" / "epsilon.md"


def _run(program: Path, *models: Path) -> dict[str, Any]:
    request = {"program": str(program), "models": [str(model) for model in models]}
    return harness("configured", request)


def test_what_a_script_of_epsilon_stores_is_saved_by_us_with_the_same_bytes(tmp_path):
    folder = copy_models(tmp_path)

    renamed = _run(PROGRAMS / "rename_robot.eol", folder / MISSION)
    checked = _run(EVL / "faults.evl", folder / FAULTS)

    assert renamed["printed"] == ["Ada"]
    assert checked["unsatisfied"] == []
    stored = {path: path.read_bytes() for path in (folder / MISSION, folder / FAULTS)}
    for content in stored.values():
        assert b" xsi:schemaLocation=" in content
    assert b'name="Ada"' in stored[folder / MISSION]
    assert stored == saved(load_mission_folder(folder))


def test_constraints_over_the_fault_model_alone_judge_the_mission_too_and_warn_of_nothing(tmp_path):
    folder = copy_models(tmp_path)
    edit(folder / MISSION, 'ID="g2"', 'ID="g2" dependentGoals="g2"')

    answer = _run(EVL / "faults.evl", folder / FAULTS)

    assert answer["warned"] == []
    assert [found["constraint"] for found in answer["unsatisfied"]] == ["GoalDependsOnOthers"]


def test_the_query_of_the_page_prints_what_the_page_says(tmp_path):
    page = PAGE.read_text(encoding="utf-8")
    (query, printed) = re.findall(r"```(?:eol|text)\n(.*?)```", page, re.DOTALL)
    program = tmp_path / "query.eol"
    program.write_text(query, encoding="utf-8")

    answer = _run(program, copy_models(tmp_path) / FAULTS)

    assert answer["warned"] == []
    assert answer["printed"] == printed.splitlines()


def test_constraints_over_two_models_warn_that_types_are_ambiguous(tmp_path):
    folder = copy_models(tmp_path)

    answer = _run(EVL / "faults.evl", folder / MISSION, folder / FAULTS)

    assert len(answer["warned"]) > 100
    assert all("is ambiguous" in warning for warning in answer["warned"])
