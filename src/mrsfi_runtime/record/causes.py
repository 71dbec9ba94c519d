"""What a campaign keeps of what it found out about the causes of its evaluations."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Self

from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.record import encoding


@dataclass(frozen=True, slots=True)
class RecordedCause:
    """What the violations of an evaluation are due to, or why that is not known.

    Attributes
    ----------
    index
        The evaluation.
    n_flown
        Number of flights that it took to find out.
    reason
        Why it is not known; empty if it is, and the rest then says what.
    places
        The cause set: faults of the specification, by their places in it, ascending.
    leading
        Which of them, by its place among them, most violations are lost without.
    outcome
        What flying the cause set finds in the first mission seed.
    sentences
        What each of its faults did, in words.
    chains, firmness
        First differences that each makes, and counts in other weather, as scripts read them.
    """

    index: int
    n_flown: int
    reason: str = ""
    places: tuple[int, ...] = ()
    leading: int = 0
    outcome: Outcome | None = None
    sentences: tuple[str, ...] = ()
    chains: tuple[Mapping[str, Any], ...] = ()
    firmness: tuple[Mapping[str, Any], ...] = ()

    @property
    def sentence(self) -> str:
        """What the leading fault did, in words; empty if there is none."""
        return self.sentences[self.leading] if self.sentences else ""

    def text(self) -> str:
        """Return all of it but the index as JSON."""
        content = asdict(self)
        del content["index"]
        return encoding.canonical(content)

    @classmethod
    def from_text(cls, row: tuple[int, str]) -> Self:
        """Return what an index and such a text say; a ValueError or TypeError if they do not."""
        index, text = row
        content = encoding.object_from_text(text)
        outcome = content.pop("outcome", None)
        lists = {name: tuple(each) for name, each in content.items() if isinstance(each, list)}
        return cls(index, outcome=_outcome(outcome), **content | lists)


def _outcome(content: Mapping[str, Any] | None) -> Outcome | None:
    if content is None:
        return None
    counts = {name: tuple(content[name]) for name in encoding.COUNTS}
    return Outcome(**counts, digest=content["digest"])
