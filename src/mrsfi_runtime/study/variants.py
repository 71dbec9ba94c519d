"""What a comparison compares: variants of a search, algorithms or the settings of one.

References
----------
Source paper, section VII: "experiment on a range of genetic algorithm parameters".
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from fractions import Fraction
from itertools import product
from types import MappingProxyType
from typing import Any, Self, TypeAlias

from mrsfi_runtime.errors import UsageError, expected
from mrsfi_runtime.record.settings import ALGORITHM_NAMES, CampaignSettings

Value: TypeAlias = int | float

_NOT_VARIED = (
    "seed",
    "generations",
    "max_failures",
)  # the comparison's: seeds, and what ends a run

PAPERS: Mapping[str, Value] = MappingProxyType(
    {
        key: value
        for key, value in asdict(CampaignSettings()).items()
        if type(value) in (int, float) and key not in _NOT_VARIED
    }
)
"""Settings in numbers that a sweep can vary, with the values of the paper."""

_SYNTAX = "KEY=LOW:HIGH:N or KEY=A,B,C, several with commas between"


@dataclass(frozen=True, slots=True)
class Variant:
    """A search by its name, and what it replaces in the campaign file."""

    name: str
    overrides: Mapping[str, str | Value]


def variants_of(algorithms: object, sweep: "Sweep | None" = None) -> tuple[Variant, ...]:
    """Return algorithms as variants, or those of the one that a sweep varies; refuse others."""
    found = algorithms if isinstance(algorithms, list | tuple) else ()
    variants = [
        Variant(each, {"algorithm": each}) if isinstance(each, str) else each for each in found
    ]
    names = [each.name for each in variants]
    if not names or len({*names}) < len(names):
        known = expected(algorithms, ALGORITHM_NAMES, "a list of different ones of")
        raise UsageError(f"algorithms: found {algorithms!r}; {known}")
    if sweep is None:
        return tuple(variants)
    if len(names) > 1:
        raise UsageError(f"algorithms: found {names}; expected one, whose settings are swept")
    return sweep.variants(names[0])


@dataclass(frozen=True, slots=True)
class Sweep:
    """Settings of one algorithm, each with the values that it takes; all are combined."""

    values: Mapping[str, tuple[Value, ...]]

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read ``crossover=0.3:0.9:5,population=10,20,40``."""
        found: dict[str, dict[Value, None]] = {}
        key = ""
        for part in text.split(","):
            name, is_named, values = part.rpartition("=")
            if is_named:
                key = _key(name.strip(), text, found)
                found[key] = {}
            if not key:
                raise UsageError(f"sweep {text!r}: found {part!r}; expected {_SYNTAX}")
            found[key].update(dict.fromkeys(_numbers(key, values)))
        return cls({name: tuple(values) for name, values in found.items()})

    @property
    def papers(self) -> str:
        """Name of the variant with the paper's values."""
        return _name({key: PAPERS[key] for key in self.values})

    def settings(self) -> Mapping[str, Mapping[str, Value]]:
        """Return the values of each variant by its name; the paper's come last if they are new."""
        combined = product(*self.values.values())
        grid = [dict(zip(self.values, chosen, strict=True)) for chosen in combined]
        return {_name(each): each for each in (*grid, {key: PAPERS[key] for key in self.values})}

    def with_values(self, values: Mapping[str, Value]) -> set[str]:
        """Return names of combinations with some values; the paper's setting need not be one."""
        return {
            name
            for name, each in self.settings().items()
            if values.items() <= each.items()
            and all(each[key] in known for key, known in self.values.items())
        }

    def as_json(self) -> dict[str, Any]:
        """Return its values, and those of each setting by its name, as values of JSON."""
        values = {key: list(each) for key, each in self.values.items()}
        return {"values": values, "papers": self.papers, "settings": dict(self.settings())}

    def variants(self, algorithm: str) -> tuple[Variant, ...]:
        """Return the variants of an algorithm."""
        return tuple(
            Variant(name, {"algorithm": algorithm, **values})
            for name, values in self.settings().items()
        )


def _key(name: str, text: str, found: Mapping[str, object]) -> str:
    if name not in PAPERS:
        raise UsageError(f"sweep {text!r}: found {name!r}; {expected(name, PAPERS)}")
    if name in found:
        raise UsageError(f"sweep {text!r}: found {name} twice; expected each setting once")
    return name


def _numbers(key: str, text: str) -> list[Value]:
    """Return the numbers that a part of a list says, one or some that are evenly spaced."""
    ends = text.split(":")
    try:
        low, *others = map(Fraction, ends)
    except (ValueError, ZeroDivisionError):
        raise UsageError(f"sweep {key}: found {text!r}; expected {_SYNTAX}") from None
    if not others:
        return [_value(low)]
    if len(others) != 2 or others[1].denominator != 1 or others[1] < 2:
        wanted = "LOW:HIGH:N, N values evenly spaced, two or more"
        raise UsageError(f"sweep {key}: found {text!r}; expected {wanted}")
    high, n = others[0], int(others[1])
    return [_value(low + (high - low) * place / (n - 1)) for place in range(n)]


def _value(exact: Fraction) -> Value:
    return int(exact) if exact.denominator == 1 else float(exact)


def _name(values: Mapping[str, Value]) -> str:
    return ",".join(f"{key}={value}" for key, value in values.items())
