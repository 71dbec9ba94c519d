"""Summarise a campaign as one value, and list and draw its figures.

``summarise`` collects the results of a campaign, ``as_json`` returns them for scripts.
``illustrate``, at the end, lists the figures for which the campaign has numbers. An
``Illustration`` names a function of ``plots`` and its arguments.

References
----------
Source paper, section V, figures 5 to 12.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mrsfi_runtime.analysis import fronts, tables, weaknesses
from mrsfi_runtime.analysis.fronts import Columns, Front, Harm, Pick, Ratio
from mrsfi_runtime.analysis.tables import Table, Trend, TypePattern
from mrsfi_runtime.analysis.weaknesses import GoalVerdict, facts, headline, verdicts
from mrsfi_runtime.causes.consequences import confirmed, ladder, risks
from mrsfi_runtime.causes.harvest import Harvest, known_by
from mrsfi_runtime.causes.mildest import GoalWeakness
from mrsfi_runtime.causes.weakness import faults_of
from mrsfi_runtime.errors import counted
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Mission, Outcome
from mrsfi_runtime.record.observers import NamedFault, named_faults
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore, Evaluation, Measure
from mrsfi_runtime.search.space import SearchSpace


@dataclass(frozen=True, slots=True)
class Summary:
    """The results of a campaign.

    ``name`` is the mission's, ``place`` its place in the project. ``top`` has the most critical
    distinct specifications, at most ten, the worst first, with the ``faults`` of each and the
    weaknesses that it ``contained``. ``harvest`` is ``None`` without a search for weaknesses.
    ``highlights`` are the headline of ``verdicts`` and the facts below it.
    ``sentences`` describe by number what the faults of some weaknesses did. ``front`` is ``None``
    if it has fewer than two aims. ``patterns`` are fault types in the top, ``guilty`` those in the
    weaknesses. ``unrepeated`` describes how an external simulation or node gave different results
    for the same faults, if it did. ``decided`` has the decisions on weaknesses by number, in words;
    ``since`` the days since when these are known.
    """

    folder: Path
    mission: Mission
    pool: FaultPool
    name: str
    place: str
    settings: CampaignSettings
    measure: Measure
    semantics: int
    unrepeated: str
    n_generations: int
    n_evaluations: int
    n_distinct: int
    n_failures: int
    digest: str
    top: tuple[Evaluation, ...]
    faults: tuple[tuple[NamedFault, ...], ...]
    harvest: Harvest | None
    weaknesses: tuple[GoalWeakness, ...]
    verdicts: tuple[GoalVerdict, ...]
    highlights: tuple[str, ...]
    contained: tuple[tuple[GoalWeakness, ...], ...]
    front: Front | None
    harm: tuple[Harm, ...] | None
    pick: Pick | None
    trend: Trend
    patterns: tuple[TypePattern, ...]
    guilty: tuple[TypePattern, ...]
    sentences: Mapping[int, Sequence[str]] = field(default_factory=dict)
    decided: Mapping[int, str] = field(default_factory=dict)
    since: Mapping[int, str] = field(default_factory=dict)

    @property
    def counted(self) -> str:
        """The number of evaluations, and of how many if the search made fewer than it should."""
        if self.settings.is_short(self.n_evaluations + self.n_failures):
            return f"{self.n_evaluations} of {self.settings.evaluations} evaluations"
        return counted(self.n_evaluations, "evaluations")

    def outcome(self, weakness: GoalWeakness) -> Outcome:
        """Return the outcome of the variant of a weakness that is shown."""
        assert self.harvest is not None
        return self.harvest.outcomes[weakness.shown.witness]


def _contained(
    known: Harvest | None, found: Iterable[GoalWeakness], each: Evaluation
) -> tuple[GoalWeakness, ...]:
    if known is None or known.yardstick is None:
        return ()
    broken, faults = known.yardstick.broken(each.outcome), faults_of(each.specification)
    return tuple(
        weakness
        for weakness in found
        if faults.issuperset(weakness.faults) and any(one.column in broken for one in weakness.by)
    )


def summarise(
    folder: Path, store: CampaignStore, mission: Mission, pool: FaultPool, ratio: str | None
) -> tuple[Summary, Columns]:
    """Return the results so far of the campaign in a folder, and its evaluations."""
    measure = Measure.of(store.settings, mission)
    wanted = None if ratio is None else fronts.parse_ratio(ratio)
    goals = store.settings.goals
    if len(goals) < (1 if measure.minimised else 2):
        goals = () if wanted is None else wanted.goals
    harmed = measure.chosen if measure.minimised else ()
    looked_at = (*goals, *(() if wanted is None else wanted.goals), *harmed)
    columns = Columns.read(store, measure, tuple(dict.fromkeys(looked_at)))
    front = fronts.find_front(measure, columns, goals) if goals else None
    best = tuple(map(store.evaluation, columns.top(10)))
    trend = tables.find_trend(store.generations())
    known = known_by(SearchSpace.of(mission, pool), store)
    found = () if known is None else known.goal_weaknesses
    judged = () if known is None else verdicts(mission, pool, known)
    summary = Summary(
        folder=folder,
        mission=mission,
        pool=pool,
        name=store.manifest.mission or mission.name,
        place=store.manifest.place or store.manifest.mission,
        settings=store.settings,
        measure=measure,
        semantics=store.manifest.semantics,
        unrepeated=store.manifest.engine.unrepeated,
        n_generations=len(trend.generations),
        n_evaluations=len(columns),
        n_distinct=len(columns.distinct),
        n_failures=store.n_failures,
        digest=store.digest(),
        top=best,
        faults=tuple(named_faults(mission, pool, each.specification) for each in best),
        harvest=known,
        weaknesses=found,
        verdicts=judged,
        highlights=()
        if known is None
        else (headline(judged), *facts(mission, pool, judged, known)),
        contained=tuple(_contained(known, found, each) for each in best),
        front=front,
        harm=fronts.find_harm(measure, columns) if measure.minimised else None,
        pick=None if wanted is None else _pick(measure, columns, front, wanted),
        trend=trend,
        patterns=tables.find_patterns([each.specification for each in best], columns.tried, pool),
        guilty=tables.find_patterns([each.shown.witness for each in found], columns.tried, pool),
    )
    return summary, columns


def as_json(summary: Summary) -> dict[str, Any]:
    """Return a summary as plain values, whose keys always stand in the same order."""
    pairs = zip(summary.top, summary.faults, summary.contained, strict=True)
    ranked, pick = [_ranked(summary, *each) for each in pairs], summary.pick
    return {
        "schema": 2,
        "campaign": summary.folder.name,
        "mission": summary.name,
        "settings": summary.settings.as_json(),
        "measure": {"violations": summary.measure.kind, "mission_seeds": summary.measure.n_seeds},
        "semantics": summary.semantics,
        "unrepeated": summary.unrepeated or None,
        "n_generations": summary.n_generations,
        "n_evaluations": summary.n_evaluations,
        "n_distinct": summary.n_distinct,
        "n_failures": summary.n_failures,
        "digest": summary.digest,
        "best": ranked[0] if ranked else None,
        "top": ranked,
        "weaknesses": summary.harvest and _weaknesses(summary, summary.harvest),
        "front": summary.front and _front(summary.front),
        "harm": None if summary.harm is None else [asdict(harm) for harm in summary.harm],
        "pick": pick
        and {
            "ratio": str(pick.ratio),
            "evaluation": pick.point and pick.point.evaluation,
            "violations": pick.point and dict(zip(pick.goals, pick.point.violations, strict=True)),
        },
        "trend": asdict(summary.trend),
        "patterns": [asdict(pattern) for pattern in summary.patterns],
    }


def _weaknesses(summary: Summary, known: Harvest) -> dict[str, Any]:
    at_risk = risks(summary.pool, summary.mission.goal_ids, [summary.weaknesses])
    return {
        "n_flown": known.n_flights,
        "found": [
            each
            | {
                "sentences": list(summary.sentences.get(weakness.number, ())),
                "mildest": least and least.as_json(),  # which the sentences describe
            }
            for weakness, least in ((each, each.mildest) for each in summary.weaknesses)
            for each in weaknesses.as_json(summary.mission, summary.pool, weakness)
        ],
        "patterns": [asdict(pattern) for pattern in summary.guilty],
        "protect": [*_protect(summary, known)],
        "risk": {goal: each._asdict() for goal, each in at_risk.items()},
    }


def _protect(summary: Summary, known: Harvest) -> Iterator[dict[str, Any]]:
    """Yield the elements to protect, one after the other, and the weaknesses that each closes."""
    steps = ladder(summary.mission, summary.pool, summary.weaknesses)
    _, gone = confirmed(steps, known.known)
    for step in steps:
        numbers = [each.number for each in step.closed]
        flown = {"gone": [each for each in numbers if gone.get(each)]}
        yield {"element": step.element, "faults": sorted(step.faults), "closes": numbers, **flown}


def _pick(measure: Measure, columns: Columns, front: Front | None, wanted: Ratio) -> Pick:
    """Pick from the campaign's front, or from one over the ratio's own goals if that lacks them."""
    if front is None or not set(wanted.goals) <= set(front.goals):
        front = fronts.find_front(measure, columns, wanted.goals)
    return Pick(wanted, fronts.nearest_ratio(front, wanted), front.goals)


def _ranked(
    summary: Summary,
    evaluation: Evaluation,
    faults: Sequence[NamedFault],
    found: Iterable[GoalWeakness],
) -> dict[str, Any]:
    outcome, goals = evaluation.outcome, summary.measure.goals
    results = outcome.results(summary.measure.duration)
    return {
        "evaluation": evaluation.index,
        "generation": evaluation.generation,
        "fitness": evaluation.fitness[0],
        "fault_ticks": evaluation.fault_ticks,
        **{kind: dict(zip(goals, counts, strict=True)) for kind, counts in results.items()},
        "measured": summary.measure.by_goal(evaluation),
        "digest": outcome.digest,
        **({"repetition": flown._asdict()} if (flown := outcome.repetition) else {}),
        "weaknesses": [each.number for each in found],
        "specification": [{"fault": fault.fault.id, **fault.as_json()} for fault in faults],
    }


def _front(front: Front) -> dict[str, Any]:
    return {
        "goals": list(front.goals),
        "points": [
            {
                "evaluation": point.evaluation,
                "violations": dict(zip(front.goals, point.violations, strict=True)),
                **({front.minimised: point.cost} if front.minimised else {}),
            }
            for point in front.points
        ],
    }


class Illustration(NamedTuple):
    """A figure and its table, whose title is the caption; ``name`` is the stem of their files.

    A function of ``plots`` draws it from the arguments.
    """

    name: str
    table: Table
    function: str
    arguments: tuple[Any, ...]

    def save(self, folder: Path, suffixes: Sequence[str] = (".png", ".svg")) -> None:
        """Draw it into files in a folder."""
        from mrsfi_runtime.analysis import plots  # noqa: PLC0415 - matplotlib takes its time

        figure = getattr(plots, self.function)(*self.arguments)
        for suffix, content in plots.rendered(figure, suffixes).items():
            (folder / f"{self.name}{suffix}").write_bytes(content)


def illustrate(summary: Summary, columns: Columns, store: CampaignStore) -> Iterator[Illustration]:
    """Yield the figures for which a campaign has numbers, in the order of the paper.

    A campaign on chosen goals gets figures 8 and 9 in place of 6 and 7; they differ only in the
    fitness. Figures 10 and 11 show the first two goals of its front, whatever else it minimises.
    """
    table = tables.map_table("Mission map", summary.mission)
    yield Illustration("figure_05_mission_map", table, "mission_map", (summary.mission,))
    if summary.trend.generations:
        yield from _fitness(summary)
    if summary.harm:
        harm = summary.harm, summary.measure
        yield Illustration("figure_harm", tables.harm_table(*harm), "harm_front", harm)
    if summary.front is not None and summary.front.points and len(summary.front.goals) >= 2:
        yield from _fronts(summary, summary.front.goals[:2], columns, store)
    for name, found, where, patterns in (
        ("fault_types", summary.top, "most critical specifications", summary.patterns),
        ("weaknesses", summary.weaknesses, "weaknesses", summary.guilty),
    ):
        if found:
            table = tables.pattern_table(f"Fault types in the {len(found)} {where}", patterns)
            arguments = patterns, table.title
            yield Illustration(f"figure_12_{name}", table, "fault_types", arguments)


def fitness_label(settings: CampaignSettings, measure: Measure) -> str:
    """Return the label of an axis for the fitness of a campaign."""
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
            Table(title, ("generation", *names), rows),
            f"{what}_fitness",
            (summary.trend, label),
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
            for row in tables.front_table(front).rows
        ]
        title = f"Pareto points of some generations {over}"
        yield Illustration(
            "figure_10_front_by_generation",
            Table(title, ("generation", "evaluation", *goals), rows),
            "generation_fronts",
            (by_generation,),
        )
    front = fronts.find_front(measure, columns, goals)
    cloud, n_left_out = fronts.thinned(columns.of(goals))
    drawn = f"; {len(cloud)} of {len(cloud) + n_left_out} points are drawn" if n_left_out else ""
    title = f"All non-dominated specifications {over}{drawn}"
    yield Illustration(
        "figure_11_front",
        replace(tables.front_table(front), title=title),
        "whole_front",
        (front, cloud, _shown_pick(summary, front), n_left_out),
    )


def _generation_fronts(
    measure: Measure, columns: Columns, store: CampaignStore, goals: Sequence[str]
) -> dict[int, Front]:
    populated = store.populated()
    evenly = np.linspace(0, len(populated) - 1, 5).astype(int).tolist()
    found = {}
    for place in dict.fromkeys(evenly) if populated else ():
        generation = store.generation(populated[place])
        assert generation is not None
        rows = columns.distinct_among(generation.population)
        found[generation.index] = fronts.find_front(measure, columns, goals, rows)
    return found


def _shown_pick(summary: Summary, front: Front) -> Pick | None:
    pick = summary.pick
    if pick is None or pick.point is None or set(pick.ratio.goals) != set(front.goals):
        return None
    drawn = {point.evaluation: point for point in front.points}
    return Pick(pick.ratio, drawn.get(pick.point.evaluation), front.goals)
