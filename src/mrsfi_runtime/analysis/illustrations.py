"""Which figures there are numbers for in a campaign, and what these numbers are.

References
----------
Source paper, section V, figures 5 to 12.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mrsfi_runtime.analysis.campaign_tables import (
    front_table,
    harm_table,
    map_table,
    pattern_table,
)
from mrsfi_runtime.analysis.columns import Columns
from mrsfi_runtime.analysis.drawing import Drawing
from mrsfi_runtime.analysis.fronts import Front, Pick, find_front, thinned
from mrsfi_runtime.analysis.summary import Summary
from mrsfi_runtime.analysis.table import Table
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore, Measure

N_GENERATION_FRONTS = 5


class Illustration(NamedTuple):
    """A figure and the numbers behind it, with its caption as title, by the stem of their files."""

    name: str
    drawing: Drawing
    table: Table


def illustrate(summary: Summary, columns: Columns, store: CampaignStore) -> Iterator[Illustration]:
    """Yield the figures that a campaign has numbers for, in the order of the paper.

    A campaign on chosen goals gets figures 8 and 9 in place of 6 and 7, which differ in the
    fitness only; figures 10 and 11 show the first two goals of its front, whatever is minimised
    beside them.
    """
    table = map_table("Mission map", summary.mission)
    yield Illustration("figure_05_mission_map", map_drawing(summary.mission), table)
    if summary.trend.generations:
        yield from _fitness(summary)
    if summary.harm:
        drawing = Drawing("harm_front", (summary.harm, summary.measure))
        yield Illustration("figure_harm", drawing, harm_table(summary.harm, summary.measure))
    if summary.front is not None and summary.front.points and len(summary.front.goals) >= 2:
        yield from _fronts(summary, summary.front.goals[:2], columns, store)
    for name, found, where, patterns in (
        ("fault_types", summary.top, "most critical specifications", summary.patterns),
        ("weaknesses", summary.ways, "least sets that break a goal", summary.guilty),
    ):
        if found:
            table = pattern_table(f"Fault types in the {len(found)} {where}", patterns)
            drawing = Drawing("fault_types", (patterns, table.title))
            yield Illustration(f"figure_12_{name}", drawing, table)


def map_drawing(mission: Mission) -> Drawing:
    """Return the figure of a mission, which needs no evaluation."""
    return Drawing("mission_map", (mission,), "mission_plots")


def fitness_label(settings: CampaignSettings, measure: Measure) -> str:
    """Return what the fitness of a campaign measures, for an axis."""
    name = settings.fitness
    goals = " + ".join(settings.goals) or "the chosen goals"
    known = {
        "weighted": f"0.3 · {measure.words} + 0.7 · goals",
        "weighted_normalised": f"0.3 · {measure.words} + 0.7 · goals, as shares",
        "focused": f"{measure.words} of {goals}, ticks",
    }
    return f"fitness ({known.get(name, name)}{measure.means})"


def _fitness(summary: Summary) -> Iterator[Illustration]:
    first = 8 if summary.settings.fitness == "focused" else 6
    label = fitness_label(summary.settings, summary.measure)
    for number, (what, *spread) in enumerate((("mean", "std"), ("best",)), first):
        names = (what, *spread)
        rows = [
            (row.generation, *(getattr(row, name) for name in names))
            for row in summary.trend.generations
        ]
        title = f"{what.capitalize()} fitness of each generation"
        yield Illustration(
            f"figure_{number:02d}_{what}_fitness",
            Drawing(f"{what}_fitness", (summary.trend, label)),
            Table(title, ("generation", *names), rows),
        )


def _fronts(
    summary: Summary, goals: Sequence[str], columns: Columns, store: CampaignStore
) -> Iterator[Illustration]:
    measure = replace(summary.measure, minimised=None)
    over = f"over the {measure.words} of {' and '.join(goals)}{measure.means}"
    by_generation = _generation_fronts(measure, columns, store, goals)
    if by_generation:
        rows = [
            (generation, *row)
            for generation, front in by_generation.items()
            for row in front_table(front).rows
        ]
        title = f"Pareto points of some generations {over}"
        yield Illustration(
            "figure_10_front_by_generation",
            Drawing("generation_fronts", (by_generation,)),
            Table(title, ("generation", "evaluation", *goals), rows),
        )
    front = find_front(measure, columns, goals)
    cloud, n_left_out = thinned(columns.of(goals))
    drawn = f"; {len(cloud)} of {len(cloud) + n_left_out} points are drawn" if n_left_out else ""
    title = f"All non-dominated specifications {over}{drawn}"
    yield Illustration(
        "figure_11_front",
        Drawing("whole_front", (front, cloud, _shown_pick(summary, front), n_left_out)),
        replace(front_table(front), title=title),
    )


def _generation_fronts(
    measure: Measure, columns: Columns, store: CampaignStore, goals: Sequence[str]
) -> dict[int, Front]:
    populated = store.populated()
    evenly = np.linspace(0, len(populated) - 1, N_GENERATION_FRONTS).astype(int).tolist()
    fronts = {}
    for place in dict.fromkeys(evenly) if populated else ():
        generation = store.generation(populated[place])
        assert generation is not None
        rows = columns.distinct_among(generation.population)
        fronts[generation.index] = find_front(measure, columns, goals, rows)
    return fronts


def _shown_pick(summary: Summary, front: Front) -> Pick | None:
    pick = summary.pick
    if pick is None or pick.point is None or set(pick.ratio.goals) != set(front.goals):
        return None
    drawn = {point.evaluation: point for point in front.points}
    return Pick(pick.ratio, drawn.get(pick.point.evaluation), front.goals)
