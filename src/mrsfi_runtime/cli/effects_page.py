"""What each fault of a pool does alone: as a table of the terminal, and as a page of docs/."""

from collections.abc import Iterator, Sequence

from rich.table import Table
from rich.text import Text

from mrsfi_runtime.analysis.effects import AuditRow
from mrsfi_runtime.analysis.markdown_text import plain, table_row
from mrsfi_runtime.cli.tables import plain_table
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.model.mission import Mission

_PAGE = """# What each fault does alone

Made by `make docs`; do not edit. Mission `{name}` ({duration} ticks, seed {seed}) was
flown {n_faults} times, each time with one fault of its pool, with the pool's values, active
from tick {start} to tick {finish}.

- *touches*: the properties that the fault can change.
- *applied*, *changed*: ticks at which it was active, and at which it changed a value.
- *violations*: for every goal with violations, ticks believed / ticks true.
- *why none*: for a fault that changes no goal in this mission, the reason, as measured.

| fault | type | touches | applied | changed | violations | why none |
|---|---|---|--:|--:|---|---|
"""

_SUMMARY = "\n{n_effective} of {n_faults} faults change a goal.{silent}\n"


def effects_table(mission: Mission, rows: Sequence[AuditRow]) -> Table:
    """Return the audit for a terminal."""
    table = plain_table(("fault", "type"), ("applied", "changed"))
    table.add_column("violations, or why there are none")
    for row in rows:
        table.add_row(
            Text(row.fault.id),
            Text(row.fault.type),
            str(row.outcome.applied[0]),
            str(row.outcome.changed[0]),
            Text(", ".join(_violations(mission, row)) or row.reason),
        )
    return table


def effects_page(
    name: str, engine: Engine, window: tuple[int, int], rows: Sequence[AuditRow]
) -> str:
    """Return the audit as a page in Markdown."""
    mission = engine.code.mission
    head = _PAGE.format(
        name=plain(name),
        duration=mission.duration,
        seed=engine.seed,
        n_faults=len(rows),
        start=window[0],
        finish=window[1],
    )
    return head + "".join(_line(mission, row) for row in rows) + _summary(rows)


def _line(mission: Mission, row: AuditRow) -> str:
    cells = (
        row.fault.id,
        row.fault.type,
        ", ".join(row.touched),
        str(row.outcome.applied[0]),
        str(row.outcome.changed[0]),
        ", ".join(_violations(mission, row)),
        row.reason,
    )
    return table_row(cell or "–" for cell in cells) + "\n"


def _summary(rows: Sequence[AuditRow]) -> str:
    silent = ", ".join(plain(row.fault.type) for row in rows if not row.differs)
    return _SUMMARY.format(
        n_effective=sum(1 for row in rows if row.differs),
        n_faults=len(rows),
        silent=f" These change none, for the reasons given: {silent}." if silent else "",
    )


def _violations(mission: Mission, row: AuditRow) -> Iterator[str]:
    counts = zip(mission.goal_ids, row.outcome.believed, row.outcome.true, strict=True)
    return (f"{goal} {believed}/{true}" for goal, believed, true in counts if believed or true)
