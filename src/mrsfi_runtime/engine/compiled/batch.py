"""Fault specifications laid out side by side for the compiled flight, and what it leaves.

What flights read and write is in arrays, of which they are given the directory.
"""

from collections.abc import Callable, Iterable, Sequence, Sized
from dataclasses import astuple
from functools import cached_property
from itertools import accumulate, chain
from typing import Any

import numpy as np
import numpy.typing as npt

from mrsfi_runtime.engine.compiled.layout import (
    ALLOWED,
    OWN,
    FreshState,
    Words,
    entries,
    n_entries,
    packed,
)
from mrsfi_runtime.engine.flights import digested
from mrsfi_runtime.engine.recording import Records, record_type
from mrsfi_runtime.kernel.flight import Verdicts
from mrsfi_runtime.kernel.injections import (
    FaultTally,
    InjectionState,
    OwnRow,
    Plan,
    PlanRows,
    TriggerState,
    WaitingState,
)
from mrsfi_runtime.model.mission import COUNTED, Outcome

_INJECTION = record_type(InjectionState)
_TALLY = record_type(FaultTally)
_TRIGGERS = {"triggers": record_type(TriggerState), "waiting": record_type(WaitingState)}
_PLACES = {name: entry.place for name, entry in entries(Plan).items()}


class Batch:
    """Plans of some specifications, one after the other, and room for their results.

    ``plans`` and ``verdicts`` have a directory a specification. Of own faults, ``allowed`` returns
    which words of the belief they may change.
    """

    def __init__(
        self,
        plans: Sequence[PlanRows],
        result_type: np.dtype[Any],
        allowed: Callable[[OwnRow], Sequence[int]],
    ) -> None:
        self._plans: Words = np.zeros((len(plans), n_entries(Plan), 2), np.int64)
        self._n_held = [one.n_held for one in plans]
        self._plans[:, _PLACES["held"], 1] = self._n_held
        injections = zip(*(one.lists for one in plans), strict=True)
        self._injections = [
            self._listed(name, _records(_INJECTION, lists), lists)
            for name, lists in zip(("messages", "reports", "commands"), injections, strict=True)
        ]
        own = [one.own for one in plans]
        self._own = self._listed("own", _records(OWN, own), own)
        self._own[ALLOWED] = [allowed(row) for one in plans for row in one.own] or 0
        tallies: Records = np.zeros(sum(one.n_faults for one in plans), _TALLY)
        tallies[:] = astuple(FaultTally())
        self._tallies = self._listed("tallies", tallies, [range(one.n_faults) for one in plans])
        self._triggers = self._triggered(plans) if any(one.triggers for one in plans) else ()
        ends = accumulate(one.n_faults for one in plans)
        self._tallied = [(end - one.n_faults, end) for end, one in zip(ends, plans, strict=True)]
        self.results: Records = np.zeros(len(plans), result_type)

    def _listed(self, name: str, records: Records, lists: Iterable[Sized]) -> Records:
        """Return the records of all plans, and enter in the directories where each plan's lie."""
        sizes = np.array([*map(len, lists)], np.int64)
        begins = np.cumsum(sizes) - sizes
        self._plans[:, _PLACES[name], 0] = records.ctypes.data + begins * records.itemsize
        self._plans[:, _PLACES[name], 1] = sizes
        return records

    def _triggered(self, plans: Sequence[PlanRows]) -> tuple[Records, ...]:
        """Return the records of what sets faults off, which plans without any do not have."""
        sources = np.array([number for one in plans for number in one.sources], np.int64)
        found = [self._listed("sources", sources, [one.sources for one in plans])]
        for name, layout in _TRIGGERS.items():
            lists = [getattr(one, name) for one in plans]
            records = _records(layout, lists)
            if name == "triggers":
                records["fired"] = -1
            found.append(self._listed(name, records, lists))
        return tuple(found)

    def plans(self, first: int, last: int) -> tuple[Words, Any]:
        """Return the directories of some plans, and the room in which they hold messages back."""
        held = np.zeros(max(self._n_held[first:last], default=0))
        found = self._plans.copy()
        found[:, _PLACES["held"], 0] = held.ctypes.data
        return found, held

    @cached_property
    def verdicts(self) -> Words:
        """Directories of the verdicts, which are part of the results."""
        fields: Any = self.results.dtype.fields
        rows = self.results.ctypes.data + np.arange(len(self.results)) * self.results.itemsize
        found = np.zeros((len(self.results), n_entries(Verdicts), 2), np.int64)
        for name, entry in entries(Verdicts).items():
            found[:, entry.place, 0] = rows + fields[name][1]
            found[:, entry.place, 1] = fields[name][0].itemsize // 8
        return found

    def outcome(self, k: int, measured: Sequence[bool]) -> Outcome:
        """Return what the flight of one specification found; ``measured`` goals have a margin."""
        of_goals, of_faults = self._counts
        first, last = self._tallied[k]
        counts = [*(column[k] for column in of_goals), *(each[first:last] for each in of_faults)]
        margin, nearest, *detection = (column[k] for column in self._beside)
        beside = zip(margin, nearest, measured, strict=True), zip(*detection, strict=True)
        return digested(counts, *beside, *(rows[k] for rows in self._packed))

    def tallies_of(self, k: int) -> list[FaultTally]:
        """Return what each fault of one specification did."""
        first, last = self._tallied[k]
        return [FaultTally(*row) for row in self._tallies[first:last].tolist()]

    @cached_property
    def _counts(self) -> tuple[list[Any], list[Any]]:
        goals = [*(self.results[name] for name in COUNTED), self.results["world"]["goals"]["count"]]
        faults = [self._tallies["applied"], self._tallies["changed"]]
        return [column.tolist() for column in goals], [column.tolist() for column in faults]

    @cached_property
    def _beside(self) -> list[Any]:
        names = ("margin", "nearest", "broken", "undetected")
        return [self.results[name].tolist() for name in names]

    @cached_property
    def _packed(self) -> tuple[list[memoryview], list[memoryview]]:
        return packed(self.results["world"]), packed(self.results["belief"])


def _records(layout: np.dtype[Any], lists: Iterable[Sequence[tuple[Any, ...]]]) -> Records:
    rows = [*chain.from_iterable(lists)]
    records: Records = np.zeros(len(rows), layout)
    for name, column in zip(layout.names or (), zip(*rows, strict=True), strict=False):
        records[name] = column
    return records


class Frame:
    """Three states, and what is flown in them: all of the mission, unless ``keep`` says else."""

    def __init__(
        self, fresh: FreshState, calls: Words, batch: Batch, span: tuple[int, int]
    ) -> None:
        n = fresh.n_changing
        self._fresh = fresh
        self._states = [fresh.words.copy() for _ in range(3)]
        directories = [fresh.directory(words, calls) for words in self._states]
        plans, held = batch.plans(*span)
        self._at = np.array([0, 0, len(fresh.samples)], np.int64)
        self._n_moments = np.zeros(1, np.int64)
        self._moments: Records = np.zeros(0, np.int64)
        arrays: list[npt.NDArray[Any]] = [
            self._n_moments,
            self._at,
            _addresses(directories),
            fresh.words[:n],
            *(words[:n] for words in self._states),
            fresh.samples,
            _addresses(plans),
            _addresses(batch.verdicts),
            batch.results,
            self._moments,
        ]
        sizes = [array.nbytes // (1 if array is fresh.samples else 8) for array in arrays]
        self._kept = (arrays, directories, plans, held, calls, batch)
        addresses = [array.ctypes.data for array in arrays]
        self.directory: Words = np.array(list(zip(addresses, sizes, strict=True)), np.int64)

    def keep(self, moments: Records, begin: int, end: int) -> None:
        """Fly from one tick on and before another next, and keep as many as there is room for."""
        self._at[1:] = begin, end
        self._n_moments[0] = len(moments)
        self._moments = moments
        self.directory[-1] = moments.ctypes.data, moments.nbytes // 8

    @property
    def at(self) -> int:
        """Number of the specification that flies."""
        return int(self._at[0])

    @property
    def tick(self) -> int:
        """Tick of the mission that flies."""
        return int(self._states[0][self._fresh.tick])

    @property
    def has_written_to_tables(self) -> bool:
        """Whether a flight has changed what none may change."""
        n = self._fresh.n_changing
        return any(not np.array_equal(words[n:], self._fresh.words[n:]) for words in self._states)


def _addresses(rows: Sequence[Words] | Words) -> Words:
    return np.array([row.ctypes.data for row in rows], np.int64)
