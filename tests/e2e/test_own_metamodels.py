"""Metamodels that a team has added to: missions that use the additions fly as before."""

import shutil
from pathlib import Path

import pytest

from m2t.metamodels import FAULTS_FILE, MISSION_FILE
from tests.support.cli import MISSION, ROOT, edit, mrsfi_process, workspace
from tests.support.own_metamodels import (
    a_class,
    add_classes,
    add_fault_type,
    add_faults,
    add_feature,
    attribute,
    meaning,
    parameter,
)
from tests.tiers import slow


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a project with metamodels and code of its own, as a clone has them."""
    for name in ("m2t", "metamodels"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    workspace(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    return tmp_path


def _require_flight(project: Path) -> None:
    mrsfi_process("validate", MISSION, cwd=project)
    mrsfi_process("generate", MISSION, cwd=project)
    mrsfi_process("simulate", MISSION, "--no-faults", cwd=project)


@slow
def test_team_adds_features(project):
    mission, faults = (project / "metamodels" / name for name in (MISSION_FILE, FAULTS_FILE))
    models = project / "models" / MISSION
    add_feature(mission, "Robot", attribute("colour") + attribute("tags", more='upperBound="-1"'))
    add_feature(mission, "Goal", attribute("start") + attribute("period"))
    add_feature(faults, "RandomSpeed", attribute("remark"))
    add_feature(faults, "Fault", attribute("weight", "EDouble"))
    edit(models / "mission.xmi", '<robots ID="r1"', '<robots ID="r1" colour="red"')
    edit(
        models / "mission.xmi",
        '<position x="250.0" y="-250.0"',
        '<tags>a</tags><tags>b</tags><position x="250.0" y="-250.0"',
    )
    edit(models / "mission.xmi", '<goals ID="g1"', '<goals ID="g1" start="dawn" period="day"')
    edit(models / "faults.xmi", "<randomSpeed", '<randomSpeed remark="x"')
    edit(models / "faults.xmi", 'ID="f24"', 'ID="f24" weight="2.0"')

    _require_flight(project)

    done = mrsfi_process("diff", ROOT / "models" / MISSION, models, cwd=project)
    assert done.stdout.splitlines() == [
        "robot r1: colour none → 'red'",
        "robot r1: tags none → 'a' 'b'",
        "goal g1: start none → 'dawn'",
        "goal g1: period none → 'day'",
        "fault f24: remark none → 'x'",
        "fault f24: weight 0.0 → 2.0",
    ]
    loader = (project / "generated" / MISSION / "fault_loader.py").read_text(encoding="utf-8")
    assert 'own={"weight": 2.0, "remark": "x"},' in loader


@slow
def test_team_adds_subclasses(project):
    mission, faults = (project / "metamodels" / name for name in (MISSION_FILE, FAULTS_FILE))
    models = project / "models" / MISSION
    add_classes(
        mission,
        a_class("Tagged", "", attribute("tag")),
        a_class("Glider", "#//Robot #//Tagged"),
        a_class("DeepSamples", "#//GatherSamples", attribute("area")),
    )
    add_classes(faults, a_class("WildSpeed", "#//RandomSpeed", attribute("wild")))
    edit(models / "mission.xmi", '<robots ID="r1"', '<robots xsi:type="mission:Glider" ID="r1"')
    edit(models / "mission.xmi", '"mission:GatherSamples"', '"mission:DeepSamples" area="reef"')
    edit(
        models / "faults.xmi",
        "<randomSpeed",
        '<randomSpeed xsi:type="faults:WildSpeed" wild="very"',
    )
    edit(
        models / "faults.xmi",
        "xmlns:faults=",
        'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xmlns:faults=',
    )

    _require_flight(project)

    done = mrsfi_process("diff", ROOT / "models" / MISSION, models, cwd=project)
    assert done.stdout.splitlines()[:3] == [
        "robot r1: class none → Glider",
        "goal g4: task GatherSamples → DeepSamples",
        "goal g4: task.area none → 'reef'",
    ]
    loader = project / "generated" / MISSION / "mission_loader.py"
    shipped = ROOT / "generated" / MISSION / "mission_loader.py"
    assert loader.read_bytes() == shipped.read_bytes()


@slow
def test_team_adds_parts_of_its_own(project):
    mission, faults = (project / "metamodels" / name for name in (MISSION_FILE, FAULTS_FILE))
    models = project / "models" / MISSION
    part = '<eStructuralFeatures xsi:type="ecore:EReference" containment="true" '
    add_classes(mission, a_class("Zone", "#//Identified", attribute("radius")))
    add_feature(mission, "Mission", f'{part} name="zones" eType="#//Zone" upperBound="-1"/>')
    add_classes(faults, a_class("Note", "", attribute("text")))
    add_feature(faults, "Fault", f'{part} name="note" eType="#//Note"/>')
    edit(
        models / "mission.xmi",
        "</mission:Mission>",
        '<zones ID="z" radius="wide"/></mission:Mission>',
    )
    edit(models / "faults.xmi", "</faults>", '<note text="x"/></faults>')

    _require_flight(project)


@slow
@pytest.mark.turn(0)
def test_team_writes_an_effect_of_its_own_in_two_files(project):
    content = meaning(mode="OWN", property="SPEED") + parameter("OFFSET", range="SPEED")
    add_fault_type(project / "metamodels" / FAULTS_FILE, "StuckSpeed", "RobotFault", content)
    stuck = '<stuckSpeed OFFSET="0.5"><affectedRobot href="mission.xmi#r3"/></stuckSpeed>'
    add_faults(project / "models" / MISSION / "faults.xmi", {"stuck": stuck})
    effects = project / "generated" / MISSION / "fault_effects.py"
    end = "    # protected region StuckSpeed.apply end\n"
    body = (
        "    if fault.age == 0:\n"
        "        fault.memory[0] = ci.robots[fault.target].speed\n"
        "    ci.robots[fault.target].speed = fault.memory[0] + fault.values[STUCK_SPEED_OFFSET]\n"
    )
    small = ("--population", "2", "--generations", "1", "--out", "runs/own")

    for command, expected in (("generate", 4), ("validate", 6), ("simulate", 6), ("evolve", 6)):
        done = mrsfi_process(command, MISSION, cwd=project, expected=expected)
        assert "region 'StuckSpeed.apply'" in done.stdout + done.stderr
    edit(effects, end, body + end)
    mrsfi_process("generate", MISSION, cwd=project)
    mrsfi_process("validate", MISSION, cwd=project)
    mrsfi_process("evolve", MISSION, *small, cwd=project)

    (kept,) = (project / "runs" / "own").rglob("fault_effects.py")
    assert kept.read_bytes() == effects.read_bytes()
