"""Fault specifications laid out side by side for the compiled flight, and what it leaves."""

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from mrsfi_runtime.engine.compiled.layout import ALLOWED, OWN, PlanSize, packed
from mrsfi_runtime.engine.flights import digested
from mrsfi_runtime.engine.recording import Records, record_type
from mrsfi_runtime.kernel.injections import (
    FaultTally,
    InjectionRow,
    InjectionState,
    OwnRow,
    PlanRows,
)
from mrsfi_runtime.model.outcome import COUNTED, Outcome

_INJECTION = record_type(InjectionState)
_TALLY = record_type(FaultTally)


class Batch:
    """Plans of some specifications in flat arrays, one after the other, and room for their results.

    ``ends``, shape ``(n, 8)``, says where each specification's messages, reports and commands begin
    in ``injections``, where its commands end, where its tallies begin and end, and its ``own``. Of
    those, ``allowed`` returns which words of the belief they may change.
    """

    def __init__(
        self,
        plans: Sequence[PlanRows],
        result_type: np.dtype[Any],
        allowed: Callable[[OwnRow], Sequence[int]],
    ) -> None:
        rows: list[InjectionRow] = []
        ends = []
        n_tallies = 0
        own: list[OwnRow] = []
        for one in plans:
            marks = [len(rows)]
            for injections in one.lists:
                rows.extend(injections)
                marks.append(len(rows))
            last = len(own) + len(one.own)
            ends.append((*marks, n_tallies, n_tallies + one.n_faults, len(own), last))
            own.extend(one.own)
            n_tallies += one.n_faults
        self.injections: Records = np.zeros(len(rows), _INJECTION)
        _fill(self.injections, rows)
        self.own: Records = np.zeros(len(own), OWN)
        _fill(self.own, own)
        self.own[ALLOWED] = [allowed(row) for row in own] or 0
        self.ends = np.array(ends, np.int64)
        self.tallies: Records = np.zeros(n_tallies, _TALLY)
        for name in ("last_applied", "last_changed", "first_changed"):
            self.tallies[name] = -1
        self.results: Records = np.zeros(len(plans), result_type)
        self.plan_size = PlanSize().for_plans(plans)

    def outcome(self, k: int) -> Outcome:
        """Return what the flight of one specification found."""
        of_goals, of_faults = self._counts
        first, last = self._tallied[k]
        counts = [*(column[k] for column in of_goals), *(each[first:last] for each in of_faults)]
        return digested(counts, *(rows[k] for rows in self._packed))

    def tallies_of(self, k: int) -> list[FaultTally]:
        """Return what each fault of one specification did."""
        first, last = self._tallied[k]
        return [FaultTally(*row) for row in self.tallies[first:last].tolist()]

    @cached_property
    def _tallied(self) -> list[list[int]]:
        """Where the tallies of each specification begin and end."""
        ends: list[list[int]] = self.ends[:, 4:6].tolist()
        return ends

    @cached_property
    def _counts(self) -> tuple[list[Any], list[Any]]:
        """What is counted of each specification, and of each fault of all of them."""
        goals = [*(self.results[name] for name in COUNTED), self.results["world"]["goals"]["count"]]
        faults = [self.tallies["applied"], self.tallies["changed"]]
        return [column.tolist() for column in goals], [column.tolist() for column in faults]

    @cached_property
    def _packed(self) -> tuple[list[memoryview], list[memoryview]]:
        return packed(self.results["world"]), packed(self.results["belief"])


def _fill(records: Records, rows: Sequence[tuple[Any, ...]]) -> None:
    """Write rows into records that begin alike."""
    for name, column in zip(records.dtype.names or (), zip(*rows, strict=True), strict=False):
        records[name] = column
