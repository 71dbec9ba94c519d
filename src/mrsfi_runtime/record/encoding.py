"""Canonical JSON text of what a campaign stores: same value, same bytes, and back bit for bit.

Floats are written as their shortest exact decimal form, so that reading gives the very
same IEEE-754 bits.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import fields
from itertools import chain
from numbers import Integral
from typing import Any, TypeAlias

from mrsfi_runtime.model.faults import Specification, TimedFault
from mrsfi_runtime.model.outcome import Outcome

JSON: TypeAlias = "bool | int | float | str | Sequence[JSON] | Mapping[str, JSON] | None"
"""What JSON can say."""

COUNTS = tuple(entry.name for entry in fields(Outcome) if entry.name != "digest")
"""Names of the count vectors of an outcome, in the order in which they are stored."""


_decode = json.JSONDecoder().decode
_ENCODER = json.JSONEncoder(separators=(",", ":"), ensure_ascii=False, allow_nan=False)


def canonical(value: Any) -> str:
    """Return the one JSON text of a value: no spaces, given key order, no NaN or infinity.

    Raises
    ------
    ValueError
        If a number is not finite.
    """
    return _ENCODER.encode(value)


def specification_text(specification: Specification) -> str:
    """Return ``[["f9",100,900,[200.0,-450.0]],…]``.

    Raises
    ------
    ValueError
        If a value is not finite.
    """
    return canonical(
        [
            [timed.fault, int(timed.start), int(timed.finish), [float(v) for v in timed.values]]
            for timed in specification
        ]
    )


def specification_from_text(text: str) -> Specification:
    """Return the specification that ``specification_text`` wrote.

    Raises
    ------
    ValueError
        If the text is no such specification.
    """
    rows = _list(text)
    try:
        return tuple(
            TimedFault(str(fault), int(start), int(finish), tuple(map(float, values)))
            for fault, start, finish, values in rows
        )
    except TypeError as error:
        raise ValueError(str(error)) from error


def counts_text(counts: Sequence[int]) -> str:
    """Return integers, numpy's too, as a JSON list."""
    return canonical([int(count) for count in counts])


def counts_from_texts(texts: Sequence[str]) -> tuple[tuple[int, ...], ...]:
    """Return the integers of several JSON lists, read at once, which is quicker than one by one.

    Raises
    ------
    ValueError
        If one of them is anything else.
    """
    found = _list(f"[{','.join(texts)}]")
    is_sound = len(found) == len(texts) and all(type(counts) is list for counts in found)
    if not is_sound or not set(map(type, chain.from_iterable(found))) <= {int}:
        raise ValueError(f"found {' '.join(texts)[:60]}; expected lists of integers")
    return tuple(map(tuple, found))


def numbers_text(numbers: Sequence[float]) -> str:
    """Return floats as a JSON list; a ValueError if one is not finite."""
    return canonical([float(number) for number in numbers])


def numbers_from_text(text: str) -> tuple[float, ...]:
    """Return the floats of a JSON list; a ValueError if it holds anything else."""
    try:
        return tuple(map(float, _list(text)))
    except TypeError as error:
        raise ValueError(str(error)) from error


def statistics_text(statistics: Mapping[str, float]) -> str:
    """Return named numbers, numpy's too, as a JSON object; whole numbers stay whole."""
    return canonical(
        {
            name: int(value) if isinstance(value, Integral) else float(value)
            for name, value in statistics.items()
        }
    )


def object_from_text(text: str) -> dict[str, Any]:
    """Return a JSON object; a ValueError if the text is anything else."""
    value = json.loads(text)
    if not isinstance(value, dict):
        raise ValueError(f"found {text[:60]}; expected an object")  # noqa: TRY004 - the text is wrong, not its type
    return value


def _list(text: str) -> list[Any]:
    value = _decode(text)
    if not isinstance(value, list):
        raise ValueError(f"found {text[:60]}; expected a list")  # noqa: TRY004 - the text is wrong, not its type
    return value
