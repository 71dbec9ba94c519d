"""The numbers behind the figures: where a mission happens, and tables as CSV."""

import csv
import io
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import astuple
from itertools import chain
from typing import TextIO, TypeAlias

from mrsfi_runtime.analysis.fronts import Front, Harm
from mrsfi_runtime.model.mission import ROBOT_RADIUS, Area, Mission
from mrsfi_runtime.model.outcome import TOLD
from mrsfi_runtime.record.measure import Measure, ticks
from mrsfi_runtime.record.store import Flown

Cell: TypeAlias = str | int | float | None
Rows: TypeAlias = list[tuple[Cell, ...]]
"""A table: the first row names the columns."""

_FORMULA = ("=", "+", "-", "@", "\t", "\r")
_MOST_LISTED = 100_000  # evaluations of a table


def working_window(mission: Mission) -> tuple[float, float, float]:
    """Return the square around all robots' starts, obstacles and goal areas, with a margin.

    It is centre x, centre y and half width, in distance units.
    """
    discs = [(disc.x, disc.y, disc.radius) for disc in mission.goal_discs]
    discs += [(robot.position.x, robot.position.y, ROBOT_RADIUS) for robot in mission.robots]
    discs += [
        (obstacle.area.center.x, obstacle.area.center.y, obstacle.area.radius)
        for obstacle in mission.obstacles
    ]
    left, right = min(x - r for x, _, r in discs), max(x + r for x, _, r in discs)
    low, high = min(y - r for _, y, r in discs), max(y + r for _, y, r in discs)
    half = max(right - left, high - low) / 2
    return (left + right) / 2, (low + high) / 2, max(half * 1.12, mission.area.radius * 0.01)


def as_csv(rows: Rows) -> bytes:
    """Return rows as CSV with line feeds, floats in their shortest exact form."""
    text = io.StringIO()
    write_csv(text, rows)
    return text.getvalue().encode()


def write_csv(file: TextIO, rows: Iterable[tuple[Cell, ...]]) -> None:
    """Write rows as CSV into a file that leaves line feeds as they are, one after the other."""
    csv.writer(file, lineterminator="\n").writerows(map(_inert, row) for row in rows)


def _inert(cell: Cell) -> Cell:
    """Return a cell that no spreadsheet takes for a formula: a name may begin like one."""
    return f"'{cell}" if isinstance(cell, str) and cell.startswith(_FORMULA) else cell


def map_table(mission: Mission) -> Rows:
    """Return everything with a place in the mission, in distance units."""

    def row(kind: str, identifier: str, name: str, area: Area) -> tuple[Cell, ...]:
        return kind, identifier, name, area.center.x, area.center.y, area.radius

    return [
        ("kind", "id", "name", "x", "y", "radius"),
        row("mission area", mission.area.id, mission.name, mission.area),
        *(
            ("robot", each.id, each.name, each.position.x, each.position.y, 1.0)
            for each in mission.robots
        ),
        *(row("obstacle", each.id, "", each.area) for each in mission.obstacles),
        *(
            ("goal area", disc.goal.id, disc.goal.name, disc.x, disc.y, disc.radius)
            for disc in mission.goal_discs
        ),
    ]


def front_table(front: Front) -> Rows:
    """Return the points of a front, with what it has few of beside many violations last."""
    n_columns = 1 + len(front.aims)
    rows = ((point.evaluation, *point.violations, point.cost) for point in front.points)
    return [("evaluation", *front.aims), *(row[:n_columns] for row in rows)]


def harm_table(harm: Sequence[Harm], minimised: str) -> Rows:
    """Return the front of harm against what is minimised; ``by`` names an evaluation."""
    header = (minimised, "goals violated", "goals by", "violations", "violations by")
    return [header, *map(astuple, harm)]


def in_words(rows: Rows) -> list[tuple[str, ...]]:
    """Return a table of numbers as people read it."""
    return [
        tuple(ticks(cell) if isinstance(cell, float) else str(cell) for cell in row) for row in rows
    ]


def evaluations_table(flown: Iterable[Flown], measure: Measure) -> Iterator[tuple[Cell, ...]]:
    """Yield evaluations with what came of each goal; several objectives in one cell.

    The counts are those of the first mission seed. A cell is empty where a goal was not missed
    since any tick, or an older record does not say.
    """
    counted = (f"{name}_{goal}" for name in TOLD for goal in measure.goals)
    first = ("evaluation", "generation", "fitness", "n_faults", "fault_ticks")
    yield (*first, *counted, "digest")
    for each in flown:
        yield (
            each.index,
            each.generation,
            " ".join(map(repr, each.fitness)),
            len(each.outcome.applied),
            each.fault_ticks,
            *chain.from_iterable(each.outcome.told(measure.duration).values()),
            each.outcome.digest,
        )


def listed_step(n_evaluations: int) -> int:
    """Return how far apart the evaluations are that a table lists: 1 if it lists all."""
    return max(1, -(-n_evaluations // _MOST_LISTED))
