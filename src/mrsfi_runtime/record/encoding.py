"""Canonical JSON text of what a campaign stores: same value, same bytes, and back bit for bit."""

import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import fields
from itertools import chain
from operator import methodcaller
from typing import Any

from mrsfi_runtime.errors import SpecificationError
from mrsfi_runtime.model.faults import Specification, TimedFault, plain
from mrsfi_runtime.model.mission import Margin, Outcome

OUTCOME = tuple(each.name for each in fields(Outcome))
"""Names of what an outcome has, in the order in which they are stored."""

COUNTS = OUTCOME[: OUTCOME.index("digest")]
"""Of these, the count vectors."""

_ENCODER = json.JSONEncoder(
    separators=(",", ":"), ensure_ascii=False, allow_nan=False, default=methodcaller("item")
)


def canonical(value: Any) -> str:
    """Return the one JSON text of a value: no spaces, given key order, numpy's numbers as Python's.

    A number that is not finite is a ValueError.
    """
    return _ENCODER.encode(value)


def texts(found: Sequence[Sequence[float]]) -> list[str]:
    """Return the texts of several lists of numbers, written at once, which is quicker."""
    return [f"[{numbers}]" for numbers in canonical(found)[2:-2].split("],[")]


def specification_text(specification: Specification) -> str:
    """Return ``[["f9",100,900,[200.0,-450.0]],…]``; a trigger stands last, where there is one."""
    rows = map(plain, specification)
    return canonical([timed if timed.trigger else timed[:-1] for timed in rows])


def specification(rows: Iterable[Any]) -> Specification:
    """Return the specification whose text has such rows; a ValueError if none."""
    try:
        return tuple(
            plain(TimedFault(fault, start, finish, tuple(values), *trigger))
            for fault, start, finish, values, *trigger in rows
        )
    except (SpecificationError, TypeError) as error:
        raise ValueError(f"{error}") from error


_BEGINNING = re.compile(r'\["([^"\\]*)",')  # of a timed fault, unless its ID is an odd one
_OPENING, _CLOSING = len("[["), len("]]]")  # around all of its timed faults


def fault_texts(text: str) -> tuple[list[str], list[str]]:
    """Return the pool fault of each timed fault, and texts that tell timed faults apart.

    They are found in the text of a specification without making its timed faults, which takes
    six times as long. Equal timed faults have equal texts.
    """
    faults, texts = _BEGINNING.findall(text), text[_OPENING:-_CLOSING].split("]],[")
    is_plain = text.endswith("]]]") and "-0.0" not in text and '"]' not in text  # no triggers
    if is_plain and len(faults) == len(texts):
        return faults, texts
    (rows,) = lists([text])
    plain = [
        timed._replace(values=tuple(value + 0.0 for value in timed.values))  # 0 equals -0
        for timed in specification(rows)
    ]
    texts = [specification_text((timed,))[_OPENING:-_CLOSING] for timed in plain]
    return [timed.fault for timed in plain], texts


def lists(texts: Sequence[str]) -> list[list[Any]]:
    """Return what several JSON lists hold, read at once, which is quicker; a ValueError if none."""
    found: list[list[Any]] = json.loads(f"[{','.join(texts)}]")
    if len(found) != len(texts) or not all(type(each) is list for each in found):
        raise ValueError(f"found {' '.join(texts)[:60]}; expected lists")
    return found


def integers(found: Sequence[Sequence[Any]]) -> tuple[tuple[int, ...], ...]:
    """Return lists of integers as tuples; a ValueError if they hold anything else."""
    if not set(map(type, chain.from_iterable(found))) <= {int}:
        raise ValueError(f"found {str(found)[:60]}; expected lists of integers")
    return tuple(map(tuple, found))


def margins(found: object) -> tuple[Margin | None, ...] | None:
    """Return margins as they are in an outcome; a ValueError if they make no sense."""
    if not found:
        return None
    if not isinstance(found, list):
        raise ValueError(f"found {str(found)[:60]}; expected a list of margins")  # noqa: TRY004 - the text is wrong
    return tuple(None if each is None else _margin(*each) for each in found)


def _margin(least: float, tick: int) -> Margin:
    if type(tick) is not int:
        raise ValueError(f"found tick {tick!r}; expected an integer")
    return float(least), tick


def object_from_text(text: str) -> dict[str, Any]:
    """Return a JSON object; a ValueError if the text is anything else."""
    value = json.loads(text)
    if not isinstance(value, dict):
        raise ValueError(f"found {text[:60]}; expected an object")  # noqa: TRY004 - the text is wrong, not its type
    return value
