"""What would have caught it: monitors, judged on recorded flights.

A ``Monitor`` measures, at each tick, what the CI receives of an element against what it commanded,
or against the map and the data sheet in the model (``mrsfi_runtime.monitors``). It raises an
*alarm* while the measure exceeds a threshold. ``Heard`` is a recorded belief as monitors read it,
with arrays over all ticks in place of numbers: neither the truth nor a forged command.
``formulas`` has them compute on names in place of numbers.

Thresholds are fitted, for each element, to flights without faults: the largest measure there, and a
reserve of ``RESERVE`` of it, at least one tick or sample. So none of these flights raises an alarm.
Fresh flights show how often others do. A ``Watch`` has monitors with their thresholds.

A ``Case`` is a variant of a weakness in its recorded flight: from which tick on the goal is broken,
when the CI's own belief detects that, and the first alarms. As in ``kernel.flight.Verdicts``, a
goal is *broken* from its first true violation on, or from the tick at which it can no longer be
met, and a belief detects it from then on. An alarm claims that a report or an execution is wrong.
It is right from the first tick at which a fault changes a value. Detection is *in time* if it is no
later than the goal is broken.

The weight of a variant is the chance to draw it, as in ``weakness.Share``; of several faults, all
variants weigh the same. So each weakness counts by its share. ``Study.recommended`` adds monitors
one after the other: next is the one that brings the most weight in time. Begin with ``Watch``.
"""

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import chain
from types import FunctionType, ModuleType, SimpleNamespace
from typing import Any, NamedTuple, Self, TypeAlias

import numpy as np
import numpy.typing as npt

from mrsfi_runtime.causes.cause_set import Column
from mrsfi_runtime.causes.consequences import Addition, Advice, Coverage, Monitored
from mrsfi_runtime.causes.harvest import Harvest
from mrsfi_runtime.causes.mildest import GoalWeakness
from mrsfi_runtime.causes.weakness import MEASURES, Weakness, form
from mrsfi_runtime.engine.recording import Record, Recording
from mrsfi_runtime.kernel.flight import initial_state
from mrsfi_runtime.kernel.state import PROPERTIES, State, is_kernel
from mrsfi_runtime.model.fault_types import Field, Range, plain_name
from mrsfi_runtime.model.faults import Specification, Target
from mrsfi_runtime.model.mission import Mission, Obstacle, Robot, Sensor
from mrsfi_runtime.monitors import Monitor
from mrsfi_runtime.search.space import SearchSpace, drawn_as, draws

Values: TypeAlias = npt.NDArray[Any]
"""Values at each tick, of shape ``(n_ticks,)``."""

Measure: TypeAlias = Callable[[Any, int], Any]


def lifted(measure: Callable[..., Any], names: Mapping[str, Any]) -> Measure:
    """Return a kernel function that uses other values by ``names``, also in those it calls."""
    used = {*measure.__code__.co_names}

    def exchanged(name: str, value: Any) -> Any:
        if isinstance(value, ModuleType) and name not in names:
            inner = {
                each: exchanged(each, known) for each, known in vars(value).items() if each in used
            }
            return SimpleNamespace(**inner)
        return names.get(name, lifted(value, names) if is_kernel(value) else value)

    scope = {
        name: exchanged(name, each) for name, each in measure.__globals__.items() if name in used
    }
    return FunctionType(measure.__code__, {**names, **scope}, argdefs=measure.__defaults__)


@cache
def _over_ticks(measure: Measure) -> Measure:
    """Return a measure that takes arrays over all ticks in place of numbers."""
    return lifted(measure, {"math": np, "min": np.minimum, "max": np.maximum})


_ELEMENTS = ("robots", "sensors", "obstacles")
_REPORTS = {**PROPERTIES, Field.ACTIVATION: ("sensors", ("active",))}


class Heard:
    """What the CI has received and commanded in a flight, as monitors read it.

    In place of each number of a ``State`` it has an array over all ticks, except for indices. What
    a node did not receive stays as in the model.
    """

    def __init__(self, mission: Mission, seed: int, flight: Recording) -> None:
        belief, before = flight["belief"], initial_state(mission, seed)
        self.mission, self.n_ticks = before.mission, len(flight)
        now = {name: [*_elements(belief[name])] for name in _ELEMENTS}
        was = {name: [*_elements(belief[name], getattr(before, name))] for name in _ELEMENTS}
        for name, k, of_model in _not_received(before, flight.received):
            vars(now[name][k]).update(of_model)
            vars(was[name][k]).update(of_model)
        self.robots, self.sensors, self.obstacles = now.values()
        self.commands, self.switches = (
            [*_elements(belief[name], getattr(before, name))] for name in ("commands", "switches")
        )
        self.heard = [*chain(*was.values())]

    def measured(self, monitor: Monitor) -> list[Values]:
        """Return the measure of each element at each tick."""
        measure, places = _over_ticks(monitor.measure), range(len(getattr(self, monitor.elements)))
        found = [np.broadcast_to(measure(self, k), self.n_ticks) for k in places]
        return [*map(_in_a_row, found)] if monitor.unit is Range.TICKS else found


def _not_received(
    before: State, received: Container[Target] | None
) -> Iterator[tuple[str, int, dict[str, Any]]]:
    """Yield the list and index of an element, with its fields that are not received."""
    for affected, (name, columns) in _REPORTS.items():
        for k, own in enumerate(getattr(before, name)):
            if received is not None and (affected, k) not in received:
                yield name, k, {column: getattr(own, column) for column in columns}


_INDICES = {"first_sensor", "n_sensors", "gps", "robot"}


def _elements(listed: Any, before: Sequence[Any] = ()) -> Iterator[SimpleNamespace]:
    """Yield the fields of each element at all ticks; with ``before``, those of the tick before."""
    names = listed.dtype.names
    columns = {name: listed[name] for name in names}
    if before:
        first = {name: [[getattr(each, name) for each in before]] for name in names}
        columns = {name: np.concatenate([first[name], columns[name][:-1]]) for name in names}
    for k in range(columns[names[0]].shape[1]):
        found = {name: values[:, k] for name, values in columns.items()}
        yield SimpleNamespace(**found | {name: int(found[name][0]) for name in _INDICES & {*names}})


def _in_a_row(flags: Values) -> Values:
    """Return for how many ticks in a row a flag has been set."""
    ticks = np.arange(1, len(flags) + 1)
    return ticks - np.maximum.accumulate(np.where(flags, 0, ticks))


def _infix(form: str) -> Any:
    def joined(term: object, other: object) -> "_Term":
        return _Term(form.format(term, other))

    return joined


class _Term:
    """A term of past-time temporal logic, which grows as a measure is computed.

    Equality has a tolerance, since a margin of 0 is neither. A square names its base once:
    RTAMT computes a repeated ``prev`` twice in a tick.
    """

    def __init__(self, text: str) -> None:
        self._text = text

    def __str__(self) -> str:
        return self._text

    def __abs__(self) -> "_Term":
        return _Term(f"abs({self})")

    def __mul__(self, other: object) -> "_Term":
        return _Term(f"pow({self}, 2)" if other is self else f"({self} * {other})")

    __hash__ = None  # type: ignore[assignment]
    __eq__, __ne__ = map(_infix, ("(abs({} - {}) <= 1e-09)", "(abs({} - {}) > 1e-09)"))
    __lt__, __le__, __gt__, __ge__ = (
        _infix(f"({{}} {sign} {{}})") for sign in ("<", "<=", ">", ">=")
    )
    __add__, __sub__, __truediv__ = (_infix(f"({{}} {sign} {{}})") for sign in "+-/")
    __radd__, __rsub__, __rmul__ = (_infix(f"({{1}} {sign} {{0}})") for sign in "+-*")
    __and__, __or__ = map(_infix, ("({} and {})", "({} or {})"))


_ON_TERMS = {
    "math": SimpleNamespace(sqrt=lambda term: _Term(f"sqrt({term})")),
    "max": lambda a, b: _Term(f"(({a} + {b} + abs({a} - {b})) / 2)"),
    "min": lambda a, b: _Term(f"(({a} + {b} - abs({a} - {b})) / 2)"),
    "ordered": lambda ci, r: ci.robots[r].ordered,
    "left": lambda ci, r: ci.robots[r].left,
}
_SIGNALS = {"x", "y", "z", "speed", "energy", "count", "active", "rate", "cost"}
_SIGNALS |= {"heading_x", "heading_y", "ordered", "left"}


def _named(records: Iterable[Any], elements: Iterable[Robot | Sensor | Obstacle], name: str) -> Any:
    """Return records with a term in place of each signal; other fields stay numbers."""
    return [
        SimpleNamespace(
            **{field: getattr(record, field) for field in record.__slots__}
            | {field: _Term(name.format(plain_name(each.id), field)) for field in _SIGNALS}
        )
        for record, each in zip(records, elements, strict=True)
    ]


def formulas(watch: "Watch", name: str) -> dict[str, str]:
    """Return for each element when a monitor raises no alarm, in temporal logic as of RTAMT.

    Signal ``r1_x`` is field ``x`` of element ``r1``, ``r1_commanded_x`` that of its last command,
    ``r1_ordered`` and ``r1_left`` are what ``mrsfi_runtime.monitors`` calls so.
    """
    mission, state = watch.mission, initial_state(watch.mission, 0)
    heard: Any = (*mission.robots, *mission.sensors, *mission.obstacles)
    ci = SimpleNamespace(
        mission=state.mission,
        robots=_named(state.robots, mission.robots, "{}_{}"),
        sensors=_named(state.sensors, mission.sensors, "{}_{}"),
        obstacles=_named(state.obstacles, mission.obstacles, "{}_{}"),
        commands=_named(state.commands, mission.robots, "{}_commanded_{}"),
        switches=_named(state.switches, mission.sensors, "{}_commanded_{}"),
        heard=_named(state.heard, heard, "(prev({}_{}))"),
    )
    (monitor,) = (each for each in watch.monitors if each.name == name)
    measure, whole = lifted(monitor.measure, _ON_TERMS), "{} <= {!r}"
    if monitor.unit is Range.TICKS:
        whole = "not(historically[0:{1:.0f}]{0})"
    limits = watch.thresholds[name].items()
    return {id: whole.format(measure(ci, k), limit) for k, (id, limit) in enumerate(limits)}


RESERVE = 0.2
"""Share of the highest measure without faults by which a threshold exceeds it."""

_ROUNDING = 1e-6  # the least reserve of what is not counted; of a count it is 1

Thresholds: TypeAlias = Mapping[str, Mapping[str, float]]
"""Thresholds by the name of the monitor and the ID of the element."""

Alarms: TypeAlias = Mapping[str, Mapping[str, int]]
"""The tick of the first alarm by the name of the monitor and the ID of the element."""


@dataclass(frozen=True, slots=True)
class Watch:
    """Monitors of a mission, each with a threshold for each of its elements."""

    mission: Mission
    monitors: tuple[Monitor, ...]
    thresholds: Thresholds

    @classmethod
    def fitted(
        cls, mission: Mission, monitors: Sequence[Monitor], flights: Iterable[tuple[int, Recording]]
    ) -> Self:
        """Fit thresholds that no flight without faults exceeds; each follows its mission seed."""
        most = [[0.0] * len(getattr(mission, each.elements)) for each in monitors]
        for seed, flight in flights:
            heard = Heard(mission, seed, flight)
            for monitor, highest in zip(monitors, most, strict=True):
                highest[:] = (
                    max(before, float(values.max(initial=0.0)))
                    for before, values in zip(highest, heard.measured(monitor), strict=True)
                )
        thresholds = {
            monitor.name: {
                each.id: threshold(monitor.unit, value)
                for each, value in zip(getattr(mission, monitor.elements), highest, strict=True)
            }
            for monitor, highest in zip(monitors, most, strict=True)
        }
        return cls(mission, tuple(monitors), thresholds)

    def alarms(self, seed: int, flight: Recording, since: int = 0) -> Alarms:
        """Return the first alarms of a flight from a tick on, without monitors that raise none."""
        heard, found = Heard(self.mission, seed, flight), defaultdict[str, dict[str, int]](dict)
        for monitor in self.monitors:
            limits = self.thresholds[monitor.name]
            for (id, limit), values in zip(limits.items(), heard.measured(monitor), strict=True):
                over = np.flatnonzero(values[since:] > limit)
                if len(over):
                    found[monitor.name][id] = since + int(over[0])
        return found


def threshold(unit: Range, highest: float) -> float:
    """Return the threshold for the highest measure without faults; counts stay whole."""
    if unit in {Range.TICKS, Range.COUNT}:
        return highest + max(1.0, RESERVE * highest // 1.0)
    return highest + max(_ROUNDING, RESERVE * highest)


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
        """Return the place in ``consequences.STAGES`` of the detection."""
        tick = self.detected(names)
        if tick <= self.broken:
            return 0
        return 3 if tick == math.inf else 1 if tick < self.failed else 2


Breaking: TypeAlias = Mapping[Specification, Sequence[tuple[GoalWeakness, float]]]
"""The weaknesses of which each variant truly breaks the goal, with its weights."""


def breaking(space: SearchSpace, known: Harvest) -> Breaking:
    """Return the tried variants of weaknesses that truly break the goal."""
    broken = known.known.flown
    found = defaultdict[Specification, list[tuple[GoalWeakness, float]]](list)
    for weakness in known.goal_weaknesses:
        real = {Column(weakness.goal, kind) for kind in MEASURES[1:]}
        for variant, weight in _weights(space, known, weakness.shown):
            if not real.isdisjoint(broken[form(variant)]):
                found[variant].append((weakness, weight))
    return found


def cases(
    mission: Mission,
    variants: Breaking,
    record: Record,
    raised: Callable[[Recording, int], Alarms],
) -> Iterator[Case]:
    """Fly variants, and yield a case for each goal that one truly breaks.

    ``raised`` returns the alarms of a flight from a tick on.
    """
    for variant, some in variants.items():
        flight = record(variant)
        since = min((each.first_changed for each in flight.tallies if each.changed), default=0)
        alarms = raised(flight, max(0, since))
        for weakness, weight in some:
            place = mission.goal_ids.index(weakness.goal)
            yield Case(weakness, variant, weight, *verdict_ticks(flight, place), alarms)


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


def coverage(cases: Iterable[Case], names: Sequence[str]) -> Coverage:
    """Return the coverage of at least one case by the CI's belief and some monitors."""
    return Coverage.of([(each.stage(names), each.weight) for each in cases])


@dataclass(frozen=True)
class Study:
    """Monitors with their thresholds, the cases in which they were judged, and other flights.

    ``fresh`` has the alarms of flights without faults that fitted nothing, ``harmless`` those of
    flights of single faults that broke nothing. ``n_evaluations`` are those of the campaign.
    """

    watch: Watch
    cases: tuple[Case, ...]
    fresh: tuple[Alarms, ...]
    harmless: tuple[Alarms, ...]
    n_evaluations: int

    @cached_property
    def recommended(self) -> tuple[Addition, ...]:
        """Monitors to add, the one that gains most first, until none gains."""
        steps, names = list[Addition](), list[str]()
        while self.cases:
            best = max(self.watch.monitors, key=lambda each: self._reached([*names, each.name]))
            then = [*names, best.name]
            gaining = [each for each in self.cases if each.stage(then) < each.stage(names)]
            if not gaining:
                break
            raised = [each.alarms[best.name] for each in gaining]
            first = {id for each in raised for id in each if each[id] == min(each.values())}
            steps.append(Addition(best.name, tuple(sorted(first)), coverage(self.cases, then)))
            names = then
        return tuple(steps)

    @cached_property
    def advice(self) -> Advice:
        """What the campaign's record keeps; there is at least one case."""
        steps = self.recommended
        names, watched = [each.monitor for each in steps], dict[int, Monitored]()
        for weakness in {each.weakness.number: each.weakness for each in self.cases}.values():
            own = [each for each in self.cases if each.weakness == weakness]
            stages = {
                monitor: sum(each.stage(names[: place + 1]) for each in own)
                for place, monitor in enumerate(names)
            }
            late = sum(each.stage(()) for each in own)
            gains = [monitor for monitor, then in stages.items() if then < late]
            n_in_time = sum(each.stage(names) == 0 for each in own)
            watched[weakness.number] = Monitored("".join(gains[:1]), n_in_time, len(own))
        n_false = n_raised(self.fresh, names)
        before = coverage(self.cases, ())
        return Advice(self.n_evaluations, before, steps, watched, n_false, len(self.fresh))

    def _reached(self, names: Sequence[str]) -> tuple[float, ...]:
        """Return the weight that reaches each stage but the last, then fewest false alarms."""
        stages = [(each.stage(names), each.weight) for each in self.cases]
        reached = [math.fsum(weight for stage, weight in stages if stage <= k) for k in range(3)]
        return *reached, -float(n_raised(self.fresh, names))


def n_raised(flights: Iterable[Alarms], names: Iterable[str]) -> int:
    """Return in how many flights one of some monitors raises an alarm."""
    return sum(not raised.keys().isdisjoint(names) for raised in flights)
