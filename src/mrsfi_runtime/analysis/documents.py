"""Write a campaign for people: Markdown and LaTeX.

No text of a model becomes markup in either format. ``report_text`` writes the Markdown report.
``report_latex`` writes tables with booktabs and figures at column width.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from mrsfi_runtime.analysis import tables
from mrsfi_runtime.analysis.summary import Illustration, Summary
from mrsfi_runtime.analysis.tables import Cell, Table, Trend, TypePattern, plain
from mrsfi_runtime.analysis.weaknesses import broken_by, matrix_table, weakness_table
from mrsfi_runtime.causes.mildest import least
from mrsfi_runtime.errors import printable
from mrsfi_runtime.record.observers import named_faults

_FREQUENT = (
    "A frequent fault type need not be harmful. Compare its occurrences with the two expected "
    "numbers, which follow from its share in the pool and in all specifications of the campaign. A "
    "type may also be frequent because it occurs together with a harmful one."
)


def report_text(summary: Summary, captions: Mapping[str, str]) -> str:
    """Return the report, which links the figures that ``captions`` names."""
    step = tables.every(summary.n_evaluations, tables.MOST_LISTED)
    listed = f" `tables/evaluations.csv` lists one evaluation in {step}; `campaign.sqlite` has all."
    extent = (
        f"{summary.counted} of {summary.n_distinct} distinct specifications in "
        f"{summary.n_generations} finished generations; {summary.n_failures} ended with an error. "
        f"Digest over all evaluations: `{summary.digest}`. Semantics: {summary.semantics}."
    )
    sections = [
        f"# Campaign {plain(summary.folder.name)} on mission {plain(summary.name)}",
        f"{extent}{listed if step > 1 else ''}",
        *([f"**Caution**: {plain(summary.unrepeated)}."] if summary.unrepeated else []),
        *_weaknesses(summary),
        *_section(tables.settings_table(summary.settings)),
        "## Fitness over the generations",
        trend_in_words(summary.trend),
        *_linked(captions, "fitness"),
        *_top(summary),
        *_section(_occurring("Fault types in these specifications", summary.patterns), _FREQUENT),
        *_linked(captions, "fault_types"),
    ]
    if summary.weaknesses:
        sections += _section(
            _occurring("Fault types in the weaknesses", summary.guilty),
            "The same numbers for all weaknesses. A type that is listed above but not here is part "
            "of no known weakness.",
        )
        sections += _linked(captions, "figure_12_weaknesses")
    if summary.front is not None:
        words = "The non-dominated specifications. Of equal ones, the earliest is listed."
        sections += [
            *_section(tables.front_table(summary.front), words),
            *_linked(captions, "front"),
        ]
    if summary.harm is not None:
        sections += _section(
            tables.harm_table(summary.harm, summary.measure),
            f"For each limit on {summary.measure.minimised}: the most goals that one specification "
            "within this limit violates, the most violations in total, and the evaluations that "
            "found them. Limits that are not listed have the numbers of the line above.",
        )
        sections += _linked(captions, "harm")
    if summary.pick is not None:
        picked = summary.pick.in_words(summary.measure)
        words = f"The specification {picked}. `mrsfi replay` simulates any evaluation again."
        sections += ["## Pick by ratio", words]
    sections += ["## Mission", *_linked(captions, "mission_map")]
    return "\n\n".join(sections) + "\n"


def _section(table: Table, *words: str, level: int = 2) -> Iterator[str]:
    yield f"{'#' * level} {plain(table.title)}"
    yield from words
    yield tables.to_markdown(table)


def _occurring(title: str, patterns: Sequence[TypePattern]) -> Table:
    return tables.pattern_table(title, [each for each in patterns if each.n_occurrences])


def trend_in_words(trend: Trend) -> str:
    """Return how mean fitness changed; not a test, because generations depend on each other."""
    rows = trend.generations
    if len(rows) < 3:
        return f"{len(rows)} finished generations are too few for a trend."
    return (
        f"Mean fitness changes from {rows[0].mean:,.4g} in generation {rows[0].generation} to "
        f"{rows[-1].mean:,.4g} in generation {rows[-1].generation}, {trend.slope:+.3g} per "
        "generation (least squares). This describes one run and is not a statistical test, because "
        "its generations depend on each other; `mrsfi compare` tests over many seeds. "
        f"The best fitness of all generations is {max(row.best for row in rows):,.6g}."
    )


def _top(summary: Summary) -> Iterator[str]:
    measure, top = summary.measure, summary.top
    table = tables.critical_table(measure, summary.pool, top, summary.n_distinct)
    if not top:
        yield f"## {table.title}"
        yield "No evaluation is recorded yet."
        return
    measured = "" if measure.is_shown_by_outcomes else f", {measure}; then"
    seed = ", in the first mission seed" if measure.n_seeds > 1 else ""
    yield from _section(
        table,
        f"For each goal{measured}{seed}: the number of ticks at which it was violated in belief "
        "(of the collective intelligence) and in truth (in the simulation), and the tick from "
        "which on it fails, if it does.",
    )
    yield (
        "The tables below list the faults of each specification. *start* and *finish* are the "
        "window of a fault, *applied* and *changed* the numbers of ticks at which it was active "
        "and changed a value. *target* is the affected property, after its message, if any."
    )
    of_each = zip(top, summary.faults, summary.contained, strict=True)
    for rank, (evaluation, faults, known) in enumerate(of_each, 1):
        title = f"Specification {rank}, evaluation {evaluation.index}"
        yield from _section(tables.fault_table(title, faults, evaluation.outcome), level=3)
        yield (
            f"Generation {evaluation.generation}, {evaluation.fault_ticks} fault-ticks, "
            f"file [critical/{rank:02d}.xmi](critical/{rank:02d}.xmi)."
        )
        if known:
            causes = (f"{one.number} ({one.goal} by {' and '.join(one.faults)})" for one in known)
            yield f"It contains the weaknesses {', '.join(causes)}."


def _weaknesses(summary: Summary) -> Iterator[str]:
    if summary.harvest is None:
        return
    mission, pool, (headline, *facts) = summary.mission, summary.pool, summary.highlights
    yield f"## {plain(headline)}"
    facts += [f"{each.in_full}. Evidence: {' · '.join(each.evidence)}" for each in summary.verdicts]
    yield "\n".join(f"- {plain(each)}." for each in facts)
    if not summary.weaknesses:
        return
    matrix = matrix_table(mission, pool, summary.weaknesses)
    title, key = matrix.title.split("\n")
    yield from _section(replace(matrix, title=title), f"{key}.", level=3)
    title = "Weaknesses, by goal"
    yield from _section(
        weakness_table(title, mission, pool, summary.weaknesses),
        "The faults of each weakness in one variant. A percentage is the share of variants "
        "that break the goal, by each measure; *seeds* counts mission seeds in which this variant "
        "does. `weaknesses/` has each weakness by its number as a fault specification, and the "
        "mildest variant of those below. `mrsfi show RUN N` draws weakness N in time and space.",
        level=3,
    )
    if summary.decided:
        yield "### Decisions on weaknesses"
        yield "\n".join(f"- Weakness {n}: {plain(words)}" for n, words in summary.decided.items())
    for weakness in least(summary.weaknesses):
        title = f"{mission.label_of(weakness.goal)}, weakness {weakness.number}"
        faults = named_faults(mission, pool, weakness.shown.witness)
        outcome = summary.outcome(weakness)
        goals, by = tables.goal_table(title, mission, outcome), broken_by(weakness, mission.units)
        yield from _section(goals, f"{by} {tables.COUNTS} First mission seed only.", level=3)
        yield tables.to_markdown(tables.fault_table("", faults, outcome))
        if sentences := summary.sentences.get(weakness.number):
            yield "\n".join(f"- {plain(each)}" for each in sentences)


def _linked(captions: Mapping[str, str], part: str) -> list[str]:
    return [
        f"![{caption}](figures/{name}.png)" for name, caption in captions.items() if part in name
    ]


LATEX_HEAD = r"""\documentclass[twocolumn]{article}
\usepackage[T1]{fontenc}
\usepackage{booktabs,graphicx,textcomp}
\begin{document}
"""
_SPECIAL = {
    **{letter: f"\\{letter}" for letter in "&%$#_{}"},
    "\\": r"\textbackslash{}",
    "[": "{[}",  # after a row's end it would set the spacing, as would a star
    "*": "{*}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "–": "--",
    "…": r"\ldots{}",
    "·": r"\textperiodcentered{}",
    "×": r"\texttimes{}",
    "±": r"\textpm{}",
    "≤": r"$\leq$",
    "→": r"$\to$",
}
"""Replacements of letters that are special in LaTeX or missing in its usual fonts."""

_USUAL = {chr(n) for n in (*range(0x20, 0x7F), *range(0xA0, 0x17F))} - {*"ĦħĸĿŀŉŦŧ"} | {
    *"\u2018\u2019\u201c\u201d\u2014\u2022\u20ac\u2122"
}
"""Letters that pdfLaTeX sets with these packages; others are shown by their numbers."""


def in_latex(text: str) -> str:
    """Return a text as one line of LaTeX in which nothing is a command."""
    return "".join(
        _SPECIAL.get(letter, letter if letter in _USUAL else f"{{[}}U+{ord(letter):04X}]")
        for letter in printable(text)
    )


def to_latex(table: Table) -> str:
    """Return a floating table, at most as wide as the page, with its title as caption."""

    def line(cells: Sequence[Cell]) -> str:
        return " & ".join(in_latex(tables.in_words(cell)) for cell in cells) + r" \\"

    words = {*table.words, *table.texts}
    columns = "".join("l" if name in words else "r" for name in table.columns)
    rows = "\n".join(map(line, table.rows))
    return (
        f"\\begin{{table*}}\n\\centering\n\\caption{{{in_latex(table.title)}}}\n"
        f"\\resizebox{{\\ifdim\\width>\\textwidth\\textwidth\\else\\width\\fi}}{{!}}{{%\n"
        f"\\begin{{tabular}}{{{columns}}}\n\\toprule\n{line(table.columns)}\n\\midrule\n{rows}\n"
        f"\\bottomrule\n\\end{{tabular}}}}\n\\end{{table*}}"
    )


def report_latex(summary: Summary, shown: Iterable[Illustration]) -> str:
    """Return ``report.tex``; its figures are the PDFs in ``figures/``."""
    return "\n\n".join((LATEX_HEAD, *_parts(summary, shown), "\\end{document}\n"))


def _parts(summary: Summary, shown: Iterable[Illustration]) -> Iterator[str]:
    mission, pool = summary.mission, summary.pool
    yield f"\\section*{{Campaign {in_latex(summary.folder.name)} on {in_latex(summary.name)}}}"
    halves = (f"\\texttt{{{half}}}" for half in (summary.digest[:32], summary.digest[32:]))
    yield "\\\\\n".join((f"{summary.counted}, digest", *halves))
    if summary.unrepeated:
        yield f"Caution: {in_latex(summary.unrepeated)}."
    if summary.harvest is not None:
        yield "\n".join(f"{in_latex(each)}." for each in summary.highlights)
        items = "\n".join(f"\\item {in_latex(each.in_full)}." for each in summary.verdicts)
        yield f"\\begin{{itemize}}\n{items}\n\\end{{itemize}}"
    if summary.weaknesses:
        matrix = matrix_table(mission, pool, summary.weaknesses)
        yield to_latex(replace(matrix, title=matrix.title.replace("\n", ". ")))
        title = "One weakness of each goal, in its mildest variant"
        yield to_latex(weakness_table(title, mission, pool, least(summary.weaknesses)))
    yield to_latex(tables.critical_table(summary.measure, pool, summary.top, summary.n_distinct))
    yield to_latex(tables.settings_table(summary.settings))
    for each in shown:
        yield (
            "\\begin{figure}\n\\centering\n"
            f"\\includegraphics[width=\\columnwidth]{{figures/{each.name}.pdf}}\n"
            f"\\caption{{{in_latex(each.table.title)}}}\n\\end{{figure}}"
        )
