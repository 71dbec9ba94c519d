"""Fault trees read by the real pfta: it computes from them the sets that went into them."""

import csv
import subprocess
import sys
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import pytest

from mrsfi_runtime.analysis.documents import as_pfta
from mrsfi_runtime.causes.mildest import goal_weaknesses
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Requirement
from tests.support.missing import skip
from tests.support.search import PAPER_FAULTS, paper_mission
from tests.support.weaknesses import weakness

N_ALONE = 27
"""Faults that are enough alone: many orders of their sums would never be computed."""

IDS = [fault.id for fault in PAPER_FAULTS]
SETS = {
    "g2": [*((fault,) for fault in IDS[:N_ALONE]), (IDS[-2], IDS[-1])],
    "g5": [(IDS[0],)],
}


@pytest.mark.parametrize("chance", [0.5, None])
def test_pfta_finds_the_same_minimal_cut_sets(tmp_path, chance):
    if find_spec("pfta") is None:
        skip("pfta is missing; pip install -e '.[interop]'")
    mission = paper_mission()
    hostile = 'a, "b": <c>\n- type: AND'
    goals = tuple(replace(each, name=hostile, requirements=("R 1",)) for each in mission.goals)
    pool = FaultPool("pool", tuple(replace(fault, likelihood=chance) for fault in PAPER_FAULTS))
    found = [weakness(goal, "true", *faults) for goal, sets in SETS.items() for faults in sets]
    found.append(weakness("g2", "missed", IDS[0], IDS[-1]))  # not minimal over both
    found.append(weakness("g1", "believed", IDS[0]))  # not real
    path = tmp_path / "trees.txt"
    required = (Requirement("R 1", hostile),)
    mission = replace(mission, goals=goals, requirements=required)
    path.write_bytes(as_pfta(mission, pool, goal_weaknesses(found)))

    done = subprocess.run(
        [sys.executable, "-m", "pfta.cli", path],
        capture_output=True,
        check=False,
        encoding="utf-8",
        timeout=60,
    )

    assert done.returncode == 0, done.stderr
    told = Path(f"{path}.out")
    gates = {each["id"]: each for each in _rows(told / "gates.tsv")}
    assert [name for name, each in gates.items() if each["is_paged"] == "True"] == [*SETS, "R_1"]
    assert [name for name, each in gates.items() if each["is_top_gate"] == "True"] == ["R_1"]
    of_both = SETS | {"R_1": [*dict.fromkeys((*SETS["g2"], *SETS["g5"]))]}
    for goal, sets in of_both.items():
        computed = [each["cut_set"].split(".") for each in _rows(told / "cut-sets" / f"{goal}.tsv")]
        assert sorted(map(sorted, computed)) == sorted(map(sorted, sets))


def _rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return [*csv.DictReader(file, delimiter="\t")]
