"""Unified differences of long files in time that grows with their length.

``difflib`` looks at the whole file for every changed line. Here, lines that stand once in both
files divide them first, as in a patience diff, and what lies between two of them is divided again.
That gives a right difference for any two files, and that of ``difflib`` for short ones.
"""

from bisect import bisect_left
from collections import Counter, defaultdict, deque
from collections.abc import Iterator, Sequence
from difflib import SequenceMatcher
from itertools import groupby

SHORT = 400
"""Lines that are compared undivided; more only where nothing divides them."""

_CONTEXT = 3

Opcode = tuple[str, int, int, int, int]


def unified_difference(
    old: Sequence[str], new: Sequence[str], old_name: str, new_name: str, line_end: str = "\n"
) -> Iterator[str]:
    """Yield the lines of the unified difference, as ``difflib.unified_diff`` does.

    ``line_end`` ends the lines of header and hunks; it is empty where the compared lines have none.
    """
    for number, group in enumerate(_Aligned(old, new).get_grouped_opcodes(_CONTEXT)):
        if number == 0:
            yield f"--- {old_name}{line_end}"
            yield f"+++ {new_name}{line_end}"
        (_, old_first, _, new_first, _), (_, _, old_last, _, new_last) = group[0], group[-1]
        ranges = f"-{_range(old_first, old_last)} +{_range(new_first, new_last)}"
        yield f"@@ {ranges} @@{line_end}"
        for opcode in group:
            yield from _changed(opcode, old, new)


def _changed(opcode: Opcode, old: Sequence[str], new: Sequence[str]) -> Iterator[str]:
    what, old_first, old_last, new_first, new_last = opcode
    mark = " " if what == "equal" else "-"
    yield from (f"{mark}{line}" for line in old[old_first:old_last])
    if what != "equal":
        yield from (f"+{line}" for line in new[new_first:new_last])


def _range(first: int, last: int) -> str:
    """Return the lines of a hunk as patches write them."""
    length = last - first
    begin = first + 1 if length else first
    return f"{begin}" if length == 1 else f"{begin},{length}"


class _Aligned(SequenceMatcher[str]):
    """A matcher that knows the runs of equal lines of two files before it is asked."""

    def __init__(self, old: Sequence[str], new: Sequence[str]) -> None:
        super().__init__(None, (), ())
        pairs = enumerate(_pairs(old, new))
        runs = [[*run] for _, run in groupby(pairs, lambda each: [p - each[0] for p in each[1]])]
        blocks = [(*run[0][1], len(run)) for run in runs]
        self.matching_blocks = [*blocks, (len(old), len(new), 0)]


def _pairs(old: Sequence[str], new: Sequence[str]) -> Iterator[tuple[int, int]]:
    """Yield the places of equal lines in both files, in order."""
    anchors = [] if max(len(old), len(new)) <= SHORT else _anchors(old, new)
    if not anchors:
        for a, b, length in SequenceMatcher(None, old, new).get_matching_blocks():
            yield from zip(range(a, a + length), range(b, b + length), strict=True)
        return
    begin = (0, 0)
    for a, b in anchors:
        yield from _pairs_between(old, new, begin, (a, b))
        yield a, b
        begin = (a + 1, b + 1)
    yield from _pairs_between(old, new, begin, (len(old), len(new)))


def _pairs_between(
    old: Sequence[str], new: Sequence[str], begin: tuple[int, int], end: tuple[int, int]
) -> Iterator[tuple[int, int]]:
    if begin[0] < end[0] and begin[1] < end[1]:
        for a, b in _pairs(old[begin[0] : end[0]], new[begin[1] : end[1]]):
            yield begin[0] + a, begin[1] + b


def _anchors(old: Sequence[str], new: Sequence[str]) -> list[tuple[int, int]]:
    """Return where lines stand that both files have once: as many as are in the same order.

    Without such lines, they are those that both files have as often as each other.
    """
    counts_old, counts_new = Counter(old), Counter(new)
    alike = {line for line, count in counts_old.items() if counts_new[line] == count}
    dividing = {line for line in alike if counts_old[line] == 1} or alike
    places: dict[str, deque[int]] = defaultdict(deque)
    for n, line in enumerate(new):
        places[line].append(n)
    pairs = [(n, places[line].popleft()) for n, line in enumerate(old) if line in dividing]
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
