"""Tables that the commands print, and what scripts get in their place."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, TypeAlias

from rich import box
from rich.table import Table
from rich.text import Text

from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.mission import Goal, Mission
from mrsfi_runtime.model.outcome import COUNTED, Outcome
from mrsfi_runtime.record.measure import MISSED_FROM, NONE, UNKNOWN, Measure, missed_from, ticks
from mrsfi_runtime.record.named_faults import FAULT_COLUMNS, NamedFault, fault_rows
from mrsfi_runtime.record.store import Evaluation


def plain_table(
    left: Sequence[str],
    right: Sequence[str],
    rows: Iterable[Sequence[object]] = (),
    last: Sequence[str] = (),
) -> Table:
    """Return a table of left-aligned columns, right-aligned ones, and ones whose words may wrap.

    Nothing in a cell becomes markup.
    """
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
    for name in left:
        table.add_column(Text(name), no_wrap=True)
    for name in right:
        table.add_column(Text(name), justify="right")
    for name in last:
        table.add_column(Text(name))
    for row in rows:
        table.add_row(*(Text(str(cell)) for cell in row))
    return table


def goal_table(mission: Mission, outcome: Outcome) -> Table:
    """Return what happened to each goal, in model order."""
    counts = [name for name in COUNTED if name != "missed"]
    missed = missed_from(outcome, mission.duration)
    rows = (
        (
            goal.id,
            goal.task.name,
            *(getattr(outcome, name)[index] for name in counts),
            missed[index],
            _samples(goal, outcome.samples[index]),
        )
        for index, goal in enumerate(mission.goals)
    )
    header = (*counts, MISSED_FROM.replace(" ", "\n"), "samples")
    table = plain_table(("goal", "task", *header), (), rows)
    for column in table.columns[2:]:
        column.justify = "right"
    table.padding = (0, 1, 0, 0)  # so that it fits into 80 columns
    return table


def goals_as_json(mission: Mission, outcome: Outcome) -> list[dict[str, Any]]:
    """Return what ``goal_table`` shows, for scripts."""
    told = outcome.told(mission.duration) | {"samples": outcome.samples}
    return [
        {
            "id": goal.id,
            "task": goal.task.name,
            **{name: counts[index] for name, counts in told.items()},
        }
        for index, goal in enumerate(mission.goals)
    ]


def _samples(goal: Goal, n_samples: int) -> str:
    terms = goal.terms
    return NONE if terms.sensor is None else f"{n_samples} of {terms.target_sample_number}"


_LEAST_FOR_FAULTS = 16
"""Columns that faults have at least, beside goals with a column each."""

_N_LEFT, _N_NARROW = 2, 6
"""Columns of ``FAULT_COLUMNS`` that are aligned left, and that stand in a narrow table too."""


def fault_tables(faults: Sequence[NamedFault], outcome: Outcome) -> tuple[Table, Table]:
    """Return what each timed fault of a specification is, and what it did.

    The second table is for where the first does not fit: targets stand above values.
    """
    left, right, told = (
        FAULT_COLUMNS[:_N_LEFT],
        FAULT_COLUMNS[_N_LEFT:_N_NARROW],
        FAULT_COLUMNS[_N_NARROW:],
    )
    rows = fault_rows(faults, outcome)
    wide = plain_table(left, right, rows, told)
    for column in wide.columns[_N_NARROW:]:
        column.no_wrap = True
    stacked = (
        (*row[:_N_NARROW], "\n".join(map(str, row[_N_NARROW:])).removesuffix(f"\n{NONE}"))
        for row in rows
    )
    narrow = plain_table(left, right, stacked, ("\n".join(told),))
    narrow.columns[-1].min_width = _LEAST_FOR_FAULTS
    narrow.columns[-1].overflow = "fold"
    narrow.padding = (0, 1, 0, 0)
    return wide, narrow


def faults_as_json(faults: Sequence[NamedFault], outcome: Outcome) -> list[dict[str, Any]]:
    """Return what ``fault_tables`` show, for scripts."""
    return [
        {"id": fault.fault.id, **fault.as_json(), "applied": applied, "changed": changed}
        for fault, applied, changed in zip(faults, outcome.applied, outcome.changed, strict=True)
    ]


def critical_tables(
    measure: Measure, pool: FaultPool, evaluations: Sequence[Evaluation]
) -> tuple[Table, Table]:
    """Return specifications with their fitness, violations per goal, and faults.

    Before the lines of ``_ranked`` comes one for the campaign's measure if it is another.
    """
    header = ("#", "evaluation", "fitness")
    rows = (
        (
            (str(rank), str(evaluation.index), f"{evaluation.fitness[0]:.2f}"),
            dict(_violation_lines(measure, evaluation)),
            _fault_counts(pool, evaluation.specification),
        )
        for rank, evaluation in enumerate(evaluations, 1)
    )
    return _ranked(header, measure.goals, rows)


_Ranked: TypeAlias = tuple[Sequence[str], Mapping[str, Sequence[str]], str]
"""First cells, what came of each goal by what it says, and faults."""


def _ranked(
    header: Sequence[str], goals: Sequence[str], rows: Iterable[_Ranked]
) -> tuple[Table, Table]:
    """Return rows of what came of goals, and of faults.

    Each takes a line for violations as the collective intelligence believed them, one for those
    that were true, and one for the tick from which on a goal was certain to be missed. The first
    table has a column for each goal; the second, for where these do not fit, names the goals that
    were violated, or missed: ``g3:509 g5:915``.
    """
    wide, narrow = plain_table((), header), plain_table((), header)
    for table in (wide, narrow):
        for column in table.columns:
            column.no_wrap = True
    wide.add_column("violations", no_wrap=True)
    for goal in goals:
        wide.add_column(Text(goal), justify="right", no_wrap=True)
    wide.add_column("faults", overflow="fold", min_width=_LEAST_FOR_FAULTS)
    narrow.add_column("violations")
    narrow.add_column("faults")
    for head, lines, faults in rows:
        columns = map("\n".join, zip(*lines.values(), strict=True))
        wide.add_row(*head, "\n".join(lines), *columns, Text(faults))
        named = (f"{name} {_violated(goals, name, line)}" for name, line in lines.items())
        narrow.add_row(*head, Text("\n".join(named)), Text(faults))
    return wide, narrow


def _violated(goals: Sequence[str], name: str, cells: Sequence[str]) -> str:
    """Return the goals that a line says something of: ``g3:509 g5:915``; ``?`` if it cannot."""
    nothing = {NONE, UNKNOWN} if name == MISSED_FROM else {NONE, "0", "0.00"}
    pairs = zip(goals, cells, strict=True)
    named = " ".join(f"{goal}:{cell}" for goal, cell in pairs if cell not in nothing)
    return named or (UNKNOWN if UNKNOWN in cells else "none")


def _violation_lines(
    measure: Measure, evaluation: Evaluation
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield what came of each goal, by what it says."""
    if not measure.is_shown_by_outcomes:
        measured = measure.by_goal(evaluation)
        name = measure.kind if measure.n_seeds == 1 else f"mean {measure.kind}"
        yield (
            name,
            tuple(ticks(measured[goal]) if goal in measured else NONE for goal in measure.goals),
        )
    yield from _outcome_lines(evaluation.outcome, measure.duration)


def _outcome_lines(outcome: Outcome, duration: int) -> Iterator[tuple[str, tuple[str, ...]]]:
    yield "believed", tuple(map(str, outcome.believed))
    yield "true", tuple(map(str, outcome.true))
    yield MISSED_FROM, missed_from(outcome, duration)


def _fault_counts(pool: FaultPool, specification: Specification) -> str:
    """Return the faults of a specification in the order of the pool: ``f4 f9×2 f11``."""
    counts = Counter(timed.fault for timed in specification)
    return " ".join(
        fault.id if counts[fault.id] == 1 else f"{fault.id}×{counts[fault.id]}"
        for fault in pool
        if fault.id in counts
    )
