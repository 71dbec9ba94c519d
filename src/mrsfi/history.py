"""The history of a mission: which weaknesses came, went and stayed from campaign to campaign.

``history`` reads the weaknesses of campaigns, in the given order. A search that did not find a
weakness proves little, so each campaign flies in its own mission those that others found: the
variant of the last campaign before it that found the weakness, or else of the next one after it. A
``Sight`` is what one campaign has of one weakness. A ``Course`` has its sights in all campaigns and
says whether it went, came or stayed from the first to the last. ``mrsfi compare RUN_A RUN_B``
prints a history of two, ``mrsfi history`` one of many.

A weakness went if its variant no longer has its effect; other variants may still have it. Where a
campaign found a true violation, one that found only a false alarm did not find the weakness.
"""

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import date
from itertools import groupby
from operator import attrgetter
from pathlib import Path
from typing import Any, NamedTuple

from mrsfi.campaign_folders import FlyableCampaign, OpenCampaign, deciding, open_campaign
from mrsfi.engines import Given, Tell, silent
from mrsfi.explaining import flying_again, harvested, same_flights
from mrsfi_runtime.analysis.tables import Cell, Table, to_page
from mrsfi_runtime.analysis.weaknesses import cause_in_words
from mrsfi_runtime.causes.consequences import Estimate, estimate
from mrsfi_runtime.causes.mildest import GoalWeakness
from mrsfi_runtime.causes.weakness import MEASURES, Breaking, Weakness
from mrsfi_runtime.engine.flights import Evaluator
from mrsfi_runtime.errors import SpecificationError, UsageError, counted
from mrsfi_runtime.model.fault_types import SEMANTICS, difference
from mrsfi_runtime.model.faults import Gate
from mrsfi_runtime.record.decisions import Cause
from mrsfi_runtime.record.engine_settings import Manifest, Workers

WENT, CAME, BRIEF, UNKNOWN, STAYED = "went", "came", "came and went", "cannot be flown", "stayed"
_ORDER = (WENT, CAME, BRIEF, UNKNOWN, STAYED)

MARKS = {
    "●": "found",
    "○": "not found, but a variant that another campaign found has this effect",
    "–": "this variant does not have it; others may",
    "?": "this variant cannot be flown",
}
"""What a campaign has of a weakness."""

_FLOWN = {True: "○", False: "–", None: "?"}  # by whether the variant has this effect


class Searched(NamedTuple):
    """A campaign, how many flights it made, and the weaknesses that it found."""

    path: Path
    manifest: Manifest
    campaign: OpenCampaign
    setup: str  # all that decides its flights, but the search seed
    n_flights: int
    found: Mapping[Cause, GoalWeakness]
    sample: tuple[Weakness, ...]


class Sight(NamedTuple):
    """What a campaign has of a weakness: one of ``MARKS``, its number there, and a remark."""

    mark: str
    number: int | None = None
    remark: str = ""

    @property
    def is_there(self) -> bool:
        """Whether the weakness is there."""
        return self.mark in "●○"


@dataclass(frozen=True, slots=True)
class Course:
    """A weakness, as the first campaign that found it recorded it, in several campaigns.

    ``decision`` is the one beside the mission's models of today on it, as found last, in words.
    """

    goal: str
    cause: str
    weakness: GoalWeakness
    sights: tuple[Sight, ...]
    decision: str = ""

    @property
    def verdict(self) -> str:
        """Whether it went, came or stayed from the first campaign to the last."""
        before, after = self.sights[0], self.sights[-1]
        if "?" in {before.mark, after.mark}:
            return UNKNOWN
        if before.is_there:
            return STAYED if after.is_there else WENT
        return CAME if after.is_there else BRIEF

    @property
    def remark(self) -> str:
        """A remark on the verdict."""
        return self.sights[0].remark or self.sights[-1].remark

    @property
    def marks(self) -> str:
        """One of ``MARKS`` for each campaign."""
        return "".join(each.mark for each in self.sights)

    @property
    def is_constant(self) -> bool:
        """Whether it is there in every campaign."""
        return all(each.is_there for each in self.sights)

    @property
    def faults(self) -> str:
        """Its faults in words."""
        return " and ".join(self.weakness.faults)

    def as_json(self) -> dict[str, Any]:
        """Return it as plain values."""
        before, after = self.sights[0], self.sights[-1]
        return {
            "verdict": self.verdict,
            "goal": self.goal,
            "faults": list(self.weakness.faults),
            "cause": self.cause,
            "before": before.number,
            "after": after.number,
            "remark": self.remark,
            "marks": self.marks,
            "decision": self.decision,
        }


@dataclass(frozen=True, slots=True)
class History:
    """Campaigns of a mission in order, and the course of every weakness that one of them found."""

    mission: str
    runs: tuple[Searched, ...]
    courses: tuple[Course, ...]

    @property
    def goals(self) -> dict[str, list[tuple[int, Estimate | None]]]:
        """By goal, for each campaign: how many weaknesses it found, of how many as estimated.

        An estimate takes campaigns of the same models, code and mission seed with other search
        seeds.
        """
        alike = defaultdict[str, dict[int, tuple[Weakness, ...]]](dict)
        for run in self.runs:
            alike[run.setup].setdefault(run.campaign.store.settings.seed, run.sample)

        def count(run: Searched, goal: str) -> tuple[int, Estimate | None]:
            samples, n_found = [*alike[run.setup].values()], Counter(each for each, *_ in run.found)
            return n_found[goal], estimate(samples, goal) if len(samples) > 1 else None

        goals = (goal for run in self.runs[::-1] for goal in run.campaign.mission.goal_ids)
        return {goal: [count(run, goal) for run in self.runs] for goal in dict.fromkeys(goals)}


def history(
    runs: Iterable[Path], engine: Given, workers: Workers, today: date, tell: Tell = silent
) -> History:
    """Return the history of campaigns of one mission, in the given order, by new flights."""
    searched, names = list[Searched](), list[str]()
    for path in runs:
        with open_campaign(path) as campaign:
            known, made = harvested(campaign), campaign.store.manifest
            n, setup = campaign.store.n_evaluations + known.n_flights, str(same_flights(campaign))
            found = {Cause(each.goal, each.faults): each for each in known.goal_weaknesses}
        searched.append(Searched(path, made, campaign, setup, n, found, known.weaknesses))
        names.append(made.mission or campaign.mission.name)
        if names[0] != names[-1]:
            what = f"{path}: found a campaign of mission '{names[-1]}'"
            raise UsageError(f"{what}; expected one of '{names[0]}', as {searched[0].path} is")
    finds = counting([run.found for run in searched])
    sights = [
        _sights(run, finds, place, engine, workers, tell) for place, run in enumerate(searched)
    ]
    first, last = dict[Cause, tuple[Searched, GoalWeakness]](), dict[Cause, GoalWeakness]()
    for run, found in zip(searched, finds, strict=True):
        first = {cause: (run, each) for cause, each in found.items()} | first
        last |= found
    courses, decided = [], deciding(searched[-1].campaign, today)
    for cause, (run, weakness) in first.items():
        mission, pool = run.campaign.mission, run.campaign.pool
        words, goal = cause_in_words(mission, pool, weakness), mission.label_of(weakness.goal)
        seen = tuple(each[cause] for each in sights)
        courses.append(Course(goal, words, weakness, seen, decided(last[cause])))
    ranked = sorted(courses, key=lambda each: (_ORDER.index(each.verdict), each.is_constant))
    return History(names[0], tuple(searched), tuple(ranked))


def counting(finds: Sequence[Mapping[Cause, GoalWeakness]]) -> list[dict[Cause, GoalWeakness]]:
    """Return weaknesses by campaign, without false alarms of what another one found truly."""
    alarms = [{cause for cause in found if found[cause].measure == MEASURES[0]} for found in finds]
    truly = {
        cause for found, false in zip(finds, alarms, strict=True) for cause in {*found} - false
    }
    return [
        {cause: found[cause] for cause in found if cause not in false & truly}
        for found, false in zip(finds, alarms, strict=True)
    ]


def _sights(
    run: Searched,
    finds: Sequence[Mapping[Cause, GoalWeakness]],
    place: int,
    engine: Given,
    workers: Workers,
    tell: Tell,
) -> dict[Cause, Sight]:
    """Return what a campaign has of each weakness; fly those that others found."""
    nearest = (*finds[:place:-1], *finds[:place])  # the nearest one before comes last
    others = {cause: each for found in nearest for cause, each in found.items()}
    wanted = {cause: each for cause, each in others.items() if cause not in finds[place]}
    flown: dict[Cause, tuple[bool | None, str]] = {}
    if run.manifest.semantics != SEMANTICS:
        flown = dict.fromkeys(wanted, (None, difference(run.manifest.semantics)))
    elif wanted:
        with flying_again(run.path, engine, workers, tell) as (campaign, evaluator, _):
            flown = _broken(campaign, evaluator, wanted)
    sights = {cause: Sight("●", each.number) for cause, each in finds[place].items()}
    for cause, (breaks, remark) in flown.items():
        alarm = f"only a false alarm in {run.path.name}" if cause in run.found else ""
        sights[cause] = Sight(_FLOWN[breaks], remark=remark or alarm)
    return sights


def _broken(
    campaign: FlyableCampaign, evaluator: Evaluator, weaknesses: Mapping[Cause, GoalWeakness]
) -> dict[Cause, tuple[bool | None, str]]:
    seed, gate = campaign.store.settings.mission_seed, Gate(campaign.mission, campaign.pool)
    outcomes: dict[Cause, tuple[bool | None, str]] = {}
    flyable = {}
    for cause, weakness in weaknesses.items():
        try:
            form = gate.admitted(weakness.shown.witness)
        except SpecificationError as error:
            outcomes[cause] = None, str(error).partition(";")[0]
            continue
        if weakness.goal in campaign.mission.goal_ids:
            flyable[cause, weakness.shown.column] = form
        else:
            outcomes[cause] = None, f"the mission has no goal {weakness.goal}"
    breaking = Breaking(campaign.mission, evaluator.evaluate_many, [seed])
    for (cause, column), broken in zip(flyable, breaking([*flyable.values()], seed), strict=True):
        outcomes[cause] = column in broken, ""
    return outcomes


def sentence(courses: Iterable[Course]) -> str:
    """Return in a sentence how many weaknesses went, came and stayed."""
    verdicts = [each.verdict for each in courses]
    counts = ", ".join(f"{verdicts.count(x) or 'none'} {x}" for x in (WENT, CAME, STAYED))
    brief, unknown = map(verdicts.count, (BRIEF, UNKNOWN))
    rest = f"; {brief} {BRIEF}" if brief else ""
    rest += f"; {counted(unknown, 'weaknesses')} can no longer be flown" if unknown else ""
    return f"Weaknesses: {counts}{rest}"


def listed(courses: Iterable[Course]) -> str:
    """Return goals and faults of weaknesses: ``g1: f2, f5 and f6; g2: f3``."""
    by_goal = groupby(sorted(courses, key=attrgetter("goal")), key=attrgetter("goal"))
    return "; ".join(f"{goal}: {', '.join(each.faults for each in some)}" for goal, some in by_goal)


def run_tables(history: History) -> tuple[Table, Table]:
    """Return a table of the campaigns, and one of what each found of each goal."""
    changes = (CAME, WENT, STAYED)
    runs, names = list[Sequence[Cell]](), dict[str, str]()
    for place, run in enumerate(history.runs):
        pair, courses = slice(place - 1, place + 1), history.courses if place else ()
        verdicts = [replace(each, sights=each.sights[pair]).verdict for each in courses]
        counts = [verdicts.count(each) if place else None for each in changes]
        runs.append((f"{place + 1}", run.path.name, *run.manifest.made, run.n_flights, *counts))
        for goal in (mission := run.campaign.mission).goals:
            names[goal.id] = ", ".join((mission.label_of(goal.id), *goal.requirements))
    goals = [(names[goal], *map(_of, counts)) for goal, counts in history.goals.items()]
    heads = ("#", "campaign", "date", "commit", "flights", *changes)
    columns = ("goal", *(f"{place + 1}" for place in range(len(runs))))
    what = "Weaknesses that each campaign found, of how many as estimated (95 %). No estimate (?) "
    why = "without any, or without campaigns that differ only in the search seed"
    return (
        Table(f"Campaigns of {history.mission}", heads, runs, heads[:4]),
        Table(what + why, columns, goals, columns[1:], columns[:1], spare=columns[1:-4]),
    )


def _of(count: tuple[int, Estimate | None]) -> str:
    n_found, of = count
    if of is None or not of.total.n_found:
        return f"{n_found} of ?"
    return f"{n_found} of {of.total.value:.0f} ({of.total.low} to {of.total.high})"


def drawn(history: History, suffix: str) -> bytes:
    """Return a figure of how many weaknesses of each goal each campaign found."""
    from mrsfi_runtime.analysis import plots  # noqa: PLC0415 - matplotlib takes its time

    labels = ["\n".join((run.path.name, *run.manifest.made)) for run in history.runs]
    counts = {goal: [n for n, _ in some] for goal, some in history.goals.items()}
    figure = plots.found_weaknesses(f"Weaknesses of {history.mission}", labels, counts)
    return plots.rendered(figure, [suffix])[suffix]


def course_table(history: History, courses: Iterable[Course]) -> Table:
    """Return a row for each weakness: what each campaign has of it, since when it is known."""
    days, rows = [run.manifest.made[0] for run in history.runs], []
    for each in courses:
        words = filter(None, (each.cause, each.remark, each.decision))
        since = next(day for day, sight in zip(days, each.sights, strict=True) if sight.number)
        text = f"{each.goal}: {'; '.join(words)}"
        rows.append((each.verdict, each.faults, " ".join(each.marks), since, text))
    numbers = " ".join(f"{place % 10}" for place, _ in enumerate(days, 1))
    heads = ("verdict", "faults", numbers, "known since", "goal: cause, remark and decision")
    title = "; ".join(f"{mark} {meaning}" for mark, meaning in MARKS.items())
    return Table(f"Weaknesses in each campaign: {title}", heads, rows, heads[:-1], heads[-1:])


def page(history: History) -> dict[str, Any]:
    """Return the content of a page: a line for each campaign, a column for each weakness."""
    courses, runs = history.courses, history.runs
    lines = [(run.path.name, *(each.marks[n] for each in courses)) for n, run in enumerate(runs)]
    heads = ("campaign", *(f"{each.weakness.goal}: {each.faults}" for each in courses))
    what = f"Mission {history.mission}, from the first campaign to the last. {sentence(courses)}"
    tables = (Table(what, heads, lines), *run_tables(history), course_table(history, courses))
    record = [(run.path.name, str(run.path)) for run in runs]
    return {"title": "History", "tables": [*map(to_page, tables)], "record": record}
