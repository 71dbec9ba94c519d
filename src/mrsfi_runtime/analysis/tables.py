"""The numbers behind the figures, as CSV."""

import csv
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TypeAlias

from mrsfi_runtime.analysis.fronts import Front
from mrsfi_runtime.analysis.goal_discs import goal_discs
from mrsfi_runtime.analysis.patterns import TypePattern
from mrsfi_runtime.analysis.trend import Trend
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.campaign import Evaluation
from mrsfi_runtime.record.measure import Measure

Cell: TypeAlias = str | int | float
Rows: TypeAlias = list[tuple[Cell, ...]]
"""A table: the first row names the columns."""


def write_table(path: Path, rows: Rows) -> Path:
    """Write rows as CSV with line feeds, floats in their shortest exact form."""
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)
    return path


def map_table(mission: Mission) -> Rows:
    """Return everything with a place in the mission, in distance units."""
    area = mission.area
    rows: Rows = [("kind", "id", "name", "x", "y", "radius")]
    rows.append(("mission area", area.id, mission.name, area.center.x, area.center.y, area.radius))
    rows += [
        ("robot", robot.id, robot.name, robot.position.x, robot.position.y, 1.0)
        for robot in mission.robots
    ]
    rows += [
        (
            "obstacle",
            obstacle.id,
            "",
            obstacle.area.center.x,
            obstacle.area.center.y,
            obstacle.area.radius,
        )
        for obstacle in mission.obstacles
    ]
    rows += [
        ("goal area", disc.goal.id, disc.goal.name, disc.x, disc.y, disc.radius)
        for disc in goal_discs(mission)
    ]
    return rows


def mean_table(trend: Trend) -> Rows:
    """Return mean and standard deviation of fitness per generation."""
    rows: Rows = [("generation", "mean", "std")]
    rows += [(row.generation, row.mean, row.std) for row in trend.generations]
    return rows


def best_table(trend: Trend) -> Rows:
    """Return the best fitness per generation."""
    rows: Rows = [("generation", "best")]
    rows += [(row.generation, row.best) for row in trend.generations]
    return rows


def generation_fronts_table(fronts: Mapping[int, Front], goals: Sequence[str]) -> Rows:
    """Return the front of each of some generations, by generation."""
    rows: Rows = [("generation", "evaluation", *goals)]
    rows += [
        (generation, point.evaluation, *point.violations)
        for generation, front in fronts.items()
        for point in front.points
    ]
    return rows


def front_table(front: Front) -> Rows:
    """Return the points of a front."""
    rows: Rows = [("evaluation", *front.goals)]
    rows += [(point.evaluation, *point.violations) for point in front.points]
    return rows


def patterns_table(patterns: Iterable[TypePattern]) -> Rows:
    """Return the occurrences of every fault type, with what its base share would give."""
    rows: Rows = [
        (
            "type",
            "occurrences",
            "specifications",
            "share",
            "pool_share",
            "campaign_share",
            "pool_expected",
            "campaign_expected",
        )
    ]
    rows += [
        (
            pattern.type,
            pattern.n_occurrences,
            pattern.n_specifications,
            pattern.share,
            pattern.pool_share,
            pattern.campaign_share,
            pattern.pool_expected,
            pattern.campaign_expected,
        )
        for pattern in patterns
    ]
    return rows


def evaluations_table(evaluations: Iterable[Evaluation], measure: Measure) -> Rows:
    """Return every evaluation with its violations per goal; several objectives in one cell.

    The counts are those of the first mission seed.
    """
    kinds = ("believed", "true", "phantom", "masked")
    rows: Rows = [
        (
            "evaluation",
            "generation",
            "fitness",
            "n_faults",
            "fault_ticks",
            *(f"{kind}_{goal}" for kind in kinds for goal in measure.goals),
            "digest",
        )
    ]
    rows += [
        (
            evaluation.index,
            evaluation.generation,
            " ".join(map(repr, evaluation.fitness)),
            len(evaluation.specification),
            evaluation.fault_ticks,
            *(count for kind in kinds for count in getattr(evaluation.outcome, kind)),
            evaluation.outcome.digest,
        )
        for evaluation in evaluations
    ]
    return rows
