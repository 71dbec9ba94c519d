"""What a campaign found, as one value and as JSON."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from mrsfi_runtime.analysis.fronts import (
    Columns,
    Front,
    Harm,
    Pick,
    Ratio,
    find_front,
    find_harm,
    nearest_ratio,
    parse_ratio,
)
from mrsfi_runtime.analysis.tables import Trend, TypePattern, find_patterns, find_trend
from mrsfi_runtime.analysis.weaknesses import GoalVerdict, facts, headline, verdicts
from mrsfi_runtime.causes.harvest import Harvest, known_by
from mrsfi_runtime.causes.mildest import Way
from mrsfi_runtime.causes.weakness import faults_of
from mrsfi_runtime.errors import counted
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Mission, Outcome
from mrsfi_runtime.record.observers import NamedFault, named_faults
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore, Evaluation, Measure
from mrsfi_runtime.search.space import SearchSpace

SCHEMA = 2
"""Version of ``summary.json``."""

N_TOP = 10


@dataclass(frozen=True, slots=True)
class Summary:
    """What a campaign found.

    ``name`` is that of the mission, ``place`` where it lies in its project. ``top`` are the most
    critical distinct specifications, at most ten, the worst first, with the ``faults`` of each and
    the ways that it ``contained``. ``harvest`` is ``None`` if nobody looked for ``ways``; ``said``
    is the headline of ``verdicts`` and what stands out; ``sentences`` say by number what each fault
    of some ways did. ``front`` is ``None`` if it is over fewer than two. ``patterns`` are fault
    types in the top, ``guilty`` those in the ways. ``unrepeated`` says how an external simulation
    or node was seen not to repeat itself, and nothing if it was not.
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
    ways: tuple[Way, ...]
    verdicts: tuple[GoalVerdict, ...]
    said: tuple[str, ...]
    contained: tuple[tuple[Way, ...], ...]
    front: Front | None
    harm: tuple[Harm, ...] | None
    pick: Pick | None
    trend: Trend
    patterns: tuple[TypePattern, ...]
    guilty: tuple[TypePattern, ...]
    sentences: Mapping[int, Sequence[str]] = field(default_factory=dict)

    @property
    def counted(self) -> str:
        """How many evaluations were made, and of how many if the search made fewer than wanted."""
        if self.settings.is_short(self.n_evaluations + self.n_failures):
            return f"{self.n_evaluations} of {self.settings.evaluations} evaluations"
        return counted(self.n_evaluations, "evaluations")

    def outcome(self, way: Way) -> Outcome:
        """Return what flying the form of a way finds."""
        assert self.harvest is not None
        return self.harvest.outcomes[way.shown.witness]


def _contained(known: Harvest | None, found: Iterable[Way], each: Evaluation) -> tuple[Way, ...]:
    if known is None or known.yardstick is None:
        return ()
    broken, faults = known.yardstick.broken(each.outcome), faults_of(each.specification)
    return tuple(
        way
        for way in found
        if faults.issuperset(way.faults) and any(one.column in broken for one in way.by)
    )


def summarise(
    folder: Path,
    store: CampaignStore,
    mission: Mission,
    pool: FaultPool,
    ratio: str | None,
) -> tuple[Summary, Columns]:
    """Return what the campaign in a folder found so far, and its evaluations."""
    measure = Measure.of(store.settings, mission)
    wanted = None if ratio is None else parse_ratio(ratio)
    goals = store.settings.goals
    if len(goals) < (1 if measure.minimised else 2):
        goals = () if wanted is None else wanted.goals
    harmed = measure.chosen if measure.minimised else ()
    looked_at = (*goals, *(() if wanted is None else wanted.goals), *harmed)
    columns = Columns.read(store, measure, tuple(dict.fromkeys(looked_at)))
    front = find_front(measure, columns, goals) if goals else None
    best = tuple(map(store.evaluation, columns.top(N_TOP)))
    tops = {each.index: each.specification for each in best}
    trend = find_trend(store.generations())
    known = known_by(SearchSpace.of(mission, pool), store)
    found = () if known is None else known.ways
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
        ways=found,
        verdicts=judged,
        said=() if known is None else (headline(judged), *facts(mission, pool, judged, found)),
        contained=tuple(_contained(known, found, each) for each in best),
        front=front,
        harm=find_harm(measure, columns) if measure.minimised else None,
        pick=None if wanted is None else _pick(measure, columns, front, wanted),
        trend=trend,
        patterns=find_patterns([*tops.values()], columns.tried, pool),
        guilty=find_patterns([each.shown.witness for each in found], columns.tried, pool),
    )
    return summary, columns


def as_json(summary: Summary) -> dict[str, Any]:
    """Return a summary as plain values, whose keys always stand in the same order."""
    pairs = zip(summary.top, summary.faults, summary.contained, strict=True)
    ranked = [_ranked(summary, *each) for each in pairs]
    return {
        "schema": SCHEMA,
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
        "pick": summary.pick and _picked(summary.pick),
        "trend": asdict(summary.trend),
        "patterns": [asdict(pattern) for pattern in summary.patterns],
    }


def _weaknesses(summary: Summary, known: Harvest) -> dict[str, Any]:
    return {
        "n_flown": known.n_flights,
        "found": [
            each
            | {
                "sentences": list(summary.sentences.get(way.number, ())),
                "mildest": way.mildest and way.mildest.as_json(),  # what the sentences tell of
            }
            for way in summary.ways
            for each in way.as_json()
        ],
        "patterns": [asdict(pattern) for pattern in summary.guilty],
    }


def _pick(measure: Measure, columns: Columns, front: Front | None, wanted: Ratio) -> Pick:
    """Pick from the campaign's front, or from one over the ratio's own goals if that lacks them."""
    if front is None or not set(wanted.goals) <= set(front.goals):
        front = find_front(measure, columns, wanted.goals)
    return Pick(wanted, nearest_ratio(front, wanted), front.goals)


def _ranked(
    summary: Summary, evaluation: Evaluation, faults: Sequence[NamedFault], found: Iterable[Way]
) -> dict[str, Any]:
    outcome = evaluation.outcome
    told = outcome.told(summary.measure.duration)
    return {
        "evaluation": evaluation.index,
        "generation": evaluation.generation,
        "fitness": evaluation.fitness[0],
        "fault_ticks": evaluation.fault_ticks,
        **{
            kind: dict(zip(summary.measure.goals, counts, strict=True))
            for kind, counts in told.items()
        },
        "measured": summary.measure.by_goal(evaluation),
        "digest": outcome.digest,
        "weaknesses": [way.number for way in found],
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


def _picked(pick: Pick) -> dict[str, Any]:
    point = pick.point
    return {
        "ratio": str(pick.ratio),
        "evaluation": point and point.evaluation,
        "violations": point and dict(zip(pick.goals, point.violations, strict=True)),
    }
