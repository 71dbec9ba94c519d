"""What happens in a flight, for whatever writes it down."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import combinations

from mrsfi_runtime.kernel.flight import Verdicts, no_verdicts
from mrsfi_runtime.kernel.geometry import distance
from mrsfi_runtime.kernel.injections import FaultTally
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.mission import ROBOT_RADIUS, Mission
from mrsfi_runtime.record.named_faults import NamedFault


class Kind(Enum):
    """What an event is about."""

    FAULT = "fault"
    COMMAND = "command"
    COLLISION = "collision"
    VERDICT = "verdict"


@dataclass(frozen=True, slots=True)
class Event:
    """What happens to something at a tick, in words."""

    kind: Kind
    subject: str
    said: str

    def __str__(self) -> str:
        return f"{self.subject}: {self.said}"


class Events:
    """Tells what happens in a flight, tick by tick from the first.

    That is the first and the last tick at which a fault is active, and the first at which it
    changes something; changes of speed, heading and activation, the beginning and end of collisions
    and goal violations (true ones, and whether they are believed), and that a goal is from now on
    certain to be missed. ``tallies`` say what each fault does, and are filled before the first
    tick.
    """

    def __init__(
        self,
        mission: Mission,
        faults: Sequence[NamedFault] = (),
        tallies: Sequence[FaultTally] = (),
    ) -> None:
        self._mission = mission
        self._faults = faults
        self._tallies = tallies
        self._known = {
            subject: fact for _, subject, fact in self._judged(no_verdicts(len(mission.goals)))
        }

    def at(self, world: State, verdicts: Verdicts) -> Iterator[Event]:
        """Yield what happens at the next tick."""
        yield from self._of_faults(world.mission.tick)
        for kind, subject, fact in (*self._facts(world), *self._judged(verdicts)):
            before = self._known.get(subject, fact)
            self._known[subject] = fact
            if before != fact:
                yield Event(kind, subject, f"{before} -> {fact}")

    def _of_faults(self, tick: int) -> Iterator[Event]:
        for fault, tally in zip(self._faults, self._tallies, strict=True):
            what = f"fault {fault.fault.id} {fault.words}"
            if fault.window is None:
                if tick == fault.timed.start:
                    yield Event(Kind.FAULT, what, "is active at no tick")
                continue
            first, last = fault.window
            if tick == first:
                values = f" with {fault.values}" if fault.values else ""
                yield Event(Kind.FAULT, what, f"starts ({first} … {last}){values}")
            if tick == tally.first_changed:
                yield Event(Kind.FAULT, what, "first changes something")
            if tick == last:
                yield Event(Kind.FAULT, what, "ends")

    def _facts(self, world: State) -> Iterator[tuple[Kind, str, str]]:
        """Yield what is worth an event when it changes, as subject and value."""
        mission = self._mission
        for index, robot in enumerate(mission.robots):
            command = world.commands[index]
            degrees = math.degrees(math.atan2(command.heading_y, command.heading_x)) % 360.0
            yield Kind.COMMAND, f"{robot.id} speed", f"{world.robots[index].speed:g}"
            yield Kind.COMMAND, f"{robot.id} heading", f"{degrees:.1f} degrees"
        for k, sensor in enumerate(mission.sensors):
            is_on = world.sensors[k].active
            yield Kind.COMMAND, f"{sensor.id} activation", "on" if is_on else "off"
        for name, gap in self._gaps(world):
            yield Kind.COLLISION, f"collision of {name}", "yes" if gap < 0.0 else "no"

    def _judged(self, verdicts: Verdicts) -> Iterator[tuple[Kind, str, str]]:
        """Yield what is said of each goal; before the first tick, nothing is violated or missed."""
        for index, goal in enumerate(self._mission.goal_ids):
            for what, flag in (
                ("violated", verdicts.is_true[index]),
                ("believed violated", verdicts.is_believed[index]),
                ("missed", verdicts.missed[index]),
            ):
                yield Kind.VERDICT, f"{goal} {what}", "yes" if flag else "no"

    def _gaps(self, world: State) -> Iterator[tuple[str, float]]:
        """Yield the gap between the discs of every two robots, and of robots and obstacles."""
        robots = list(zip(self._mission.robots, world.robots, strict=True))
        for (first, a), (second, b) in combinations(robots, 2):
            gap = distance(a.x, a.y, b.x, b.y) - 2.0 * ROBOT_RADIUS
            yield f"{first.id} and {second.id}", gap
        for obstacle, area in zip(self._mission.obstacles, world.obstacles, strict=True):
            for robot, a in robots:
                gap = distance(a.x, a.y, area.model_x, area.model_y) - area.radius - ROBOT_RADIUS
                yield f"{robot.id} and {obstacle.id}", gap
