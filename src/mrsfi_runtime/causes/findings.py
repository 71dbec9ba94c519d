"""Which of several cause sets are one and the same finding."""

from collections.abc import Sequence
from typing import TypeAlias

from mrsfi_runtime.model.faults import Specification

Finding: TypeAlias = tuple[int, ...]
"""Places of cause sets, ascending; the first is the finding's leader."""


def findings(causes: Sequence[Specification]) -> tuple[Finding, ...]:
    """Return cause sets grouped into findings, each in the first whose leader it is like.

    Two are alike if they have the same pool faults, and with them the same targets, in windows
    that overlap one by one: of several of one fault, the earliest with the earliest.

    Parameters
    ----------
    causes
        Cause sets, the most critical first.
    """
    found: list[list[int]] = []
    for place, cause in enumerate(causes):
        like = (group for group in found if _is_like(causes[group[0]], cause))
        group = next(like, None)
        if group is None:
            found.append([place])
        else:
            group.append(place)
    return tuple(map(tuple, found))


def _is_like(leader: Specification, cause: Specification) -> bool:
    if len(leader) != len(cause):
        return False
    return all(
        one.fault == other.fault and one.start <= other.finish and other.start <= one.finish
        for one, other in zip(sorted(leader), sorted(cause), strict=True)
    )
