"""Where effects of a team's own have regions: in missions whose pool has a fault of the type."""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from m2t.generate import generate
from m2t.metamodels import read_metamodels
from mrsfi_runtime.engine.reference import ReferenceEngine
from mrsfi_runtime.errors import SpecificationError
from mrsfi_runtime.mission import load_code
from mrsfi_runtime.model.faults import Fault, FaultPool, TimedFault
from tests.support.cli import MISSION, ROOT
from tests.support.own_metamodels import (
    add_fault_type,
    add_faults,
    copy_metamodels,
    meaning,
    metamodels_of,
)

STUCK = '<stuckSpeed><affectedMessage href="mission.xmi#m8"/></stuckSpeed>'


@pytest.fixture
def metamodels(tmp_path: Path) -> Path:
    """Return metamodels with a type whose effect is a team's own."""
    faults = copy_metamodels(tmp_path / "metamodels")
    add_fault_type(faults, "StuckSpeed", "MessageFault", meaning(mode="OWN", property="SPEED"))
    return faults.parent


def generated(folder: Path, metamodels: Path, *, has_fault: bool) -> str:
    models = shutil.copytree(ROOT / "models" / MISSION, folder / "models" / MISSION)
    if has_fault:
        add_faults(models / "faults.xmi", {"stuck": STUCK})
    with metamodels_of(metamodels):
        generate(models, folder / "generated")
    return (folder / "generated" / "fault_effects.py").read_text(encoding="utf-8")


def test_a_mission_whose_pool_has_a_fault_of_the_type_gets_a_region(
    tmp_path: Path, metamodels: Path
) -> None:
    text = generated(tmp_path, metamodels, has_fault=True)

    assert "# protected region StuckSpeed.apply on begin" in text


def test_any_other_mission_stays_as_it_was(tmp_path: Path, metamodels: Path) -> None:
    text = generated(tmp_path, metamodels, has_fault=False)

    committed = ROOT / "generated" / MISSION / "fault_effects.py"
    assert text == committed.read_text(encoding="utf-8")


def test_a_fault_whose_effect_the_mission_has_not_does_not_fly(metamodels: Path) -> None:
    code = load_code(ROOT / "generated" / MISSION)
    code = replace(code, mission=replace(code.mission, duration=5))
    stuck = Fault("stuck", read_metamodels(metamodels).fault_types["StuckSpeed"], "m8")
    engine = ReferenceEngine(code, 1)

    with pytest.raises(SpecificationError) as caught:
        engine.evaluate((TimedFault("stuck", 1, 3),), pool=FaultPool("own", (stuck,)))

    assert str(caught.value) == (
        "fault 'stuck' is of type StuckSpeed, whose effect is a region that fault_effects.py has "
        "only where the mission's pool has a fault of the type; add one to its faults.xmi and run "
        "`mrsfi generate`"
    )
