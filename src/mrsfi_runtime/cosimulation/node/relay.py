"""Commands that are no heading and speed: passed on to the team's world as they came.

Faults that delay or block a message that a server sends to a robot hold them back.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple, cast

from mrsfi_runtime.kernel.effects import note
from mrsfi_runtime.kernel.injections import Plan, longest
from mrsfi_runtime.model.fault_types import Mode
from mrsfi_runtime.model.faults import LAST, FaultPool, Specification
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.transport.topics import Payload, Publisher

if TYPE_CHECKING:
    from mrsfi_runtime.kernel.injections import InjectionState


class Held(NamedTuple):
    """A timed fault that holds back the commands of a robot: ``delay`` ticks, or for good at 0.

    One with a ``trigger``, by its place in the pool, does so at ``most`` ticks of its window.
    """

    fault: int
    robot: int
    start: int
    finish: int
    delay: int
    trigger: int
    most: int

    def window(self, plan: Plan) -> tuple[int, int]:
        """Return when it is active, as far as a flight has come."""
        if self.trigger < 0:
            return self.start, min(self.finish, self.start + self.most - 1)
        trigger = plan.triggers[self.trigger]
        begin = max(self.start, trigger.fired + 1 + trigger.delay)
        return begin, min(self.finish, begin + self.most - 1) if trigger.fired >= 0 else -1


def robot_held(mission: Mission, pool: FaultPool, fault: str) -> int | None:
    """Return the robot whose commands a fault of a pool holds back, if it does."""
    known = pool[fault]
    if known.kind.mode not in {Mode.DELAY, Mode.BLOCK}:
        return None
    message, _ = mission.message_goal[known.target]
    is_of_robot = message.sender in mission.robot_index
    return None if is_of_robot else mission.robot_index.get(message.receiver)


def held_commands(
    mission: Mission, pool: FaultPool, specification: Specification
) -> Iterator[Held]:
    """Yield the timed faults of a specification that hold commands back."""
    for number, timed in enumerate(specification):
        robot = robot_held(mission, pool, timed.fault)
        if robot is not None:
            kind, ticks = pool[timed.fault].kind, int(timed.values[0])
            delay = 0 if kind.mode is Mode.BLOCK else ticks
            place, most = -1, ticks if kind.mode is Mode.BLOCK else LAST
            if timed.trigger:
                place = [*pool.triggers_by_id].index(timed.trigger)
                most = longest(kind, timed.values, pool.triggers[place])
            if ticks > 0:
                yield Held(number, robot, timed.start, timed.finish, delay, place, most)


class Relay:
    """Passes on what a node said in a tick, the newest of each topic, when it has answered.

    ``publishers`` are those of the world by the node's topic, with the robot of each. ``held`` are
    the faults of the flight.
    """

    def __init__(self, publishers: Mapping[str, tuple[int, Publisher]]) -> None:
        self._publishers = publishers
        self.begin(())

    def begin(self, held: Sequence[Held]) -> None:
        """Begin a flight."""
        self._held = held
        self._said: dict[str, Payload] = {}
        self._under_way: list[tuple[int, str, Payload]] = []

    def take(self, topic: str, message: Payload) -> None:
        """Take a command."""
        self._said[topic] = message

    def pass_on(self, plan: Plan, tick: int) -> None:
        """Publish what is due in a tick, and hold back what faults do."""
        due = {name: message for when, name, message in self._under_way if when == tick}
        self._under_way = [each for each in self._under_way if each[0] > tick]
        said, self._said = self._said, {}
        for held in self._held:
            first, last = held.window(plan)
            if not first <= tick <= last:
                continue
            names = [name for name in said if self._publishers[name][0] == held.robot]
            note(plan, cast("InjectionState", held), tick, bool(names))
            for name in names:
                message = said.pop(name)
                if held.delay and tick + held.delay <= last:
                    self._under_way.append((tick + held.delay, name, message))
        for name, message in {**due, **said}.items():
            self._publishers[name][1](message)
