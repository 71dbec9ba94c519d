"""A mission whose robots have hardly more energy than they need."""

import subprocess
import sys

import pytest

from m2t.generate import stale
from mrsfi_runtime.engine.reference import ReferenceEngine
from mrsfi_runtime.mission import load_code
from mrsfi_runtime.model.faults import TimedFault
from tests.support.world import ROOT
from tests.tiers import seeds

MODELS = ROOT / "models" / "tight_energy"
CODE = load_code(ROOT / "generated" / "tight_energy")
ENERGY = CODE.mission.goal_ids.index("energy")


def test_the_build_script_writes_the_committed_models(tmp_path):
    subprocess.run([sys.executable, MODELS / "build.py", tmp_path], check=True, cwd=ROOT)

    for name in ("mission.xmi", "faults.xmi"):
        assert (tmp_path / name).read_bytes() == (MODELS / name).read_bytes()


def test_the_generated_code_follows_from_the_models():
    assert stale(MODELS, CODE.directory) == ()


@pytest.mark.parametrize("seed", seeds(range(10)))
def test_without_faults_it_violates_no_goal(seed):
    outcome = ReferenceEngine(CODE, seed).evaluate(())

    assert (outcome.believed, outcome.true) == ((0,) * 6, (0,) * 6)


@pytest.mark.parametrize("kind", ["DecrementSpeed", "ZeroSpeed", "RandomSpeed"])
def test_a_false_report_of_speed_truly_costs_the_energy_that_is_needed(kind):
    (fault,) = [fault for fault in CODE.pool if fault.type == kind]
    timed = TimedFault(fault.id, 60, 340, fault.values)

    outcome = ReferenceEngine(CODE, 1).evaluate((timed,))

    assert outcome.true[ENERGY] > 100
