"""Describe weaknesses in tables and sentences: which faults break which goal, and who detects it.

Names come before IDs. A goal *fails* when it can no longer be met. It is *violated* at a tick, in
truth. It has a *false alarm* if only the belief of the collective intelligence shows a violation.

The tables come first. ``verdicts`` returns a ``GoalVerdict`` for each goal: a sentence with its
evidence. ``deed`` describes a fault. Failure modes (FMEA) are in ``documents.py``.
"""

import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from itertools import accumulate
from pathlib import Path
from typing import Any

from mrsfi_runtime.analysis.tables import Cell, Table, nearness
from mrsfi_runtime.causes.cause_set import Column
from mrsfi_runtime.causes.confirmation import transfers
from mrsfi_runtime.causes.consequences import (
    Advice,
    Estimate,
    Risk,
    confirmed,
    ladder,
    risks,
)
from mrsfi_runtime.causes.harvest import Harvest, Nearest
from mrsfi_runtime.causes.mildest import GoalWeakness, least
from mrsfi_runtime.causes.weakness import MEASURES, Known, faults_of, form
from mrsfi_runtime.errors import counted
from mrsfi_runtime.model.fault_types import OF_SENSOR, Field, Mode, Units
from mrsfi_runtime.model.faults import Fault, FaultPool, Target, robots_of, touched
from mrsfi_runtime.model.mission import Goal, Mission, starvation, with_id
from mrsfi_runtime.record.observers import NamedFault, named_faults

_DOES = {
    "believed": ("violates it in belief only (a false alarm)", "violate it in belief"),
    "true": ("violates it", "truly violate it"),
    "missed": ("makes it fail", "make it fail"),
}
"""What one fault does to a goal, and what several specifications do, by measure."""


def matrix_table(mission: Mission, pool: FaultPool, weaknesses: Sequence[GoalWeakness]) -> Table:
    """Return a row for each fault of a weakness: the fault, its type, goals, what it touches.

    A cell has the share of the fault's variants that break the goal without other faults, by the
    gravest measure; or ``joint``. Goals without weaknesses are left out.
    """
    cells: dict[str, dict[str, str]] = {}
    targets: dict[str, str] = {}
    for weakness in weaknesses:
        for named in named_faults(mission, pool, weakness.shown.witness):
            targets[named.name] = named.target
            row = cells.setdefault(named.name, {})
            if len(weakness.faults) == 1:
                share = f"{100 * weakness.shown.share:.0f}%"
                is_believed = weakness.shown.column.kind == MEASURES[0]
                mark = "*" * weakness.is_undetected
                row[weakness.goal] = f"({share})" if is_believed else share + mark
            else:
                row.setdefault(weakness.goal, "joint")
    goals = [goal for goal in mission.goal_ids if any(each.goal == goal for each in weaknesses)]
    rows = [
        (fault.id, fault.type, *map(cells[fault.id].get, goals), targets[fault.id])
        for fault in pool
        if fault.id in cells
    ]
    title = (
        "Share of variants in which the fault alone breaks the goal\n(n %): false alarm "
        "only; *: undetected in at least one variant; joint: only with other faults"
    )
    columns = ("fault", "type", *goals, "target")
    words, folded = (*columns[:2], columns[-1]), ("goals", goals)
    return Table(title, columns, rows, words, is_compact=True, spare=words[-1:], folded=folded)


def harmless(pool: FaultPool, known: Harvest) -> str:
    """Return in a sentence which faults of a pool are part of no weakness.

    Each is listed with the number of variants in which the fault alone changed a value.
    """
    guilty = {fault for each in known.goal_weaknesses for fault in each.faults}
    rest = [fault.id for fault in pool if fault.id not in guilty]
    faults = counted(len(pool), "faults")
    if not rest:
        return f"Each of {faults} is part of a known weakness"
    are = "is" if len(rest) == 1 else "are"
    acting = {form(each) for each, outcome in known.outcomes.items() if any(outcome.changed)}
    n_alone = Counter(map(faults_of, acting))
    first, *others = ((fault, n_alone[frozenset([fault])]) for fault in rest)
    listed = [f"{first[0]} (alone in {counted(first[1], 'variants')})"]
    listed += [f"{fault} ({n})" for fault, n in others]
    return f"{len(rest)} of {faults} {are} part of no known weakness: {', '.join(listed)}"


def untried_in_words(n_faults: int, untried: Mapping[int, int], goals: Sequence[str]) -> str:
    """Return in a sentence how many sets of faults were not tried for some goals, by size."""
    names, rows = {1: "fault", 2: "pair", 3: "triple"}, []
    for n, n_untried in untried.items():
        n_all = math.comb(n_faults, n)
        rows.append(f"{n_untried:,} of {n_all:,} {names[n]}{'s' * (n_all > 1)}")
    some = goals[0] if len(goals) == 1 else "at least one goal"
    return f"Not tried yet for {some}: {', '.join(rows)}"


def weakness_table(
    title: str, mission: Mission, pool: FaultPool, weaknesses: Iterable[GoalWeakness]
) -> Table:
    """Return a row for each fault of each weakness, in the variant that breaks the goal."""
    rows = []
    for weakness in weaknesses:
        shares = {each.column.kind: f"{100 * each.share:.0f}%" for each in weakness.by}
        shares[weakness.shown.column.kind] += "*" * weakness.is_undetected
        seeds = f"{weakness.shown.n_held}/{weakness.shown.n_seeds}"
        by = map(shares.get, MEASURES)
        depth = (depth_in_words(mission, weakness) or "").removesuffix(" units") or None
        found = weakness.shown.since, depth, seeds
        head: tuple[Cell, ...] = (weakness.number, weakness.goal, *by, *found)
        for named in named_faults(mission, pool, weakness.shown.witness):
            window = f"{named.timed.start} … {named.timed.finish}"
            how = named.fault.type, window, named.target, named.values_in_words
            rows.append((*head, named.name, *how))
            head = ("", "and", *[""] * (len(head) - 2))
    folded = ("type", "window", "target", "values")
    columns = ("#", "goal", *MEASURES[:2], "failed", "since", "depth", "seeds", "fault", *folded)
    words, texts = ("#", "goal", "fault", *folded[::2]), folded[1::2]
    return Table(title, columns, rows, words, texts, is_compact=True, folded=("how", folded))


def not_found(known: Known, goal: str) -> str:
    """Return in a sentence the bounds on specifications that break a goal by no known set."""

    def part(measure: str) -> str:
        column, does = Column(goal, measure), _DOES[measure][1]
        n = known.n_kept[column]
        least = f"at most {100 * known.bound(column):.1f} % {does} (0 of {n} did)"
        return least if n else f"no bound yet on those that {does}"

    truly, believed, missed = map(part, ("true", "believed", "missed"))
    return (
        f"Not found yet for {goal} ({known.confidence}): of random specifications that contain "
        f"none of these sets, {truly}; {believed}; {missed}"
    )


def estimated(goal: str, estimate: Estimate, run: Path) -> str:
    """Return in sentences how many weaknesses of a goal there are, and which a campaign lacks."""
    total, campaigns = estimate.total, counted(estimate.n_campaigns, "campaigns")
    if not total.n_found:
        return f"Found no weakness of {goal} in {campaigns}, so no number is estimated"
    lacking = "; ".join(map(" and ".join, estimate.lacking))
    lacks = f"{len(estimate.lacking)} of them: {lacking}" if lacking else "none of them"
    return (
        f"Found {counted(total.n_found, 'weaknesses')} of {goal} in {campaigns}; an estimated "
        f"{total.value:.0f} in all ({total.low} to {total.high}). {run} lacks {lacks}"
    )


_ASSUMED = "if no fault undoes another and variants break goals as often as those tried"


def risk_in_words(goal: str, found: Risk) -> str:
    """Return in a sentence how likely a goal is to break, with what is left out."""
    unknown = f", without {found.n_unknown} that have a fault of unknown likelihood"
    sets = f"{counted(found.n_sets, 'known sets')}{unknown if found.n_unknown else ''}"
    upper = "an upper value needs --with"
    if found.upper is not None:
        often = f"{100 * found.upper:.2g} %" if found.upper < 0.995 else "all"
        upper = (
            f"{often} if as many sets exist as are estimated at most, and each variant breaks it"
        )
    return (
        f"Risk of {goal}: it is truly violated or fails in at least {100 * found.lower:.2g} % of "
        f"missions {_ASSUMED}, a lower bound from {sets}; {upper}"
    )


def detection(weakness: GoalWeakness, units: Units) -> str:
    """Return in a sentence whether the CI detects what breaks a goal."""
    if weakness.shown.column.kind == MEASURES[0]:
        return "It is a false alarm of the CI"
    found = weakness.shown.detection
    return found.in_words(units) if found else "Whether the CI detects it is not recorded"


def effect_class(weakness: GoalWeakness) -> str:
    """Return what happens to the goal, by the gravest measure, as a predicate."""
    return _WORDS[_STATES[weakness.shown.column.kind]]


def evidence(weakness: GoalWeakness) -> str:
    """Return in sentences in how many variants, mission seeds and worlds a weakness holds."""
    shown = weakness.shown
    does = "violate the goal in belief" if shown.column.kind == MEASURES[0] else "break the goal"
    flown = f"{counted(shown.n_tried, 'variants')} flown to isolate the faults"
    estimate = f", an estimated {shown.share_in_words}" if shown.weighted else ""
    seeds = f"This one does in {shown.n_held} of {counted(shown.n_seeds, 'mission seeds')}"
    of = f"Of {flown}, {shown.n_broken} {does}{estimate}"
    return ". ".join((of, seeds, *(each.sentence for each in weakness.elsewhere)))


def broken_by(weakness: GoalWeakness, units: Units) -> str:
    """Return in sentences which faults break a goal, its detection, and the mildest variant."""
    kind, faults = weakness.shown.column.kind, " and ".join(weakness.faults)
    alone, together = _DOES[kind]
    does = f"alone {alone}" if len(weakness.faults) == 1 else f"together {together}"
    sentences = [f"{faults} {does}", "" if kind == MEASURES[0] else detection(weakness, units)]
    sentences += [evidence(weakness), weakness.mildest.sentence if weakness.mildest else ""]
    return " ".join(f"{each}." for each in filter(None, sentences))


class State(IntEnum):
    """Result for a goal, the gravest first."""

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
"""Predicate of each state in a sentence."""

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
"""Effect of a fault of each mode: as it follows ``is`` in a sentence, and in a word or two."""


@dataclass(frozen=True, slots=True)
class GoalVerdict:
    """Verdict on a goal: its state, one weakness, and the number of other weaknesses.

    ``label`` is the name before the ID. ``cause`` says when the goal breaks, ``detection`` whether
    the CI detects it, ``depth`` how far it is beyond its limit, ``strength`` in how many mission
    seeds and variants, ``bound`` how many other specifications may break it. ``nearest`` is the
    closest approach of a goal that no weakness truly breaks; ``is_unexplained`` says that it was
    violated there. ``stakes`` has its requirements, severity and integrity level. Texts may be
    empty.
    """

    goal: str
    name: str
    label: str
    state: State
    weakness: GoalWeakness | None
    n_others: int
    cause: str
    detection: str
    strength: tuple[str, ...]
    bound: str
    nearest: str = ""
    depth: str = ""
    severity: int = 0
    stakes: str = ""
    is_unexplained: bool = False

    @property
    def words(self) -> str:
        """The state."""
        return _WORDS[self.state]

    @property
    def in_full(self) -> str:
        """All but the evidence in sentences: the verdict, and what the goal stands for."""
        verdict = f"{self.label} {self.words}{self.because}"
        return f"{verdict}. {self.stakes[:1].upper()}{self.stakes[1:]}" if self.stakes else verdict

    @property
    def because(self) -> str:
        """The rest of the sentence: its cause, and whether the CI detects it."""
        cause = f" {self.cause}" if self.cause else ""
        return f"{cause}. {self.detection}" if self.detection else cause

    @property
    def evidence(self) -> tuple[str, ...]:
        """The weakness, its strength, other weaknesses, and the bound on what was not found."""
        near = (self.nearest,) if self.nearest else ()
        if self.weakness is None:
            return (self.bound, *near)
        number = f"weakness {self.weakness.number}", " and ".join(self.weakness.faults)
        others = counted(self.n_others, "other weaknesses") if self.n_others else ""
        facts = (*number, self.depth, *self.strength, others, self.bound, *near)
        return tuple(filter(None, facts))


def verdicts(mission: Mission, pool: FaultPool, known: Harvest) -> tuple[GoalVerdict, ...]:
    """Return the verdict on each goal of a mission, the gravest and most severe first."""
    least_of = {each.goal: each for each in least(known.goal_weaknesses)}
    found = (_verdict(mission, pool, known, goal, least_of.get(goal.id)) for goal in mission.goals)

    def rank(each: GoalVerdict) -> tuple[State, int, bool]:
        return each.state, -each.severity, not (each.weakness and each.weakness.is_undetected)

    return tuple(sorted(found, key=rank))


def _verdict(
    mission: Mission, pool: FaultPool, known: Harvest, goal: Goal, weakness: GoalWeakness | None
) -> GoalVerdict:
    unknown = max(known.known.bound(Column(goal.id, measure)) for measure in MEASURES)
    n_weaknesses = sum(each.goal == goal.id for each in known.goal_weaknesses)
    state = State.HOLDS if weakness is None else _STATES[weakness.shown.column.kind]
    of = known.yardstick
    fault_free = dict(zip(of.columns, of.most, strict=True)) if of else {}
    is_broken = any(fault_free.get(Column(goal.id, kind), 0) > 0 for kind in MEASURES[1:])
    if state in {State.FALSE_ALARM, State.HOLDS} and is_broken:
        state = State.BROKEN_ANYWAY
    cause = detected = depth = ""
    strength: tuple[str, ...] = ()
    if state is State.BROKEN_ANYWAY:  # not because of the weakness
        cause = starvation(mission, goal)
    elif weakness is not None:
        cause = f"if {cause_in_words(mission, pool, weakness)}"
        detected = "" if state is State.FALSE_ALARM else detection(weakness, mission.units)
    if weakness is not None:
        seeds = f"in {weakness.shown.n_held} of {counted(weakness.shown.n_seeds, 'mission seeds')}"
        strength = seeds, weakness.shown.share_in_words
        beyond = depth_in_words(mission, weakness)
        depth = f"{beyond} beyond its limit at worst" if beyond else ""
    others = "other random specifications"
    limit = f"{others} that break it: at most {100 * unknown:.0f} % ({known.known.confidence})"
    needed = max(known.known.flights_to_bound(Column(goal.id, measure)) for measure in MEASURES)
    none = f"no bound yet on {others}; one of 10 % needs at least {needed:,} more flights"
    near = known.nearest.get(goal.id)
    return GoalVerdict(
        goal=goal.id,
        name=mission.name_of(goal),
        label=mission.label_of(goal.id),
        state=state,
        weakness=weakness,
        n_others=n_weaknesses - (weakness is not None),
        cause=cause,
        detection=detected,
        strength=strength,
        nearest=_nearest_in_words(mission, goal, near),
        depth=depth,
        bound=limit if unknown < 1.0 else none,
        severity=goal.severity,
        stakes=mission.stakes_of(goal.id),
        is_unexplained=near is not None and near.is_violated,
    )


def _nearest_in_words(mission: Mission, goal: Goal, found: Nearest | None) -> str:
    if found is None:
        return ""
    where = f"in evaluation {found.evaluation}"
    if found.margin is not None:
        where = f"at tick {found.margin[1]} of evaluation {found.evaluation}"
        if not found.is_violated:
            near = nearness(mission, goal, found.margin)
            return f"closest approach: {near} from its limit, {where}"
        beyond = nearness(mission, goal, (-found.margin[0], 0))
        return f"{beyond} beyond its limit {where}, which no known weakness explains"
    return f"violated {where}, which no known weakness explains"


def depth_in_words(mission: Mission, weakness: GoalWeakness) -> str | None:
    """Return how far its goal is beyond its limit at worst, with the unit; ``None`` if unknown."""
    goal, depth = mission.goals[mission.goal_ids.index(weakness.goal)], weakness.shown.depth
    return nearness(mission, goal, depth) if depth else None


def cause_in_words(mission: Mission, pool: FaultPool, weakness: GoalWeakness) -> str:
    """Return the conditions under which a weakness breaks its goal."""
    faults = named_faults(mission, pool, weakness.shown.witness)
    off = weakness.mildest.off if weakness.is_mildest and weakness.mildest else ()
    pairs = zip(faults, off or [None] * len(faults), strict=True)
    return " and ".join(deed(mission, fault, apart) for fault, apart in pairs)


def sentence(mission: Mission, pool: FaultPool, weakness: GoalWeakness) -> str:
    """Return in one or two sentences which goal a weakness breaks, when, and who detects it."""
    state, cause = _STATES[weakness.shown.column.kind], cause_in_words(mission, pool, weakness)
    breaks = f"{mission.label_of(weakness.goal)} {_WORDS[state]} if {cause}"
    detected = f". {detection(weakness, mission.units)}"
    return breaks if state is State.FALSE_ALARM else breaks + detected


def as_json(mission: Mission, pool: FaultPool, weakness: GoalWeakness) -> list[dict[str, Any]]:
    """Return a weakness as plain values, with the team's ratings of its goal and its faults."""
    goal = mission.goals[mission.goal_ids.index(weakness.goal)]
    rated = {
        "requirements": [*goal.requirements],
        "severity": goal.severity or None,
        "integrity_level": goal.integrity_level,
        "rationale": goal.rationale,
        "references": [pool[fault].reference for fault in weakness.faults],
    }
    return [each | rated for each in weakness.as_json()]


def deed(mission: Mission, fault: NamedFault, off: str | None = None) -> str:
    """Return what a fault does and for how long; ``off`` is the error of a fixed value."""
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
        distance = one.sub(r"\1", off.removesuffix(" off"))
        apart = f", {_apart(mission, fault.fault, distance)}"
    own = f"{kind.name} ({kind.in_words(values, units, 4)})" if values else kind.name
    done = _DEEDS[kind.mode][0].format(first=first, fixed=fixed, own=own)
    begin, end = fault.window or (0, -1)
    waits = "" if fault.trigger is None else f" at most, {fault.trigger.when}"
    n_ticks = min(end - begin + 1, fault.most)
    return f"{subject} {are} {done} for {units.ticks(n_ticks)}{waits}{apart}"


def _apart(mission: Mission, fault: Fault, off: str) -> str:
    """Return how far a fixed value is from the true one."""
    if not fault.kind.is_place:
        return f"{off} from the true value when the fault begins"
    owner, _ = _owned(mission, touched(mission, fault)[0])
    unit = "" if mission.distance_unit else " units"
    return f"{off}{unit} from where {owner} is when the fault begins"


def _subject(mission: Mission, fault: Fault, reported: str = "") -> tuple[str, str]:
    """Return the names of what a fault touches, and ``is`` or ``are``."""
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
    """Return the name of a property's owner, and of the property; no text for a whole robot."""
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
    """Return the robot that a fault touches, as sort key and label, and its effect in few words.

    Robots have the mission's order; faults that touch no robot come last.
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
    return (robots[0], with_id(robot.name, robot.id)), f"{what} {does}".strip()


def headline(goals: Sequence[GoalVerdict]) -> str:
    """Return in a sentence how many goals break, and under how many faults."""
    broken = [each for each in goals if each.state <= State.VIOLATED]
    if not broken and (n_unexplained := sum(each.is_unexplained for each in goals)):
        many = f"{_number(n_unexplained).capitalize()} of {_number(len(goals))} goals"
        verb = "was" if n_unexplained == 1 else "were"
        return f"{many} {verb} violated in the search, but the flights after it did not find why"
    if not broken:
        return "No faults were found that break a goal"
    is_failing = all(each.state is State.FAILS for each in broken)
    verb = ("fail" if is_failing else "break") + "s" * (len(broken) == 1)
    alone = [each for each in broken if each.weakness and len(each.weakness.faults) == 1]
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
    mission: Mission,
    pool: FaultPool,
    goals: Sequence[GoalVerdict],
    known: Harvest,
    *others: Harvest,
) -> Iterator[str]:
    """Yield sentences: undetected weaknesses, false alarms, risks, what to protect and to monitor.

    Before the elements to protect come the results in other worlds. Risks count what other
    campaigns found, too.
    """
    masked = {each.goal for each in known.goal_weaknesses if each.is_undetected}
    undetected = [each.label for each in goals if each.goal in masked]
    if undetected:
        yield f"Undetected in at least one variant: {', '.join(undetected)}"
    alarms = [each.label for each in goals if each.state is State.FALSE_ALARM]
    if alarms:
        yield f"False alarms only: {', '.join(alarms)}"
    labels = {each.goal: each.label for each in goals}
    found = risks(pool, labels, [each.goal_weaknesses for each in (known, *others)])
    shares = [f"{labels[goal]} {100 * each.lower:.2g} %" for goal, each in found.items()]
    if shares:
        least = "Truly violated or failed in at least this share of missions"
        yield f"{least}, {_ASSUMED}: {', '.join(shares)}"
    yield from transfers(known.goal_weaknesses)
    yield from _protect_first(mission, pool, known)
    if known.advice and known.advice.steps:
        yield f"Monitor first: {'; then '.join(monitors_in_words(mission, known.advice))}"


def monitor_table(mission: Mission, advice: Advice) -> Table:
    """Return a row for each monitor to add: its elements, and shares before and after it."""
    rows = list[tuple[Cell, ...]]()
    then = [each.coverage for each in advice.steps]
    for (monitor, elements, after), before in zip(
        advice.steps, [advice.before, *then], strict=False
    ):
        named = [element_name(mission, each) for each in elements]
        named[_N_NAMED:] = [f"{len(named) - _N_NAMED} more"] * (len(named) > _N_NAMED)
        never, late = (
            f"{in_percent(sum(before[since:4]))} → {in_percent(sum(after[since:4]))}"
            for since in (3, 1)
        )
        rows.append((monitor, ", ".join(named), never, late))
    title = (
        "Share of breaking variants that is not detected before and after each is added. False "
        f"alarms of all: in {advice.n_false} of {advice.n_fresh} mission seeds without faults."
    )
    return Table(title, ("monitor", "of", "undetected", "not in time"), rows)


def monitors_in_words(mission: Mission, advice: Advice) -> Iterator[str]:
    """Yield each monitor to add as a sentence."""
    for monitor, elements, never, late in monitor_table(mission, advice).rows:
        yield f"{monitor} of {elements}: undetected {never}, not in time {late}"


def in_percent(share: float) -> str:
    """Return a share in whole per cent."""
    return "< 1 %" if 0.0 < share < 0.01 else f"{100 * share:.0f} %"


_N_NAMED = 4  # elements in a sentence


def _protect_first(mission: Mission, pool: FaultPool, known: Harvest) -> Iterator[str]:
    """Yield the sentences about the elements to protect, if several weaknesses are true."""
    steps = ladder(mission, pool, known.goal_weaknesses)
    n_closed = [*accumulate(len(step.closed) for step in steps)]
    n = n_closed[-1] if steps else 0
    if n < 2:
        return
    rungs = [
        f"{element_name(mission, step.element)}: "
        + (f"all {n}" if closed == n else f"{closed} of {n}")
        for step, closed in zip(steps, n_closed, strict=True)
    ]
    rungs[0] += " weaknesses"
    if len(rungs) > _N_NAMED:
        rungs[_N_NAMED:] = [f"{counted(len(rungs) - _N_NAMED, 'other elements')}: all {n}"]
    yield f"Protect first: {'; and '.join(rungs)}"
    n_flights, gone = confirmed(steps, known.known)
    unknown = f"; {n - len(gone)} were not flown" if len(gone) < n else ""
    flown = f"In {counted(n_flights, 'flights')} without the faults of these"
    yield f"{flown}, {sum(gone.values())} of {len(gone)} weaknesses are gone{unknown}"


def element_name(mission: Mission, element: str) -> str:
    """Return the name of what can be protected: ``KAL (r3)``, ``message m9 of KAL``."""
    robots = mission.robot_index
    if element in robots:
        return with_id(mission.robots[robots[element]].name, element)
    if element in mission.sensor_index:
        owner, measured = _owned(mission, (Field.ACTIVATION, mission.sensor_index[element]))
        return f"{owner}'s {measured} sensor ({element})"
    if element in mission.message_goal:
        sender = mission.message_goal[element][0].sender
        name = mission.robots[robots[sender]].name if sender in robots else ""
        return f"message {element} of {name or sender}"
    return f"obstacle {element}"


def verdict_table(mission: Mission, pool: FaultPool, known: Harvest) -> Table:
    """Return a row for each goal: its verdict and the evidence."""
    found = verdicts(mission, pool, known)
    rows = [(each.in_full, " · ".join(each.evidence)) for each in found]
    columns = ("goal", "evidence")
    return Table(headline(found), columns, rows, texts=columns)


_NUMBERS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")


def _number(n: int) -> str:
    return _NUMBERS[n] if n < len(_NUMBERS) else str(n)
