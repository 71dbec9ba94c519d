"""Unified differences of long files in time that grows with their length.

``difflib`` looks at the whole file for every changed line. Here, lines that stand once in both
files divide them first, as in a patience diff; what lies between two of them is compared a part
at a time. That gives a right difference for any two files, and that of ``difflib`` where both fit
into one part.
"""

from bisect import bisect_left
from collections import Counter
from collections.abc import Iterator, Sequence
from difflib import SequenceMatcher

PART = 400
"""Lines that are compared at a time; more only where they have nothing in common."""

_CONTEXT = 3

Block = tuple[int, int, int]
Opcode = tuple[str, int, int, int, int]


def unified_difference(
    old: Sequence[str], new: Sequence[str], old_name: str, new_name: str, line_end: str = "\n"
) -> Iterator[str]:
    """Yield the lines of the unified difference, as ``difflib.unified_diff`` does.

    Parameters
    ----------
    old, new
        Lines to compare.
    old_name, new_name
        What the header calls them.
    line_end
        End of the lines of header and hunks; empty where the compared lines have none.
    """
    is_first = True
    for group in _Aligned(old, new).get_grouped_opcodes(_CONTEXT):
        if is_first:
            is_first = False
            yield f"--- {old_name}{line_end}"
            yield f"+++ {new_name}{line_end}"
        first, last = group[0], group[-1]
        ranges = f"-{_range(first[1], last[2])} +{_range(first[3], last[4])}"
        yield f"@@ {ranges} @@{line_end}"
        for opcode in group:
            yield from _changed(opcode, old, new)


def _changed(opcode: Opcode, old: Sequence[str], new: Sequence[str]) -> Iterator[str]:
    what, old_first, old_last, new_first, new_last = opcode
    if what == "equal":
        yield from (f" {line}" for line in old[old_first:old_last])
        return
    yield from (f"-{line}" for line in old[old_first:old_last])
    yield from (f"+{line}" for line in new[new_first:new_last])


def _range(first: int, last: int) -> str:
    """Return the lines of a hunk as patches write them."""
    length = last - first
    begin = first + 1 if length else first
    return f"{begin}" if length == 1 else f"{begin},{length}"


class _Aligned(SequenceMatcher[str]):
    """A matcher that knows what two files have in common before it is asked."""

    def __init__(self, old: Sequence[str], new: Sequence[str]) -> None:
        super().__init__(None, (), ())
        self._lengths = (len(old), len(new))
        self._blocks = _common_blocks(old, new)

    def get_matching_blocks(self) -> list[Block]:  # type: ignore[override]
        return [*self._blocks, (*self._lengths, 0)]


def _common_blocks(old: Sequence[str], new: Sequence[str]) -> list[Block]:
    """Return runs of equal lines, in order: where they begin in both, and how long they are."""
    blocks: list[Block] = []
    at_old, at_new = 0, 0
    is_short = max(len(old), len(new)) <= PART
    for anchor_old, anchor_new in () if is_short else _anchors(old, new):
        between = _compared(old[at_old:anchor_old], new[at_new:anchor_new])
        _join(blocks, at_old, at_new, [*between, (anchor_old - at_old, anchor_new - at_new, 1)])
        at_old, at_new = anchor_old + 1, anchor_new + 1
    _join(blocks, at_old, at_new, _compared(old[at_old:], new[at_new:]))
    return blocks


def _anchors(old: Sequence[str], new: Sequence[str]) -> list[tuple[int, int]]:
    """Return where lines stand that both files have once: as many as are in the same order."""
    counts_old, counts_new = Counter(old), Counter(new)
    places = {line: n for n, line in enumerate(new) if counts_new[line] == 1}
    pairs = [(n, places[line]) for n, line in enumerate(old) if line in places]
    pairs = [(n, m) for n, m in pairs if counts_old[old[n]] == 1]
    ends: list[int] = []  # the least end of an increasing run, by its length
    chosen: list[int] = []  # the pair that has it
    before: list[int] = []  # by pair, the one before it in its run; -1 if none
    for k, (_, place) in enumerate(pairs):
        length = bisect_left(ends, place)
        before.append(chosen[length - 1] if length else -1)
        ends[length : length + 1] = [place]
        chosen[length : length + 1] = [k]
    run = []
    k = chosen[-1] if chosen else -1
    while k >= 0:
        run.append(pairs[k])
        k = before[k]
    return run[::-1]


def _compared(old: Sequence[str], new: Sequence[str]) -> list[Block]:
    """Return runs of equal lines, part by part.

    A part is settled up to three quarters of its length, because its last lines may belong to
    lines beyond it. One that settles nothing is compared again at twice the length.
    """
    blocks: list[Block] = []
    at_old, at_new, size = 0, 0, PART
    while at_old < len(old) and at_new < len(new):
        part = SequenceMatcher(None, old[at_old : at_old + size], new[at_new : at_new + size])
        found = part.get_matching_blocks()[:-1]
        is_last = at_old + size >= len(old) and at_new + size >= len(new)
        settled = found if is_last else [*_settled(found, size * 3 // 4)]
        _join(blocks, at_old, at_new, settled)
        if is_last:
            break
        if settled:
            a, b, length = settled[-1]
            at_old, at_new, size = at_old + a + length, at_new + b + length, PART
        else:
            size *= 2
    return blocks


def _settled(found: Sequence[Block], limit: int) -> Iterator[Block]:
    for a, b, length in found:
        fitting = min(length, limit - max(a, b))
        if fitting > 0:
            yield a, b, fitting


def _join(blocks: list[Block], at_old: int, at_new: int, found: Sequence[Block]) -> None:
    """Add runs that were found from a place on, joined where nothing lies between."""
    for a, b, length in found:
        begin = (at_old + a, at_new + b)
        old, new, before = blocks[-1] if blocks else (-1, -1, 0)
        if blocks and (old + before, new + before) == begin:
            blocks[-1] = (old, new, before + length)
        else:
            blocks.append((*begin, length))
