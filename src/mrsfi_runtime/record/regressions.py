"""Findings that a team keeps beside its models, with what each goal may be violated at most.

Each is two files in ``models/<mission>/regressions/``: a fault specification, ``NAME.xmi``, and
its limits, ``NAME.toml``.
"""

import json
import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.record.settings import VIOLATIONS

_BARE = re.compile(r"[A-Za-z0-9_-]+")
_KEYS = ("found", "violations", "mission_seeds", "max")


@dataclass(frozen=True, slots=True)
class Regression:
    """A fault specification that must not do more harm than is kept.

    Attributes
    ----------
    path
        The file of its limits.
    found
        Where it comes from, and what it did, for people.
    violations
        What is limited, one of ``VIOLATIONS``, in ticks.
    mission_seeds
        Weathers in which it is flown; the limits hold in each.
    limits
        The most that a goal may have, by its ID; other goals are not looked at.
    """

    path: Path
    found: str
    violations: str
    mission_seeds: tuple[int, ...]
    limits: Mapping[str, int]

    @property
    def name(self) -> str:
        """Its name: that of its files."""
        return self.path.stem

    @property
    def specification(self) -> Path:
        """File of its fault specification."""
        return self.path.with_suffix(".xmi")

    def counts(self, goals: tuple[str, ...], outcome: Outcome) -> dict[str, int]:
        """Return what a flight has of what is limited.

        Parameters
        ----------
        goals
            IDs of the mission's goals, in the order of an outcome's counts.
        outcome
            What came of the flight.

        Raises
        ------
        UsageError
            If the mission has no such goal.
        """
        found = dict(zip(goals, getattr(outcome, self.violations), strict=True))
        for goal in self.limits:
            if goal not in found:
                raise UsageError(
                    f"{self.path}: max: found goal '{goal}'; expected goals of the mission: "
                    f"{', '.join(goals)}"
                )
        return {goal: found[goal] for goal in self.limits}

    def exceeded(self, counts: Mapping[str, int]) -> tuple[str, ...]:
        """Return the goals that have more than is kept, by what ``counts`` returned."""
        return tuple(goal for goal, ticks in counts.items() if ticks > self.limits[goal])

    def text(self) -> str:
        """Return what ``load`` reads."""
        limits = "".join(f"{_key(goal)} = {most}\n" for goal, most in self.limits.items())
        return (
            f"found = {_quoted(self.found)}\n"
            f"violations = {json.dumps(self.violations)}\n"
            f"mission_seeds = {list(self.mission_seeds)}\n"
            f"\n[max]\n{limits}"
        )

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read the file of some limits.

        Raises
        ------
        UsageError
            If it cannot be read, has an unknown key, lacks one, or has one of a wrong kind.
        """
        try:
            content = tomllib.loads(path.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            raise UsageError(
                f"{path}: cannot be read ({error}); expected the limits of a kept finding in TOML"
            ) from error
        for key in content:
            if key not in _KEYS:
                raise UsageError(f"{path}: found unknown key '{key}'; expected {', '.join(_KEYS)}")
        for key, (expected, accepts) in _RULES.items():
            value = content.get(key)
            if not accepts(value):
                found = "nothing" if value is None else repr(value)
                raise UsageError(f"{path}: {key}: found {found}; expected {expected}")
        seeds = tuple(content["mission_seeds"])
        return cls(path, content["found"], content["violations"], seeds, content["max"])


def kept(models: Path) -> tuple[Regression, ...]:
    """Return what is kept beside the models of a mission, by name.

    Raises
    ------
    UsageError
        If the limits of one cannot be read, or a specification has none.
    """
    folder = folder_of(models)
    for path in sorted(folder.glob("*.xmi")):
        if not path.with_suffix(".toml").is_file():
            raise UsageError(f"{path}: found no limits; expected {path.stem}.toml beside it")
    return tuple(Regression.load(path) for path in sorted(folder.glob("*.toml")))


def folder_of(models: Path) -> Path:
    """Return where findings are kept that are about a mission, by the folder of its models."""
    return models / "regressions"


def _key(name: str) -> str:
    return name if _BARE.fullmatch(name) else _quoted(name)


def _quoted(text: str) -> str:
    """Return a text as TOML writes it: as JSON does, but for one character."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")


def _is_count(value: Any) -> bool:
    return type(value) is int and value >= 0


_RULES: Mapping[str, tuple[str, Callable[[Any], bool]]] = {
    "found": ("a text", lambda value: isinstance(value, str)),
    "violations": (f"one of {', '.join(VIOLATIONS)}", lambda value: value in VIOLATIONS),
    "mission_seeds": (
        "a list of whole numbers >= 0, at least one",
        lambda value: isinstance(value, list) and bool(value) and all(map(_is_count, value)),
    ),
    "max": (
        "a table with a whole number >= 0 for at least one goal",
        lambda value: (
            isinstance(value, dict) and bool(value) and all(map(_is_count, value.values()))
        ),
    ),
}
