"""The reference engine flies as the independent simulation does, field by field and tick by tick.

``simulation.py`` was written from the pages alone. Where the two part, one of them does not do
what the pages say, or the pages do not say enough.
"""

import ast
import inspect
import math
import sys
from collections.abc import Iterator
from pathlib import Path
from random import Random

import pytest

from m2t.generate import generate
from m2t.specification import write_specification
from mrsfi_runtime.engine.reference import ReferenceEngine
from mrsfi_runtime.mission import load_code
from mrsfi_runtime.model.faults import TimedFault
from tests.independent import simulation
from tests.independent.simulation import Flight, Mission, Timed, read_faults, read_specification
from tests.support.models.shapes import draw_mission, draw_pool, draw_specification, shape, write
from tests.support.tree import ROOT
from tests.support.world import specification
from tests.tiers import seeds, slow

HARBOUR = Path(__file__).parent / "harbour"
"""A mission with all tasks and odd robots, and a pool of all types with odd targets."""
SHORT = ("tight_margins", "harbour")
LONG = ("uuv_sampling", "tight_energy")
MISSIONS = (*SHORT, *LONG)
N_SPECIFICATIONS = 25
SEEDS = (0, 1, 7, 2**32, 2**64 + 3, 123_456_789_012)
"""Mission seeds, of as many 32 bits as they take."""
SHAPES = {
    "one robot": (shape(1, 1, seed=14), 60),
    "three robots": (shape(3, 2, ("Visit", "GatherSamples"), seed=5), 60),
    "eleven robots": (shape(11, 4, ("AvoidCollision", "Patrol", "Track"), seed=1), 40),
    "thirty robots": (shape(30, 40, ("Stay",), seed=15), 20),
}
"""All nine tasks, maximum speeds and three messages a goal: shape, and the longest mission."""
MEASURES = ("believed", "true", "phantom", "masked", "missed")
NOTED = {"Patrol": "since", "Visit": "reached", "Track": "waypoint", "Stay": "reached"}
"""What the progress of a task's members is called on both sides."""


def hurry(goal, ci):
    """What the region `react_energy` of tight_margins does instead of the reference reaction."""
    left = max(ci.left, 1)
    for robot in goal.members:
        said = ci.mission.robots[robot]
        affordable = max((0.98 * ci.energy[robot] / left - ci.sensing(robot)) / said.cost, 0.0)
        wanted = min(1.5 * said.speed, affordable)
        ci.set_speed(robot, ci.sent_speed[robot] + wanted - ci.speed[robot])


REACTIONS = {"tight_margins": {"energy": hurry}}


class Twins:
    """A mission twice: as the independent simulation reads it, and as it is generated."""

    def __init__(self, models, generated):
        self.mission = Mission(models / "mission.xmi")
        self.pool = read_faults(self.mission, models / "faults.xmi")
        self.code = load_code(generated)
        self._reactions = REACTIONS.get(models.name)

    def timed(self, faults):
        """Return timed faults of the engine as those of the independent simulation."""
        pool = self.code.pool
        return [
            Timed(self.pool[pool[each.fault].id], each.start, each.finish, each.values)
            for each in faults
        ]

    def fly(self, faults, seed, timed=None):
        """Fly a specification twice, and name the first tick and field that differ."""
        timed = self.timed(faults) if timed is None else timed
        flight = Flight(self.mission, timed, seed, self._reactions)
        ticks = flight.fly()
        differences = []

        def watch(*moment):
            tick = next(ticks)
            if not differences:
                found = theirs(self.mission.goals, *moment)
                differences.extend(
                    f"tick {tick}, {name}: {value!r} by the pages, {other!r} in the engine"
                    for (name, value), other in zip(ours(flight), found, strict=True)
                    if not is_same(value, other)
                )

        outcome = ReferenceEngine(self.code, seed).evaluate(faults, observer=watch)

        case = f"seed {seed}, {faults}"
        assert not differences, f"{differences[0]} (and {len(differences) - 1} more): {case}"
        assert next(ticks, "over") == "over"
        for name in MEASURES:
            assert tuple(flight.counts[name]) == getattr(outcome, name), f"{name}, {case}"
        assert tuple(notes.count for notes in flight.truth.notes) == outcome.samples, case
        assert tuple(each.applied for each in timed) == outcome.applied, case
        assert tuple(each.changed for each in timed) == outcome.changed, case


@pytest.fixture(scope="module")
def harbour(tmp_path_factory):
    target = tmp_path_factory.mktemp("harbour")
    generate(HARBOUR, target)
    return Twins(HARBOUR, target)


@pytest.fixture
def twins(request):
    if request.param == "harbour":
        return request.getfixturevalue("harbour")
    return Twins(ROOT / "models" / request.param, ROOT / "generated" / request.param)


def ours(flight: Flight) -> Iterator[tuple[str, object]]:
    """Yield every field of a moment of the independent simulation, by name."""
    for side, view in (("true", flight.truth), ("believed", flight.belief)):
        for k, (x, y, z) in enumerate(view.position):
            fields = {"x": x, "y": y, "z": z, "speed": view.speed[k], "energy": view.energy[k]}
            yield from ((f"{side} {name} of robot {k}", value) for name, value in fields.items())
        for k in range(len(view.count)):
            for name in ("count", "active", "rate", "cost"):
                yield f"{side} {name} of sensor {k}", getattr(view, name)[k]
        for k, (x, y, _) in enumerate(view.obstacle):
            yield from ((f"{side} x of obstacle {k}", x), (f"{side} y of obstacle {k}", y))
        for goal in flight.mission.goals:
            notes = view.notes[goal.index]
            yield f"{side} count of goal {goal.id}", notes.count
            noted = getattr(notes, NOTED.get(goal.task, ""), {})
            yield from ((f"{side} progress of {k} in {goal.id}", noted[k]) for k in noted)
    for k, (x, y) in enumerate(flight.belief.heading):
        yield from ((f"heading x of robot {k}", x), (f"heading y of robot {k}", y))
        yield f"commanded speed of robot {k}", flight.belief.command[k]
        yield f"sent speed of robot {k}", flight.belief.sent_speed[k]
    for k, is_on in enumerate(flight.belief.switch):
        yield f"switch of sensor {k}", is_on
    for goal in flight.mission.goals:
        yield f"true violation of {goal.id}", flight.true[goal.index]
        yield f"believed violation of {goal.id}", flight.believed[goal.index]
        for name in MEASURES:
            yield f"ticks {name} of {goal.id}", flight.counts[name][goal.index]


def theirs(goals, world, belief, verdicts) -> Iterator[object]:
    """Yield the values of the same fields of a moment of the engine, in the same order."""
    for view in (world, belief):
        for robot in view.robots:
            yield from (robot.x, robot.y, robot.z, robot.speed, robot.energy)
        for sensor in view.sensors:
            yield from (sensor.count, sensor.active, sensor.rate, sensor.cost)
        for obstacle in view.obstacles:
            yield from (obstacle.x, obstacle.y)
        for said, goal in zip(goals, view.goals, strict=True):
            yield goal.count
            if said.task in NOTED:
                members = view.members[goal.first_member : goal.first_member + goal.n_members]
                yield from (getattr(member, NOTED[said.task]) for member in members)
    for command in belief.commands:
        yield from (command.heading_x, command.heading_y, command.speed, command.sent_speed)
    yield from (switch.active for switch in belief.switches)
    for k in range(len(goals)):
        yield from (verdicts.is_true[k], verdicts.is_believed[k])
        yield from (getattr(verdicts, name)[k] for name in MEASURES)


def is_same(one, two):
    """Numbers that grow by sums are the same within 1e-6, or 1e-12 of their size; others equal."""
    if isinstance(one, float) or isinstance(two, float):
        return math.isclose(one, two, rel_tol=1e-12, abs_tol=1e-6)
    return one == two


@pytest.mark.parametrize("seed", seeds(range(N_SPECIFICATIONS), 3))
@pytest.mark.parametrize("twins", MISSIONS, indirect=True)
def test_random_specifications_fly_alike(twins, seed):
    twins.fly(specification(twins.code, seed), SEEDS[seed % len(SEEDS)])


@pytest.mark.parametrize("twins", MISSIONS, indirect=True)
def test_missions_without_faults_fly_alike(twins):
    twins.fly((), 1)


@pytest.mark.parametrize(
    "twins", [*SHORT, *(pytest.param(name, marks=slow) for name in LONG)], indirect=True
)
def test_each_fault_alone_flies_alike(twins):
    n_ticks = twins.code.mission.duration
    for fault in twins.code.pool:
        twins.fly((TimedFault(fault.id, n_ticks // 6, n_ticks // 2, fault.values),), 1)


@pytest.mark.parametrize("n_ticks", [0.0, 0.5, 1.5, 2.5, 3.5, 1e6])
def test_ticks_of_delays_and_blocks_are_rounded_alike(harbour, n_ticks):
    harbour.fly((TimedFault("h1", 0, 60, (n_ticks,)), TimedFault("h2", 20, 90, (n_ticks,))), 3)


def test_what_was_falsified_is_kept_by_the_block_that_follows(harbour):
    false = TimedFault("h35", 20, 29, (30.0, 40.0, 0.0))
    blocked = TimedFault("h33", 30, 60, (12.0,))
    late = TimedFault("h1", 61, 90, (5.0,))

    harbour.fly((false, blocked, late), 4)


def test_specifications_in_xmi_are_read_and_fly_alike(harbour, tmp_path):
    faults = (TimedFault("h23", 10, 40, (1.5, -3.0, 0.25)), TimedFault("h15", 5, 99, (12.0,)))
    rows = [
        ("h23", 10, 40, {"NEW_X": 1.5, "NEW_Y": -3.0, "NEW_Z": 0.25}),
        ("h15", 5, 99, {"FIXED_VAL": 12.0}),
    ]
    path = tmp_path / "found.xmi"
    write_specification(HARBOUR, rows, path, identifier="found")

    harbour.fly(faults, 5, read_specification(harbour.mission, path))


def test_the_simulation_imports_nothing_of_the_product_and_is_short():
    text = inspect.getsource(simulation)
    nodes = list(ast.walk(ast.parse(text)))
    names = {each.name for node in nodes if isinstance(node, ast.Import) for each in node.names}
    names |= {str(node.module) for node in nodes if isinstance(node, ast.ImportFrom)}

    assert {name.split(".")[0] for name in names} - sys.stdlib_module_names == {"lxml"}
    assert len(text.splitlines()) < 700


@pytest.mark.parametrize("seed", seeds(range(5), 2))
@pytest.mark.parametrize("name", SHAPES)
def test_drawn_missions_fly_alike(tmp_path, name, seed):
    """Each under some drawn specifications, and each fault of its pool alone."""
    of, longest = SHAPES[name]
    rng = Random(f"{name} {seed}")
    models = write(tmp_path / "models", draw_mission(rng, of, longest), draw_pool(rng, of))
    generate(models, tmp_path / "generated")
    twins = Twins(models, tmp_path / "generated")

    for _ in range(10):
        twins.fly(draw_specification(rng, twins.code), rng.getrandbits(40))
    for fault in twins.code.pool:
        whole = TimedFault(fault.id, 0, twins.code.mission.duration - 1, fault.values)
        twins.fly((whole,), rng.getrandbits(40))
