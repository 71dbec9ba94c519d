"""The report of a campaign as Markdown, in which nothing of a model becomes markup."""

from collections.abc import Iterator, Mapping, Sequence

from mrsfi_runtime.analysis.campaign_tables import (
    COUNTS,
    MOST_LISTED,
    critical_table,
    fault_table,
    front_table,
    goal_table,
    harm_table,
    pattern_table,
    settings_table,
)
from mrsfi_runtime.analysis.patterns import Trend, TypePattern
from mrsfi_runtime.analysis.summary import Summary
from mrsfi_runtime.analysis.table import Table, every, plain, to_markdown
from mrsfi_runtime.analysis.weaknesses import (
    broken_by,
    goal_in_words,
    matrix_table,
    way_table,
)
from mrsfi_runtime.causes.mildest import least
from mrsfi_runtime.record.observers import named_faults

_BELIEVED_TRUE = "believed by the collective intelligence / true in the simulation"
_MISSED = "and the tick from which on it was certain that the goal's purpose is not met, if it was"
_POPULAR = (
    "Popular is not guilty: compare the occurrences of a type with what its share in the pool, and "
    "in everything the campaign tried, would give by chance. A type may also ride along with the "
    "one that does the harm."
)
_FEW_GENERATIONS = 3


def report_text(summary: Summary, captions: Mapping[str, str]) -> str:
    """Return the report, which links the figures that ``captions`` names."""
    sections = [
        f"# Campaign {plain(summary.folder.name)} on mission {plain(summary.name)}",
        _extent(summary),
        *([f"**Caution**: {plain(summary.unrepeated)}."] if summary.unrepeated else []),
        *_weaknesses(summary),
        *_section(settings_table(summary.settings)),
        "## Fitness over the generations",
        trend_in_words(summary.trend),
        *_linked(captions, "fitness"),
        *_top(summary),
        *_section(_occurring("Fault types among them", summary.patterns), _POPULAR),
        *_linked(captions, "fault_types"),
    ]
    if summary.ways:
        words = (
            "The same over the least sets that break a goal: a type that is above but not here "
            "rode along."
        )
        sections += _section(_occurring("Fault types in the least sets", summary.guilty), words)
        sections += _linked(captions, "figure_12_weaknesses")
    if summary.front is not None:
        words = "Non-dominated specifications; of equal ones the earliest."
        sections += [*_section(front_table(summary.front), words), *_linked(captions, "front")]
    if summary.harm is not None:
        words = (
            "The most goals violated, and the most violations in all, by a specification of at "
            f"most so many {summary.measure.minimised}, and the evaluations that found it. What is "
            "not listed does no more than the line above."
        )
        table = harm_table(summary.harm, summary.measure)
        sections += [*_section(table, words), *_linked(captions, "harm")]
    if summary.pick is not None:
        picked = summary.pick.in_words(summary.measure)
        words = f"The specification {picked}. `mrsfi replay` flies any evaluation again."
        sections += ["## Pick by ratio", words]
    sections += ["## Mission", *_linked(captions, "mission_map")]
    return "\n\n".join(sections) + "\n"


def _section(table: Table, *words: str, level: int = 2) -> Iterator[str]:
    yield f"{'#' * level} {plain(table.title)}"
    yield from words
    yield to_markdown(table)


def _occurring(title: str, patterns: Sequence[TypePattern]) -> Table:
    return pattern_table(title, [each for each in patterns if each.n_occurrences])


def trend_in_words(trend: Trend) -> str:
    """Return how mean fitness went in this run, which is no test: generations are dependent."""
    rows = trend.generations
    if len(rows) < _FEW_GENERATIONS:
        return f"{len(rows)} finished generations: too few to speak of a trend."
    return (
        f"Mean fitness goes from {rows[0].mean:,.4g} in generation {rows[0].generation} to "
        f"{rows[-1].mean:,.4g} in generation {rows[-1].generation}, {trend.slope:+.3g} per "
        "generation (least squares). This describes one run and tests nothing, because its "
        "generations depend on each other; `mrsfi compare` tests over many seeds. "
        f"The best specification of all generations has {max(row.best for row in rows):,.6g}."
    )


def _extent(summary: Summary) -> str:
    step = every(summary.n_evaluations, MOST_LISTED)
    listed = f" `tables/evaluations.csv` lists one in {step} of them, `campaign.sqlite` has all."
    return (
        f"{summary.counted} of {summary.n_distinct} distinct specifications in "
        f"{summary.n_generations} finished generations; {summary.n_failures} evaluations failed. "
        f"Digest over all evaluations: `{summary.digest}`. Flown by semantics {summary.semantics}."
        f"{listed if step > 1 else ''}"
    )


def _top(summary: Summary) -> Iterator[str]:
    measure, top = summary.measure, summary.top
    table = critical_table(measure, summary.pool, top, summary.n_distinct)
    if not top:
        yield f"## {table.title}"
        yield "No evaluation is recorded yet."
        return
    words = _BELIEVED_TRUE + (" on the first mission seed" if measure.n_seeds > 1 else "")
    if not measure.is_shown_by_outcomes:
        words = f"{measure}: {words}"
    yield from _section(table, f"Violations per goal in ticks, {words}; {_MISSED}.")
    yield (
        "The faults of each: *start* and *finish* are the window, *applied* and *changed* the "
        "numbers of ticks at which it was active and changed a value; *target* is what it "
        "touches, behind the message that carries it."
    )
    of_each = zip(top, summary.faults, summary.contained, strict=True)
    for rank, (evaluation, faults, found) in enumerate(of_each, 1):
        title = f"Faults of {rank}, evaluation {evaluation.index}"
        yield from _section(fault_table(title, faults, evaluation.outcome), level=3)
        yield (
            f"Of generation {evaluation.generation}, {evaluation.fault_ticks} fault-ticks; "
            f"[critical/{rank:02d}.xmi](critical/{rank:02d}.xmi)."
        )
        if found:
            some = (f"{way.goal} by {' and '.join(way.faults)} ({way.number})" for way in found)
            yield f"Of the least sets it has: {'; '.join(some)}."


def _weaknesses(summary: Summary) -> Iterator[str]:
    if summary.harvest is None:
        return
    mission, pool, (headline, *facts) = summary.mission, summary.pool, summary.said
    yield f"## {plain(headline)}"
    facts += [f"{each.sentence} ({', '.join(each.evidence)})" for each in summary.verdicts]
    yield "\n".join(f"- {plain(each)}." for each in facts)
    if not summary.ways:
        return
    yield from _section(matrix_table(mission, pool, summary.ways), level=3)
    title = "The least sets of faults, by goal"
    yield from _section(
        way_table(title, mission, pool, summary.ways),
        "The share of the forms tried that break it by each measure, in how many mission seeds the "
        "form that is shown does, and this form. `weaknesses/` has each by its number, as a fault "
        "specification; of what is the least that breaks each goal also the mildest form that was "
        "found, which is told of below. `mrsfi show RUN N` draws number N in time and in space.",
        level=3,
    )
    for way in least(summary.ways):
        title = f"{goal_in_words(mission, way.goal)}, broken by weakness {way.number}"
        outcome, faults = summary.outcome(way), named_faults(mission, pool, way.shown.witness)
        goals, by = goal_table(title, mission, outcome), broken_by(way, mission.units)
        yield from _section(goals, f"{by} {COUNTS} It flew in the first mission seed.", level=3)
        yield to_markdown(fault_table("", faults, outcome))
        if sentences := summary.sentences.get(way.number):
            yield "\n".join(f"- {plain(each)}" for each in sentences)


def _linked(captions: Mapping[str, str], part: str) -> list[str]:
    return [
        f"![{caption}](figures/{name}.png)" for name, caption in captions.items() if part in name
    ]
