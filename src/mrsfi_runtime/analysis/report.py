"""Writes what a campaign found into its folder: specifications, figures, tables, report."""

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TypeAlias

from mrsfi_runtime.analysis import tables
from mrsfi_runtime.analysis.drawing_process import Draw, draw_here
from mrsfi_runtime.analysis.figures import illustrate
from mrsfi_runtime.analysis.markdown import report_text
from mrsfi_runtime.analysis.summary import Summary, as_json, parameter_values, summarise
from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.mission import MissionCode
from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.record.campaign import CampaignStore
from mrsfi_runtime.record.folder import CampaignFolder

SpecificationRow: TypeAlias = tuple[str, int, int, Mapping[str, float]]
"""Pool fault ID, start, finish, and values by parameter name."""

SpecificationWriter: TypeAlias = Callable[[Sequence[SpecificationRow], Path, str], None]
"""Writes rows as a fault specification to a path, under an identifier."""


def write_report(
    folder: Path,
    code: MissionCode,
    write_specification: SpecificationWriter,
    *,
    ratio: str | None = None,
    draw: Draw = draw_here,
) -> Summary:
    """Write everything a person or a script wants from a campaign, finished or interrupted.

    Parameters
    ----------
    folder
        Campaign folder. Of an earlier report there, every file is replaced or removed.
    code
        Mission and pool that the campaign ran on.
    write_specification
        Writes one critical specification as XMI.
    ratio
        Ratio of violations to pick by, such as ``g3:g1=2:1``.
    draw
        Draws the figures.

    Returns
    -------
    Summary
        What the report says.

    Raises
    ------
    RecordError
        If the campaign cannot be read, or its folder not be written.
    UsageError
        If the ratio makes no sense.
    """
    with CampaignStore.open(folder) as store:
        evaluations, generations = store.evaluations(), store.generations()
        summary = summarise(folder, store, code.mission, code.pool, ratio, evaluations)
    layout = CampaignFolder(folder)
    try:
        shown = tuple(illustrate(summary, code.mission, evaluations, generations))
        _emptied(layout.figures, "figure_*.*")
        finish = draw([(each.drawing, layout.figures / each.name) for each in shown])
        _write_critical(layout, summary, code.pool, write_specification)
        _emptied(layout.tables, "*.csv")
        all_rows = tables.evaluations_table(evaluations, summary.measure)
        for name, rows in (*((each.name, each.rows) for each in shown), ("evaluations", all_rows)):
            (layout.tables / f"{name}.csv").write_bytes(tables.as_csv(rows))
        content = json.dumps(as_json(summary, code.pool), indent=2, ensure_ascii=False)
        layout.summary.write_text(content + "\n", encoding="utf-8")
        captions = {each.name: each.caption for each in shown}
        layout.report.write_text(report_text(summary, captions), encoding="utf-8")
        finish()
    except OSError as error:
        raise RecordError(
            f"{folder}: cannot write the report: {error}; expected a folder to write to"
        ) from error
    return summary


def critical_name(rank: int) -> str:
    """Return the file name of the specification at a rank, from 1."""
    return f"{rank:02d}.xmi"


def specification_rows(
    pool: FaultPool, specification: Specification
) -> tuple[SpecificationRow, ...]:
    """Return a specification with its values by name."""
    return tuple(
        (timed.fault, timed.start, timed.finish, parameter_values(pool, timed))
        for timed in specification
    )


def _write_critical(
    layout: CampaignFolder, summary: Summary, pool: FaultPool, write: SpecificationWriter
) -> None:
    _emptied(layout.critical, "[0-9][0-9].xmi")
    for rank, evaluation in enumerate(summary.top, start=1):
        rows = specification_rows(pool, evaluation.specification)
        write(rows, layout.critical / critical_name(rank), f"evaluation_{evaluation.index}")


def _emptied(folder: Path, pattern: str) -> None:
    """Make a folder, or remove from it what an earlier report left."""
    folder.mkdir(exist_ok=True)
    for file in sorted(folder.glob(pattern)):
        file.unlink()
