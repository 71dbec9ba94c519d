"""Flies a mission twice, by the reference engine and by the independent simulation."""

import math
from collections.abc import Iterator

from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.generated_code import load_code
from tests.independent.digest import digest
from tests.independent.margins import Margins
from tests.independent.simulation import Flight, Mission, Timed, read_faults, read_triggers

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

    def __init__(self, models, generated, regions=None):
        self.mission = Mission(models / "mission.xmi")
        self.pool = read_faults(self.mission, models / "faults.xmi")
        self.triggers = read_triggers(self.mission, models / "faults.xmi")
        self.code = load_code(generated)
        self.n_digests = 0
        self._regions = REACTIONS.get(models.name, {}) | (regions or {})

    def timed(self, faults):
        """Return timed faults of the engine as those of the independent simulation."""
        pool, triggers = self.code.pool, self.triggers
        return [
            Timed(self.pool[pool[name].id], *window, values, triggers.get(trigger))
            for name, *window, values, trigger in faults
        ]

    def fly(self, faults, seed, timed=None, *, may_round=False):
        """Fly a specification twice, and name the first tick and field that differ.

        The pages do not state the order of every sum, so that last bits may differ. If they may,
        a digest is compared where the last moments have the same bits, and counted.
        """
        timed = self.timed(faults) if timed is None else timed
        flight = Flight(self.mission, timed, seed, self._regions)
        ticks = flight.fly()
        margins, differences, last = Margins(flight), [], []

        def watch(*moment):
            tick = next(ticks)
            margins.see()
            last[:] = zip(ours(flight), theirs(self.mission.goals, *moment), strict=True)
            if not differences:
                differences.extend(
                    f"tick {tick}, {name}: {value!r} by the pages, {other!r} in the engine"
                    for (name, value), other in last
                    if not is_same(value, other)
                )

        outcome = ReferenceEngine(self.code, seed).evaluate(faults, observer=watch)

        case = f"seed {seed}, {faults}"
        assert not differences, f"{differences[0]} (and {len(differences) - 1} more): {case}"
        assert next(ticks, "over") == "over"
        for name in MEASURES:
            assert tuple(flight.counts[name]) == getattr(outcome, name), f"{name}, {case}"
        assert tuple(flight.detection()) == outcome.detection, f"detection, {case}"
        assert tuple(notes.count for notes in flight.truth.notes) == outcome.samples, case
        for goal, margin in zip(self.mission.goals, outcome.margins, strict=True):
            assert margins.agree(goal, margin), f"margin {margin} of {goal.id}, {case}"
        assert tuple(each.applied for each in timed) == outcome.applied, case
        assert tuple(each.changed for each in timed) == outcome.changed, case
        if not may_round or all(value == other for (_, value), other in last):
            assert digest(flight) == outcome.digest, f"digest, {case}"
            self.n_digests += 1
        return outcome


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
        yield f"sent heading x of robot {k}", flight.belief.sent_heading[k][0]
        yield f"sent heading y of robot {k}", flight.belief.sent_heading[k][1]
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
    for command, sent in zip(belief.commands, world.commands, strict=True):
        yield from (command.heading_x, command.heading_y, sent.heading_x, sent.heading_y)
        yield from (command.speed, command.sent_speed)
    yield from (switch.active for switch in belief.switches)
    for k in range(len(goals)):
        yield from (verdicts.is_true[k], verdicts.is_believed[k])
        yield from (getattr(verdicts, name)[k] for name in MEASURES)


def is_same(one, two):
    """Numbers that grow by sums are the same within 1e-6, or 1e-12 of their size; others equal."""
    if isinstance(one, float) or isinstance(two, float):
        return math.isclose(one, two, rel_tol=1e-12, abs_tol=1e-6)
    return one == two
