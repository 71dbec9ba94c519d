"""Which figures and tables a campaign gets, and under which names.

References
----------
Source paper, section V, figures 5 to 12.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from mrsfi_runtime.analysis import tables
from mrsfi_runtime.analysis.drawing_process import Drawing
from mrsfi_runtime.analysis.fronts import Front, Pick, find_front
from mrsfi_runtime.analysis.summary import Summary
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.campaign import Evaluation, Generation
from mrsfi_runtime.record.measure import Measure
from mrsfi_runtime.record.settings import CampaignSettings

N_GENERATION_FRONTS = 5


class Illustration(NamedTuple):
    """A figure and the numbers behind it; ``name`` is the stem of their files."""

    name: str
    caption: str
    drawing: Drawing
    rows: tables.Rows


def illustrate(
    summary: Summary,
    mission: Mission,
    evaluations: Sequence[Evaluation],
    generations: Sequence[Generation],
) -> Iterator[Illustration]:
    """Yield the figures that a campaign has numbers for, in the order of the paper.

    A campaign on chosen goals gets figures 8 and 9 in place of 6 and 7, which differ in the
    fitness only; figures 10 and 11 show the first two goals of its front.
    """
    yield Illustration(
        "figure_05_mission_map",
        "Mission map",
        map_drawing(mission),
        tables.map_table(mission),
    )
    if generations:
        yield from _fitness(summary)
    if summary.front is not None and summary.front.points:
        yield from _fronts(summary, summary.front.goals, evaluations, generations)
    if summary.top:
        yield Illustration(
            "figure_12_fault_types",
            f"Fault types in the {len(summary.top)} most critical specifications",
            Drawing("fault_types", (summary.patterns, len(summary.top))),
            tables.patterns_table(summary.patterns),
        )


def map_drawing(mission: Mission) -> Drawing:
    """Return the figure of a mission, which needs no evaluation."""
    return Drawing("mission_map", (mission,))


def fitness_label(settings: CampaignSettings, measure: Measure) -> str:
    """Return what the fitness of a campaign measures, for an axis."""
    name = settings.fitness
    goals = " + ".join(settings.goals) or "the chosen goals"
    known = {
        "weighted": f"0.3 · {measure.kind} violations + 0.7 · goals",
        "weighted_normalised": f"0.3 · {measure.kind} violations + 0.7 · goals, as shares",
        "focused": f"{measure.kind} violations of {goals}, ticks",
    }
    return f"fitness ({known.get(name, name)}{measure.means})"


def evenly_spaced(n: int, n_wanted: int) -> tuple[int, ...]:
    """Return up to ``n_wanted`` of ``0 … n - 1`` with the first, the last and equal steps."""
    if n <= n_wanted:
        return tuple(range(n))
    return tuple(step * (n - 1) // (n_wanted - 1) for step in range(n_wanted))


def _fitness(summary: Summary) -> Iterator[Illustration]:
    is_focused = summary.settings.fitness == "focused"
    mean, best = ("08", "09") if is_focused else ("06", "07")
    label = fitness_label(summary.settings, summary.measure)
    yield Illustration(
        f"figure_{mean}_mean_fitness",
        "Mean fitness of each generation",
        Drawing("mean_fitness", (summary.trend, label)),
        tables.mean_table(summary.trend),
    )
    yield Illustration(
        f"figure_{best}_best_fitness",
        "Best fitness of each generation",
        Drawing("best_fitness", (summary.trend, label)),
        tables.best_table(summary.trend),
    )


def _fronts(
    summary: Summary,
    front_goals: tuple[str, ...],
    evaluations: Sequence[Evaluation],
    generations: Sequence[Generation],
) -> Iterator[Illustration]:
    goals, measure = front_goals[:2], summary.measure
    over = f"over the {measure.kind} violations of {' and '.join(goals)}{measure.means}"
    by_generation = _generation_fronts(measure, evaluations, generations, goals)
    if by_generation:
        yield Illustration(
            "figure_10_front_by_generation",
            f"Pareto points of some generations {over}",
            Drawing("generation_fronts", (by_generation,)),
            tables.generation_fronts_table(by_generation, goals),
        )
    front = find_front(measure, evaluations, goals)
    cloud = [measure.violations(evaluation, goals) for evaluation in evaluations]
    yield Illustration(
        "figure_11_front",
        f"All non-dominated specifications {over}",
        Drawing("whole_front", (front, cloud, _shown_pick(summary, front))),
        tables.front_table(front),
    )


def _generation_fronts(
    measure: Measure,
    evaluations: Sequence[Evaluation],
    generations: Sequence[Generation],
    goals: Sequence[str],
) -> dict[int, Front]:
    """Return the fronts of evenly spaced generations' populations, by generation."""
    by_index = {evaluation.index: evaluation for evaluation in evaluations}
    populated = [generation for generation in generations if generation.population]
    shown = [populated[i] for i in evenly_spaced(len(populated), N_GENERATION_FRONTS)]
    return {
        generation.index: find_front(
            measure, [by_index[index] for index in generation.population], goals
        )
        for generation in shown
    }


def _shown_pick(summary: Summary, front: Front) -> Pick | None:
    """Return the pick if it is one of the front that is drawn."""
    pick = summary.pick
    if pick is None or pick.point is None or set(pick.ratio.goals) != set(front.goals):
        return None
    drawn = {point.evaluation: point for point in front.points}
    return Pick(pick.ratio, drawn.get(pick.point.evaluation), front.goals)
