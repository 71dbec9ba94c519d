"""The report of a campaign for a paper: tables with booktabs, figures as PDF at column width."""

from collections.abc import Iterable, Iterator, Sequence

from mrsfi_runtime.analysis.campaign_tables import critical_table, settings_table
from mrsfi_runtime.analysis.illustrations import Illustration
from mrsfi_runtime.analysis.summary import Summary
from mrsfi_runtime.analysis.table import Cell, Table, in_words, printable
from mrsfi_runtime.analysis.weaknesses import matrix_table, way_table
from mrsfi_runtime.causes.mildest import least

_HEAD = r"""\documentclass[twocolumn]{article}
\usepackage[T1]{fontenc}
\usepackage{booktabs,graphicx,textcomp}
\begin{document}
"""
_SPECIAL = {
    **{letter: f"\\{letter}" for letter in "&%$#_{}"},
    "\\": r"\textbackslash{}",
    "[": "{[}",  # which after the end of a row would say how much space to leave, as would a star
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
"""What letters become that mean something to LaTeX, or that its usual fonts lack."""

_USUAL = {chr(n) for n in (*range(0x20, 0x7F), *range(0xA0, 0x17F))} - {*"ĦħĸĿŀŉŦŧ"} | {
    *"\u2018\u2019\u201c\u201d\u2014\u2022\u20ac\u2122"
}
"""Letters that pdfLaTeX sets with these packages; of others the number is shown."""


def in_latex(text: str) -> str:
    """Return a text in one line that LaTeX sets as it stands."""
    return "".join(
        _SPECIAL.get(letter, letter if letter in _USUAL else f"{{[}}U+{ord(letter):04X}]")
        for letter in printable(text)
    )


def to_latex(table: Table) -> str:
    """Return a table that floats, at most as wide as the page, with its title as caption."""

    def line(cells: Sequence[Cell]) -> str:
        return " & ".join(in_latex(in_words(cell)) for cell in cells) + r" \\"

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
    return "\n\n".join((_HEAD, *_parts(summary, shown), "\\end{document}\n"))


def _parts(summary: Summary, shown: Iterable[Illustration]) -> Iterator[str]:
    mission, pool = summary.mission, summary.pool
    yield f"\\section*{{Campaign {in_latex(summary.folder.name)} on {in_latex(summary.name)}}}"
    halves = (f"\\texttt{{{half}}}" for half in (summary.digest[:32], summary.digest[32:]))
    yield "\\\\\n".join((f"{summary.counted}, of digest", *halves))
    if summary.unrepeated:
        yield f"Caution: {in_latex(summary.unrepeated)}."
    if summary.harvest is not None:
        yield "\n".join(f"{in_latex(each)}." for each in summary.said)
        items = "\n".join(f"\\item {in_latex(each.sentence)}." for each in summary.verdicts)
        yield f"\\begin{{itemize}}\n{items}\n\\end{{itemize}}"
    if summary.ways:
        yield to_latex(matrix_table(mission, pool, summary.ways))
        title = "The least that breaks each goal, in its mildest form"
        yield to_latex(way_table(title, mission, pool, least(summary.ways)))
    yield to_latex(critical_table(summary.measure, pool, summary.top, summary.n_distinct))
    yield to_latex(settings_table(summary.settings))
    for each in shown:
        yield (
            "\\begin{figure}\n\\centering\n"
            f"\\includegraphics[width=\\columnwidth]{{figures/{each.name}.pdf}}\n"
            f"\\caption{{{in_latex(each.table.title)}}}\n\\end{{figure}}"
        )
