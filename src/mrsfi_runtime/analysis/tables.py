"""Tables as values, their writers, and the tables of flights and campaigns.

A ``Table`` has a title, named columns and rows. Writers turn it into Markdown, CSV, HTML and values
for the page; ``cli/terminal.py`` prints it. The trend of fitness and the patterns of fault types
come next, then one function for each table; ``weaknesses.py`` has those of weaknesses. This module
loads without numpy, because ``mrsfi simulate`` prints some of its tables.

A fault type that a search drew often need not be harmful. Its count is therefore shown beside the
counts that its share in the pool, and its share in the campaign, would give.

References
----------
Source paper, section V, RQ1, RQ2 and figures 6 to 9 and 12.
"""

import csv
import io
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, fields, replace
from datetime import datetime
from itertools import chain, zip_longest
from operator import itemgetter
from typing import TYPE_CHECKING, Any, TextIO, TypeAlias, TypeGuard

from mrsfi_runtime.errors import printable
from mrsfi_runtime.model.fault_types import Range
from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.mission import (
    COUNTED,
    RESULTS,
    Goal,
    Margin,
    Mission,
    Outcome,
    Repetition,
    interval_in_words,
    with_id,
)
from mrsfi_runtime.record.observers import NamedFault
from mrsfi_runtime.record.settings import CampaignSettings

if TYPE_CHECKING:
    from mrsfi_runtime.analysis.fronts import Front, Harm
    from mrsfi_runtime.record.store import Evaluation, Flown, Generation, Measure


NONE = "–"
"""The content of an empty table cell."""

Cell: TypeAlias = str | int | float | None


@dataclass(frozen=True, slots=True)
class Table:
    """Rows under named columns of ``words``, of ``texts``, which may wrap, and of numbers.

    A cell may have several lines; an empty one is ``None``. A compact table has little space
    between columns. On a narrow terminal, ``spare`` columns are left out first. Then the adjacent
    columns that are ``folded`` become one of that name.
    """

    title: str
    columns: Sequence[str]
    rows: Iterable[Sequence[Cell]]
    words: Sequence[str] = ()
    texts: Sequence[str] = ()
    is_compact: bool = False
    spare: Sequence[str] = ()
    folded: tuple[str, Sequence[str]] = ("", ())

    @property
    def lines(self) -> Iterator[Sequence[Cell]]:
        """The names of the columns, then the rows."""
        yield self.columns
        yield from self.rows

    def narrower(self) -> "Iterator[Table]":
        """Yield the table, then narrower ones: without spare columns, with folded ones."""
        yield self
        table = self
        if self.spare:
            kept = [k for k, name in enumerate(self.columns) if name not in self.spare]
            shorter = [[row[k] for k in kept] for row in self.rows]
            table = replace(self, columns=[self.columns[k] for k in kept], rows=shorter)
            yield table
        name, folded = self.folded
        if folded:
            first = table.columns.index(folded[0])
            last = first + len(folded)
            columns = (*table.columns[:first], name, *table.columns[last:])
            rows = [
                (*row[:first], self._in_one(row[first:last]), *row[last:]) for row in table.rows
            ]
            texts = (*self.texts, name)
            yield replace(table, columns=columns, rows=rows, texts=texts, folded=("", ()))

    def _in_one(self, cells: Sequence[Cell]) -> str:
        """Return folded cells as one: numbers after their names, each text on its own line."""

        def part(name: str, cell: str) -> str:
            if cell in {"", NONE}:
                return ""
            if name in self.texts:
                return f"\n{cell}"
            return f" {cell}" if name in self.words else f" {name}:{cell}"

        by_line = zip_longest(*(in_words(cell).split("\n") for cell in cells), fillvalue="")
        return "\n".join("".join(map(part, self.folded[1], line))[1:] for line in by_line)


def every(n: int, most: int) -> int:
    """Return the step with which at most ``most`` of ``n`` items are kept; 1 keeps all."""
    return max(1, -(-n // most))


def ticks(count: float) -> str:
    """Return a count, or a mean of counts, as text."""
    return str(count) if isinstance(count, int) else f"{count:.2f}"


def in_words(cell: Cell) -> str:
    """Return a cell as text for people."""
    if isinstance(cell, float):
        return f"{cell:.2f}" if abs(cell) >= 1 else f"{cell:.3g}"
    return NONE if cell is None else str(cell)


def to_markdown(table: Table) -> str:
    """Return a table without its title; lines of a cell are joined by slashes."""
    first, *others = (
        f"| {' | '.join(plain(in_words(cell).replace(chr(10), ' / ')) for cell in line)} |"
        for line in table.lines
    )
    return "\n".join((first, f"| {' | '.join('---' for _ in table.columns)} |", *others))


def to_page(table: Table) -> dict[str, Any]:
    """Return a table as ``page.js`` reads it."""
    return {"title": table.title, "header": list(table.columns), "rows": list(table.rows)}


def to_html(table: Table) -> str:
    """Return a table with its title as HTML; cells are escaped."""
    from html import escape  # noqa: PLC0415 - slow

    def line(tag: str, cells: Sequence[Cell]) -> str:
        return "".join(f"<{tag}>{escape(printable(in_words(cell)))}</{tag}>" for cell in cells)

    rows = "".join(f"<tr>{line('td', row)}</tr>" for row in table.rows)
    caption, head = escape(printable(table.title)), line("th", table.columns)
    return (
        f"<table><caption>{caption}</caption><thead><tr>{head}</tr></thead>"
        f"<tbody>{rows}</tbody></table>"
    )


def as_csv(lines: Iterable[Sequence[Cell]]) -> bytes:
    """Return lines of a table as CSV with line feeds, floats in their shortest exact form."""
    text = io.StringIO()
    write_csv(text, lines)
    return text.getvalue().encode()


def write_csv(file: TextIO, lines: Iterable[Sequence[Cell]]) -> None:
    """Write lines as CSV, one after the other, into a file that keeps line feeds."""

    def inert(cell: Cell) -> Cell:  # a name may look like a formula to spreadsheets
        is_formula = isinstance(cell, str) and cell.startswith(("=", "+", "-", "@", "\t", "\r"))
        return f"'{cell}" if is_formula else cell

    csv.writer(file, lineterminator="\n").writerows(map(inert, line) for line in lines)


def as_xlsx(table: Table) -> bytes:
    """Return a table as a workbook: texts are strings, an equal table has the same bytes.

    Texts are printable. Excel reads the letter of a number in ``_x0041_``, so ``_x`` is escaped.
    """
    from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo  # noqa: PLC0415 - only for this format

    from openpyxl import Workbook  # noqa: PLC0415 - likewise
    from openpyxl.writer.excel import ExcelWriter  # noqa: PLC0415

    workbook = Workbook()
    workbook.properties.created = workbook.properties.modified = datetime(1980, 1, 1, tzinfo=None)
    sheet = workbook.worksheets[0]
    for row, line in enumerate(table.lines, 1):
        for column, value in enumerate(line, 1):
            cell = sheet.cell(row, column, value)
            if isinstance(value, str):
                text = value.replace("_x", "_x005F_x")
                cell.value, cell.data_type, cell.quotePrefix = text, "s", True
    sheet.freeze_panes, sheet.auto_filter.ref = "B2", sheet.dimensions
    written, content = io.BytesIO(), io.BytesIO()
    ExcelWriter(workbook, ZipFile(written, "w")).save()
    with ZipFile(written) as parts, ZipFile(content, "w") as archive:
        for name in parts.namelist():
            archive.writestr(ZipInfo(name), parts.read(name), ZIP_DEFLATED)  # dates of 1980
    return content.getvalue()


def plain(text: str) -> str:
    """Return text that stays in its line and cell of Markdown, without control characters."""
    return printable(text).replace("|", "\\|").replace("<", "&lt;")


@dataclass(frozen=True, slots=True)
class GenerationFitness:
    """Fitness of one generation's population."""

    generation: int
    mean: float
    std: float
    best: float
    worst: float


@dataclass(frozen=True, slots=True)
class Trend:
    """Fitness over the generations, and the least-squares line through their means.

    It describes one run. There is no p-value, because generations of one search are dependent;
    ``study.comparison`` tests algorithms over many seeds.
    """

    generations: tuple[GenerationFitness, ...]
    slope: float
    intercept: float


def find_trend(generations: "Iterable[Generation]") -> Trend:
    """Return the fitness of each generation and the trend of the means."""
    from statistics import linear_regression  # noqa: PLC0415 - slow, and seldom needed

    of = itemgetter("mean", "std", "max", "min")
    rows = tuple(GenerationFitness(each.index, *of(each.statistics)) for each in generations)
    means = [row.mean for row in rows]
    slope, intercept = 0.0, sum(means, 0.0)
    if len(rows) > 1:
        slope, intercept = linear_regression([float(row.generation) for row in rows], means)
    return Trend(rows, slope, intercept)


@dataclass(frozen=True, slots=True)
class TypePattern:
    """Occurrences of one fault type in the top: timed faults, and specifications with one.

    ``share`` is of the top's timed faults, ``pool_share`` of the pool's faults, ``campaign_share``
    of all specifications' timed faults, each in [0, 1]. ``…_expected`` are the occurrences that the
    top would have with these shares.
    """

    type: str
    n_occurrences: int
    n_specifications: int
    share: float
    pool_share: float
    campaign_share: float
    pool_expected: float
    campaign_expected: float


def find_patterns(
    top: Sequence[Specification], tried: Mapping[str, int], pool: FaultPool
) -> tuple[TypePattern, ...]:
    """Count every fault type of the pool in the top, most occurrences first, then by name.

    ``tried`` has the number of each fault, by ID, in the campaign's specifications.
    """
    types = [[pool[timed.fault].type for timed in each] for each in top]
    in_top, in_pool = Counter(chain(*types)), Counter(fault.type for fault in pool)
    in_campaign: Counter[str] = Counter()
    for fault, n_occurrences in tried.items():
        in_campaign[pool[fault].type] += n_occurrences
    containing = Counter(chain.from_iterable(map(set, types)))
    patterns = []
    for kind in in_pool:
        counts = (in_top, in_pool, in_campaign)
        shares = [each[kind] / (each.total() or 1) for each in counts]
        expected = [in_top.total() * share for share in shares[1:]]
        patterns.append(TypePattern(kind, in_top[kind], containing[kind], *shares, *expected))
    return tuple(sorted(patterns, key=lambda pattern: (-pattern.n_occurrences, pattern.type)))


COUNTS = (
    "Ticks at which each goal was violated in belief and in truth. Phantom: in belief only; "
    "masked: in truth only."
)
"""Explanation of the counts in ``goal_table``."""

MOST_LISTED = 100_000
"""Evaluations that ``evaluations.csv`` lists, at most."""

_FAILED_FROM, _BROKEN_IN = "failed from", "broken in"


def goal_table(title: str, mission: Mission, outcome: Outcome) -> Table:
    """Return the results of each goal, in model order.

    If it was flown several times, the last column has in how many flights a goal was violated or
    missed, with the 95 % interval of that share.
    """
    counted = [name for name in COUNTED if name != "missed"]
    counts = [getattr(outcome, name) for name in counted]
    since = outcome.missed_since(mission.duration)
    found = zip(mission.goals, zip(*counts, since, strict=True), outcome.samples, strict=True)
    rows = [(goal.id, goal.task.name, *cells, _samples(goal, n)) for goal, cells, n in found]
    words, columns = ("goal", "task"), (*counted, _FAILED_FROM, "samples")
    if _is_repeated(outcome.repetition):
        n, broken = outcome.repetition.n_flights, outcome.repetition.broken
        shares = (f"{k} of {n} {interval_in_words(k, n)}" for k in broken)
        rows = [(*row, share) for row, share in zip(rows, shares, strict=True)]
        columns += (_BROKEN_IN,)
    return Table(title, (*words, *columns), rows, words, is_compact=True)


def _is_repeated(repetition: Repetition | None) -> TypeGuard[Repetition]:
    return repetition is not None and repetition.n_flights > 1


def late_in_words(mission: Mission, outcome: Outcome) -> str:
    """Return how many ticks were late; empty if none was."""
    found = outcome.repetition
    if found is None or not found.n_late:
        return ""
    n_ticks = found.n_flights * mission.duration
    return f"Commands came too late in {found.n_late} of {n_ticks:,} ticks"


def goals_as_json(mission: Mission, outcome: Outcome) -> list[dict[str, Any]]:
    """Return the content of ``goal_table`` for scripts."""
    results = outcome.results(mission.duration) | {"samples": outcome.samples}
    margins = outcome.margins or [None] * len(mission.goals)
    least, ticks = zip(*(each or (None, None) for each in margins), strict=True)
    results |= {"margin": least, "nearest": ticks}
    if outcome.repetition is not None:
        results["broken_in"] = outcome.repetition.broken
    return [
        {"id": goal.id, "task": goal.task.name, **dict(zip(results, counts, strict=True))}
        for goal, *counts in zip(mission.goals, *results.values(), strict=True)
    ]


def nearest_in_words(mission: Mission, outcome: Outcome) -> str:
    """Return how near goals came to their limits, or how far beyond; empty without such goals."""
    about = "Closest approach of unbroken goals to their limits"
    if outcome.margins is None:
        return f"{about}: not recorded"
    judged = zip(mission.goals, outcome.margins, outcome.true, outcome.missed, strict=True)
    approaches = [
        f"{goal.id} {nearness(mission, goal, margin)} at tick {margin[1]}"
        for goal, margin, *n_broken in judged
        if margin is not None and not any(n_broken)
    ]
    depths = [
        f"{goal.id} by {nearness(mission, goal, depth)} at tick {depth[1]}"
        for goal, depth in zip(mission.goals, outcome.depths, strict=True)
        if depth is not None
    ]
    found = {about: approaches, "Beyond their limits": depths}
    return ". ".join(f"{about}: {', '.join(some)}" for about, some in found.items() if some)


def nearness(mission: Mission, goal: Goal, margin: Margin) -> str:
    """Return a goal's margin, or its depth, with its unit."""
    if goal.task.spares is Range.TICKS:
        return mission.units.ticks(int(margin[0]))
    quantity = mission.units.quantity(margin[0], goal.task.spares)
    return quantity if " " in quantity else f"{quantity} units"


def _samples(goal: Goal, n_samples: int) -> str:
    terms = goal.terms
    return NONE if terms.sensor is None else f"{n_samples} of {terms.target_sample_number}"


def fault_table(title: str, faults: Sequence[NamedFault], outcome: Outcome) -> Table:
    """Return the timed faults of a specification, with their ticks of activity and change."""
    words, texts = ("fault", "type"), ("target", "values")
    rows: list[tuple[Cell, ...]] = []
    for each, *counts in zip(faults, outcome.applied, outcome.changed, strict=True):
        head = (each.name, each.fault.type, each.timed.start, each.timed.finish)
        rows.append((*head, *counts, each.target, each.values_in_words or NONE))
    columns = (*words, "start", "finish", "applied", "changed", *texts)
    folded = ("\n".join(texts), texts)
    return Table(title, columns, rows, words, texts, is_compact=True, folded=folded)


def faults_as_json(faults: Sequence[NamedFault], outcome: Outcome) -> list[dict[str, Any]]:
    """Return the content of ``fault_table`` for scripts."""
    return [
        {"id": fault.fault.id, **fault.as_json(), "applied": applied, "changed": changed}
        for fault, applied, changed in zip(faults, outcome.applied, outcome.changed, strict=True)
    ]


def critical_table(
    measure: "Measure", pool: FaultPool, top: "Sequence[Evaluation]", n_distinct: int
) -> Table:
    """Return the most critical specifications with fitness, results of each goal, and faults.

    Each has a line for believed violations, one for true ones, and one for the tick from which on a
    goal failed. A measure of the campaign that is none of these has a line before them; the number
    of flights in which a goal broke has one after them, if there are several.
    """
    rows: list[tuple[Cell, ...]] = []
    for rank, each in enumerate(top, 1):
        lines = map("\n".join, zip(*_violation_lines(measure, each), strict=True))
        n_timed = Counter(timed.fault for timed in each.specification)
        counts = ((fault.id, n_timed[fault.id]) for fault in pool if fault.id in n_timed)
        faults = " ".join(fault if n == 1 else f"{fault}×{n}" for fault, n in counts)
        rows.append((rank, each.index, each.fitness[0], *lines, faults))
    title = f"The {len(top)} most critical of {n_distinct} fault specifications"
    folded = ("violations", *measure.goals)
    columns = ("#", "evaluation", "fitness", *folded, "faults")
    return Table(title, columns, rows, folded[:1], columns[-1:], folded=("violations", folded))


def _violation_lines(measure: "Measure", evaluation: "Evaluation") -> Iterator[tuple[str, ...]]:
    if not measure.is_shown_by_outcomes:
        measured = measure.by_goal(evaluation)
        name = measure.kind if measure.n_seeds == 1 else f"mean {measure.kind}"
        counts = (ticks(measured[goal]) if goal in measured else NONE for goal in measure.goals)
        yield (name, *counts)
    yield ("believed", *map(str, evaluation.outcome.believed))
    yield ("true", *map(str, evaluation.outcome.true))
    since = evaluation.outcome.missed_since(measure.duration)
    yield (_FAILED_FROM, *map(in_words, since))
    if _is_repeated(found := evaluation.outcome.repetition):
        yield (_BROKEN_IN, *(f"{k} of {found.n_flights}" for k in found.broken))


def map_table(title: str, mission: Mission) -> Table:
    """Return the areas, robots and obstacles of a mission with their places, in distance units."""
    area, obstacles = mission.area, mission.obstacles
    discs = [(each.label, each.goal.name, each.area) for each in mission.goal_discs]
    places = [
        ("mission area", area.id, mission.name, area.center, area.radius),
        *(("robot", each.id, each.name, each.position, each.radius) for each in mission.robots),
        *(("obstacle", each.id, "", each.area.center, each.area.radius) for each in obstacles),
        *(("goal area", label, name, each.center, each.radius) for label, name, each in discs),
    ]
    rows = [(kind, of, name, at.x, at.y, radius) for kind, of, name, at, radius in places]
    return Table(title, ("kind", "id", "name", "x", "y", "radius"), rows)


def mission_table(name: str, mission: Mission, pool: FaultPool) -> Table:
    """Return the robots, goals, obstacles and faults of a mission."""
    parts = {
        "robots": (with_id(each.name, each.id) for each in mission.robots),
        "goals": (with_id(each.name, each.id) for each in mission.goals),
        "obstacles": (each.id for each in mission.obstacles),
        "faults": (f"{each.type} ({each.id})" for each in pool),
    }
    rows = [(what, ", ".join(some) or NONE) for what, some in parts.items()]
    title = f"Mission {name}, {mission.units.ticks(mission.duration)}"
    return Table(title, ("what", "which"), rows)


def settings_table(settings: CampaignSettings) -> Table:
    """Return the settings of the campaign file and the options, by name."""
    rows = (
        (name, " ".join(value) or "none named" if isinstance(value, list) else str(value))
        for name, value in settings.as_json().items()
        if value is not None
    )
    return Table("Settings", ("setting", "value"), sorted(rows))


def pattern_table(title: str, patterns: Iterable[TypePattern]) -> Table:
    """Return how often each fault type occurs, and how often by chance."""
    columns = [field.name.removeprefix("n_") for field in fields(TypePattern)]
    return Table(title, columns, [*map(astuple, patterns)])


def front_table(front: "Front") -> Table:
    """Return the points of a front; a cost that it minimises comes last."""
    columns = ("evaluation", *front.aims)
    rows = [
        (point.evaluation, *point.violations, point.cost)[: len(columns)] for point in front.points
    ]
    title = f"{len(rows)} trade-offs between {', '.join(front.aims)} ({front.counts})"
    return Table(f"Pareto front: {title}", columns, rows)


def harm_table(harm: Iterable["Harm"], measure: "Measure") -> Table:
    """Return the front of harm against a minimised cost; ``by`` is an evaluation."""
    few = str(measure.minimised)
    title = f"Most violations for each limit on {few} ({measure}, {', '.join(measure.chosen)})"
    columns = (few, "goals violated", "goals by", "violations", "violations by")
    return Table(title, columns, [*map(astuple, harm)])


def evaluations_table(title: str, flown: "Iterable[Flown]", measure: "Measure") -> Table:
    """Return evaluations with the results of each goal; several objectives share one cell.

    Counts are of the first mission seed. ``missed_since`` is empty for goals that did not fail.
    """
    counted = (f"{name}_{goal}" for name in RESULTS for goal in measure.goals)
    first = ("evaluation", "generation", "fitness", "n_faults", "fault_ticks")
    rows = (
        (
            each.index,
            each.generation,
            " ".join(map(repr, each.fitness)),
            len(each.outcome.applied),
            each.fault_ticks,
            *chain.from_iterable(each.outcome.results(measure.duration).values()),
            each.outcome.digest,
        )
        for each in flown
    )
    return Table(title, (*first, *counted, "digest"), rows)


def short_evaluations_table(title: str, flown: "Iterable[Flown]", measure: "Measure") -> Table:
    """Return evaluations in ten columns, with counts over all goals, and the goals that failed.

    If they were flown several times, an eleventh has in how many flights which goals broke.
    """

    def broken(found: Repetition) -> str:
        counted = zip(measure.goals, found.broken, strict=True)
        return " ".join(f"{goal} {k}/{found.n_flights}" for goal, k in counted if k)

    flown = [*flown]
    repeated = [each.outcome.repetition for each in flown]
    rows: Iterable[tuple[Cell, ...]] = (
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
    columns: tuple[str, ...] = (*first, *COUNTED[:-1], "goals failed")
    found = [broken(each) for each in repeated if _is_repeated(each)]
    if found and len(found) == len(flown):
        rows = ((*row, each) for row, each in zip(rows, found, strict=True))
        columns += (_BROKEN_IN,)
    return Table(title, columns, rows)
