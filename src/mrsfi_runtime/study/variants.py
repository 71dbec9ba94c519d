"""What a comparison compares: variants of a search, algorithms or the settings of one.

References
----------
Source paper, section VII.
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

_COMPARISONS = ("seed", "generations", "max_failures")  # are not varied: seeds, what ends a run
_MOST = 100  # values of a setting between two
_SYNTAX = f"KEY=LOW:HIGH:N, N from 2 to {_MOST}, or KEY=A,B,C, several with commas between"

PAPERS: Mapping[str, Value] = MappingProxyType(
    {
        key: value
        for key, value in asdict(CampaignSettings()).items()
        if type(value) in (int, float) and key not in _COMPARISONS
    }
)
"""Settings in numbers that a sweep can vary, with the values of the paper."""


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
        found: dict[str, tuple[Value, ...]] = {}
        key = ""
        for part in text.split(","):
            name, is_named, numbers = part.rpartition("=")
            if is_named:
                key = name.strip()
                if key not in PAPERS or key in found:
                    known = expected(key, [each for each in PAPERS if each not in found])
                    raise UsageError(f"sweep: found {part.strip()!r}; {known}")
            values = _numbers(numbers) if key else ()
            if not values:
                raise UsageError(f"sweep: found {part.strip()!r}; expected {_SYNTAX}")
            found[key] = tuple(dict.fromkeys((*found.get(key, ()), *values)))
        return cls(found)

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
        found = {name for name, each in self.settings().items() if values.items() <= each.items()}
        is_combined = all(PAPERS[key] in known for key, known in self.values.items())
        return found if is_combined else found - {self.papers}

    def as_json(self) -> dict[str, Any]:
        """Return its values, and those of each setting by its name, as values of JSON."""
        values = {key: list(each) for key, each in self.values.items()}
        return {"values": values, "papers": self.papers, "settings": dict(self.settings())}

    def variants(self, algorithm: str) -> tuple[Variant, ...]:
        """Return the variants of an algorithm."""
        found = self.settings().items()
        return tuple(Variant(name, {"algorithm": algorithm, **values}) for name, values in found)


def _numbers(text: str) -> tuple[Value, ...]:
    """Return the number that a text says, or some that are evenly spaced; none if it is wrong."""
    try:
        low, *others = map(Fraction, text.split(":"))
        high, n = others or (low, Fraction(1))
    except (ValueError, ZeroDivisionError):
        return ()
    if n.denominator != 1 or not 2 * bool(others) <= n <= _MOST:
        return ()
    step = (high - low) / max(1, int(n) - 1)
    exact = (low + step * place for place in range(int(n)))
    return tuple(int(each) if each.denominator == 1 else float(each) for each in exact)


def _name(values: Mapping[str, Value]) -> str:
    return ",".join(f"{key}={value}" for key, value in values.items())
