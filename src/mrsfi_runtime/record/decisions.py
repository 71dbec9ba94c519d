"""Decisions of a team on weaknesses: accepted, to be mitigated, or duplicates of another one.

A ``Decision`` is a TOML file in ``models/<mission>/decisions/``, whose changes are reviewed as a
diff. Numbers of weaknesses change from campaign to campaign, so it names goal, measure and faults.
The keys of a file are the fields of the class.
"""

import datetime as dt
import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, NamedTuple, Self

from mrsfi_runtime.errors import UsageError, printable
from mrsfi_runtime.record.settings import VIOLATIONS, Rules, parse_table, quoted, read_text

_KINDS = {
    "accept": "accepted",
    "mitigate": "to be mitigated, decided",
    "duplicate": "duplicate of {of}, decided",
}
KINDS = tuple(_KINDS)
_WHAT = "a decision on a weakness"


class Cause(NamedTuple):
    """A goal, and the faults that break it, by their sorted IDs."""

    goal: str
    faults: tuple[str, ...]

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
        return Cause(self.goal, self.faults)

    def renamed(self, names: Mapping[str, str]) -> Self:
        """Return it with other IDs, given by old ones, in the file that they name."""

        def new(cause: Cause) -> Cause:
            faults = sorted(names.get(fault, fault) for fault in cause.faults)
            return Cause(names.get(cause.goal, cause.goal), tuple(faults))

        cause, of = new(self.cause), self.of and new(self.of)
        if (cause, of) == (self.cause, self.of):
            return self
        path = decision_file(self.path.parent.parent, cause, self.violations)
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

    def text(self) -> str:
        """Return the text of the file, as ``parse`` reads it."""
        values = {each.name: getattr(self, each.name) for each in fields(self)[1:]}
        return "".join(f"{key} = {_in_toml(each)}\n" for key, each in values.items() if each)

    def require_known(self, ids: Collection[str]) -> None:
        """Refuse the decision unless all goals and faults that it names are among ``ids``."""
        for cause in filter(None, (self.cause, self.of)):
            for found in (cause.goal, *cause.faults):
                if found not in ids:
                    what = f"{self.path}: found '{found}', which the mission does not have"
                    raise UsageError(f"{what}; decide again, or remove the file")

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


def decision_files(models: Path) -> list[Path]:
    """Return the files of decisions beside a mission's models."""
    return sorted((models / "decisions").glob("*.toml"))


def read_decision(path: Path) -> Decision:
    """Return the decision in a file."""
    return Decision.parse(path, read_text(path, _WHAT))


def decisions_of(models: Path) -> tuple[Decision, ...]:
    """Return the decisions beside a mission's models."""
    return tuple(map(read_decision, decision_files(models)))


def decision_on(cause: Cause, measure: str, decisions: Iterable[Decision]) -> Decision | None:
    """Return the decision on a weakness; none if its measure is graver than what was decided."""
    rank = VIOLATIONS.index
    found = (each for each in decisions if each.cause == cause)
    return next((each for each in found if rank(measure) <= rank(each.violations)), None)


def decision_file(models: Path, cause: Cause, measure: str) -> Path:
    """Return the file of a decision on a weakness, beside the models of its mission."""
    return models / "decisions" / f"{cause.goal}-{measure}-{'+'.join(cause.faults)}.toml"


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
