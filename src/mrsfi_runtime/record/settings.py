"""The TOML files of campaigns: their settings, and the limits of kept weaknesses.

A campaign file has one table, ``[search]``, which ``CampaignSettings`` reads strictly: an unknown
key or a wrong value is a ``UsageError`` that names the file. A key that the file leaves out has
the paper's value. Each setting is one field with a ``_Rule`` that checks and converts its value,
whether that comes from a file, an option, a record or a script.

A ``Regression`` is a weakness that a team keeps beside its models. It is two files in
``models/<mission>/regressions/``: a fault specification, ``NAME.xmi``, and ``NAME.toml`` with the
most ticks for which each goal may be violated.
"""

import json
import math
import os
import re
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, fields
from numbers import Integral
from pathlib import Path
from typing import Any, NamedTuple, Self, TypeAlias

from mrsfi_runtime.errors import MrsfiError, SpecificationError, UsageError, expected
from mrsfi_runtime.model.faults import COSTS, Specification
from mrsfi_runtime.model.mission import Outcome
from mrsfi_runtime.record.engine_settings import BOTH, CI, INJECTOR

_LARGEST_SEED = 2**63 - 1

ALGORITHM_NAMES = (
    "paper", "eaSimple", "eaMuPlusLambda", "eaMuCommaLambda", "eaGenerateUpdate", "nsga2", "guided",
    "random", "drift", "cover",
)  # fmt: skip
"""The built-in algorithms, as a campaign file names them."""

COVERING = "cover"
"""The algorithm without populations and generations."""

COVER = 2
"""Version of the rules of ``cover``: a search of another one is neither continued nor recounted.

1: without substitution, and ten variants of each fault before several are flown together.
"""

MINIMISING = ("nsga2", "guided")
"""Algorithms with a Pareto front, which can minimise a cost while they maximise violations."""

VIOLATIONS = ("believed", "true", "masked", "missed")
"""Counts of an outcome that a search can maximise."""

KEEP = 0.95
"""Share of every goal's violations that a cause set keeps."""


class _Rule(NamedTuple):
    expected: str
    accepts: Callable[[Any], bool]
    converted: Callable[[Any], Any]
    names: tuple[str, ...] = ()


def _whole(low: int, high: float = math.inf) -> _Rule:
    words = f"a whole number >= {low}" if high == math.inf else f"a whole number {low} … {high}"

    def accepts(value: Any) -> bool:
        is_whole = isinstance(value, Integral) and not isinstance(value, bool)
        return is_whole and low <= int(value) <= high

    return _Rule(words, accepts, int)


_CHANCE = _Rule(
    "a number 0 … 1",
    lambda value: type(value) in (int, float) and math.isfinite(value) and 0 <= value <= 1,
    float,
)
_NAME = _Rule("a name", lambda value: isinstance(value, str) and bool(value), str)


def _one_of(names: Iterable[str]) -> _Rule:
    known = tuple(names)
    return _Rule("", lambda value: value in known, str, known)


def _are_different(value: Any) -> bool:
    is_texts = isinstance(value, list | tuple) and all(isinstance(each, str) for each in value)
    return is_texts and len(set(value)) == len(value)


def _ids(of: str) -> _Rule:
    return _Rule(f"a list of different {of}", _are_different, tuple)


_SEED = _whole(0, _LARGEST_SEED)


def _setting(default: Any, rule: _Rule) -> Any:
    return field(default=default, metadata={"rule": rule})


@dataclass(frozen=True, slots=True)
class CampaignSettings:
    """The settings of a search; defaults are those of the paper's case studies.

    Functions are named by ``ALGORITHM_NAMES``, ``SELECTIONS``, ``CROSSOVERS``, ``MUTATIONS`` and
    ``FITNESS_FUNCTIONS``, or user-defined, ``module:function``. Fitness and front use one of
    ``VIOLATIONS``; ``missed`` counts the ticks from the one at which a goal can no longer be met.

    References
    ----------
    Source paper, sections III-E and V-A.
    """

    algorithm: str = _setting("paper", _NAME)
    population: int = _setting(20, _whole(1))
    generations: int = _setting(50, _whole(0))  # after the first, which is generation 0
    # Of an individual, as far as the mission has room; with ``minimise`` at most so many
    faults: int = _setting(20, _whole(1))
    crossover: float = _setting(0.7, _CHANCE)  # of a pair to exchange faults
    mutation: float = _setting(0.7, _CHANCE)  # of an individual to mutate
    mutation_share: float = _setting(0.5, _CHANCE)  # of each of its faults; the paper has none
    selection: str = _setting("roulette", _NAME)
    crossover_operator: str = _setting("exchange", _NAME)
    mutation_operator: str = _setting("redraw", _NAME)
    # Offspring in a generation of ``eaMuPlusLambda`` and ``eaMuCommaLambda``; none means
    # ``population``, and twice that for ``eaMuCommaLambda``
    offspring: int | None = _setting(None, _whole(1))
    fitness: str = _setting("weighted", _NAME)
    violations: str = _setting("believed", _one_of(VIOLATIONS))
    # The cost that a front minimises while it maximises violations
    minimise: str | None = _setting(None, _one_of(COSTS))
    # Mission seeds, from ``mission_seed`` on, over which fitness and goal vector are averaged
    replications: int = _setting(1, _whole(1, 1000))
    # IDs of the goals that ``focused`` and the Pareto front use; none means all
    goals: tuple[str, ...] = _setting((), _ids("goal IDs"))
    # IDs of robots, messages, sensors and obstacles whose faults are left out
    protect: tuple[str, ...] = _setting((), _ids("IDs of elements"))
    seed: int = _setting(1, _SEED)  # of the search
    mission_seed: int = _setting(1, _SEED)
    # The run ends after exactly so many, in place of ``generations``: a control run gets as many
    # as the run that it is compared with
    evaluations: int | None = _setting(None, _whole(1))
    # ``cover`` ends when the bound on what it has not found is at most this for every goal
    until: float | None = _setting(None, _CHANCE)
    max_failures: int = _setting(10, _whole(1))  # failed evaluations that end the run
    source: str = field(default="settings", compare=False)  # where they come from, for messages
    options: frozenset[str] = field(default=frozenset(), compare=False)  # those given as options

    @classmethod
    def load(cls, path: Path, **overrides: object) -> Self:
        """Read a campaign file, as ``parse`` does; one that cannot be read is a ``UsageError``."""
        return cls.parse(read_text(path, "a campaign file"), str(path), **overrides)

    @classmethod
    def parse(cls, text: str, source: str, **overrides: object) -> Self:
        """Read the text of a campaign file; keyword arguments replace its values."""
        table = _search_table(text, source)
        values = _checked(table, f"{source}: [search]")
        given = {key: value for key, value in overrides.items() if value is not None}
        if "generations" in given:
            values.pop("evaluations", None)  # of the file, which would take precedence
        values |= _checked(given, "option")
        if values.get("algorithm") == COVERING:
            _require_no_generations("option", given)
            if "algorithm" not in given:  # else the file's settings are for another algorithm
                _require_no_generations(source, table)
            values = {"evaluations": 100_000 if "until" in values else 909} | values
        elif "until" in values:
            raise UsageError(
                f"{'option' if 'until' in given else source}: found until with an algorithm that "
                f"gives no bound; expected algorithm '{COVERING}'"
            )
        return cls(**values, source=source, options=frozenset(given))

    @classmethod
    def from_json(cls, values: Mapping[str, object], source: str = "record") -> Self:
        """Return the settings that ``as_json`` described."""
        given = {key: value for key, value in values.items() if value is not None}
        return cls(**_checked(given, source), source=source)

    def as_json(self) -> dict[str, Any]:
        """Return all settings as values of JSON, ``protect`` only if set, without their source."""
        values = asdict(self)
        del values["source"], values["options"], values["protect"]
        protect = {"protect": list(self.protect)} if self.protect else {}
        return values | {"goals": list(self.goals)} | protect

    def where(self, key: str) -> str:
        """Return the source of a setting, for messages: an option, or the campaign file."""
        return f"option {key}" if key in self.options else f"{self.source}: [search] {key}"

    @property
    def own_modules(self) -> list[str]:
        """Modules of the user-defined functions that it names."""
        values = self.as_json().values()
        named = (value for value in values if isinstance(value, str) and ":" in value)
        return sorted({value.partition(":")[0] for value in named})

    def costs(self, specification: Specification, duration: int) -> tuple[int, ...]:
        """Return the cost of a specification; empty unless the campaign minimises one."""
        return () if self.minimise is None else (COSTS[self.minimise](specification, duration),)

    def is_short(self, n_asked: int) -> bool:
        """Whether a search ended before its ``evaluations``, which only ``cover`` may."""
        return self.algorithm != COVERING and n_asked < (self.evaluations or 0)

    @property
    def mission_seeds(self) -> tuple[int, ...]:
        """The mission seeds over which fitness is averaged, ``mission_seed`` first."""
        return following(self.mission_seed, self.replications)


def following(seed: int, n: int) -> tuple[int, ...]:
    """Return ``n`` mission seeds from ``seed`` on; after the largest comes 0."""
    return tuple((seed + number) % (_LARGEST_SEED + 1) for number in range(n))


_RULES: Mapping[str, _Rule] = {
    each.name: each.metadata["rule"] for each in fields(CampaignSettings) if each.metadata
}


def _search_table(text: str, source: str) -> dict[str, Any]:
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise UsageError(f"{source}: is not TOML: {error}") from error
    for name in document:
        if name != "search":
            raise UsageError(f"{source}: found '{name}'; expected one table, [search]")
    table = document.get("search")
    if not isinstance(table, dict):
        raise UsageError(
            f"{source}: has no table [search]; expected one with the campaign's settings"
        )
    return table


def _checked(table: Mapping[str, object], where: str) -> dict[str, Any]:
    values = {}
    for key, value in table.items():
        if key not in _RULES:
            raise UsageError(f"{where} found unknown key '{key}'; {expected(key, _RULES)}")
        values[key] = _kept(_RULES[key], f"{where} {key}", value)
    return values


def _require_no_generations(where: str, table: Mapping[str, object]) -> None:
    """Refuse settings that the algorithm ``cover`` does not have."""
    for key in ("population", "generations"):
        if key in table:
            raise UsageError(
                f"{where}: found {key} with algorithm '{COVERING}', which has no {key}; expected "
                "evaluations"
            )


def _kept(rule: _Rule, where: str, value: object) -> Any:
    if not rule.accepts(value):
        wanted = expected(value, rule.names) if rule.names else f"expected {rule.expected}"
        raise UsageError(f"{where}: found {value!r}; {wanted}")
    return rule.converted(value)


def require_whole(name: str, value: object) -> int:
    """Return a script's whole number of at least one; refuse anything else."""
    return int(_kept(_whole(1), name, value))


def require_seed(value: object) -> int:
    """Return a script's mission seed; refuse anything else."""
    return int(_kept(_SEED, "seed", value))


Rules: TypeAlias = Mapping[str, tuple[str, Callable[[Any], object]]]
"""For each key of a TOML file: what is expected, and whether a value is that; ``None`` is none."""


def read_text(path: Path, what: str) -> str:
    """Return the text of a file; one that cannot be read is an error that names ``what``."""
    if path.exists() and not path.is_file():  # reading a pipe would wait
        raise SpecificationError(f"{path}: is no regular file; expected {what}")
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"{path}: cannot be read ({error}); expected {what} in TOML") from error


def parse_table(path: Path, text: str, what: str, rules: Rules) -> dict[str, Any]:
    """Return the values of a TOML file; refuse unknown keys, and missing or wrong values."""
    try:
        content = tomllib.loads(text)
    except ValueError as error:  # also numbers of thousands of digits
        raise UsageError(f"{path}: cannot be read ({error}); expected {what} in TOML") from error
    for key in content:
        if key not in rules:
            raise UsageError(f"{path}: found unknown key '{key}'; expected {', '.join(rules)}")
    for key, (wanted, accepts) in rules.items():
        value = content.get(key)
        if not accepts(value):
            found = "nothing" if value is None else repr(value)
            raise UsageError(f"{path}: {key}: found {found}; expected {wanted}")
    return content


@dataclass(frozen=True, slots=True)
class Regression:
    """A kept weakness: a fault specification, and limits that its flights must not exceed.

    ``limits`` has, by goal ID, the most ticks of ``violations`` with each of the ``mission_seeds``.
    ``path`` is the file of the limits. ``found`` states where the weakness was found and what it
    did, ``accepted`` why it is accepted, ``side`` which parts flew, as in ``--side``, and
    ``defect`` why its files cannot be read.
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

    def counts(self, goals: tuple[str, ...], outcome: Outcome, source: str = "") -> dict[str, int]:
        """Return the violations of each limited goal in a flight; refuse an unknown goal.

        ``source`` names where the limits come from, if not from the file.
        """
        violations = dict(zip(goals, getattr(outcome, self.violations), strict=True))
        for goal in self.limits:
            if goal not in violations:
                known = expected(goal, goals, "goals of the mission:")
                raise UsageError(f"{source or f'{self.path}: max'}: found goal '{goal}'; {known}")
        return {goal: violations[goal] for goal in self.limits}

    def exceeded(self, counts: Mapping[str, int]) -> tuple[str, ...]:
        """Return the goals that exceed their limits, by what ``counts`` returned."""
        return tuple(goal for goal, ticks in counts.items() if ticks > self.limits[goal])

    def idle(self, duration: int) -> Iterator[str]:
        """Yield a warning for each limit that no flight of ``duration`` ticks can exceed."""
        for goal, most in self.limits.items():
            if most >= duration:
                yield (
                    f"{self.path}: max: a mission of {duration} ticks cannot exceed the limit "
                    f"{goal} = {most}; expected fewer ticks"
                )

    def text(self) -> str:
        """Return the text of the file, as ``load`` reads it."""
        accepted = f"accepted = {quoted(self.accepted)}\n" if self.accepted else ""
        side = "" if self.side == BOTH else f'side = "{self.side}"\n'
        text = (
            f"found = {quoted(self.found)}\n{accepted}"
            f"{side}violations = {json.dumps(self.violations)}\n"
            f"mission_seeds = {list(self.mission_seeds)}\n"
            f"goals = {len(self.limits)}\n"
            "\n[max]\n"
        )
        for goal, most in self.limits.items():
            is_bare = re.fullmatch(r"[A-Za-z0-9_-]+", goal)
            text += f"{goal if is_bare else quoted(goal)} = {most}\n"
        return text

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read a file of limits; refuse unknown keys, and missing or wrong values."""
        what = "the limits of a kept weakness"
        content = parse_table(path, read_text(path, what), what, _KEPT_RULES)
        seeds, limits = tuple(content["mission_seeds"]), content["max"]
        if content["goals"] != len(limits):
            raise UsageError(
                f"{path}: max: found {len(limits)} limits; expected {content['goals']}, the number "
                "in goals; restore the file, or correct goals if the limits are right"
            )
        rest = content.get("accepted", ""), content.get("side", BOTH)
        return cls(path, content["found"], content["violations"], seeds, limits, None, *rest)


def kept(models: Path) -> tuple[Regression, ...]:
    """Return the weaknesses kept beside a mission's models, by name, unreadable ones included."""
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
    specification = path.with_suffix(".xmi")
    try:
        if specification.exists() and not specification.is_file():  # reading a pipe would wait
            raise SpecificationError(
                f"{specification}: is no regular file; expected a kept weakness"
            )
        if not path.exists():
            raise UsageError(f"{specification}: found no limits; expected {path.name} beside it")
        return Regression.load(path)
    except MrsfiError as error:
        return Regression(path, "", "", (), {}, error)


def folder_of(models: Path) -> Path:
    """Return the folder of a mission's kept weaknesses, by the folder of its models."""
    return models / "regressions"


def quoted(text: str) -> str:
    """Return a text as a TOML string, which differs from JSON in one character."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")


def _is_count(value: Any) -> bool:
    return type(value) is int and value >= 0


_KEPT_RULES: Rules = {
    "found": ("a text", lambda value: isinstance(value, str)),
    "accepted": ("a text", lambda value: value is None or isinstance(value, str)),
    "side": (f"{CI} or {INJECTOR}", lambda value: value in (None, CI, INJECTOR)),
    "violations": (f"one of {', '.join(VIOLATIONS)}", lambda value: value in VIOLATIONS),
    "mission_seeds": (
        "a list of whole numbers >= 0, at least one",
        lambda value: isinstance(value, list) and value and all(map(_is_count, value)),
    ),
    "goals": ("a whole number >= 0, the number of limits, as from mrsfi 0.3.0 on", _is_count),
    "max": (
        "a table with a whole number >= 0 for at least one goal",
        lambda value: isinstance(value, dict) and value and all(map(_is_count, value.values())),
    ),
}
