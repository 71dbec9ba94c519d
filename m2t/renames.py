"""Which elements of a model have another ID than in an older one, and are otherwise the same."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TypeAlias

from m2t.outlines import Outline, Value

Signature: TypeAlias = tuple[object, ...]
"""What an element says but for IDs that only one of the models has."""

_SOME_ID = "•"


def renamed(olds: Sequence[Outline], news: Sequence[Outline]) -> dict[Outline, Outline]:
    """Return the elements of an older model that have another ID now, by those of the newer one.

    An element that is gone and one that is new, in the same place, are one if they say the same
    with all in them; references to what was renamed count as the same.
    """
    gone, added = _without(olds, news), _without(news, olds)
    found: dict[Outline, Outline] = {}
    for old, new in zip(olds, news, strict=True):
        found |= _within(old, new, gone, added)
    return found


def rename(roots: Iterable[Outline], found: Mapping[Outline, Outline]) -> None:
    """Let the older model have the IDs of the newer one, also where it refers to what has them."""
    names = {old.identity: new.identity for new, old in found.items()}
    for new, old in found.items():
        old.identity, old.key = new.identity, new.key
    for root in roots:
        for outline in root.walk():
            outline.values = {name: _with(value, names) for name, value in outline.values.items()}


def _with(value: Value, names: Mapping[str, str]) -> Value:
    return value if value is None else " ".join(names.get(word, word) for word in value.split(" "))


def _without(roots: Sequence[Outline], others: Sequence[Outline]) -> dict[str, Outline]:
    """Return the elements of some models, by ID, whose ID no element of other models has."""
    known = {outline.identity for other in others for outline in other.walk()}
    every = (outline for root in roots for outline in root.walk())
    return {each.identity: each for each in every if each.identity and each.identity not in known}


def _within(
    old: Outline, new: Outline, gone: Mapping[str, Outline], added: Mapping[str, Outline]
) -> dict[Outline, Outline]:
    """Return what was renamed below an element that both models have."""
    found: dict[Outline, Outline] = {}
    for name, after in new.children.items():
        before = old.children.get(name, [])
        lost = [each for each in before if gone.get(each.identity) is each]
        for each in after:
            if added.get(each.identity) is not each:
                continue
            sought = _signature(each, added)
            same = next((one for one in lost if _signature(one, gone) == sought), None)
            if same is not None:
                lost.remove(same)
                found[each] = same
    kept = {each.key: each for each in _children(old)}
    for each in _children(new):
        earlier = found.get(each, kept.get(each.key))
        if earlier is not None:
            found |= _within(earlier, each, gone, added)
    return found


def _children(outline: Outline) -> Iterator[Outline]:
    for children in outline.children.values():
        yield from children


def _signature(outline: Outline, own: Mapping[str, Outline]) -> Signature:
    """Return what an element says; ``own`` are the IDs that only its model has."""
    values = tuple(
        (name, None if value is None else _hidden(value, own))
        for name, value in outline.values.items()
    )
    inside = tuple(
        (name, tuple(_signature(child, own) for child in children))
        for name, children in outline.children.items()
    )
    return (outline.kind, _hidden(outline.identity, own), values, inside)


def _hidden(text: str, own: Mapping[str, Outline]) -> str:
    """Return a text without the IDs that only one model has, be they references or a name."""
    return " ".join(_SOME_ID if word.strip("'") in own else word for word in text.split(" "))
