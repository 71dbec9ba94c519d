"""Metamodels that a team has added to: missions that use the additions fly as before."""

import re
import shutil
from pathlib import Path

import pytest

from m2t.metamodels import FAULTS_FILE, MISSION_FILE
from tests.support.cli import MISSION, ROOT, edit, mrsfi_process, workspace

ECORE_TYPE = "ecore:EDataType http://www.eclipse.org/emf/2002/Ecore#//"


def _attribute(name: str, kind: str = "EString", more: str = "") -> str:
    return (
        f'<eStructuralFeatures xsi:type="ecore:EAttribute" name="{name}" '
        f'eType="{ECORE_TYPE}{kind}" {more}/>'
    )


def _subclass(name: str, parents: str, content: str = "") -> str:
    supertypes = f' eSuperTypes="{parents}"' if parents else ""
    return (
        f'<eClassifiers xsi:type="ecore:EClass" name="{name}"{supertypes}>{content}</eClassifiers>'
    )


def _add_feature(path: Path, class_name: str, feature: str) -> None:
    text = path.read_text(encoding="utf-8")
    start = text.index(f'<eClassifiers xsi:type="ecore:EClass" name="{class_name}"')
    end = text.index("</eClassifiers>", start)
    path.write_text(text[:end] + feature + text[end:], encoding="utf-8")


def _add_classes(path: Path, *classes: str) -> None:
    edit(path, "</ecore:EPackage>", f"{''.join(classes)}</ecore:EPackage>")


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


def test_team_adds_features(project: Path) -> None:
    mission, faults = (project / "metamodels" / name for name in (MISSION_FILE, FAULTS_FILE))
    models = project / "models" / MISSION
    _add_feature(
        mission, "Robot", _attribute("colour") + _attribute("tags", more='upperBound="-1"')
    )
    _add_feature(mission, "Goal", _attribute("start") + _attribute("period"))
    _add_feature(faults, "RandomSpeed", _attribute("remark") + _attribute("weight", "EDouble"))
    edit(models / "mission.xmi", '<robots ID="r1"', '<robots ID="r1" colour="red"')
    edit(
        models / "mission.xmi",
        '<position x="250.0" y="-250.0"',
        '<tags>a</tags><tags>b</tags><position x="250.0" y="-250.0"',
    )
    edit(models / "mission.xmi", '<goals ID="g1"', '<goals ID="g1" start="dawn" period="day"')
    edit(models / "faults.xmi", "<randomSpeed", '<randomSpeed remark="x" weight="2.0"')

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


def test_team_adds_subclasses(project: Path) -> None:
    mission, faults = (project / "metamodels" / name for name in (MISSION_FILE, FAULTS_FILE))
    models = project / "models" / MISSION
    _add_classes(
        mission,
        _subclass("Tagged", "", _attribute("tag")),
        _subclass("Glider", "#//Robot #//Tagged"),
        _subclass("DeepSamples", "#//GatherSamples", _attribute("area")),
    )
    _add_classes(faults, _subclass("WildSpeed", "#//RandomSpeed", _attribute("wild", "EDouble")))
    edit(models / "mission.xmi", '<robots ID="r1"', '<robots xsi:type="mission:Glider" ID="r1"')
    edit(models / "mission.xmi", '"mission:GatherSamples"', '"mission:DeepSamples" area="reef"')
    edit(models / "faults.xmi", "<randomSpeed", '<randomSpeed xsi:type="faults:WildSpeed"')
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


def test_team_adds_parts_of_its_own(project: Path) -> None:
    mission, faults = (project / "metamodels" / name for name in (MISSION_FILE, FAULTS_FILE))
    models = project / "models" / MISSION
    part = '<eStructuralFeatures xsi:type="ecore:EReference" containment="true" '
    _add_classes(mission, _subclass("Zone", "#//Identified", _attribute("radius")))
    _add_feature(mission, "Mission", f'{part} name="zones" eType="#//Zone" upperBound="-1"/>')
    _add_classes(faults, _subclass("Note", "", _attribute("text")))
    _add_feature(faults, "Fault", f'{part} name="note" eType="#//Note"/>')
    edit(
        models / "mission.xmi",
        "</mission:Mission>",
        '<zones ID="z" radius="wide"/></mission:Mission>',
    )
    edit(models / "faults.xmi", "</faults>", '<note text="x"/></faults>')

    _require_flight(project)


def test_team_adds_a_fault_type_that_nothing_implements(project: Path) -> None:
    faults = project / "metamodels" / FAULTS_FILE
    models = project / "models" / MISSION
    part = '<eStructuralFeatures xsi:type="ecore:EReference" containment="true" '
    _add_classes(faults, _subclass("Jam", "#//RobotFault", _attribute("strength", "EDouble")))
    _add_feature(faults, "Fault", f'{part} name="jam" eType="#//Jam"/>')
    text = (models / "faults.xmi").read_text(encoding="ascii")
    jammed = re.sub(r"<(/?)stopRobot>", r"<\1jam>", text)
    assert jammed != text
    (models / "faults.xmi").write_text(jammed, encoding="ascii")

    mrsfi_process("generate", MISSION, cwd=project)
    small = ("--population", "2", "--generations", "1", "--engine", "reference")
    done = mrsfi_process("evolve", MISSION, *small, cwd=project, expected=5)

    assert "is of type 'Jam', of which the runtime knows no effect" in done.stderr
