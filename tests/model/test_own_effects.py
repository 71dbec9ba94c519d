"""Where effects of a team's own have regions: in missions whose pool has a fault of the type."""

from dataclasses import replace
from pathlib import Path

import pytest

from m2t.generate import generate
from m2t.metamodels import read_metamodels
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.errors import SpecificationError
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.faults import Fault, FaultPool, TimedFault
from tests.support.cli import MISSION, ROOT
from tests.support.own_metamodels import add_fault_type, copy_metamodels, meaning, metamodels_of


@pytest.fixture
def metamodels(tmp_path: Path) -> Path:
    """Return metamodels with a type whose effect is a team's own."""
    faults = copy_metamodels(tmp_path / "metamodels")
    add_fault_type(faults, "StuckSpeed", "MessageFault", meaning(mode="OWN", property="SPEED"))
    return faults.parent


def test_a_mission_whose_pool_has_no_fault_of_the_type_stays_as_it_was(tmp_path, metamodels):
    with metamodels_of(metamodels):
        generate(ROOT / "models" / MISSION, tmp_path / "generated")

    fresh, committed = (
        (folder / "fault_effects.py").read_bytes()
        for folder in (tmp_path / "generated", ROOT / "generated" / MISSION)
    )
    assert fresh == committed


def test_a_fault_whose_effect_the_mission_has_not_does_not_fly(metamodels, refused):
    code = load_code(ROOT / "generated" / MISSION)
    code = replace(code, mission=replace(code.mission, duration=5))
    stuck = Fault("stuck", read_metamodels(metamodels).fault_types["StuckSpeed"], "m8")
    engine = ReferenceEngine(code, 1)

    with refused(SpecificationError):
        engine.evaluate((TimedFault("stuck", 1, 3),), pool=FaultPool("own", (stuck,)))
