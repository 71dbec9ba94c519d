"""Decisions of a team on weaknesses: accepted, to be mitigated, or duplicates of another one.

A ``Decision`` is a TOML file in ``models/<mission>/decisions/``, whose changes are reviewed as a
diff. Numbers of weaknesses change from campaign to campaign, so it names goal, measure and faults.
There is at most one on a goal and a set of faults. The keys of a file are the fields of the class.
"""

import datetime as dt
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple, Protocol, Self

from mrsfi_runtime.errors import MrsfiError, UsageError, expected, printable
from mrsfi_runtime.record.settings import VIOLATIONS, Rules, parse_table, quoted, read_text

_KINDS = {
    "accept": "accepted",
    "mitigate": "to be mitigated, decided",
    "duplicate": "duplicate of {of}, decided",
}
KINDS = tuple(_KINDS)
_WHAT = "a decision on a weakness"
_LONGEST = 200  # characters of a file's name, of which file systems take 255


class Judged(Protocol):
    """What can be decided on: faults, by sorted IDs, that break a goal, at worst by ``measure``."""

    @property
    def goal(self) -> str: ...  # noqa: D102 - as the next, in the docstring of the class
    @property
    def faults(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def measure(self) -> str: ...  # noqa: D102


class Cause(NamedTuple):
    """A goal, the faults that break it, by their sorted IDs, and a measure or none."""

    goal: str
    faults: tuple[str, ...]
    measure: str = ""

    def __str__(self) -> str:
        """Return ``g2 by f3 and f7``."""
        return f"{self.goal} by {' and '.join(self.faults)}"


@dataclass(frozen=True, slots=True)
class Decision:
    """A decision on a weakness, whose ``violations`` are its gravest measure when it was decided.

    ``because`` is the reason, ``by`` who decided, ``until`` the last day on which it is valid. A
    duplicate is one of the weakness ``of``. ``found`` describes the weakness.
    """

    path: Path
    goal: str
    violations: str
    faults: tuple[str, ...]
    kind: str
    because: str
    by: str
    date: dt.date
    until: dt.date | None = None
    of: Cause | None = None
    found: str = ""

    @property
    def cause(self) -> Cause:
        """The weakness on which it decides."""
        return Cause(self.goal, self.faults, self.violations)

    def renamed(self, names: Mapping[str, str]) -> Self:
        """Return it with other IDs, given by old ones, in the file that they name."""

        def new(cause: Cause) -> Cause:
            faults = sorted(names.get(fault, fault) for fault in cause.faults)
            return cause._replace(goal=names.get(cause.goal, cause.goal), faults=tuple(faults))

        cause, of = new(self.cause), self.of and new(self.of)
        if (cause, of) == (self.cause, self.of):
            return self
        path = decision_file(self.path.parent.parent, cause)
        return replace(self, path=path, goal=cause.goal, faults=cause.faults, of=of)

    def has_expired(self, today: dt.date) -> bool:
        """Return whether it is no longer valid."""
        return self.until is not None and self.until < today

    def in_words(self, today: dt.date) -> str:
        """Return the decision in one line: who decided what, until when, and why."""
        expired = "expired, " if self.has_expired(today) else ""
        until = "" if self.until is None else f" until {self.until}"
        what = _KINDS[self.kind].format(of=self.of)
        return printable(f"{expired}{what} by {self.by} on {self.date}{until}: {self.because}")

    def sentence(self, today: dt.date) -> str:
        """Return the decision in a sentence that names the weakness."""
        return f"Decision on {self.cause}: {self.in_words(today)}."

    def as_json(self, today: dt.date) -> dict[str, Any]:
        """Return it as plain values, without the weakness."""
        names = ("kind", "because", "by", "date", "until", "of", "path")
        values = {name: getattr(self, name) for name in names}
        plain = {name: None if each is None else str(each) for name, each in values.items()}
        return plain | {"expired": self.has_expired(today)}

    def text(self) -> str:
        """Return the text of the file, as ``parse`` reads it."""
        values = {each.name: getattr(self, each.name) for each in fields(self)[1:]}
        return "".join(f"{key} = {_in_toml(each)}\n" for key, each in values.items() if each)

    @classmethod
    def parse(cls, path: Path, text: str) -> Self:
        """Return the decision of a file's text; refuse unknown keys, missing and wrong values."""
        table = parse_table(path, text, _WHAT, _RULES)
        until, of = table.get("until"), table.get("of")
        if (of is not None) != (table["kind"] == "duplicate"):
            raise UsageError(
                f"{path}: of: found {of or 'nothing'}; expected the weakness of which it is a "
                "duplicate, and for other decisions nothing"
            )
        if until is not None and until < table["date"]:
            raise UsageError(f"{path}: until: found {until}; expected {table['date']} or later")
        table["of"] = of and Cause(of["goal"], tuple(sorted(of["faults"])))
        return cls(path, **table | {"faults": tuple(sorted(table["faults"]))})


def read_decisions(
    models: Path, goals: Collection[str] | None = None, faults: Collection[str] = ()
) -> Iterator[tuple[Path, Decision | MrsfiError]]:
    """Yield the files of decisions beside a mission's models, each with its decision or defect.

    With the IDs of the mission, a decision that names others is a defect.
    """
    first: dict[tuple[object, ...], str] = {}
    for path in sorted((models / "decisions").glob("*.toml")):
        try:
            found = Decision.parse(path, read_text(path, _WHAT))
            other = first.setdefault(found.cause[:2], path.name)
            if other != path.name:
                what = f"found a second decision on {found.cause}, beside {other}"
                raise UsageError(f"{path}: {what}; expected one; remove one of the files")
            if goals is not None:
                _require_known(found, goals, faults)
        except MrsfiError as error:
            yield path, error
        else:
            yield path, found


def _require_known(decision: Decision, goals: Collection[str], faults: Collection[str]) -> None:
    for cause in filter(None, (decision.cause, decision.of)):
        named = [("goals", cause.goal, goals), *(("faults", each, faults) for each in cause.faults)]
        for what, found, known in named:
            if found not in known:
                wanted = expected(found, known, f"one of the {what} of the mission:")
                advice = "decide again, or remove the file"
                raise UsageError(f"{decision.path}: found '{found}'; {wanted}; {advice}")


def decisions_of(models: Path) -> tuple[Decision, ...]:
    """Return the decisions beside a mission's models; one that cannot be read is an error."""
    decisions = []
    for _, found in read_decisions(models):
        if isinstance(found, MrsfiError):
            raise found
        decisions.append(found)
    return tuple(decisions)


def decision_on(weakness: Judged, decisions: Iterable[Decision]) -> Decision | None:
    """Return the decision on a weakness; none if the weakness is graver than what was decided."""
    rank, cause = VIOLATIONS.index, (weakness.goal, weakness.faults)
    found = (each for each in decisions if each.cause[:2] == cause)
    return next((each for each in found if rank(weakness.measure) <= rank(each.violations)), None)


def words_on(weakness: Judged, decisions: Iterable[Decision], today: dt.date) -> str:
    """Return the decision on a weakness in words; empty if there is none."""
    found = decision_on(weakness, decisions)
    return "" if found is None else found.in_words(today)


def decision_file(models: Path, weakness: Judged) -> Path:
    """Return the file of a decision on a weakness, beside the models of its mission."""
    name = f"{weakness.goal}-{weakness.measure}-{'+'.join(weakness.faults)}"
    if len(name) > _LONGEST:
        name = f"{name[:_LONGEST]}-{sha256(name.encode()).hexdigest()[:8]}"
    return models / "decisions" / f"{name}.toml"


def _in_toml(value: object) -> str:
    if isinstance(value, Cause):
        return f"{{ goal = {quoted(value.goal)}, faults = {_in_toml(value.faults)} }}"
    if isinstance(value, tuple):
        return f"[{', '.join(map(quoted, value))}]"
    return quoted(value) if isinstance(value, str) else str(value)


def _is_text(value: Any) -> object:
    return isinstance(value, str) and re.fullmatch(r"(?s)(?=.*\S)[^\ud800-\udfff]+", value)


def _are_ids(value: Any) -> object:
    is_list = isinstance(value, list) and value and all(map(_is_text, value))
    return is_list and len({*value}) == len(value)


def _is_cause(value: Any) -> object:
    is_table = isinstance(value, dict) and {*value} == {"goal", "faults"}
    return is_table and _is_text(value["goal"]) and _are_ids(value["faults"])


_MEASURES = [each for each in VIOLATIONS if each != "masked"]
_TEXT, _DAY = ("a text", _is_text), "a day, such as 2027-03-01"
_RULES: Rules = {
    "goal": ("the ID of a goal", _is_text),
    "violations": (f"one of {', '.join(_MEASURES)}", lambda value: value in _MEASURES),
    "faults": ("a list of different IDs of faults", _are_ids),
    "kind": (f"one of {', '.join(KINDS)}", lambda value: value in KINDS),
    "because": _TEXT,
    "by": _TEXT,
    "date": (_DAY, lambda value: type(value) is dt.date),
    "until": (_DAY, lambda value: value is None or type(value) is dt.date),
    "of": ("a table with goal and faults", lambda value: value is None or _is_cause(value)),
    "found": ("a text", lambda value: value is None or _is_text(value)),
}
