"""Check attribute texts as values of their Ecore type, strictly.

Numbers are accepted as Java accepts them, without the spellings that only Python knows, so that
a model that loads here loads in Eclipse.
"""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from pyecore.ecore import EEnum

from m2t.diagnostics import Defect, listed, shown
from m2t.metaclasses import Slot
from mrsfi_runtime.model.faults import LAST, MOST

MAX_NAME_LENGTH = 200
MAX_TEXT_LENGTH = 2_000

_INT_RANGE = range(-(2**31), 2**31)
_INTEGER = re.compile(r"[+-]?[0-9]{1,20}", re.ASCII)
DOUBLE = re.compile(r"[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?", re.ASCII)
_NOT_FINITE = re.compile(r"[+-]?(nan|inf(inity)?)", re.ASCII | re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Range:
    """Which numbers a feature allows, and the constraint that says so."""

    constraint: str
    lowest: float
    highest: float = math.inf
    is_open: bool = False

    def __contains__(self, value: float) -> bool:
        above = value > self.lowest if self.is_open else value >= self.lowest
        return above and value <= self.highest

    def __str__(self) -> str:
        if self.highest < math.inf:
            above = "above " * self.is_open
            return f"{above}{self.lowest:,} to {self.highest:,}"
        return f"a number above {self.lowest}" if self.is_open else f"{self.lowest} or more"


_ENERGY = Range("EnergyNotNegative", 0)
_TICKS = Range("DelayNotNegative", 0, LAST)

RANGES: Mapping[str, Range] = {
    "duration": Range("DurationInRange", 1, 10_000_000),
    "radius": Range("RadiusPositive", 0, is_open=True),
    **dict.fromkeys(("speed", "maxSpeed"), Range("SpeedNotNegative", 0)),
    "turnRate": Range("TurnRateInRange", 0, 180, is_open=True),
    "positionNoise": Range("NoiseNotNegative", 0),
    **dict.fromkeys(("energyPerSample", "totalEnergy", "energyPerDistanceUnit"), _ENERGY),
    "samplesPerSecond": Range("SamplesPerSecondPositive", 1),
    "targetSampleNumber": Range("TargetSampleNumberNotNegative", 0),
    "period": Range("PeriodPositive", 1),
    "deadline": Range("DeadlinePositive", 1),
    "tolerance": Range("TolerancePositive", 0, is_open=True),
    "fixedDistance": Range("FixedDistancePositive", 0, is_open=True),
    **dict.fromkeys(("start", "finish"), Range("WindowNotNegative", 0)),
    "likelihood": Range("LikelihoodInRange", 0, 1),
    "delay": _TICKS,
}
"""Allowed numbers by feature name; a feature of that name means the same in every class."""


def require_value(slot: Slot, text: str) -> None:
    """Refuse, by a ``Defect``, a text that is no value of an attribute or outside its range."""
    if slot.type.name == "EString":
        _require_length(slot, text)
        return
    for constraint, is_kept, expected in _rules(slot, text):
        if not is_kept:
            raise Defect(constraint, f"has {slot.name} {shown(text)}; expected {expected}")


def _require_length(slot: Slot, text: str) -> None:
    limit = MAX_NAME_LENGTH if slot.name in ("ID", "name") else MAX_TEXT_LENGTH
    if len(text) > limit:
        raise Defect(
            "StringLength",
            f"has a {slot.name} of {len(text):,} characters; expected at most {limit:,}; "
            "shorten it",
        )


def _rules(slot: Slot, text: str) -> Iterator[tuple[str, bool, str]]:
    """Yield what a text has to keep, each with whether it does; each builds on the one before."""
    kind = slot.type.name
    if isinstance(slot.type, EEnum):
        names = [literal.name for literal in slot.type.eLiterals]
        yield "EnumLiteral", text in names, f"one of {listed(names, text)}; correct the spelling"
    elif kind == "EBoolean":
        is_literal = text in ("true", "false")
        yield "EnumLiteral", is_literal, "true or false; correct the spelling"
    elif kind == "EInt":
        is_whole = bool(_INTEGER.fullmatch(text)) and int(text) in _INT_RANGE
        yield "NumberSyntax", is_whole, "a whole number of 32 bits, such as 20; correct it"
    else:
        yield "FiniteNumber", not _NOT_FINITE.fullmatch(text), "a finite number; correct it"
        yield "NumberSyntax", bool(DOUBLE.fullmatch(text)), "a number such as 2.5; correct it"
        is_near = abs(float(text)) <= MOST
        yield "NumberMagnitude", is_near, "a number between -1.0E12 and 1.0E12; correct it"
    allowed = _TICKS if slot.counts_ticks else RANGES.get(slot.name)
    if allowed is not None and kind in ("EInt", "EDouble"):
        yield allowed.constraint, float(text) in allowed, f"{allowed}; correct it"
