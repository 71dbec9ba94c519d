"""Every table of a flight and of a campaign; ``weaknesses.py`` has those of weaknesses.

What they are made from needs no numpy at run time: ``mrsfi simulate`` prints some of them.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import astuple, fields
from itertools import chain
from typing import TYPE_CHECKING, Any

from mrsfi_runtime.analysis.patterns import TypePattern
from mrsfi_runtime.analysis.table import Cell, Table, in_words
from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.mission import (
    COUNTED,
    ROBOT_RADIUS,
    TOLD,
    Coordinates,
    Goal,
    GoalDisc,
    Margin,
    Mission,
    Outcome,
)
from mrsfi_runtime.record.observers import NamedFault
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import NONE, Evaluation, Flown, Measure, ticks

if TYPE_CHECKING:
    from mrsfi_runtime.analysis.fronts import Front, Harm

COUNTS = (
    "Ticks at which each goal was violated; phantom: believed, not true; masked: true, not "
    "believed."
)
"""What ``goal_table`` shows."""

MOST_LISTED = 100_000
"""Evaluations that ``evaluations.csv`` lists, at most."""

_MISSED_FROM = "missed from"


def goal_table(title: str, mission: Mission, outcome: Outcome) -> Table:
    """Return what happened to each goal, in model order."""
    counted = [name for name in COUNTED if name != "missed"]
    counts = [getattr(outcome, name) for name in counted]
    since = outcome.missed_since(mission.duration)
    found = zip(mission.goals, zip(*counts, since, strict=True), outcome.samples, strict=True)
    rows = [(goal.id, goal.task.name, *cells, _samples(goal, n)) for goal, cells, n in found]
    words = ("goal", "task")
    return Table(title, (*words, *counted, _MISSED_FROM, "samples"), rows, words, is_compact=True)


def goals_as_json(mission: Mission, outcome: Outcome) -> list[dict[str, Any]]:
    """Return what ``goal_table`` shows, for scripts."""
    told = outcome.told(mission.duration) | {"samples": outcome.samples}
    margins = outcome.margins or [None] * len(mission.goals)
    least, ticks = zip(*(each or (None, None) for each in margins), strict=True)
    told |= {"margin": least, "nearest": ticks}
    return [
        {"id": goal.id, "task": goal.task.name, **dict(zip(told, counts, strict=True))}
        for goal, *counts in zip(mission.goals, *told.values(), strict=True)
    ]


def nearest_in_words(mission: Mission, outcome: Outcome) -> str:
    """Say of goals that held by how much, and when that was the least; empty if of none."""
    if outcome.margins is None:
        return "Held: not recorded"
    found = zip(mission.goals, outcome.margins, outcome.true, outcome.missed, strict=True)
    told = [
        f"{goal.id} by {nearness(mission, goal, margin)} at tick {margin[1]}"
        for goal, margin, n_violated, n_missed in found
        if margin is not None and not n_violated and not n_missed
    ]
    return f"Held: {', '.join(told)}" if told else ""


def nearness(mission: Mission, goal: Goal, margin: Margin) -> str:
    """Return a goal's margin with its unit."""
    return mission.units.told(margin[0], goal.task.spares, 5)


def _samples(goal: Goal, n_samples: int) -> str:
    terms = goal.terms
    return NONE if terms.sensor is None else f"{n_samples} of {terms.target_sample_number}"


def fault_table(title: str, faults: Sequence[NamedFault], outcome: Outcome) -> Table:
    """Return what each timed fault of a specification is, and at how many ticks it did what."""
    words, texts = ("fault", "type"), ("target", "values")
    rows: list[tuple[Cell, ...]] = []
    for each, *counts in zip(faults, outcome.applied, outcome.changed, strict=True):
        head = (each.name, each.fault.type, each.timed.start, each.timed.finish)
        rows.append((*head, *counts, each.target, each.told or NONE))
    columns = (*words, "start", "finish", "applied", "changed", *texts)
    folded = ("\n".join(texts), texts)
    return Table(title, columns, rows, words, texts, is_compact=True, folded=folded)


def faults_as_json(faults: Sequence[NamedFault], outcome: Outcome) -> list[dict[str, Any]]:
    """Return what ``fault_table`` shows, for scripts."""
    return [
        {"id": fault.fault.id, **fault.as_json(), "applied": applied, "changed": changed}
        for fault, applied, changed in zip(faults, outcome.applied, outcome.changed, strict=True)
    ]


def critical_table(
    measure: Measure, pool: FaultPool, top: Sequence[Evaluation], n_distinct: int
) -> Table:
    """Return the most critical specifications with fitness, what came of each goal, and faults.

    Each takes a line for violations as the collective intelligence believed them, one for those
    that were true, and one for the tick from which on a goal was certain to be missed; before these
    one for the campaign's measure if it is another.
    """
    rows: list[tuple[Cell, ...]] = []
    for rank, each in enumerate(top, 1):
        lines = map("\n".join, zip(*_violation_lines(measure, each), strict=True))
        faults = _fault_counts(pool, each.specification)
        rows.append((rank, each.index, each.fitness[0], *lines, faults))
    title = f"The {len(top)} most critical of {n_distinct} fault specifications"
    folded = ("violations", *measure.goals)
    columns = ("#", "evaluation", "fitness", *folded, "faults")
    return Table(title, columns, rows, folded[:1], columns[-1:], folded=("violations", folded))


def _violation_lines(measure: Measure, evaluation: Evaluation) -> Iterator[tuple[str, ...]]:
    if not measure.is_shown_by_outcomes:
        measured = measure.by_goal(evaluation)
        name = measure.kind if measure.n_seeds == 1 else f"mean {measure.kind}"
        told = (ticks(measured[goal]) if goal in measured else NONE for goal in measure.goals)
        yield (name, *told)
    yield ("believed", *map(str, evaluation.outcome.believed))
    yield ("true", *map(str, evaluation.outcome.true))
    since = evaluation.outcome.missed_since(measure.duration)
    yield (_MISSED_FROM, *map(in_words, since))


def _fault_counts(pool: FaultPool, specification: Specification) -> str:
    """Return the faults of a specification in the order of the pool: ``f4 f9×2 f11``."""
    counts = Counter(timed.fault for timed in specification)
    return " ".join(
        fault.id if counts[fault.id] == 1 else f"{fault.id}×{counts[fault.id]}"
        for fault in pool
        if fault.id in counts
    )


def map_table(title: str, mission: Mission) -> Table:
    """Return everything with a place in the mission, in distance units."""
    area, obstacles, discs = mission.area, mission.obstacles, mission.goal_discs
    places: list[tuple[str, str, str, Coordinates | GoalDisc, float]] = [
        ("mission area", area.id, mission.name, area.center, area.radius),
        *(("robot", each.id, each.name, each.position, ROBOT_RADIUS) for each in mission.robots),
        *(("obstacle", each.id, "", each.area.center, each.area.radius) for each in obstacles),
        *(("goal area", disc.goal.id, disc.goal.name, disc, disc.radius) for disc in discs),
    ]
    rows = [(kind, of, name, at.x, at.y, radius) for kind, of, name, at, radius in places]
    return Table(title, ("kind", "id", "name", "x", "y", "radius"), rows)


def mission_table(name: str, mission: Mission, pool: FaultPool) -> Table:
    """Return what a mission is made of."""
    parts = {
        "robots": (" ".join(filter(None, (each.id, each.name))) for each in mission.robots),
        "goals": (" ".join(filter(None, (each.id, each.name))) for each in mission.goals),
        "obstacles": (each.id for each in mission.obstacles),
        "faults": (f"{each.id} {each.type}" for each in pool),
    }
    rows = [(what, ", ".join(some) or NONE) for what, some in parts.items()]
    return Table(
        f"Mission {name}, {mission.units.ticks(mission.duration)}", ("what", "which"), rows
    )


def settings_table(settings: CampaignSettings) -> Table:
    """Return what the campaign file and the options say, by name."""
    rows = (
        (name, " ".join(value) or "none named" if isinstance(value, list) else str(value))
        for name, value in settings.as_json().items()
        if value is not None
    )
    return Table("Settings", ("setting", "value"), sorted(rows))


def pattern_table(title: str, patterns: Iterable[TypePattern]) -> Table:
    """Return how often each type of faults occurs, and how often by chance."""
    columns = [field.name.removeprefix("n_") for field in fields(TypePattern)]
    return Table(title, columns, [*map(astuple, patterns)])


def front_table(front: "Front") -> Table:
    """Return the points of a front, with what it has few of beside many violations last."""
    columns = ("evaluation", *front.aims)
    rows = [
        (point.evaluation, *point.violations, point.cost)[: len(columns)] for point in front.points
    ]
    title = f"{len(rows)} trade-offs between {', '.join(front.aims)} ({front.counts})"
    return Table(f"Pareto front: {title}", columns, rows)


def harm_table(harm: Iterable["Harm"], measure: Measure) -> Table:
    """Return the front of harm against what is minimised; ``by`` names an evaluation."""
    few = str(measure.minimised)
    title = f"Most harm with how few {few} ({measure}, {', '.join(measure.chosen)})"
    columns = (few, "goals violated", "goals by", "violations", "violations by")
    return Table(title, columns, [*map(astuple, harm)])


def evaluations_table(title: str, flown: Iterable[Flown], measure: Measure) -> Table:
    """Return evaluations with what came of each goal; several objectives in one cell.

    The counts are those of the first mission seed. A cell is empty where a goal was not missed
    since any tick.
    """
    counted = (f"{name}_{goal}" for name in TOLD for goal in measure.goals)
    first = ("evaluation", "generation", "fitness", "n_faults", "fault_ticks")
    rows = (
        (
            each.index,
            each.generation,
            " ".join(map(repr, each.fitness)),
            len(each.outcome.applied),
            each.fault_ticks,
            *chain.from_iterable(each.outcome.told(measure.duration).values()),
            each.outcome.digest,
        )
        for each in flown
    )
    return Table(title, (*first, *counted, "digest"), rows)


def short_evaluations_table(title: str, flown: Iterable[Flown], measure: Measure) -> Table:
    """Return evaluations in ten columns: counts are over all goals; missed ones are named."""
    rows = (
        (
            each.index,
            each.generation,
            each.fitness[0] if len(each.fitness) == 1 else " ".join(map(repr, each.fitness)),
            len(each.outcome.applied),
            each.fault_ticks,
            *(sum(getattr(each.outcome, name)) for name in COUNTED[:-1]),
            " ".join(
                goal for goal, n in zip(measure.goals, each.outcome.missed, strict=True) if n > 0
            ),
        )
        for each in flown
    )
    first = ("evaluation", "generation", "fitness", "faults", "fault-ticks")
    return Table(title, (*first, *COUNTED[:-1], "goals missed"), rows)
