"""Fault specifications laid out side by side for the compiled flight, and what it leaves."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from mrsfi_runtime.engine.compiled.layout import (
    Records,
    Room,
    injection_row,
    record_type,
)
from mrsfi_runtime.engine.flights import digested
from mrsfi_runtime.kernel.injections import FaultTally, InjectionState, Plan
from mrsfi_runtime.model.outcome import Outcome

_INJECTION = record_type(InjectionState)
_TALLY = record_type(FaultTally)


class Batch:
    """Plans of some specifications in flat arrays, and room for their results.

    Attributes
    ----------
    injections, tallies
        Those of all specifications, one after the other.
    ends
        Shape ``(n, 6)``: where each specification's messages, reports and commands begin in
        ``injections``, where its commands end, and where its tallies begin and end.
    results
        One record a specification.
    room
        What a compiled plan must have room for.
    """

    def __init__(self, plans: Sequence[Plan], result_type: np.dtype[Any]) -> None:
        rows: list[tuple[Any, ...]] = []
        ends = []
        n_tallies = 0
        for one in plans:
            marks = [len(rows)]
            for injections in (one.messages, one.reports, one.commands):
                rows.extend(map(injection_row, injections))
                marks.append(len(rows))
            ends.append((*marks, n_tallies, n_tallies + len(one.tallies)))
            n_tallies += len(one.tallies)
        self.injections: Records = np.array(rows, _INJECTION)
        self.ends = np.array(ends, np.int64)
        self.tallies: Records = np.zeros(n_tallies, _TALLY)
        self.tallies["last_applied"] = self.tallies["last_changed"] = -1
        self.results: Records = np.zeros(len(plans), result_type)
        self.room = Room().for_plans(plans)

    def outcome(self, k: int) -> Outcome:
        """Return what the flight of one specification found."""
        result = self.results[k]
        tallies = self.tallies[self.ends[k, 4] : self.ends[k, 5]]
        names = ("believed", "true", "phantom", "masked", "samples")
        counts = [result[name].tolist() for name in names]
        counts += [tallies["applied"].tolist(), tallies["changed"].tolist()]
        return digested(counts, result["world"].tobytes(), result["belief"].tobytes())
