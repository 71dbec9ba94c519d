"""Weaknesses by hand, of the paper's mission."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

from mrsfi_runtime.causes.cause_set import Column
from mrsfi_runtime.causes.weakness import Detection, Weakness
from mrsfi_runtime.model.faults import FaultPool, TimedFault
from mrsfi_runtime.model.mission import Mission, Outcome
from mrsfi_runtime.record.store import CampaignStore
from tests.support.search import PAPER_FAULTS

_VALUES = {fault.id: fault.values for fault in PAPER_FAULTS}


def weakness(
    goal: str,
    measure: str,
    *faults: str,
    start: int = 10,
    finish: int = 90,
    detection: Detection | None = None,
) -> Weakness:
    """Return a weakness whose form has the pool's values."""
    form = tuple(TimedFault(fault, start, finish, _VALUES.get(fault, ())) for fault in faults)
    found = Weakness(Column(goal, measure), tuple(sorted(faults)), form, 4, 1)
    return replace(found, detection=detection)


def untried_by_hand(
    run: Path, mission: Mission, pool: FaultPool, told: Sequence[Mapping[str, Any]]
) -> str:
    """Return the sentence on untried sets, by the record and the printed weaknesses."""
    with CampaignStore.open(run) as store:
        flown = [(each.specification, each.outcome) for each in store.evaluations()]
        for each in store.flights():
            if each.mission_seed == store.settings.mission_seed:
                assert isinstance(each.found, Outcome)
                flown.append((each.specification, each.found))
    fault_free = next(outcome for specification, outcome in flown if not specification)
    left: dict[str, set[tuple[str, ...]]] = {}
    for place, goal in enumerate(mission.goal_ids):
        left[goal] = set()
        for measure in ("believed", "true", "missed"):
            most = getattr(fault_free, measure)[place]
            most += 0.05 * mission.duration if most else 0
            sets = [
                {*each["faults"]}
                for each in told
                if (each["goal"], each["measure"]) == (goal, measure)
            ]
            trials = {
                frozenset(
                    timed.fault
                    for timed, n in zip(specification, outcome.changed, strict=True)
                    if n > 0
                )
                for specification, outcome in flown
                if getattr(outcome, measure)[place] <= most
                and not any(known <= {timed.fault for timed in specification} for known in sets)
            }
            for n in (1, 2, 3):
                for some in combinations([fault.id for fault in pool], n):
                    is_open = not any(known <= {*some} for known in sets)
                    if is_open and not any(trial.issuperset(some) for trial in trials):
                        left[goal].add(some)
    names = ("faults", "pairs", "triples")
    every = [len([*combinations(pool, n)]) for n in (1, 2, 3)]
    union = zip(
        _by_size({some for each in left.values() for some in each}), every, names, strict=True
    )
    rows = ", ".join(f"{n:,} of {of:,} {name[: -1 if of == 1 else None]}" for n, of, name in union)
    return f"Not tried yet for at least one goal: {rows}"


def _by_size(sets: Iterable[tuple[str, ...]]) -> list[int]:
    sizes = [*map(len, sets)]
    return [sizes.count(n) for n in (1, 2, 3)]
