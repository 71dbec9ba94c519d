"""The report of a campaign as Markdown, in which nothing of a model becomes markup."""

from collections.abc import Iterable, Iterator, Mapping, Sequence

from mrsfi_runtime.analysis.fronts import Front, Harm, Pick, score
from mrsfi_runtime.analysis.patterns import Trend, TypePattern
from mrsfi_runtime.analysis.summary import Summary
from mrsfi_runtime.analysis.tables import front_table, harm_table, in_words, listed_step
from mrsfi_runtime.analysis.weaknesses import (
    LISTED,
    MATRIX,
    broken_by,
    goal_in_words,
    listed,
    matrix,
    said,
)
from mrsfi_runtime.causes.ways import least
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.semantics import flown_by
from mrsfi_runtime.record.measure import Measure, ticks, violated
from mrsfi_runtime.record.named_faults import FAULT_COLUMNS, fault_rows, named_faults
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import Evaluation

_BELIEVED_TRUE = "believed by the collective intelligence / true in the simulation"
_MISSED = "and the tick from which on it was certain that the goal's purpose is not met, if it was"
_COUNTS = f"Violations per goal in ticks, on the first mission seed: {_BELIEVED_TRUE}; {_MISSED}."
_POPULAR = (
    "Popular is not guilty: compare the occurrences of a type with what its share in the pool, and "
    "in everything the campaign tried, would give by chance. A type may also ride along with the "
    "one that does the harm."
)
_SIGNIFICANT = 0.05
_FEW_GENERATIONS = 3


def report_text(
    summary: Summary, mission: Mission, pool: FaultPool, captions: Mapping[str, str]
) -> str:
    """Return the report, which links the figures that ``captions`` names."""
    sections = [
        f"# Campaign {plain(summary.folder.name)} on mission {plain(summary.mission)}",
        _extent(summary),
        *_weaknesses(summary, mission, pool),
        "## Settings",
        table(("setting", "value"), sorted(_settings(summary.settings))),
        "## Fitness over the generations",
        trend_in_words(summary.trend),
        *_linked(captions, "fitness"),
        f"## The {len(summary.top)} most critical specifications",
        _top(summary),
        *_faults(summary),
        "## Fault types among them",
        _POPULAR,
        _patterns(summary.patterns),
        *_linked(captions, "fault_types"),
        *_guilty(summary, captions),
    ]
    if summary.front is not None:
        sections += ["## Pareto front", _front(summary.front), *_linked(captions, "front")]
    if summary.harm is not None:
        words = f"## Harm against {summary.measure.minimised}"
        sections += [words, _harm(summary.harm, summary.measure), *_linked(captions, "harm")]
    if summary.pick is not None:
        sections += ["## Pick by ratio", pick_in_words(summary.pick, summary.measure)]
    sections += ["## Mission", *_linked(captions, "mission_map")]
    return "\n\n".join(sections) + "\n"


def trend_in_words(trend: Trend) -> str:
    """Return one sentence on whether mean fitness rises."""
    rows = trend.generations
    if len(rows) < _FEW_GENERATIONS:
        return f"{len(rows)} finished generations: too few to speak of a trend."
    direction = "rising" if trend.tau > 0 else "falling"
    verdict = f"a {direction} trend" if trend.p_value < _SIGNIFICANT else "no clear trend"
    return (
        f"Mean fitness goes from {rows[0].mean:,.4g} in generation {rows[0].generation} to "
        f"{rows[-1].mean:,.4g} in generation {rows[-1].generation}, {trend.slope:+.3g} per "
        f"generation: {verdict} (Kendall's tau {trend.tau:.2f}, {trend.p_in_words}). "
        f"The best specification of all generations has {max(row.best for row in rows):,.6g}."
    )


def pick_in_words(pick: Pick, measure: Measure) -> str:
    """Return one sentence on the specification that comes nearest to a ratio."""
    if pick.point is None:
        goals = " nor ".join(pick.ratio.goals)
        return f"No specification comes near {pick.ratio}: none violates {goals}."
    found = ", ".join(
        f"{goal} {ticks(count)}"
        for goal, count in zip(pick.goals, pick.point.violations, strict=True)
    )
    return (
        f"Nearest to {pick.ratio} on the front comes evaluation {pick.point.evaluation} with "
        f"{found} ({measure}){pick.distance_in_words}; `mrsfi replay` flies it again."
    )


def _extent(summary: Summary) -> str:
    step = listed_step(summary.n_evaluations)
    listed = f" `tables/evaluations.csv` lists one in {step} of them, `campaign.sqlite` has all."
    return (
        f"{summary.n_evaluations} evaluations of {summary.n_distinct} distinct specifications in "
        f"{summary.n_generations} finished generations; {summary.n_failures} evaluations failed. "
        f"Digest over all evaluations: `{summary.digest}`. Flown by semantics {summary.semantics}, "
        f"the rules of {flown_by(summary.semantics)}.{listed if step > 1 else ''}"
    )


def _settings(settings: CampaignSettings) -> Iterator[tuple[str, str]]:
    for name, value in settings.as_json().items():
        if isinstance(value, list):
            yield name, " ".join(value) or "none named"
        elif value is not None:
            yield name, str(value)


def _top(summary: Summary) -> str:
    if not summary.top:
        return "No evaluation is recorded yet."
    header = ("", "evaluation", "generation", "fitness", "fault-ticks", *summary.measure.goals)
    rows = [
        (
            f"[{rank}](critical/{rank:02d}.xmi)",
            evaluation.index,
            evaluation.generation,
            f"{score(evaluation):,.6g}",
            evaluation.fault_ticks,
            *_violations(summary.measure, evaluation),
        )
        for rank, evaluation in enumerate(summary.top, start=1)
    ]
    words = _BELIEVED_TRUE
    if summary.measure.n_seeds > 1:
        words += " on the first mission seed"
    if not summary.measure.is_shown_by_outcomes:
        words = f"{summary.measure}: {words}"
    missed = _MISSED
    if summary.top[0].outcome.missed is None:
        missed = "what was missed is not recorded"
    return f"Violations per goal in ticks, {words}; {missed}.\n\n{table(header, rows)}"


def _faults(summary: Summary) -> Iterator[str]:
    """Yield the faults of each specification under a heading of its own."""
    if summary.top:
        yield (
            "The faults of each: *start* and *finish* are the window, *applied* and *changed* the "
            "numbers of ticks at which it was active and changed a value; *target* is what it "
            "touches, behind the message that carries it."
        )
    of_each = zip(summary.top, summary.faults, summary.contained, strict=True)
    for rank, (evaluation, faults, found) in enumerate(of_each, 1):
        yield f"### Faults of {rank}, evaluation {evaluation.index}"
        yield table(FAULT_COLUMNS, fault_rows(faults, evaluation.outcome))
        if found:
            some = (f"{way.goal} by {' and '.join(way.faults)} ({way.number})" for way in found)
            yield f"Of the least sets it has: {'; '.join(some)}."


def _violations(measure: Measure, evaluation: Evaluation) -> Iterator[str]:
    """Yield what came of each goal, the measure first unless belief and truth show it."""
    measured = {} if measure.is_shown_by_outcomes else measure.by_goal(evaluation)
    found = violated(evaluation.outcome, measure.duration)
    for goal, words in zip(measure.goals, found, strict=True):
        yield f"{ticks(measured[goal])}: {words}" if goal in measured else words


def _weaknesses(summary: Summary, mission: Mission, pool: FaultPool) -> Iterator[str]:
    """Yield what breaks which goal, if anybody looked."""
    if summary.harvest is None:
        return
    goals = mission.goal_ids
    yield "## What breaks which goal"
    yield f"{said(goals, summary.ways, summary.harvest.n_flights)}."
    if not summary.ways:
        return
    yield f"{MATRIX}."
    yield table(("fault", "type", *goals, "target"), matrix(mission, pool, goals, summary.ways))
    yield (
        "The least sets of faults, by goal: the share of the forms tried that break it by each "
        "measure, in how many mission seeds the form that is shown does, and this form. "
        "`weaknesses/` has each by its number, as a fault specification; of what is the least that "
        "breaks each goal also the mildest form that was found, which is told of below. "
        "`mrsfi show RUN N` draws number N in time and in space."
    )
    yield table(("", *LISTED), listed(mission, pool, summary.ways))
    for way in least(summary.ways):
        yield f"### {plain(goal_in_words(mission, way.goal))}, broken by weakness {way.number}"
        yield f"{broken_by(way)} {_COUNTS}"
        outcome = summary.outcome(way)
        faults = named_faults(mission, pool, way.shown.witness)
        yield table(goals, [violated(outcome, summary.measure.duration)])
        yield table(FAULT_COLUMNS, fault_rows(faults, outcome))
        if sentences := summary.sentences.get(way.number):
            yield "\n".join(f"- {plain(each)}" for each in sentences)


def _guilty(summary: Summary, captions: Mapping[str, str]) -> Iterator[str]:
    """Yield which types of faults break goals at the least."""
    if summary.ways:
        yield "## Fault types in the least sets"
        yield (
            "The same over the least sets that break a goal: a type that is above but not here "
            "rode along."
        )
        yield _patterns(summary.guilty)
        yield from _linked(captions, "figure_12_weaknesses")


def _patterns(patterns: Sequence[TypePattern]) -> str:
    header = ("fault type", "occurrences", "specifications", "by pool", "by campaign")
    rows = [
        (
            pattern.type,
            pattern.n_occurrences,
            pattern.n_specifications,
            f"{pattern.pool_expected:.1f}",
            f"{pattern.campaign_expected:.1f}",
        )
        for pattern in patterns
        if pattern.n_occurrences
    ]
    return table(header, rows)


def _front(front: Front) -> str:
    header, *rows = in_words(front_table(front))
    return (
        f"{len(rows)} non-dominated specifications over {', '.join(front.aims)} ({front.counts}; "
        f"of equal ones the earliest).\n\n{table(header, rows)}"
    )


def _harm(harm: Sequence[Harm], measure: Measure) -> str:
    header, *rows = in_words(harm_table(harm, str(measure.minimised)))
    return (
        f"The most goals violated, and the most violations in all, by a specification of at most "
        f"so many {measure.minimised}, and the evaluations that found it ({measure}; "
        f"{', '.join(measure.chosen)}). What is not listed does no more than the line above.\n\n"
        f"{table(header, rows)}"
    )


def _linked(captions: Mapping[str, str], part: str) -> list[str]:
    return [
        f"![{caption}](figures/{name}.png)" for name, caption in captions.items() if part in name
    ]


def table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a table."""
    return "\n".join(map(table_row, (header, ["---"] * len(header), *rows)))


def table_row(cells: Iterable[object]) -> str:
    """Return a line of a table."""
    return "| " + " | ".join(plain(str(cell)) for cell in cells) + " |"


def plain(text: str) -> str:
    """Return text that cannot break out of its line or cell, nor steer a terminal."""
    return printable(text).replace("|", "\\|").replace("<", "&lt;")


def printable(text: str) -> str:
    """Return text in one line, of characters that are seen."""
    line = " ".join(text.split())
    return "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in line)
