"""Weaknesses that a team keeps beside its models, with what each goal may be violated at most.

Each is two files in ``models/<mission>/regressions/``: a fault specification, ``NAME.xmi``, and
its limits, ``NAME.toml``.
"""

import json
import os
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from mrsfi_runtime.errors import MrsfiError, SpecificationError, UsageError, expected
from mrsfi_runtime.model.mission import Outcome
from mrsfi_runtime.record.engine_settings import BOTH, CI, INJECTOR
from mrsfi_runtime.record.settings import VIOLATIONS

_BARE = re.compile(r"[A-Za-z0-9_-]+")


@dataclass(frozen=True, slots=True)
class Regression:
    """A fault specification that must not do more harm than is kept.

    ``limits`` are the most ticks of one of ``VIOLATIONS`` that goals may have, by their IDs, with
    each of the ``mission_seeds``; other goals are not looked at. ``path`` is their file, ``found``
    says for people where it comes from and what it did, ``accepted`` why that is accepted, if so,
    ``side`` of which parts the counts are, as ``--side`` has it, and ``defect`` why nothing of this
    is known, if its files cannot be read.
    """

    path: Path
    found: str
    violations: str
    mission_seeds: tuple[int, ...]
    limits: Mapping[str, int]
    defect: MrsfiError | None = None
    accepted: str = ""
    side: str = BOTH

    @property
    def name(self) -> str:
        """Its name: that of its files."""
        return self.path.stem

    @property
    def specification(self) -> Path:
        """File of its fault specification."""
        return self.path.with_suffix(".xmi")

    def counts(self, goals: tuple[str, ...], outcome: Outcome, said_by: str = "") -> dict[str, int]:
        """Return what a flight has of what is limited; a goal that there is not is refused.

        ``said_by`` is what says the limits, if that is not the file.
        """
        found = dict(zip(goals, getattr(outcome, self.violations), strict=True))
        for goal in self.limits:
            if goal not in found:
                known = expected(goal, goals, "goals of the mission:")
                raise UsageError(f"{said_by or f'{self.path}: max'}: found goal '{goal}'; {known}")
        return {goal: found[goal] for goal in self.limits}

    def exceeded(self, counts: Mapping[str, int]) -> tuple[str, ...]:
        """Return the goals that have more than is kept, by what ``counts`` returned."""
        return tuple(goal for goal, ticks in counts.items() if ticks > self.limits[goal])

    def idle(self, duration: int) -> Iterator[str]:
        """Yield a warning for each limit that no flight of so many ticks can exceed."""
        for goal, most in self.limits.items():
            if most >= duration:
                yield (
                    f"{self.path}: max: {goal} = {most} can never be exceeded in a mission of "
                    f"{duration} ticks; expected fewer ticks"
                )

    def text(self) -> str:
        """Return what ``load`` reads."""
        limits = "".join(f"{_key(goal)} = {most}\n" for goal, most in self.limits.items())
        accepted = f"accepted = {_quoted(self.accepted)}\n" if self.accepted else ""
        side = "" if self.side == BOTH else f'side = "{self.side}"\n'
        return (
            f"found = {_quoted(self.found)}\n{accepted}"
            f"{side}violations = {json.dumps(self.violations)}\n"
            f"mission_seeds = {list(self.mission_seeds)}\n"
            f"goals = {len(self.limits)}\n"
            f"\n[max]\n{limits}"
        )

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read the file of some limits; what it lacks, or has of a wrong kind, is refused."""
        try:
            content = tomllib.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:  # also numbers of thousands of digits
            raise UsageError(
                f"{path}: cannot be read ({error}); expected the limits of a kept weakness in TOML"
            ) from error
        for key in content:
            if key not in _RULES:
                raise UsageError(f"{path}: found unknown key '{key}'; expected {', '.join(_RULES)}")
        for key, (wanted, accepts) in _RULES.items():
            value = content.get(key)
            if not accepts(value):
                found = "nothing" if value is None else repr(value)
                raise UsageError(f"{path}: {key}: found {found}; expected {wanted}")
        seeds, limits = tuple(content["mission_seeds"]), content["max"]
        if content["goals"] != len(limits):
            raise UsageError(
                f"{path}: max: found {len(limits)} limits; expected {content['goals']}, as many as "
                "goals says; restore the file, or correct goals if that is wanted"
            )
        rest = content.get("accepted", ""), content.get("side", BOTH)
        return cls(path, content["found"], content["violations"], seeds, limits, None, *rest)


def kept(models: Path) -> tuple[Regression, ...]:
    """Return what is kept beside the models of a mission, by name, also what cannot be read."""
    folder = folder_of(models)
    if not os.path.lexists(folder):
        return ()
    try:
        found = {path.stem for path in folder.iterdir() if path.suffix in (".xmi", ".toml")}
    except OSError as error:
        defect = UsageError(f"{folder}: cannot be read: {error.strerror}; expected a folder")
        return (Regression(folder, "", "", (), {}, defect),)
    return tuple(_read(folder / f"{name}.toml") for name in sorted(found))


def _read(path: Path) -> Regression:
    """Return what is kept in two files; a pipe among them would let whoever reads it wait."""
    specification = path.with_suffix(".xmi")
    try:
        for file in (specification, path):
            if file.exists() and not file.is_file():
                raise SpecificationError(f"{file}: found no plain file; expected a kept weakness")
        if not path.exists():
            raise UsageError(f"{specification}: found no limits; expected {path.name} beside it")
        return Regression.load(path)
    except MrsfiError as error:
        return Regression(path, "", "", (), {}, error)


def folder_of(models: Path) -> Path:
    """Return where weaknesses are kept that are about a mission, by the folder of its models."""
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
    "accepted": ("a text", lambda value: value is None or isinstance(value, str)),
    "side": (f"{CI} or {INJECTOR}", lambda value: value in (None, CI, INJECTOR)),
    "violations": (f"one of {', '.join(VIOLATIONS)}", lambda value: value in VIOLATIONS),
    "mission_seeds": (
        "a list of whole numbers >= 0, at least one",
        lambda value: isinstance(value, list) and bool(value) and all(map(_is_count, value)),
    ),
    "goals": ("a whole number >= 0, that of the limits, kept from mrsfi 0.3.0 on", _is_count),
    "max": (
        "a table with a whole number >= 0 for at least one goal",
        lambda value: (
            isinstance(value, dict) and bool(value) and all(map(_is_count, value.values()))
        ),
    ),
}
