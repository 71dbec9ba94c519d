"""The recipes, one function each: what a contributor edits, and the flights that follow."""

import json
import re
import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from tests.recipes.tree import ENGINES, Tree
from tests.support.cli import MISSION, SMALL, edit
from tests.support.edited import write_body
from tests.support.own_metamodels import (
    a_class,
    add_classes,
    add_fault_type,
    add_faults,
    attribute,
    meaning,
    parameter,
)
from tests.support.tree import ROOT

MODELS = f"models/{MISSION}"
GENERATED = f"generated/{MISSION}"
SPECIFICATION = f"{MODELS}/own.xmi"
CASE = f"{MODELS}/case_own.toml"
MATERIAL = Path(__file__).parent / "material"
SUITE = "tests/conformance/test_transports.py"

_XMI = """<?xml version="1.0" encoding="ASCII"?>
<faults:FaultSpecification xmi:version="2.0" xmlns:xmi="http://www.omg.org/XMI" \
xmlns:faults="http://mrsfi.org/faults/1.0" ID="own">
  <faults ID="own1" name="own1" start="100" finish="700">{fault}</faults>
</faults:FaultSpecification>
"""

FAULTS_PAGE = ROOT / "docs" / "faults.md"
_, STUCK, _ = re.split(
    r" *# protected region StuckSpeed\.apply .*\n", FAULTS_PAGE.read_text(encoding="utf-8")
)
"""The region as the page shows it."""

LOITER = {
    "g7.check": """    robot = ci.robots[R1]
    return geometry.distance(robot.x, robot.y, 250.0, -250.0) > G7_RADIUS
""",
    "g7.react": """    guidance.approach(ci, R1, 250.0, -250.0)
""",
}


Digests: TypeAlias = Mapping[str, Mapping[str, str]]
"""For everything that was flown, the digest by what flew it."""


@dataclass(frozen=True, slots=True)
class Performed:
    """A recipe that was performed: files of the tool edited by hand, and digests of flights."""

    edited: list[str]
    digests: Digests


def perform(name: str, folder: Path) -> Performed:
    """Perform a recipe in a copy of the tree below a folder that does not exist yet."""
    tree = Tree(folder)
    digests = RECIPES[name](tree)
    edited = sorted(path for path in tree.edited if not path.startswith("models/"))
    return Performed(edited, digests)


def fault_type(tree: Tree) -> Digests:
    """Add a fault type of a known mode, a fault of it, and search with it."""
    fault = '<falseOdometer BY="3"><affectedRobot href="mission.xmi#r3"/></falseOdometer>'
    with tree.by_hand():
        add_fault_type(
            tree / "metamodels/faults.ecore",
            "FalseOdometer",
            "RobotFault",
            meaning(mode="INCREMENT", property="SPEED") + parameter("BY", "EInt", range="SPEED"),
        )
        _use_fault(tree, fault)
    _generate(tree)
    return _flown_with_faults(tree)


def own_effect(tree: Tree) -> Digests:
    """Add a fault type whose effect is a region: a speed report stuck at what it was at first."""
    fault = '<stuckSpeed OFFSET="0.5"><affectedMessage href="mission.xmi#m8"/></stuckSpeed>'
    with tree.by_hand():
        add_fault_type(
            tree / "metamodels/faults.ecore",
            "StuckSpeed",
            "MessageFault",
            meaning(mode="OWN", property="SPEED") + parameter("OFFSET", range="SPEED"),
        )
        _use_fault(tree, fault)
    _generate(tree, expected=4)
    with tree.by_hand():
        write_body(tree / f"{GENERATED}/fault_effects.py", "StuckSpeed.apply", STUCK)
    return _flown_with_faults(tree)


def goal_task(tree: Tree) -> Digests:
    """Add a goal task with an attribute, a goal of it, and the goal's two regions."""
    goal = (
        '<goals ID="g7" name="Loiter" members="r1">'
        '<task xsi:type="mission:Loiter" radius="160.0"/></goals>'
    )
    with tree.by_hand():
        add_classes(
            tree / "metamodels/mission.ecore",
            a_class("Loiter", "#//GoalTask", attribute("radius", "EDouble")),
        )
        edit(tree / f"{MODELS}/mission.xmi", "</mission:Mission>", f"  {goal}\n</mission:Mission>")
        _write_specification(tree, _STRAY)
    _generate(tree, expected=4)
    with tree.by_hand():
        for region, body in LOITER.items():
            write_body(tree / f"{GENERATED}/collective_intelligence.py", region, body)
    return _flown_with_faults(tree, goal="g7")


_STRAY = (
    '<fixedRobotCoordinates NEW_X="0.0" NEW_Y="500.0">'
    '<affectedMessage href="mission.xmi#m6"/></fixedRobotCoordinates>'
)


def fitness_function(tree: Tree) -> Digests:
    """Add a fitness function and a campaign file that names it."""
    with tree.by_hand():
        shutil.copy(MATERIAL / "own_fitness.py", tree.root)
        (tree / CASE).write_text('[search]\nfitness = "own_fitness:masked"\n', encoding="utf-8")
    return {"search": _searched(tree, "--case", "own")}


def algorithm(tree: Tree) -> Digests:
    """Add a whole search and a campaign file that names it."""
    with tree.by_hand():
        shutil.copy(MATERIAL / "own_algorithm.py", tree.root)
        (tree / CASE).write_text('[search]\nalgorithm = "own_algorithm:Walk"\n', encoding="utf-8")
    return {"search": _searched(tree, "--case", "own")}


def transport(tree: Tree) -> Digests:
    """Add a transport and a line for it in the table of its suite; run that, and fly over it."""
    with tree.by_hand():
        shutil.copy(MATERIAL / "json_text.py", tree / "src/mrsfi_runtime/transport")
        module = "mrsfi_runtime.transport"
        edit(
            tree / SUITE,
            f"from {module}.rosbridge import",
            f"from {module}.json_text import json_text_ends\nfrom {module}.rosbridge import",
        )
        edit(tree / SUITE, "TRANSPORTS = {\n", 'TRANSPORTS = {\n    "json": json_text_ends,\n')
    tested = tree.python("-m", "pytest", "-q", "-p", "no:cacheprovider", "-k", "[json]", SUITE)
    if " passed" not in tested:
        raise RuntimeError(tested)
    told = tree.python("-m", "tests.recipes.over_ends", MISSION, "json")
    return {"flight": json.loads(told)}


RECIPES: Mapping[str, Callable[[Tree], Digests]] = {
    "fault type": fault_type,
    "own effect": own_effect,
    "goal task": goal_task,
    "fitness function": fitness_function,
    "algorithm": algorithm,
    "transport": transport,
}


def _use_fault(tree: Tree, fault: str) -> None:
    """Put a fault into the pool, and write a specification of it alone."""
    add_faults(tree / f"{MODELS}/faults.xmi", {"own": fault})
    _write_specification(tree, fault)


def _write_specification(tree: Tree, fault: str) -> None:
    (tree / SPECIFICATION).write_text(_XMI.format(fault=fault), encoding="ascii")


def _generate(tree: Tree, expected: int = 0) -> None:
    """Generate all that ``make check`` compares; the first mission may have regions to fill."""
    tree.mrsfi("generate", MISSION, expected=expected)
    for models in sorted((tree / "models").iterdir()):
        if models.name != MISSION:
            tree.mrsfi("generate", models.name)
    tree.python("-m", "m2t.classes", "generated/metamodel")


def _flown_with_faults(tree: Tree, goal: str = "") -> Digests:
    """Fly the specification, which must act, and violate a goal if one is named, and search."""
    tree.mrsfi("validate", MISSION)
    tree.mrsfi("generate", MISSION, "--check")
    flown = {}
    for engine in ENGINES:
        found = tree.mrsfi_json("simulate", MISSION, "--faults", SPECIFICATION, "--engine", engine)
        if not all(fault["changed"] for fault in found["faults"]):
            message = f"the fault changes nothing: {found['faults']}"
            raise RuntimeError(message)
        if goal and not any(each["believed"] for each in found["goals"] if each["id"] == goal):
            message = f"goal {goal} is never violated: {found['goals']}"
            raise RuntimeError(message)
        flown[engine] = found["digest"]
    return {"flight": flown, "search": _searched(tree)}


def _searched(tree: Tree, *case: str) -> Mapping[str, str]:
    return {
        engine: tree.mrsfi_json(
            "evolve", MISSION, *case, *SMALL, "--engine", engine, "--out", f"runs/{engine}"
        )["digest"]
        for engine in ENGINES
    }
