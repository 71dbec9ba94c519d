"""What would have caught it: checks on what the CI receives, judged on recorded flights.

A ``Monitor`` measures, at each tick, what the CI receives of an element against what it commanded,
or against the map and the data sheet in the model. It raises an *alarm* while the measure exceeds a
threshold. Monitors read the belief of a recording alone: reports after delivery and faults, and the
commands that the CI gave itself. They read neither the truth nor a forged command.

Thresholds are fitted, for each element, to flights without faults: the largest measure there, and a
reserve of ``RESERVE`` of it, at least one tick or sample. So none of these
flights raises an alarm. Fresh flights show how often others do.

A ``Case`` is a variant of a weakness in its recorded flight: from which tick on the goal is broken,
when the CI's own belief detects that, and the first alarms. As in ``kernel.flight.Verdicts``, a
goal is *broken* from its first true violation on, or from the tick at which it can no longer be
met, and a belief detects it from then on. An alarm claims that a report or an execution is wrong.
It is right from the first tick at which a fault changes a value. Detection is *in time* if it is no
later than the goal is broken.

The weight of a variant is the chance to draw it, as in ``weakness.Share``; of several faults, all
variants weigh the same. So each weakness counts by its share. ``Study.recommended`` adds monitors
one after the other: next is the one that brings the most weight in time. Begin with ``MONITORS``.

References
----------
ISO 26262-5:2018, table 4: targets of diagnostic coverage, low, medium and high.
"""

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, NamedTuple, Self, TypeAlias

import numpy as np
import numpy.typing as npt

from mrsfi_runtime.causes.cause_set import Column
from mrsfi_runtime.causes.harvest import Harvest
from mrsfi_runtime.causes.mildest import GoalWeakness
from mrsfi_runtime.causes.weakness import MEASURES, Weakness, form
from mrsfi_runtime.engine.recording import Record, Recording
from mrsfi_runtime.model.fault_types import Range
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import Mission, wilson
from mrsfi_runtime.search.space import SearchSpace, drawn_as, draws

Values: TypeAlias = npt.NDArray[Any]
"""Values at each tick, of shape ``(n_ticks, n_elements)``."""


def _was(values: Values) -> Values:
    """Return the values of the tick before; the first tick has its own."""
    return np.concatenate([values[:1], values[:-1]])


def _step(values: Values) -> Values:
    return values - _was(values)


def _length(x: Values, y: Values | float = 0.0) -> Values:
    length: Values = np.hypot(x, y)
    return length


def _in_a_row(flags: Values) -> Values:
    """Return for how many ticks in a row, after the first, a flag has been set."""
    ticks = np.arange(len(flags))[:, None]
    return ticks - np.maximum.accumulate(np.where(flags & (ticks > 0), 0, ticks), axis=0)


@dataclass(frozen=True)
class _Heard:
    """What the CI has received and commanded in a flight, and the measures of the monitors."""

    mission: Mission
    robots: Mapping[str, Values]
    sensors: Mapping[str, Values]
    obstacles: Mapping[str, Values]
    commands: Mapping[str, Values]
    switches: Mapping[str, Values]

    def moved(self) -> Values:
        return _length(_step(self.robots["x"]), _step(self.robots["y"]))

    def had_energy(self) -> Values:  # a robot without any neither moves nor samples
        return _was(self.robots["energy"]) > 0.0

    def ordered(self) -> Values:  # the speed, by the command of the tick before
        speed = np.clip(_was(self.commands["speed"]), 0.0, self.robots["max_speed"])
        return np.where(self.had_energy(), speed, 0.0)

    def frozen(self) -> Values:
        return _in_a_row((self.moved() == 0.0) & (self.ordered() > 0.0))

    def silent(self) -> Values:
        names = ("x", "y", "z", "speed", "energy")
        is_same = np.logical_and.reduce([_step(self.robots[name]) == 0.0 for name in names])
        return _in_a_row(is_same & (self.ordered() > 0.0))

    def outside(self) -> Values:
        center, radius = self.mission.area.center, self.mission.area.radius
        off = _length(self.robots["x"] - center.x, self.robots["y"] - center.y)
        return np.maximum(off - radius, 0.0)

    def off_course(self) -> Values:
        x, y = (self.ordered() * _was(self.commands[f"heading_{axis}"]) for axis in "xy")
        return _length(_step(self.robots["x"]) - x, _step(self.robots["y"]) - y)

    def off_speed(self) -> Values:
        return _length(self.robots["speed"] - self.ordered())

    def off_distance(self) -> Values:
        return _length(self.robots["speed"] - self.moved())

    def imbalance(self) -> Values:
        n, sensors = len(self.mission.robots), self.sensors
        carried = np.eye(n)[[*self.mission.sensor_robot]].reshape(-1, n)
        sampling = sensors["active"] * sensors["nominal_rate"] * sensors["nominal_cost"]
        spent = self.robots["speed"] * self.robots["energy_per_distance"] + sampling @ carried
        left = _was(self.robots["energy"]) - np.where(self.had_energy(), spent, 0.0)
        return _length(self.robots["energy"] - np.maximum(left, 0.0))

    def disobeying(self) -> Values:
        is_other = self.sensors["active"] != _was(self.switches["active"])
        return _in_a_row(is_other & self.had_energy()[:, [*self.mission.sensor_robot]])

    def sampled(self) -> Values:
        return _length(_step(self.sensors["count"]))

    def idle(self) -> Values:
        return _in_a_row((self.sampled() == 0) & (self.sensors["active"] == 1))

    def off_sheet(self) -> Values:
        known = self.sensors
        return _length(known["rate"] - known["nominal_rate"], known["cost"] - known["nominal_cost"])

    def off_map(self) -> Values:
        rocks = self.obstacles
        return _length(rocks["x"] - rocks["model_x"], rocks["y"] - rocks["model_y"])


class Monitor(NamedTuple):
    """A check of each of the ``elements``, a list of a state: its measure, and the unit of it."""

    name: str
    elements: str
    unit: Range
    measure: Callable[[_Heard], Values]

    def of(self, flight: Recording, mission: Mission) -> dict[str, Values]:
        """Return the measure of each element by its ID, at each tick after the first."""
        lists = (flight["belief"][each.name] for each in fields(_Heard)[1:])
        measures = self.measure(_Heard(mission, *lists))[1:].T
        elements = getattr(mission, self.elements)
        return {each.id: values for each, values in zip(elements, measures, strict=True)}

    def threshold(self, highest: float) -> float:
        """Return the threshold for the highest measure without faults; counts stay whole."""
        if self.unit in {Range.TICKS, Range.COUNT}:
            return highest + max(1.0, RESERVE * highest // 1.0)
        return highest + max(_ROUNDING, RESERVE * highest)


MONITORS = (
    Monitor("position frozen", "robots", Range.TICKS, _Heard.frozen),
    Monitor("age of reports", "robots", Range.TICKS, _Heard.silent),
    Monitor("position range", "robots", Range.X, _Heard.outside),
    Monitor("position rate", "robots", Range.SPEED, _Heard.moved),
    Monitor("motion against command", "robots", Range.SPEED, _Heard.off_course),
    Monitor("speed against command", "robots", Range.SPEED, _Heard.off_speed),
    Monitor("speed against positions", "robots", Range.SPEED, _Heard.off_distance),
    Monitor("energy balance", "robots", Range.ENERGY, _Heard.imbalance),
    Monitor("switch against command", "sensors", Range.TICKS, _Heard.disobeying),
    Monitor("sample count frozen", "sensors", Range.TICKS, _Heard.idle),
    Monitor("sample count rate", "sensors", Range.COUNT, _Heard.sampled),
    Monitor("data sheet", "sensors", Range.RATE, _Heard.off_sheet),
    Monitor("map", "obstacles", Range.X, _Heard.off_map),
)
"""The built-in monitors; of two that gain the same, the earlier one is recommended."""

RESERVE = 0.2
"""Share of the highest measure without faults by which a threshold exceeds it."""

_ROUNDING = 1e-6  # the least reserve of what is not counted; of a count it is 1

Thresholds: TypeAlias = Mapping[str, Mapping[str, float]]
"""Thresholds by the name of the monitor and the ID of the element."""

Alarms: TypeAlias = Mapping[str, Mapping[str, int]]
"""The tick of the first alarm by the name of the monitor and the ID of the element."""


def fitted(mission: Mission, flights: Iterable[Recording]) -> Thresholds:
    """Return the thresholds that no flight of some without faults exceeds; at least one."""
    most = dict[Monitor, dict[str, float]]((each, {}) for each in MONITORS)
    for flight in flights:
        for each, highest in most.items():
            found = each.of(flight, mission)
            most[each] = {
                id: max(highest.get(id, 0.0), float(found[id].max(initial=0.0))) for id in found
            }
    return {
        each.name: {id: each.threshold(value) for id, value in highest.items()}
        for each, highest in most.items()
    }


def alarms(mission: Mission, thresholds: Thresholds, flight: Recording, since: int = 1) -> Alarms:
    """Return the first alarms of a flight from a tick on, without monitors that raise none."""
    found = defaultdict[str, dict[str, int]](dict)
    for each in MONITORS:
        for id, measures in each.of(flight, mission).items():
            over = np.flatnonzero(measures[since - 1 :] > thresholds[each.name][id])
            if len(over):
                found[each.name][id] = since + int(over[0])
    return found


STAGES = ("in time", "before the goal fails", "later", "never")
"""When it is detected that a goal is broken, the best first."""


class Case(NamedTuple):
    """A variant that truly breaks a goal, from a tick on, and when that is detected.

    ``failed`` is the tick at which the goal can no longer be met, ``believed`` that at which the
    CI's own belief detects it; both are infinite for never. ``weight`` is the variant's chance.
    """

    weakness: GoalWeakness
    variant: Specification
    weight: float
    broken: int
    failed: float
    believed: float
    alarms: Alarms

    def detected(self, names: Iterable[str]) -> float:
        """Return the tick of detection, by the belief or by one of some monitors."""
        raised = (self.alarms[name].values() for name in names if name in self.alarms)
        return min(self.believed, *map(min, raised), math.inf)

    def stage(self, names: Iterable[str]) -> int:
        """Return the place in ``STAGES`` of the detection."""
        tick = self.detected(names)
        if tick <= self.broken:
            return 0
        return 3 if tick == math.inf else 1 if tick < self.failed else 2


def cases(
    space: SearchSpace, known: Harvest, record: Record, thresholds: Thresholds
) -> Iterator[Case]:
    """Fly the tried variants of weaknesses, and yield one for each goal that it truly breaks."""
    mission, broken = space.gate.mission, known.known.flown
    wanted = defaultdict[Specification, list[tuple[GoalWeakness, float]]](list)
    for weakness in known.goal_weaknesses:
        real = {Column(weakness.goal, kind) for kind in MEASURES[1:]}
        for variant, weight in _weights(space, known, weakness.shown):
            if not real.isdisjoint(broken[form(variant)]):
                wanted[variant].append((weakness, weight))
    for variant, some in wanted.items():
        flight = record(variant)
        since = min((each.first_changed for each in flight.tallies if each.changed), default=1)
        raised = alarms(mission, thresholds, flight, max(1, since))
        for weakness, weight in some:
            place = mission.goal_ids.index(weakness.goal)
            yield Case(weakness, variant, weight, *verdict_ticks(flight, place), raised)


def _weights(
    space: SearchSpace, known: Harvest, weakness: Weakness
) -> Iterator[tuple[Specification, float]]:
    """Yield the tried variants of a weakness with their chances, whose sum is 1."""
    tried = known.known.tried(weakness.faults)[: weakness.n_tried]
    if weakness.weighted is None:
        yield from ((each, 1.0 / len(tried)) for each in tried)
        return
    chances = draws(space, *weakness.faults)
    ways = {each: drawn_as(space, *each) for each in tried if len(each) == 1}
    n_tried = Counter(ways.values())
    total = math.fsum(chances[way][0] for way in n_tried)
    yield from ((each, chances[way][0] / n_tried[way] / total) for each, way in ways.items())


def verdict_ticks(flight: Recording, place: int) -> tuple[int, float, float]:
    """Return the ticks from which on a goal is broken, has failed, and is believed violated."""
    names = ("broken", "missed", "is_believed")
    is_broken, is_failed, is_believed = (flight[name][:, place] > 0 for name in names)
    is_believed &= is_broken
    failed, believed = (
        float(each.argmax()) if each.any() else math.inf for each in (is_failed, is_believed)
    )
    return int(is_broken.argmax()), failed, believed


class Coverage(NamedTuple):
    """Shares of the weight of cases by the ``STAGES``, and the 95 % interval of those in time.

    The interval is Wilson's. Its number of trials is Kish's, so that each weighs the same.
    """

    in_time: float
    before_failure: float
    later: float
    never: float
    low: float
    high: float

    @classmethod
    def of(cls, cases: Sequence[Case], names: Sequence[str]) -> Self:
        """Return the coverage of at least one case by the CI's belief and some monitors."""
        weights = defaultdict[int, float](float)
        for each in cases:
            weights[each.stage(names)] += each.weight
        total = math.fsum(each.weight for each in cases)
        n = total**2 / math.fsum(each.weight**2 for each in cases)
        shares = [weights[stage] / total for stage in range(len(STAGES))]
        return cls(*(*shares, *wilson(n * shares[0], n)))

    @property
    def level(self) -> str:
        """The class of ISO 26262 that the share in time reaches."""
        levels = ((0.99, "high"), (0.9, "medium"), (0.6, "low"))
        return next((name for least, name in levels if self.in_time >= least), "none")


class Step(NamedTuple):
    """A monitor to add to those before, the elements at which it gains, and the coverage then."""

    monitor: str
    elements: tuple[str, ...]
    coverage: Coverage


@dataclass(frozen=True, slots=True)
class Study:
    """Monitors with their thresholds, the cases in which they were judged, and other flights.

    ``fresh`` has the alarms of flights without faults that fitted nothing, ``harmless`` those of
    flights of single faults that broke nothing.
    """

    mission: Mission
    thresholds: Thresholds
    cases: tuple[Case, ...]
    fresh: tuple[Alarms, ...]
    harmless: tuple[Alarms, ...]

    def recommended(self) -> tuple[Step, ...]:
        """Return monitors to add, the one that gains most first, until none gains."""
        steps, names = list[Step](), list[str]()
        while self.cases:
            best = max(MONITORS, key=lambda each: self._reached([*names, each.name]))
            then = [*names, best.name]
            gaining = [each for each in self.cases if each.stage(then) < each.stage(names)]
            if not gaining:
                break
            raised = [each.alarms[best.name] for each in gaining]
            first = {id for each in raised for id in each if each[id] == min(each.values())}
            steps.append(Step(best.name, tuple(sorted(first)), Coverage.of(self.cases, then)))
            names = then
        return tuple(steps)

    def _reached(self, names: Sequence[str]) -> tuple[float, ...]:
        """Return the weight that reaches each stage but the last, then fewest false alarms."""
        stages = [(each.stage(names), each.weight) for each in self.cases]
        reached = [math.fsum(weight for stage, weight in stages if stage <= k) for k in range(3)]
        return *reached, -float(n_raised(self.fresh, names))


def n_raised(flights: Iterable[Alarms], names: Iterable[str]) -> int:
    """Return in how many flights one of some monitors raises an alarm."""
    return sum(not raised.keys().isdisjoint(names) for raised in flights)
