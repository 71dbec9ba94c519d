"""Bodies of regions: alike when compiled or not, and what is said of them."""

from pathlib import Path
from typing import NamedTuple

from mrsfi_runtime.engine.region_lint import NAMES
from tests.support.edited import write_region

IMPORTS = "import math\nimport random\nimport time\nimport numpy as np\n"
SWEEP = "values = []\nfor k in range(1000):\n    x = {}\n    values.append({})\nreturn values"
POSITIVE = "ci.robots[0].energy + k * 0.37"
UNIT = "(ci.robots[0].x + k) / 1600.0"


class Case(NamedTuple):
    """A body of a region, and the line of it that is remarked upon."""

    name: str
    body: str
    line: int = 0
    helpers: str = ""


def sweep(name, expression, x=POSITIVE):
    """Return a case that lists an expression for a thousand values of ``x``."""
    return Case(name, SWEEP.format(x, expression), 3)


DIFFERENT = [
    sweep("square", "x ** 2"),
    sweep("pow of a float", "pow(x, 3)"),
    sweep("math.pow", "math.pow(x, 3)"),
    sweep("root as a power", "x ** 0.5"),
    sweep("negative power", "x ** -2"),
    sweep("power of two", "2.0 ** (x / 100.0)"),
    Case("whole power below 0", "return 2 ** (ci.mission.tick - 1000)"),
    sweep("hypot", "math.hypot(x, k * 0.7)"),
    Case("random", "return random.random()"),
    Case("seeded random", "random.seed(3)\nreturn random.random() + ci.mission.tick"),
    Case("numpy.random", "return np.random.rand()"),
    Case("imported random", "return uniform(0.0, 1.0)", 0, "from random import uniform\n"),
    Case("identity", "return ci.sensors[0].count + 1000 is 1000 + ci.sensors[0].count"),
    Case("not identity", "return ci.mission.tick * 1000 is not ci.mission.tick * 1000"),
    Case("inverted comparison", "return 1 if ~(ci.robots[0].x > 0.0) else 2"),
    Case("rounding to digits", "return round(ci.sensors[0].count * 0.005, 2)"),
    Case(
        "set in a loop",
        "t = 0\nfor k in {64, 1, 33, ci.mission.tick}:\n    t = t * 7 + k\nreturn t",
        1,
    ),
    Case(
        "set by name",
        "seen = {5}\nfor s in ci.sensors:\n    seen.add(s.count)\nt = 0\n"
        "for k in seen:\n    t = t * 7 + k\nreturn t",
        4,
    ),
    Case("set popped", "q = {64, 1, 33, ci.mission.tick}\nreturn q.pop()", 1),
    Case("set listed", "return list({64, 1, 33, 1000, ci.mission.tick})[2]"),
    Case(
        "sorted by key",
        "q = sorted([s.count for s in ci.sensors for k in range(9)], key=lambda v: v % 2)\n"
        "return q[0] * 3 + q[1] * 5 + q[20] * 7 + q[30]",
    ),
    Case("record copied", "ci.commands[0] = ci.commands[1]\nci.commands[1].speed = 7.5\nreturn 1"),
    Case(
        "records exchanged",
        "ci.commands[0], ci.commands[1] = ci.commands[1], ci.commands[0]\nreturn 1",
    ),
    Case("float in a whole field", "ci.goals[0].count = ci.mission.tick / 2\nreturn 1"),
    Case("float added to a whole field", "ci.goals[0].count += 0.5\nreturn 1"),
    Case("float in a whole list of the state", "ci.chances[0] = 1.5\nreturn 1"),
    Case("float in a list of integers", "q = [0] * 3\nq[0] = ci.robots[0].x\nreturn q[0]", 1),
    Case("large literal", "return ci.mission.tick + 9223372036854775808"),
    Case("large constant", "return ci.mission.tick + BIG", 0, "BIG = 2**63\n"),
    Case("wide product", "return (ci.mission.tick + 2) * 9000000000000000000"),
    Case("wide shift", "return (ci.mission.tick * 1000000000) << 40"),
    Case("shift by a variable", "return 1 << ci.mission.tick % 100"),
    Case("text of a float", "return len(str(ci.robots[0].x))"),
    Case("formatted float", 'return len(f"{ci.robots[0].x}")'),
    Case("root of a difference", "return math.sqrt(ci.robots[0].x - ci.robots[1].x)"),
    Case("logarithm of a difference", "return math.log(ci.robots[0].x - ci.robots[1].x)"),
    Case("arc cosine", "return math.acos(ci.robots[0].x / 100.0)"),
]

ALIKE = [
    Case("division", "return ci.robots[0].x / ci.robots[1].y"),
    Case("floor division", "return ci.robots[0].x // 0.1 + ci.mission.tick // -7"),
    Case("remainder", "return ci.robots[0].x % -360.0 + -ci.mission.tick % 7"),
    Case("division by zero", "return 1 // (ci.mission.tick * 0)"),
    Case("float division by zero", "return ci.robots[0].x / (ci.robots[0].y * 0.0)"),
    Case("product for a square", "return ci.robots[0].x * ci.robots[0].x"),
    Case("whole power", "return ci.mission.tick ** 2 + 2 ** 10"),
    Case("root", "return math.sqrt(ci.robots[0].energy)"),
    Case("bounded root", "return math.sqrt(max(ci.robots[0].x - ci.robots[1].x, 0.0))"),
    sweep("trigonometry", "math.sin(x) + math.cos(x) + math.tan(x) + math.atan2(x, 3.0)"),
    sweep("exponential", "math.exp(-x / 100.0) + math.log(x)"),
    Case("rounding", "return round(ci.robots[0].x) + int(ci.robots[1].x)"),
    Case("negative zero", "return min(max(ci.robots[0].x, 0.0), -0.0)"),
    Case("not a number", "x = float('nan')\nreturn (min(x, 1.0) > 0.0) + 2 * (min(1.0, x) > 0.0)"),
    Case("masked product", "return (ci.mission.tick * 0x7FEB352D7FEB352D) & 0xFFFFFFFF"),
    Case("masked shift", "return (ci.mission.tick << 60) & 0xFFFFFFFF"),
    Case("membership", "return ci.mission.tick in {1, 2, 500}"),
    Case("none", "t = None\nif ci.mission.tick > 3:\n    t = 1.0\nreturn t is None"),
    Case("general exception", "try:\n    t = 1 // 0\nexcept Exception:\n    t = 2\nreturn t"),
    Case("record by index", "best = ci.robots[0]\nbest.speed = 3\nreturn best.speed / 2"),
    Case("whole field", "ci.goals[0].count = int(ci.robots[0].x)\nreturn 1"),
    Case("global tuple", "return LIMITS[1]", 0, "LIMITS = (1, 2.0)\n"),
    Case("plain code", "return F", 0, "F = tuple(math.hypot(k, 1) ** 2 for k in range(3))[2]\n"),
]


def named(cases):
    """Return the cases as arguments of ``parametrize``."""
    return {"argvalues": cases, "ids": [case.name for case in cases]}


SUMS = sweep("sum of floats", "sum([x, 0.1, -x, 0.2, x / 3.0])")
"""Differs from Python 3.12 on, whose ``sum`` makes up for what rounding loses."""

ARGUMENTS = {"arctan2": "x, 1.5", "power": "x, 0.66", "hypot": "x * 600.0, k * 0.7"}
SERIES = {"average", "mean", "nanmean", "nansum", "linalg.norm", "std", "sum", "var", "argsort"}


def call_of(name: str) -> Case:
    """Return a case that calls a function which the lint knows by name."""
    short = name.partition(".")[2]
    call = name.replace("numpy", "np")
    if short in SERIES:
        series = "np.array([float(int(x * j * 10.0) % 9) / 7.0 for j in range(60)])"
        expression = f"{call}({series}){'[30]' if short == 'argsort' else ''}"
    else:
        expression = f"{call}({ARGUMENTS.get(short, 'x')})"
    return Case(name, SWEEP.format(f"abs({UNIT})", expression), 3)


CALLS = [*map(call_of, NAMES)]


def written(folder: Path, case: Case) -> int:
    """Write the region of a case, and return the line that is remarked upon."""
    return write_region(folder, case.body, IMPORTS + case.helpers) + case.line
