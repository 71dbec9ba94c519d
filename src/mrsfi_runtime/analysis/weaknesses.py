"""Put weaknesses into words and tables: which faults break which goal, and who detects it.

Names come before identifiers. A goal *fails* if its purpose is certainly not met, is *violated* if
it breaks in truth, and has a *false alarm* if it breaks only in what the collective intelligence
believes.

The tables come first, then failure modes (FMEA). ``verdicts`` returns a ``GoalVerdict``, a
sentence with its evidence, for each goal; ``deed`` puts a fault into words.
"""

import math
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import cache, lru_cache
from typing import NamedTuple

from mrsfi_runtime.analysis.tables import Cell, Table, as_csv, nearness, plain, to_markdown
from mrsfi_runtime.causes.cause_set import Column
from mrsfi_runtime.causes.chain import chains, local_effect
from mrsfi_runtime.causes.harvest import Harvest, Nearest
from mrsfi_runtime.causes.mildest import Way, least
from mrsfi_runtime.causes.weakness import MEASURES, Known
from mrsfi_runtime.engine.recording import Record
from mrsfi_runtime.errors import counted
from mrsfi_runtime.model.fault_types import OF_SENSOR, Field, Mode, Units
from mrsfi_runtime.model.faults import Fault, FaultPool, Specification, Target, robots_of, touched
from mrsfi_runtime.model.mission import Goal, Mission, starvation, with_id
from mrsfi_runtime.record.observers import NamedFault, named_faults
from mrsfi_runtime.record.store import NONE

_DOES = {
    "believed": ("violates it in belief only (a false alarm)", "violate it in belief"),
    "true": ("violates it", "truly violate it"),
    "missed": ("makes it fail", "make it fail"),
}
"""What one fault, and what several specifications do to a goal, by measure."""


def matrix_table(mission: Mission, pool: FaultPool, weaknesses: Sequence[Way]) -> Table:
    """Return a row for each fault that breaks a goal: the fault, its type, goals, what it touches.

    A cell has the share of forms that break the goal alone, by the gravest measure; or says that
    the fault does so jointly with others. Goals that nothing breaks are left out.
    """
    cells: dict[str, dict[str, str]] = {}
    targets: dict[str, str] = {}
    for way in weaknesses:
        for named in named_faults(mission, pool, way.shown.witness):
            targets[named.name] = named.target
            row = cells.setdefault(named.name, {})
            if len(way.faults) == 1:
                share = f"{100 * way.shown.share:.0f}%"
                is_believed = way.shown.column.kind == MEASURES[0]
                row[way.goal] = f"({share})" if is_believed else share + "*" * way.is_undetected
            else:
                row.setdefault(way.goal, "joint")
    goals = [goal for goal in mission.goal_ids if any(way.goal == goal for way in weaknesses)]
    rows = [
        (fault.id, fault.type, *map(cells[fault.id].get, goals), targets[fault.id])
        for fault in pool
        if fault.id in cells
    ]
    title = (
        "Share of tried variants in which the fault alone breaks the goal\n(n %): false alarm "
        "only; *: undetected in at least one variant; joint: only with other faults"
    )
    columns = ("fault", "type", *goals, "target")
    words, folded = (*columns[:2], columns[-1]), ("goals", goals)
    return Table(title, columns, rows, words, is_compact=True, spare=words[-1:], folded=folded)


def harmless(pool: FaultPool, weaknesses: Iterable[Way]) -> str:
    """Return in a sentence which faults of a pool are in none of all ways to break a goal."""
    guilty = {fault for way in weaknesses for fault in way.faults}
    rest = [fault.id for fault in pool if fault.id not in guilty]
    faults = counted(len(pool), "faults")
    if not rest:
        return f"Each of {faults} is part of a known weakness"
    are = "is" if len(rest) == 1 else "are"
    return f"{len(rest)} of {faults} {are} part of no known weakness: {', '.join(rest)}"


def way_table(title: str, mission: Mission, pool: FaultPool, weaknesses: Iterable[Way]) -> Table:
    """Return a row for each fault of each way, in the form that breaks the goal."""
    rows = []
    for way in weaknesses:
        shares = {each.column.kind: f"{100 * each.share:.0f}%" for each in way.by}
        shares[way.shown.column.kind] += "*" * way.is_undetected
        seeds = f"{way.shown.n_held}/{way.shown.n_seeds}"
        by = map(shares.get, MEASURES)
        head: tuple[Cell, ...] = (way.number, way.goal, *by, way.shown.since, seeds)
        for named in named_faults(mission, pool, way.shown.witness):
            window = f"{named.timed.start} … {named.timed.finish}"
            how = named.fault.type, window, named.target, named.values_in_words
            rows.append((*head, named.name, *how))
            head = ("", "and", *[""] * (len(head) - 2))
    folded = ("type", "window", "target", "values")
    columns = ("#", "goal", *MEASURES[:2], "failed", "since", "seeds", "fault", *folded)
    words, texts = ("#", "goal", "fault", *folded[::2]), folded[1::2]
    return Table(title, columns, rows, words, texts, is_compact=True, folded=("how", folded))


def not_found(known: Known, goal: str) -> str:
    """Return in a sentence how seldom a goal may break in a way that is not known."""

    def part(measure: str) -> str:
        column, does = Column(goal, measure), _DOES[measure][1]
        n = known.n_kept[column]
        least = f"at most {100 * known.bound(column):.1f} % {does} (0 of {n} did)"
        return least if n else f"no bound yet on those that {does}"

    truly, believed, missed = map(part, ("true", "believed", "missed"))
    return (
        f"Not found yet for {goal} (95 % confidence): of random specifications that contain none "
        f"of these sets, {truly}; {believed}; {missed}"
    )


def goal_in_words(mission: Mission, goal: str) -> str:
    """Return the name of a goal, if it has one, before its ID."""
    return with_id(mission.goals[mission.goal_ids.index(goal)])


def detection(way: Way, units: Units) -> str:
    """Return in a sentence whether the CI detects what breaks a goal."""
    if way.shown.column.kind == MEASURES[0]:
        return "It is a false alarm of the CI"
    found = way.shown.detection
    return found.in_words(units) if found else "Whether the CI detects it is not recorded"


def evidence(way: Way) -> str:
    """Return in a sentence in how many variants and mission seeds a way breaks its goal."""
    shown = way.shown
    variants, do = counted(shown.n_tried, "tried variants"), "does" if shown.n_tried == 1 else "do"
    return (
        f"{100 * shown.share:.0f} % of {variants} {do} so; this variant does so in {shown.n_held} "
        f"of {counted(shown.n_seeds, 'mission seeds')}"
    )


def broken_by(way: Way, units: Units) -> str:
    """Return in sentences by what a goal is broken, and from what on if that is known."""
    faults = f"{' and '.join(way.faults)} {'alone' if len(way.faults) == 1 else 'together'}"
    kind = way.shown.column.kind
    does, many = _DOES[kind]
    if len(way.faults) > 1:
        does = many.replace("truly ", "")
    said = [f"{faults} {does}", evidence(way), *([way.mildest.sentence] if way.mildest else [])]
    if kind != MEASURES[0]:
        said.insert(1, detection(way, units))
    return "".join(f"{each}. " for each in said).rstrip()


class FailureMode(NamedTuple):
    """A row of the table, of the form that breaks the goal by the gravest measure.

    ``number`` is that of the way, ``form`` whether that is the mildest one, or the one that is
    listed; ``measures`` and ``ticks`` say for how long the goal is broken by this form, by each
    measure and by the one that counts most, and ``detected`` how many variants are. ``occurrence``
    is the chance of all the faults, 0 … 1, as if none hung on another, if it is known.
    """

    number: int
    faults: str
    form: str
    item: str
    failure_mode: str
    local_effect: str
    end_effect: str
    measures: str
    detected: str
    severity: str
    ticks: int
    occurrence: float | None


def failure_modes(
    mission: Mission, pool: FaultPool, weaknesses: Sequence[Way], record: Record
) -> list[FailureMode]:
    """Return what weaknesses come to, by occurrence where it is known, then by severity.

    Severest is what lets a goal be missed, then what breaks it for longest.
    """
    fly, units = lru_cache(4)(record), mission.units

    @cache
    def flown(form: Specification) -> tuple[str, list[tuple[int, ...]]]:
        effects = (local_effect(mission, chain) or NONE for chain in chains(fly, mission, form))
        counts = (fly(form)[kind][-1].tolist() for kind in MEASURES)
        return "; ".join(effects), [*zip(*counts, strict=True)]

    def happens(named: NamedFault) -> str:
        window = f"{named.fault.type} from tick {named.timed.start} to {named.timed.finish}"
        return ", ".join(filter(None, (window, named.values_in_words)))

    def mode(way: Way) -> FailureMode:
        shown, place = way.at_least.shown, mission.goal_ids.index(way.goal)
        faults = named_faults(mission, pool, shown.witness)
        effect, counts = flown(shown.witness)
        chances = (pool[fault].likelihood for fault in way.faults)
        known = [chance for chance in chances if chance is not None]
        return FailureMode(
            number=way.number,
            faults=" ".join(way.faults),
            form="listed" if way.mildest is None else "mildest",
            item="; ".join(dict.fromkeys(each.target for each in faults)),
            failure_mode="; ".join(map(happens, faults)),
            local_effect=effect,
            end_effect=goal_in_words(mission, way.goal),
            measures=", ".join(map("{} {}".format, MEASURES, counts[place])),
            detected=detection(way, units),
            severity="missed" if shown.column.kind == "missed" else "violated",
            ticks=max(counts[place]),
            occurrence=math.prod(known) if len(known) == len(way.faults) else None,
        )

    def rank(mode: FailureMode) -> tuple[float, bool, int]:
        chance = 1.0 if mode.occurrence is None else -mode.occurrence
        return chance, mode.severity != "missed", -mode.ticks

    return sorted(map(mode, weaknesses), key=rank)


def modes_as_csv(_: str, modes: Sequence[FailureMode]) -> bytes:
    """Return failure modes as CSV."""
    return as_csv([FailureMode._fields, *modes])


def modes_as_markdown(mission: str, modes: Sequence[FailureMode]) -> bytes:
    """Return failure modes of a mission, by its name, as a page in Markdown."""
    title = f"Failure modes of mission {mission}"
    modes_table = Table(title, [name.replace("_", " ") for name in FailureMode._fields], modes)
    return f"# {plain(title)}\n\n{to_markdown(modes_table)}\n".encode()


class State(IntEnum):
    """What may become of a goal, the gravest first."""

    FAILS = 0
    VIOLATED = 1
    BROKEN_ANYWAY = 2
    FALSE_ALARM = 3
    HOLDS = 4


_STATES = {"missed": State.FAILS, "true": State.VIOLATED, "believed": State.FALSE_ALARM}
_WORDS = (
    "fails",
    "is violated",
    "is violated without any fault",
    "is violated in belief only (a false alarm)",
    "has no known weakness",
)
"""What stands for each state in a sentence."""

_DEEDS: Mapping[Mode, tuple[str, str]] = {
    Mode.DELAY: ("delayed by {first}", "late"),
    Mode.BLOCK: ("blocked", "blocked"),
    Mode.RANDOM: ("reported at random", "random"),
    Mode.ZERO: ("reported as 0", "zero"),
    Mode.FIXED: ("frozen{fixed}", "frozen"),
    Mode.INCREMENT: ("reported {first} too high", "too high"),
    Mode.DECREMENT: ("reported {first} too low", "too low"),
    Mode.INCREMENT_PERCENT: ("reported {first} too high", "too high"),
    Mode.DECREMENT_PERCENT: ("reported {first} too low", "too low"),
    Mode.STOP: ("stopped", "stopped"),
    Mode.START: ("forced to move", "moving"),
    Mode.DEACTIVATE: ("switched off", "off"),
    Mode.ACTIVATE: ("switched on", "on"),
    Mode.OWN: ("altered by {own}", ""),
}
"""What is done by a fault of each mode, after ``is``, and in a word or two."""


@dataclass(frozen=True, slots=True)
class GoalVerdict:
    """What is known of a goal: its state, the way that is told of, and how many others there are.

    ``label`` is the name before the ID. As the sentence goes on, ``cause`` says what does it and
    ``detection`` whether the CI detects it; ``strength`` in how many mission seeds and forms,
    ``unknown`` how seldom it may break otherwise, ``nearest`` how near a goal ever came to it that
    never truly breaks; each is empty where there is nothing to say.
    """

    goal: str
    name: str
    label: str
    state: State
    way: Way | None
    n_others: int
    cause: str
    detection: str
    strength: tuple[str, ...]
    bound: str
    nearest: str = ""

    @property
    def words(self) -> str:
        """The state."""
        return _WORDS[self.state]

    @property
    def sentence(self) -> str:
        """All but the evidence, in one or two sentences."""
        return f"{self.label} {self.words}{self.because}"

    @property
    def because(self) -> str:
        """By what it breaks, and whether that is detected, as a sentence goes on."""
        cause = f" {self.cause}" if self.cause else ""
        return f"{cause}. {self.detection}" if self.detection else cause

    @property
    def evidence(self) -> tuple[str, ...]:
        """The faults, how sure it is, what else breaks the goal, and what is unknown."""
        near = (self.nearest,) if self.nearest else ()
        if self.way is None:
            return (self.bound, *near)
        number = f"weakness {self.way.number}", " and ".join(self.way.faults)
        return (*number, *self.strength, *filter(None, (self.others,)), self.bound, *near)

    @property
    def others(self) -> str:
        """How many other weaknesses it has; empty if none."""
        return counted(self.n_others, "other weaknesses") if self.n_others else ""


def verdicts(mission: Mission, pool: FaultPool, known: Harvest) -> tuple[GoalVerdict, ...]:
    """Return what is known of each goal of a mission, the gravest first."""
    least_of = {way.goal: way for way in least(known.ways)}
    found = (_verdict(mission, pool, known, goal, least_of.get(goal.id)) for goal in mission.goals)
    return tuple(
        sorted(found, key=lambda each: (each.state, not (each.way and each.way.is_undetected)))
    )


def _verdict(
    mission: Mission, pool: FaultPool, known: Harvest, goal: Goal, way: Way | None
) -> GoalVerdict:
    unknown = max(known.known.bound(Column(goal.id, measure)) for measure in MEASURES)
    state = State.HOLDS if way is None else _STATES[way.shown.column.kind]
    of = known.yardstick
    fault_free = dict(zip(of.columns, of.most, strict=True)) if of else {}
    is_broken = any(fault_free.get(Column(goal.id, kind), 0) > 0 for kind in MEASURES[1:])
    if state in {State.FALSE_ALARM, State.HOLDS} and is_broken:
        state = State.BROKEN_ANYWAY
    cause = detected = ""
    strength: tuple[str, ...] = ()
    if state is State.BROKEN_ANYWAY:  # not by what it would break
        cause = starvation(mission, goal)
    elif way is not None:
        cause = f"if {cause_in_words(mission, pool, way)}"
        detected = "" if state is State.FALSE_ALARM else detection(way, mission.units)
    if way is not None:
        seeds = f"in {way.shown.n_held} of {counted(way.shown.n_seeds, 'mission seeds')}"
        strength = seeds, f"{100 * way.shown.share:.0f} % of tried variants"
    others = "other random specifications"
    limit = f"{others} that break it: at most {100 * unknown:.0f} % (95 % confidence)"
    return GoalVerdict(
        goal=goal.id,
        name=mission.name_of(goal),
        label=mission.label_of(goal),
        state=state,
        way=way,
        n_others=sum(each.goal == goal.id for each in known.ways) - (way is not None),
        cause=cause,
        detection=detected,
        strength=strength,
        nearest=_nearest_in_words(mission, goal, known.nearest.get(goal.id)),
        bound=limit if unknown < 1.0 else f"no bound yet on {others}",
    )


def _nearest_in_words(mission: Mission, goal: Goal, found: Nearest | None) -> str:
    if found is None:
        return ""
    evaluation = f"evaluation {found.evaluation}"
    if found.margin is None:
        return f"violated in {evaluation}, which no known weakness explains"
    least, tick = found.margin
    if least < 0.0:
        return f"violated at tick {tick} of {evaluation}, which no known weakness explains"
    near = nearness(mission, goal, found.margin)
    return f"closest approach: {near} from its limit, at tick {tick} of {evaluation}"


def cause_in_words(mission: Mission, pool: FaultPool, way: Way) -> str:
    """Say what has to happen for a way to break its goal."""
    faults = named_faults(mission, pool, way.shown.witness)
    off = way.mildest.off if way.is_mildest and way.mildest else ()
    pairs = zip(faults, off or [None] * len(faults), strict=True)
    return " and ".join(deed(mission, fault, apart) for fault, apart in pairs)


def sentence(mission: Mission, pool: FaultPool, way: Way) -> str:
    """Return in one or two sentences what a way does, to which goal, and who detects it."""
    goal = mission.label_of(mission.goals[mission.goal_ids.index(way.goal)])
    state = _STATES[way.shown.column.kind]
    said = f"{goal} {_WORDS[state]} if {cause_in_words(mission, pool, way)}"
    return said if state is State.FALSE_ALARM else f"{said}. {detection(way, mission.units)}"


def deed(mission: Mission, fault: NamedFault, off: str | None = None) -> str:
    """Say what a fault does and for how long; ``off``, if known, how far a fixed value is off."""
    kind, values, units = fault.fault.kind, fault.timed.values, fault.units
    is_frozen = kind.mode is Mode.FIXED
    subject, are = _subject(mission, fault.fault, "reported " * is_frozen)
    parameters = zip(values, kind.parameters, strict=True)
    one = re.compile(r"^(1 (?:energy unit|unit|tick|sample))s\b")
    words = [one.sub(r"\1", units.quantity(value, each.range)) for value, each in parameters]
    first = words[0].replace(" percent", " %") if words else ""
    fixed = apart = ""
    if off is None:
        fixed = f" at ({', '.join(words[:2])})" if kind.is_place else f" at {first}"
    elif off and is_frozen:
        apart = f", {_apart(mission, fault.fault, off.removesuffix(' off'))}"
    own = f"{kind.name} ({kind.in_words(values, units, 4)})" if values else kind.name
    done = _DEEDS[kind.mode][0].format(first=first, fixed=fixed, own=own)
    begin, end = fault.window or (0, -1)
    waits = "" if fault.trigger is None else f" at most, {fault.trigger.when}"
    n_ticks = min(end - begin + 1, fault.most)
    return f"{subject} {are} {done} for {units.ticks(n_ticks)}{waits}{apart}"


def _apart(mission: Mission, fault: Fault, off: str) -> str:
    """Say how far a fixed value is off."""
    if not fault.kind.is_place:
        return f"{off} from the true value when the fault begins"
    owner, _ = _owned(mission, touched(mission, fault)[0])
    unit = "" if mission.distance_unit else " units"
    return f"{off}{unit} from where {owner} is when the fault begins"


def _subject(mission: Mission, fault: Fault, reported: str = "") -> tuple[str, str]:
    """Return what a fault strikes, in names, and ``is`` or ``are``, which goes with it."""
    targets = touched(mission, fault)
    if not targets:
        return f"{fault.kind.struck.value} {fault.target}", "is"
    by_owner: dict[str, list[str]] = {}
    for target in targets:
        owner, what = _owned(mission, target)
        by_owner.setdefault(owner, []).append(what)
    parts = [
        f"{owner}'s {reported}{' and '.join(filter(None, what))}" if any(what) else owner
        for owner, what in by_owner.items()
    ]
    is_one = len(targets) == 1 and not parts[0].endswith("samples")
    return " and ".join(parts), "is" if is_one else "are"


def _owned(mission: Mission, target: Target) -> tuple[str, str]:
    """Return in names who has a property, and what it is called; nothing for a robot as a whole."""
    affected, index = target
    if affected is Field.OBSTACLE:
        return f"obstacle {mission.obstacles[index].id}", "place on the map"
    if affected not in {*OF_SENSOR, Field.ACTIVATION}:
        robot = mission.robots[index]
        return robot.name or robot.id, "" if affected is Field.MOTION else affected.name.lower()
    sensor, robot = mission.sensors[index], mission.robots[mission.sensor_robot[index]]
    owned = {Field.COUNT: "samples", Field.RATE: "rate", Field.COST: "cost", Field.ACTIVATION: ""}
    measured = sensor.type.lower().replace("_", " ")
    return robot.name or robot.id, f"{measured} {owned[affected]}".rstrip()


def owner_of(mission: Mission, fault: Fault) -> tuple[tuple[int, str], str]:
    """Return whom a fault strikes, by place and in names, and in two or three words what it does.

    Robots come in the mission's order, then what is of none.
    """
    targets = touched(mission, fault)
    does = _DEEDS[fault.kind.mode][1] or fault.kind.name
    robots = sorted(robots_of(mission, targets))
    what = " ".join(dict.fromkeys(_owned(mission, each)[1] for each in targets)) or fault.target
    if not targets or targets[0][0] in {Field.MOTION, Field.OBSTACLE}:
        what = fault.target if targets[:1] and targets[0][0] is Field.OBSTACLE else ""
    if not robots:
        return (len(mission.robots), "map"), f"{what} {does}".strip()
    robot = mission.robots[robots[0]]
    return (robots[0], with_id(robot)), f"{what} {does}".strip()


def headline(goals: Sequence[GoalVerdict]) -> str:
    """Say in a sentence how many goals break, and under how many faults."""
    broken = [each for each in goals if each.state <= State.VIOLATED]
    if not broken:
        return "No faults were found that break a goal"
    is_failing = all(each.state is State.FAILS for each in broken)
    verb = ("fail" if is_failing else "break") + "s" * (len(broken) == 1)
    alone = [each for each in broken if each.way is not None and len(each.way.faults) == 1]
    if len(alone) == len(broken):
        by = "under a single fault" if len(broken) == 1 else "each under a single fault"
    elif alone:
        by = f"{_number(len(alone))} of them under a single fault"
    else:
        by = "under several faults together"
    many = f"{_number(len(broken)).capitalize()} of {_number(len(goals))}"
    which = f"All {_number(len(goals))}" if len(broken) == len(goals) > 2 else many
    return f"{which} goals {verb}, {by}"


def facts(
    mission: Mission, pool: FaultPool, goals: Sequence[GoalVerdict], ways: Sequence[Way]
) -> Iterator[str]:
    """Yield what stands out, in sentences: what is not detected, what is worth protecting first."""
    unseen = [each.label for each in goals if each.way is not None and each.way.is_undetected]
    if unseen:
        yield f"Undetected in at least one variant: {', '.join(unseen)}"
    alarms = [each.label for each in goals if each.state is State.FALSE_ALARM]
    if alarms:
        yield f"False alarms only: {', '.join(alarms)}"
    struck: defaultdict[str, list[Way]] = defaultdict(list)
    for way in ways:
        if len(way.faults) == 1 and way.shown.column.kind != MEASURES[0]:
            struck[_subject(mission, pool[way.faults[0]])[0]].append(way)
    n_goals = {subject: len({way.goal for way in some}) for subject, some in struck.items()}
    first = max(struck, key=n_goals.__getitem__, default="")
    if n_goals.get(first, 0) > 1:
        by = ", ".join(sorted({way.faults[0] for way in struck[first]}))
        yield f"Protect first: {first} ({by}), which alone breaks {_number(n_goals[first])} goals"


def verdict_table(mission: Mission, pool: FaultPool, known: Harvest) -> Table:
    """Return a row for each goal: what becomes of it, by what, with the evidence."""
    found = verdicts(mission, pool, known)
    rows = [(each.sentence, " · ".join(each.evidence)) for each in found]
    columns = ("goal", "evidence")
    return Table(headline(found), columns, rows, texts=columns)


_NUMBERS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")


def _number(n: int) -> str:
    return _NUMBERS[n] if n < len(_NUMBERS) else str(n)
