"""What each fault does alone: for a terminal, as a page, and for a script."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rich.table import Table

from mrsfi_runtime.analysis.effects import AuditRow
from mrsfi_runtime.analysis.markdown import plain, table
from mrsfi_runtime.analysis.other_values import N_PLACES, N_STEPS
from mrsfi_runtime.cli.tables import plain_table
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.measure import violated

_PAGE = """# What each fault does alone

Made by `make docs`; do not edit. Mission `{name}` ({duration} ticks) was flown with one fault of
its pool at a time, with the pool's values, active from tick {start} to tick {finish}, in mission
{seeds}. A fault *changes* a goal where one of the goal's counts (ticks violated as believed,
ticks violated in truth, ticks missed) is other than in the flight without faults in the same seed.

- *touches*: the properties that the fault can change.
- *applied*, *changed*: ticks at which it was active, and at which it changed a value; these and
  the column that follows in seed {seed}.
- *violations*: for every goal with violations, ticks believed / ticks true, and the tick from which
  on it was certain that the goal's purpose is not met, if it was.
- *seeds*: in how many of {n_seeds} seeds it changes each goal.

{rows}

{n_effective} of {n_faults} faults change a goal in seed {seed}, {n_ever} in one of the seeds.

## Why none

{why}

## What other values would do

{what}
"""

_WHY = """A reason is a predicate on two flights in the same weather, with the fault and without it,
compared tick by tick. Where a fault changes no goal, the one that is true is given, and in how
many seeds it is. It says how far the fault comes: nowhere, to what is believed and to no command,
or to where robots are and what they do. Then it says what was left to the limits that the goals'
checks compare with, where that was other than without the fault: the least of all such ticks and
seeds."""

_WHAT = f"""What changes no goal in seed {{seed}} was flown again, with other values within its
bounds. A number takes {N_STEPS} equal steps from its lowest to its highest value, while the fault's
other numbers are the pool's. A place is each crossing of a grid of {N_PLACES} by {N_PLACES}
steps; each place that search knows, where robots begin, goals are pursued and obstacles stand; and
{N_STEPS + 1} places on the path of each robot within the window. For each goal the table has the
nearest of these values that changes it in seed {{seed}}, near in shares of the bounds, and in how
many of {{n_seeds}} seeds that value changes each goal."""


@dataclass(frozen=True, slots=True)
class Effects:
    """What each fault did alone, and how it was flown.

    Attributes
    ----------
    name, mission
        Name of the mission's folder, and the mission.
    seed, n_seeds
        The first mission seed, and how many were flown.
    start, finish
        Window of every fault.
    rows
        In the order of the pool.
    tries_values
        Whether other values were tried.
    """

    name: str
    mission: Mission
    seed: int
    n_seeds: int
    start: int
    finish: int
    rows: Sequence[AuditRow]
    tries_values: bool

    @property
    def title(self) -> str:
        """What a table of them shows."""
        seeds = f"seed {self.seed}"
        if self.n_seeds > 1:
            seeds += f", and changed goals in {self.n_seeds} seeds"
        return (
            f"Each fault of {self.name} alone, ticks {self.start} to {self.finish}; "
            f"violations believed/true in {seeds}"
        )

    def as_json(self) -> list[dict[str, Any]]:
        """Return them for a script."""
        return [self._row_as_json(row) for row in self.rows]

    def _row_as_json(self, row: AuditRow) -> dict[str, Any]:
        goals = self.mission.goal_ids
        return {
            "fault": row.fault.id,
            "type": row.fault.type,
            "touched": list(row.touched),
            "applied": row.outcome.applied[0],
            "changed": row.outcome.changed[0],
            **{
                name: dict(zip(goals, counts, strict=True))
                for name, counts in row.outcome.told(self.mission.duration).items()
            },
            "reason": row.reason,
            "n_seeds": self.n_seeds,
            "seeds": row.n_seeds,
            "reasons": [{"reason": reason, "seeds": n} for reason, n in row.reasons],
            "n_tried": row.n_tried,
            "others": [{"values": other.values, "seeds": other.n_seeds} for other in row.others],
        }

    def table(self) -> Table:
        """Return them for a terminal."""
        cells = (
            (
                row.fault.id,
                row.fault.type,
                row.outcome.applied[0],
                row.outcome.changed[0],
                "\n".join(self._lines(row)),
            )
            for row in self.rows
        )
        words = ("violations, or why no goal changes, and what would change one",)
        return plain_table(("fault", "type"), ("applied", "changed"), cells, words)

    def _lines(self, row: AuditRow) -> Iterator[str]:
        """Yield all that there is to say of a fault, some to a line."""
        violations = self._violations(row)
        if violations:
            yield violations
        if self.n_seeds > 1 and row.n_seeds:
            yield f"changes {_counts(row.n_seeds)} of {self.n_seeds} seeds"
        for reason, n in row.reasons:
            yield f"{n} seeds: {reason}" if self.n_seeds > 1 else reason
        for values, goals in self._others(row):
            yield f"would: {values} → {goals}"

    def page(self) -> str:
        """Return them as a page in Markdown."""
        rows = self.rows
        silent = [row for row in rows if row.reasons]
        last = self.seed + self.n_seeds - 1
        return _PAGE.format(
            name=plain(self.name),
            duration=self.mission.duration,
            seeds=f"seeds {self.seed} to {last}" if self.n_seeds > 1 else f"seed {self.seed}",
            start=self.start,
            finish=self.finish,
            rows=table(_HEADER, map(self._cells, rows)),
            n_effective=sum(not row.reason for row in rows),
            n_faults=len(rows),
            n_ever=sum(bool(row.n_seeds) for row in rows),
            why=self._why(silent),
            what=self._what([row for row in rows if row.reason]),
            seed=self.seed,
            n_seeds=self.n_seeds,
        )

    def _cells(self, row: AuditRow) -> tuple[object, ...]:
        return (
            row.fault.id,
            row.fault.type,
            ", ".join(row.touched) or "–",
            row.outcome.applied[0],
            row.outcome.changed[0],
            self._violations(row) or "–",
            _counts(row.n_seeds) or "–",
        )

    def _why(self, silent: Sequence[AuditRow]) -> str:
        if not silent:
            return "Every fault changes a goal in every seed."
        cells = [
            (row.fault.id, row.fault.type, n, reason) for row in silent for reason, n in row.reasons
        ]
        return f"{_WHY}\n\n{table(('fault', 'type', 'seeds', 'why none'), cells)}"

    def _what(self, silent: Sequence[AuditRow]) -> str:
        if not self.tries_values:
            return "None were tried."
        cells = [
            (row.fault.id, row.fault.type, values, goals)
            for row in silent
            for values, goals in self._others(row)
        ]
        if not silent:
            return "Every fault changes a goal as it is."
        parts = [_WHAT.format(seed=self.seed, n_seeds=self.n_seeds)]
        if cells:
            parts.append(table(("fault", "type", "values", "changes"), cells))
        fixed = ", ".join(plain(row.fault.id) for row in silent if not row.n_tried)
        none = ", ".join(plain(row.fault.id) for row in silent if row.n_tried and not row.others)
        if fixed:
            parts.append(f"There is no value to choose for {fixed}.")
        if none:
            parts.append(f"None of these values changes a goal for {none}.")
        return "\n\n".join(parts)

    def _others(self, row: AuditRow) -> Iterator[tuple[str, str]]:
        for other in row.others:
            values = ", ".join(f"{name} {value:.12g}" for name, value in other.values.items())
            goals = _counts(other.n_seeds) if self.n_seeds > 1 else ", ".join(other.n_seeds)
            yield values, goals

    def _violations(self, row: AuditRow) -> str:
        found = zip(
            self.mission.goal_ids, violated(row.outcome, self.mission.duration), strict=True
        )
        return ", ".join(f"{goal} {words}" for goal, words in found if words != "0/0")


_HEADER = ("fault", "type", "touches", "applied", "changed", "violations", "seeds")


def _counts(by_goal: Mapping[str, int]) -> str:
    return ", ".join(f"{goal} {n}" for goal, n in by_goal.items())
