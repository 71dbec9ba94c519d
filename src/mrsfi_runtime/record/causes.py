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
    def why_not(self) -> str:
        """That it is not known, and why, in words."""
        return f"evaluation {self.index} is not explained: {self.reason}"

    def text(self) -> str:
        """Return all of it but the index as JSON."""
        content = asdict(self)
        del content["index"]
        return encoding.canonical(content)

    @classmethod
    def from_row(cls, row: tuple[int, str, str]) -> Self:
        """Return what is stored of an evaluation: its index, such a text, its specification's.

        Raises
        ------
        ValueError, TypeError
            If they make no sense.
        """
        index, text, specification = row
        content = encoding.object_from_text(text)
        (faults,) = encoding.lists([specification])
        if not _is_whole(content) or not _makes_sense(content, len(faults)):
            raise ValueError(
                f"found {text[:60]}; expected a cause set of the {len(faults)} faults of "
                f"evaluation {index}, with a sentence and a chain each, or a reason"
            )
        lists = {name: tuple(content[name]) for name in _ELEMENTS}
        outcome = content["outcome"] and _outcome(content["outcome"])
        return cls(index, **content | lists | {"outcome": outcome})


_KINDS = {"n_flown": int, "reason": str, "leading": int, "outcome": dict | None}
_ELEMENTS = {"places": int, "sentences": str, "chains": dict, "firmness": dict}
_OUTCOME = {*encoding.COUNTS, "digest"}
_FIRMNESS = {"goal", "kind", "median", "least", "most", "n_violated"}


def _is_whole(content: Mapping[str, Any]) -> bool:
    """Return whether all is there and of its kind."""
    kinds = _KINDS | dict.fromkeys(_ELEMENTS, list)
    return content.keys() == kinds.keys() and all(
        isinstance(content[name], kind) for name, kind in kinds.items()
    )


def _makes_sense(content: Mapping[str, Any], n_faults: int) -> bool:
    """Return whether it is a cause set of some of so many faults, or none."""
    n = len(content["places"])
    outcome = content["outcome"]
    return (
        all(isinstance(one, kind) for name, kind in _ELEMENTS.items() for one in content[name])
        and {*content["places"]} <= {*range(n_faults)}
        and content["leading"] in range(max(n, 1))
        and len(content["sentences"]) == len(content["chains"]) == n
        and (outcome is None) == (n == 0)
        and (outcome is None or outcome.keys() == _OUTCOME)
        and all(each.keys() == _FIRMNESS for each in content["firmness"])
    )


def _outcome(content: Mapping[str, Any]) -> Outcome:
    counts = encoding.integers([content[name] for name in encoding.COUNTS])
    named = dict(zip(encoding.COUNTS, counts, strict=True))
    return Outcome(**named, digest=str(content["digest"]))
