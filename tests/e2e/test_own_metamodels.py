"""Metamodels that a team has added to: missions that use the additions fly as before."""

import re
import shutil
from pathlib import Path

import pytest

from m2t.metamodels import FAULTS_FILE, MISSION_FILE
from tests.support.cli import MISSION, ROOT, edit, mrsfi_process, workspace
from tests.support.own_metamodels import (
    a_class,
    add_classes,
    add_feature,
    attribute,
    part,
)
from tests.tiers import slow

AT_START = '<position x="250.0" y="-250.0"'
XSI = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
WILD = 'xsi:type="faults:WildSpeed"'


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a project with metamodels and code of its own, as a clone has them."""
    for name in ("m2t", "metamodels"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    workspace(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    return tmp_path


@slow
def test_team_adds_features_subclasses_and_parts(project, approved):
    mission, faults = (project / "metamodels" / name for name in (MISSION_FILE, FAULTS_FILE))
    models = project / "models" / MISSION
    add_feature(mission, "Robot", attribute("colour") + attribute("tags", more='upperBound="-1"'))
    add_feature(mission, "Goal", attribute("start") + attribute("period"))
    add_feature(mission, "Mission", part("zones", "Zone", 'upperBound="-1"'))
    add_feature(faults, "RandomSpeed", attribute("remark"))
    add_feature(faults, "Fault", attribute("weight", "EDouble") + part("note", "Note"))
    add_classes(
        mission,
        a_class("Tagged", "", attribute("tag")),
        a_class("Glider", "#//Robot #//Tagged"),
        a_class("DeepSamples", "#//GatherSamples", attribute("area")),
        a_class("Zone", "#//Identified", attribute("radius")),
    )
    add_classes(faults, a_class("WildSpeed", "#//RandomSpeed", attribute("wild")))
    add_classes(faults, a_class("Note", "", attribute("text")))
    for name, found, replaced in (
        (
            "mission.xmi",
            '<robots ID="r1"',
            '<robots xsi:type="mission:Glider" ID="r1" colour="red"',
        ),
        ("mission.xmi", AT_START, f"<tags>a</tags><tags>b</tags>{AT_START}"),
        ("mission.xmi", '<goals ID="g1"', '<goals ID="g1" start="dawn" period="day"'),
        ("mission.xmi", '"mission:GatherSamples"', '"mission:DeepSamples" area="reef"'),
        ("mission.xmi", "</mission:Mission>", '<zones ID="z" radius="wide"/></mission:Mission>'),
        ("faults.xmi", 'ID="f24"', 'ID="f24" weight="2.0"'),
        ("faults.xmi", "<randomSpeed", f'<randomSpeed {WILD} wild="very" remark="x"'),
        ("faults.xmi", "xmlns:faults=", f"{XSI} xmlns:faults="),
        ("faults.xmi", "</faults>", '<note text="x"/></faults>'),
    ):
        edit(models / name, found, replaced)

    for command in ("validate", "generate", "simulate"):
        mrsfi_process(command, MISSION, cwd=project)

    done = mrsfi_process("diff", ROOT / "models" / MISSION, models, cwd=project)
    told = done.stdout.splitlines()
    approved([line for line in told if not re.search("goal g[456]|: note", line)])
    approved([line for line in told if "goal g4" in line])
    generated = project / "generated" / MISSION
    loader = (generated / "fault_loader.py").read_text(encoding="utf-8")
    (own,) = re.findall(r'own=\{\s+("weight": 2.0,[^=]*"wild": "very")', loader)
    assert '"remark": "x"' in own
    shipped = ROOT / "generated" / MISSION / "mission_loader.py"
    assert (generated / "mission_loader.py").read_bytes() == shipped.read_bytes()
