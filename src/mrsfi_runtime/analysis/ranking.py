"""Which evaluations are the most critical.

References
----------
Source paper, section III-A, step 6.
"""

from collections.abc import Iterable

from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.record.campaign import Evaluation


def identity(specification: Specification) -> Specification:
    """Return the specification with its faults sorted: the order of its faults has no meaning."""
    return tuple(sorted(specification))


def score(evaluation: Evaluation) -> float:
    """Return the number to rank by."""
    return evaluation.fitness[0]


def distinct(evaluations: Iterable[Evaluation]) -> tuple[Evaluation, ...]:
    """Return the first evaluation of every specification, in the given order."""
    first: dict[Specification, Evaluation] = {}
    for evaluation in evaluations:
        first.setdefault(identity(evaluation.specification), evaluation)
    return tuple(first.values())


def top(evaluations: Iterable[Evaluation], n: int) -> tuple[Evaluation, ...]:
    """Return the ``n`` most critical distinct evaluations, or all if there are fewer.

    Of two with the same fitness the earlier one comes first.
    """
    ranked = sorted(
        distinct(evaluations), key=lambda evaluation: (-score(evaluation), evaluation.index)
    )
    return tuple(ranked[:n])
