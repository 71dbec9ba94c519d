"""Write a campaign for people and tools: Markdown, LaTeX, failure modes (FMEA) and fault trees.

No text of a model becomes markup or a formula in any of these formats. ``report_text`` writes the
Markdown report, ``report_latex`` tables with booktabs and figures at column width.

A row of the FMEA is a weakness in one variant. ``failure_modes`` returns the rows, ``fmea`` the
table that ``FMEA`` writes in four formats, with the same cells in each. A cell that neither models
nor record nor team can fill is empty. False alarms have a row without severity: the severity of a
goal is that of its violation.

``as_open_psa`` and ``as_pfta`` write fault trees: for each goal, the smallest sets of faults that
truly violate it or make it fail, and for each requirement its goals. Sets that break a goal only in
belief are in no tree.

References
----------
Open-PSA Model Exchange Format 2.0d, "Fault Tree Layer". The syntax of ``pfta``, its ``DOCS.md``.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache, lru_cache
from itertools import chain, count
from operator import itemgetter
from textwrap import fill
from types import MappingProxyType
from typing import Any, NamedTuple
from xml.etree.ElementTree import Comment, Element, SubElement, indent, tostring

from mrsfi_runtime.analysis import tables
from mrsfi_runtime.analysis.summary import Illustration, Summary
from mrsfi_runtime.analysis.tables import NONE, Cell, Table, Trend, TypePattern, plain
from mrsfi_runtime.analysis.weaknesses import (
    broken_by,
    detection,
    effect_class,
    evidence,
    matrix_table,
    weakness_table,
)
from mrsfi_runtime.causes.chain import chains, effects, struck
from mrsfi_runtime.causes.consequences import cut_sets, occurrence
from mrsfi_runtime.causes.mildest import GoalWeakness, least
from mrsfi_runtime.causes.weakness import MEASURES
from mrsfi_runtime.engine.recording import Record
from mrsfi_runtime.errors import printable
from mrsfi_runtime.model.faults import Fault, FaultPool, Specification, elements_of
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.project_file import DETECTIONS
from mrsfi_runtime.record.observers import NamedFault, named_faults

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


HEADS = (
    *("weakness", "item", "function", "failure mode", "local effect", "next effect", "end effect"),
    *("requirement", "effect class", "S", "O", "D", "RPN", "detection", "mildest variant"),
    *("evidence", "recommended action", "owner", "status", "reference", "integrity level"),
    *("faults", "likelihood", "ticks by measure", "most ticks"),
)
"""The columns of an FMEA. Those that docs/find-weaknesses.md does not explain are standard."""


def failure_modes(
    mission: Mission,
    pool: FaultPool,
    weaknesses: Iterable[GoalWeakness],
    record: Record,
    ratings: Mapping[str, Mapping[str, Any]],
    settled: Mapping[int, Mapping[str, str]],
) -> list[dict[str, Cell]]:
    """Return the failure modes of weaknesses: the most severe first, then undetected ones.

    Then come the likeliest, those that make a goal fail, and those that break it for longest.
    A cell is by its column; it describes the mildest known variant, and detection is about all.
    ``settled`` has cells that the team fills, by the numbers of weaknesses.
    """
    fly, units, rated = lru_cache(4)(record), mission.units, ratings.get("occurrence", {})

    @cache
    def flown(variant: Specification) -> tuple[str, str, list[tuple[int, ...]]]:
        by_fault = (effects(mission, each) for each in chains(fly, mission, variant))
        found = zip(*by_fault, strict=True)
        local, following = ("; ".join(each or NONE for each in some) for some in found)
        counts = (fly(variant)[kind][-1].tolist() for kind in MEASURES)
        return local, following, [*zip(*counts, strict=True)]

    def happens(named: NamedFault) -> str:
        window = f"{named.fault.type} from tick {named.timed.start} to {named.timed.finish}"
        return ", ".join(filter(None, (window, named.values_in_words)))

    def mode(weakness: GoalWeakness) -> tuple[tuple[float, ...], dict[str, Cell]]:
        shown, place = weakness.at_least.shown, mission.goal_ids.index(weakness.goal)
        goal, faults = mission.goals[place], named_faults(mission, pool, shown.witness)
        local_effect, next_effect, counts = flown(shown.witness)
        n_ticks = max(counts[place])
        chance, found = occurrence(pool, weakness.faults), weakness.shown.detection
        likely, worst = 1.0 if chance is None else -chance, found.worst if found else ""
        action = with_monitors = ""
        if (watched := weakness.monitored) is not None:
            action = watched.monitor and f"Add a monitor: {watched.monitor}"
            in_time = f"{watched.n_in_time} of {watched.n_variants} in the first mission seed"
            with_monitors = f"; with the recommended monitors in time in {in_time}"
        s = None if shown.column.kind == MEASURES[0] else goal.severity or None
        o = max((int(n) for n, least in rated.items() if least <= -likely), default=None)
        d = ratings.get("detection", {}).get(worst)
        required = (each for each in mission.requirements if each.id in goal.requirements)
        measured = map("{} {}".format, ("believed", "true", "failed"), counts[place])
        row: dict[str, Cell] = {
            "weakness": weakness.number,
            "item": _listed(struck(mission, each) for each in faults),
            "function": _listed(goal for each in faults for goal in _served(mission, each.fault)),
            "failure mode": _listed(map(happens, faults)),
            "local effect": local_effect,
            "next effect": next_effect,
            "end effect": mission.label_of(weakness.goal),
            "requirement": _listed(f"{each.id}: {each.text}" for each in required),
            "effect class": effect_class(weakness),
            "S": s,
            "O": o,
            "D": d,
            "RPN": s * o * d if s and o and d else None,
            "detection": detection(weakness, units) + with_monitors,
            "mildest variant": weakness.mildest.sentence if weakness.mildest else "",
            "evidence": evidence(weakness.at_least),
            "recommended action": action,
            **settled.get(weakness.number, {}),
            "reference": _listed(each.fault.reference for each in faults),
            "integrity level": goal.integrity_level,
            "faults": " ".join(weakness.faults),
            "likelihood": chance,
            "ticks by measure": ", ".join(measured),
            "most ticks": n_ticks,
        }
        late = DETECTIONS.index(worst) if worst else len(DETECTIONS)
        return (-(s or 0), late, likely, shown.column.kind != MEASURES[-1], -n_ticks), row

    return [row for _, row in sorted(map(mode, weaknesses), key=itemgetter(0))]


def _listed(texts: Iterable[str]) -> str:
    return "; ".join(filter(None, dict.fromkeys(texts)))


def _served(mission: Mission, fault: Fault) -> list[str]:
    """Return the goals that name what a fault strikes, or else the robots that it touches."""
    named = {
        goal.id: {*goal.members, *goal.terms.obstacles, goal.terms.sensor}.union(
            each.id for each in goal.messages
        )
        for goal in mission.goals
    }
    struck = [goal for goal, elements in named.items() if fault.target in elements]
    touched = elements_of(mission, fault)
    served = struck or [goal for goal in named if not touched.isdisjoint(named[goal])]
    return [*map(mission.label_of, served)]


def fmea(mission: str, modes: Iterable[Mapping[str, Cell]]) -> Table:
    """Return failure modes of a mission, by its name, as a table whose cells are single lines."""

    def cell(value: Cell) -> Cell:
        if isinstance(value, float):
            return float(f"{value:.15g}")  # openpyxl writes no more digits
        return printable(value) or None if isinstance(value, str) else value

    rows = [[cell(mode.get(head)) for head in HEADS] for mode in modes]
    return Table(f"Failure modes of mission {printable(mission)}", HEADS, rows)


def _as_markdown(table: Table) -> bytes:
    return f"# {plain(table.title)}\n\n{tables.to_markdown(table)}\n".encode()


def _as_latex(table: Table) -> bytes:
    """Return a document with a list of the cells of each failure mode."""
    parts = [LATEX_HEAD, f"\\section*{{{in_latex(table.title)}}}"]
    for number, *cells in table.rows:
        title = in_latex(f"Weakness {number}")
        parts.append(f"\\subsection*{{{title}}}\n\\begin{{description}}")
        named = zip(HEADS[1:], cells, strict=True)
        parts += [f"\\item[{name}] {in_latex(tables.in_words(cell))}" for name, cell in named]
        parts.append("\\end{description}")
    return "\n".join((*parts, "\\end{document}\n")).encode()


FMEA = MappingProxyType(
    {
        ".csv": lambda table: tables.as_csv(table.lines),
        ".xlsx": tables.as_xlsx,
        ".md": _as_markdown,
        ".tex": _as_latex,
    }
)
"""Writers by suffix of the file."""

_COMMENT = (
    "Known minimal sets of faults that truly violate a goal of the mission or make it fail. For a "
    "goal that is not listed, none is known. A requirement is violated with any of its goals."
)
_PFTA_COMMENT = (
    "For pfta 0.4 or newer. The probability of an event is the likelihood of the fault in its "
    "pool, or nan if the pool gives none; then probabilities that depend on it are unknown. That "
    "of a gate is the sum over its sets (order 1), an upper bound; an exact one (all orders) takes "
    "time that doubles with each set."
)


class _Gate(NamedTuple):
    """A gate that needs one of its inputs (``or``) or all of them (``and``)."""

    name: str
    label: str
    kind: str
    inputs: tuple[str, ...]


def _trees(
    mission: Mission, pool: FaultPool, weaknesses: Sequence[GoalWeakness]
) -> tuple[list[list[_Gate]], list[tuple[str, str, Fault]]]:
    """Return the gates of each goal and requirement, top gates first, and names of the faults.

    Faults have labels, too.
    """
    taken: set[str] = set()

    def named(*words: str) -> str:
        """Return a new name of ASCII letters, digits, ``_`` and ``-``, whatever the case."""
        stem = "-".join(re.sub(r"\W", "_", word, flags=re.ASCII) for word in words)[:100]
        names = chain([stem], (f"{stem}-{number}" for number in count(2)))
        name = next(each for each in names if each.lower() not in taken)
        taken.add(name.lower())
        return name

    sets = {goal.id: cut_sets(weaknesses, goal.id) for goal in mission.goals}
    tops = {goal: named(goal) for goal in sets if sets[goal]}
    used = {fault for some in sets.values() for faults in some for fault in faults}
    event = {fault.id: named(fault.id) for fault in pool if fault.id in used}
    trees = []
    for goal in (each for each in mission.goals if each.id in tops):
        below = {
            event[faults[0]] if len(faults) == 1 else named(goal.id, *faults): faults
            for faults in sets[goal.id]
        }
        label = printable(f"{goal.name} ({goal.id}): truly violated or failed")
        joint = [
            _Gate(name, " and ".join(faults), "and", tuple(event[fault] for fault in faults))
            for name, faults in below.items()
            if len(faults) > 1
        ]
        trees.append([_Gate(tops[goal.id], label, "or", tuple(below)), *joint])
    for each in mission.requirements:
        goals = [goal.id for goal in mission.goals if each.id in goal.requirements]
        if broken := tuple(tops[goal] for goal in goals if goal in tops):
            label = printable(f"{each.id}: {each.text}")
            trees.append([_Gate(named(each.id), f"Violated: {label}", "or", broken)])
    return trees, [
        (event[each.id], printable(f"{each.name} ({each.id}): {each.words}"), each)
        for each in pool
        if each.id in used
    ]


def as_open_psa(mission: Mission, pool: FaultPool, weaknesses: Sequence[GoalWeakness]) -> bytes:
    """Return the fault trees in Open-PSA's exchange format, an XML that many tools read."""
    trees, events = _trees(mission, pool, weaknesses)
    root = Element("opsa-mef")
    root.append(Comment(f" {_COMMENT} "))
    gates = {gate.name for tree in trees for gate in tree}
    for tree in trees:
        defined_in = SubElement(root, "define-fault-tree", name=tree[0].name)
        for gate in tree:
            defined = _defined(defined_in, "gate", gate.name, gate.label)
            formula = SubElement(defined, gate.kind) if len(gate.inputs) > 1 else defined
            for name in gate.inputs:
                SubElement(formula, "gate" if name in gates else "basic-event", name=name)
    data = SubElement(root, "model-data")
    for name, label, fault in events:
        defined = _defined(data, "basic-event", name, label)
        if fault.likelihood is not None:
            SubElement(defined, "float", value=repr(fault.likelihood))
    indent(root)
    content: bytes = tostring(root, encoding="utf-8", xml_declaration=True)
    return content + b"\n"


def _defined(parent: Element, what: str, name: str, label: str) -> Element:
    defined = SubElement(parent, f"define-{what}", name=name)
    SubElement(defined, "label").text = label
    return defined


def as_pfta(mission: Mission, pool: FaultPool, weaknesses: Sequence[GoalWeakness]) -> bytes:
    """Return the fault trees as text for ``pfta``."""
    trees, events = _trees(mission, pool, weaknesses)
    comment = fill(f"{_COMMENT} {_PFTA_COMMENT}", 98, initial_indent="# ", subsequent_indent="# ")
    parts = [comment, "- times: nan\n- computational_order: 1"]
    tops = {tree[0].name for tree in trees}
    for gate in (gate for tree in trees for gate in tree):
        kind = gate.kind.upper() if len(gate.inputs) > 1 else "NULL"
        inputs = ", ".join(gate.inputs)
        own = "\n- is_paged: True" * (gate.name in tops)  # a figure, also below a requirement
        parts.append(
            f"Gate: {gate.name}\n- label: {gate.label}{own}\n- type: {kind}\n- inputs: {inputs}"
        )
    for name, label, fault in events:
        chance = "nan" if fault.likelihood is None else fault.likelihood
        model = f"- model_type: Fixed\n- probability: {chance}\n- intensity: nan"
        parts.append(f"Event: {name}\n- label: {label}\n{model}")
    return "\n\n".join((*parts, "")).encode()


FAULT_TREES = MappingProxyType({".xml": as_open_psa, ".txt": as_pfta, ".pft": as_pfta})
"""Writers by suffix of the file."""
