"""Specifications whose violations are planted: functions of the faults that are flown."""

from collections.abc import Callable, Mapping, Sequence

from mrsfi_runtime.causes.cause_set import Flights
from mrsfi_runtime.model.faults import Specification, TimedFault
from mrsfi_runtime.model.mission import Outcome
from mrsfi_runtime.record.store import Measure

Planted = Mapping[str, Callable[[frozenset[str]], tuple[int, int]]]
"""Believed and true violations of each goal, from the IDs of the faults that are flown."""


def faults(names: str) -> Specification:
    """Return a timed fault for each letter."""
    return tuple(TimedFault(name, 0, 9) for name in names)


def flights(planted: Planted, kind: str = "believed") -> Flights:
    """Return flights that find what is planted."""
    goals = tuple(planted)
    return Flights(evaluator(planted), Measure(kind, 1, goals, goals, 100), (1,))


def evaluator(planted: Planted) -> Callable[[Sequence[Specification], int], list[Outcome]]:
    """Return what evaluates specifications as is planted."""

    def evaluate_many(specifications: Sequence[Specification], _seed: int) -> list[Outcome]:
        return [_outcome(planted, each) for each in specifications]

    return evaluate_many


def _outcome(planted: Planted, specification: Specification) -> Outcome:
    flown = frozenset(timed.fault for timed in specification)
    found = [violations(flown) for violations in planted.values()]
    none = tuple(0 for _ in found)
    pairs = [(max(b - t, 0), max(t - b, 0)) for b, t in found]
    ones = tuple(1 for _ in specification)
    return Outcome(
        believed=tuple(believed for believed, _ in found),
        true=tuple(true for _, true in found),
        phantom=tuple(phantom for phantom, _ in pairs),
        masked=tuple(masked for _, masked in pairs),
        missed=none,
        samples=none,
        applied=ones,
        changed=ones,
        digest="",
    )
