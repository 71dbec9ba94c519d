"""Flights that a campaign keeps beside its evaluations: what was flown after the search."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.record import encoding

_OUTCOME = (*encoding.COUNTS, "digest")


@dataclass(frozen=True, slots=True)
class RecordedFlight:
    """What came of a specification with a mission seed.

    If the mission's own code failed, ``outcome`` is ``None``, and ``traceback`` what it raised.
    """

    mission_seed: int
    specification: Specification
    outcome: Outcome | None
    traceback: str = ""

    def row(self) -> tuple[int, str, str]:
        """Return it as it is stored: mission seed, specification, what came of it."""
        outcome = self.outcome
        found = self.traceback if outcome is None else {n: getattr(outcome, n) for n in _OUTCOME}
        text = encoding.specification_text(self.specification)
        return int(self.mission_seed), text, encoding.canonical([found])

    @classmethod
    def from_row(cls, row: tuple[int, str, str]) -> Self:
        """Return what such a row says; ``ValueError`` or ``TypeError`` if it makes no sense."""
        seed, specification, text = row
        faults, (found, *rest) = encoding.lists([specification, text])
        known = encoding.specification(faults)
        if isinstance(found, str) and not rest:
            return cls(seed, known, None, found)
        if rest or not isinstance(found, dict) or found.keys() != {*_OUTCOME}:
            raise ValueError(f"found {text[:60]}; expected the outcome of a flight, or an error")
        return cls(seed, known, _outcome(found))


def _outcome(content: Mapping[str, Any]) -> Outcome:
    counts = encoding.integers([content[name] for name in encoding.COUNTS])
    named = dict(zip(encoding.COUNTS, counts, strict=True))
    return Outcome(**named, digest=str(content["digest"]))
