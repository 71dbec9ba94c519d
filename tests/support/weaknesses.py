"""Weaknesses by hand, of the paper's mission."""

from dataclasses import replace

from mrsfi_runtime.causes.cause_set import Column
from mrsfi_runtime.causes.weakness import Detection, Weakness
from mrsfi_runtime.model.faults import TimedFault
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
