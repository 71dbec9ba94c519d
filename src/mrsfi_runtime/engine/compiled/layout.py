"""The layout of many flights in arrays, which compiled code reads and writes.

States and fault plans are words in a row, field by field as their records declare them
(``entries``). Compiled code gets a state, a plan or the verdicts as the address of a directory,
which has the addresses and lengths of the parts of a record of lists. So sizes are data, and one
compiled flight serves every mission.

``FreshState`` is a state before the first tick. A ``Batch`` has the plans of specifications side by
side, and room for their results; a ``Frame`` adds the three states in which one thread flies them.
An object with a directory also keeps the arrays that it points to.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Sized
from dataclasses import astuple, dataclass, fields, replace
from functools import cache, cached_property, lru_cache, partial
from itertools import accumulate, chain, pairwise, starmap
from struct import Struct
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np
import numpy.typing as npt

from mrsfi_runtime.engine.flights import digested
from mrsfi_runtime.engine.recording import KINDS, Records, record_type, recorded_type
from mrsfi_runtime.kernel.flight import Verdicts, reached
from mrsfi_runtime.kernel.injections import (
    FaultTally,
    InjectionRow,
    InjectionState,
    OwnFault,
    OwnRow,
    Plan,
    PlanRows,
    TriggerState,
    WaitingState,
)
from mrsfi_runtime.kernel.randomness import PURPOSE_SAMPLES, draw
from mrsfi_runtime.kernel.state import COLUMNS, MissionState, State
from mrsfi_runtime.model.mission import COUNTED, Outcome

N_ALLOWED = 6
ALLOWED = " allowed"  # no name that a region could use
OWN = np.dtype([*record_type(OwnFault).descr, (ALLOWED, "<i8", (N_ALLOWED,))])
"""A user-defined fault, and the words of the belief that it may change, see ``allowed_words``."""

RECORDED, CALLS = " recorded", " calls"
"""Lists of a state that no region can name: the recorded words, and the addresses of regions."""

_HIDDEN: Mapping[type, tuple[str, ...]] = {State: (RECORDED, CALLS)}


ALIKE: Mapping[type, Mapping[str, str]] = {
    State: {
        **dict.fromkeys(("commands", "traits", "wishes"), "robots"),
        **dict.fromkeys(("required", "apart", "longest", "gaps"), "goals"),
        "switches": "sensors",
        "outlines": "obstacles",
        "routes": "members",
    },
    Verdicts: dict.fromkeys(get_type_hints(Verdicts), "is_true"),
}
"""Lists that are always as long as another one: one check of a bound is enough for all."""


@dataclass(frozen=True, slots=True)
class Entry:
    """A field of a record of lists: a list, a record, a number of one, or a directory within.

    ``place`` is the number of its entry in the directory, ``sized`` that of the list that has as
    many elements, and ``layout`` that of an element.
    """

    kind: str
    place: int
    layout: np.dtype[Any]
    inner: type | None = None
    sized: int = 0


@cache
def entries(kind: type) -> Mapping[str, Entry]:
    """Return the fields of a record of lists, by name; all its numbers are in one record."""
    hints = get_type_hints(kind)
    found: dict[str, Entry] = {}
    numbers = np.dtype([(name, KINDS[hint]) for name, hint in hints.items() if hint in KINDS])
    place = 1 if numbers.names else 0
    for name, hint in hints.items():
        if hint in KINDS:
            found[name] = Entry("number", 0, numbers)
            continue
        elements = (hint,) if hint is bytes else get_args(hint)
        if elements:
            found[name] = Entry("list", place, element_type(elements[0]))
        elif any(get_args(inner) and inner not in KINDS for inner in get_type_hints(hint).values()):
            found[name] = Entry("inner", place, np.dtype(np.int64), hint)
            place += n_entries(hint) - 1
        else:
            found[name] = Entry("record", place, record_type(hint))
        place += 1
    for name in _HIDDEN.get(kind, ()):
        found[name] = Entry("list", place, np.dtype(np.int64))
        place += 1
    alike = ALIKE.get(kind, {})
    return {
        name: replace(each, sized=found[alike.get(name, name)].place)
        for name, each in found.items()
    }


def n_entries(kind: type) -> int:
    """Return how many entries the directory of a record of lists has."""
    last = list(entries(kind).values())[-1]
    return last.place + (n_entries(last.inner) if last.inner else 1)


def element_type(element: Any) -> np.dtype[Any]:
    """Return the layout of an element of a list."""
    known = {OwnFault: OWN, bytes: np.dtype(np.uint8)}
    if element in known:
        return known[element]
    return np.dtype(KINDS[element]) if element in KINDS else record_type(element)


Words = npt.NDArray[np.int64]

TABLES = tuple(name for name, hint in get_type_hints(State).items() if get_origin(hint) is tuple)
"""Parts of a state that no flight may change, so that they need not be laid out anew for each."""

_ENTRIES = entries(State)
_TICK = list(get_type_hints(MissionState)).index("tick")
_RECORDED, _TABLES = ({_ENTRIES[name].place for name in names} for names in (COLUMNS, TABLES))


@dataclass(frozen=True)
class FreshState:
    """A state before the first tick, as words: the recorded part, other variables, tables.

    ``places`` has for each entry of a directory the first word, and the number of elements;
    ``samples`` has the valid ones of each sensor, tick after tick.
    """

    words: Words
    recorded: np.dtype[Any]
    places: tuple[tuple[int, int], ...]
    n_changing: int
    samples: npt.NDArray[np.uint8]

    @property
    def n_recorded(self) -> int:
        """Number of words that are recorded."""
        return self.recorded.itemsize // 8

    @property
    def tick(self) -> int:
        """The word that is the tick."""
        return self.places[_ENTRIES["mission"].place][0] + _TICK

    def directory(self, words: Words, calls: Words) -> Words:
        """Return the directory of a state that lies in words, with the addresses of its regions."""
        found = np.zeros((n_entries(State), 2), np.int64)
        found[: len(self.places)] = self.places
        found[:, 0] = found[:, 0] * 8 + words.ctypes.data
        found[_ENTRIES[RECORDED].place] = words.ctypes.data, self.n_recorded
        found[_ENTRIES[CALLS].place] = calls.ctypes.data, len(calls)
        return found

    def allowed_words(self, listed: str, target: int, columns: Sequence[str]) -> list[int]:
        """Return the words of some columns of a record, in order, filled up with ``n_recorded``."""
        numbers = np.arange(self.n_recorded).view(self.recorded)[0][listed][target]
        found = sorted(int(numbers[column].view(np.int64)) for column in columns)
        return found + [self.n_recorded] * (N_ALLOWED - len(found))


def laid_out(state: State) -> FreshState:
    """Return a state as words, the model for the other states of its mission."""
    parts = dict(_parts(State, state, 0))
    places = {}
    n_words = n_changing = 0
    for place in sorted(parts, key=lambda place: (place in _TABLES, place not in _RECORDED, place)):
        layout, values = parts[place]
        places[place] = n_words, len(values)
        n_words += len(values) * layout.itemsize // 8
        n_changing = n_changing if place in _TABLES else n_words
    words = np.zeros(n_words, np.int64)
    for place, (layout, values) in parts.items():
        if values:
            first, n = places[place]
            words[first : first + n * layout.itemsize // 8].view(layout)[:] = values
    ordered = tuple(places[place] for place in sorted(places))
    return FreshState(words, recorded_type(state), ordered, n_changing, sample_table(state))


def _parts(kind: type, record: Any, first: int) -> Iterator[tuple[int, tuple[np.dtype[Any], Any]]]:
    """Yield the entries of a record's directory: the layout of an element, and all elements."""
    known = entries(kind)
    numbers = [name for name, entry in known.items() if entry.kind == "number"]
    if numbers:
        yield first, (known[numbers[0]].layout, [tuple(getattr(record, n) for n in numbers)])
    for name, entry in known.items():
        place = first + entry.place
        if entry.inner:
            yield from _parts(entry.inner, getattr(record, name), place)
        elif entry.kind == "record":
            yield place, (entry.layout, [_row(entry.layout, getattr(record, name))])
        elif entry.kind == "list" and hasattr(record, name):
            listed = getattr(record, name)
            is_plain = entry.layout.names is None
            row = partial(_row, entry.layout)
            yield place, (entry.layout, listed if is_plain else [*map(row, listed)])


def _row(layout: np.dtype[Any], record: Any) -> tuple[Any, ...]:
    return tuple(getattr(record, name) for name in layout.names or ())


def sample_table(state: State) -> npt.NDArray[np.uint8]:
    """Return the ``kernel.samples.valid_samples`` of all ticks, shape ``(n_ticks, n_sensors)``."""
    ticks: Any = np.arange(state.mission.duration, dtype=np.uint64)  # drawn all at once
    table = np.empty((len(ticks), len(state.sensors)), np.uint8)
    for sensor, chances in enumerate(reached(state)):
        draws = draw(state.mission.seed, ticks, sensor, PURPOSE_SAMPLES)
        table[:, sensor] = np.searchsorted(np.array(chances, np.uint64), draws, side="right")
    table.flags.writeable = False
    return table


def packed(states: Records) -> list[memoryview]:
    """Return the ``kernel.packing.state_bytes`` of recorded states."""
    places, is_float, end = _packing(states.dtype)
    as_words = np.dtype([("words", "<i8", (states.dtype.itemsize // 8,))])
    words = states.view(as_words)["words"].take(places, axis=1)
    rows = np.where(is_float, words.view(np.float64), words) + 0.0
    remember: Any = rows[:, end:].any(axis=1)
    return [(row if has else row[:end]).data for row, has in zip(rows, remember, strict=True)]


@lru_cache(maxsize=16)
def _packing(
    recorded: np.dtype[Any],
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.bool_], int]:
    """Return which words of a state are packed, which are floats, and where memory begins."""
    numbers = np.arange(recorded.itemsize // 8).view(recorded)[0]
    memory = numbers["goals"]["memory"].view(np.int64).ravel()
    places, is_float = [], []
    for name, columns in COLUMNS.items():
        listed = numbers[name]
        places.append(np.stack([listed[column].view(np.int64) for column in columns], -1).ravel())
        kinds = [listed.dtype[column].kind == "f" for column in columns]
        is_float.append(np.tile(kinds, len(listed)))
    packed_words = np.concatenate([*places, memory])
    are_floats = np.concatenate([*is_float, np.ones(len(memory), np.bool_)])
    return packed_words, are_floats, len(packed_words) - len(memory)


def read_recorded(state: State, recorded: Any) -> None:
    """Set a state to recorded values."""
    for name in COLUMNS:
        columns = recorded[name].dtype.names
        for record, values in zip(getattr(state, name), recorded[name].tolist(), strict=True):
            for column, value in zip(columns, values, strict=True):
                setattr(record, column, value)


_PLACES = {name: entry.place for name, entry in entries(Plan).items()}


class Batch:
    """Plans of some specifications, one after the other, and room for their results.

    ``plans`` and ``verdicts`` have a directory a specification. ``allowed`` returns the words of
    the belief that a user-defined fault may change.
    """

    def __init__(
        self,
        plans: Sequence[PlanRows],
        result_type: np.dtype[Any],
        allowed: Callable[[OwnRow], Sequence[int]],
    ) -> None:
        self._plans: Words = np.zeros((len(plans), n_entries(Plan), 2), np.int64)
        self._n_held = [one.n_held for one in plans]
        self._plans[:, _PLACES["held"], 1] = self._n_held
        injections = zip(*(one.lists for one in plans), strict=True)
        self._injections = [
            self._listed(name, _injections(lists), lists)
            for name, lists in zip(("messages", "reports", "commands"), injections, strict=True)
        ]
        own = [one.own for one in plans]
        self._own = self._listed("own", _records(OWN, own), own)
        self._own[ALLOWED] = [allowed(row) for one in plans for row in one.own] or 0
        sizes = [one.n_faults for one in plans]
        tallies: Records = np.zeros(sum(sizes), record_type(FaultTally))
        tallies[:] = astuple(FaultTally())
        self._tallies = self._listed("tallies", tallies, map(range, sizes))
        self._triggers = self._triggered(plans) if any(one.triggers for one in plans) else ()
        self._tallied = [*starmap(slice, pairwise(accumulate(sizes, initial=0)))]
        self.results: Records = np.zeros(len(plans), result_type)

    def _listed(self, name: str, records: Records, lists: Iterable[Sized]) -> Records:
        """Return the records of all plans, and enter their places in the plans' directories."""
        sizes = np.array([*map(len, lists)], np.int64)
        begins = np.cumsum(sizes) - sizes
        self._plans[:, _PLACES[name], 0] = records.ctypes.data + begins * records.itemsize
        self._plans[:, _PLACES[name], 1] = sizes
        return records

    def _triggered(self, plans: Sequence[PlanRows]) -> tuple[Records, ...]:
        """Return the records of triggers, which plans without triggers do not have."""
        sources = np.array([number for one in plans for number in one.sources], np.int64)
        found = [self._listed("sources", sources, [one.sources for one in plans])]
        for name, kind in (("triggers", TriggerState), ("waiting", WaitingState)):
            lists = [getattr(one, name) for one in plans]
            records = _records(record_type(kind), lists)
            if name == "triggers":
                records["fired"] = -1
            found.append(self._listed(name, records, lists))
        return tuple(found)

    def plans(self, first: int, last: int) -> tuple[Words, Any]:
        """Return the directories of some plans, and the room for messages that they delay."""
        held = np.zeros(max(self._n_held[first:last], default=0))
        found = self._plans.copy()
        found[:, _PLACES["held"], 0] = held.ctypes.data
        return found, held

    @cached_property
    def verdicts(self) -> Words:
        """The directories of the verdicts, which are part of the results."""
        fields: Any = self.results.dtype.fields
        rows = _addresses(self.results)
        found = np.zeros((len(rows), n_entries(Verdicts), 2), np.int64)
        for name, entry in entries(Verdicts).items():
            found[:, entry.place, 0] = rows + fields[name][1]
            found[:, entry.place, 1] = fields[name][0].itemsize // 8
        return found

    def outcomes(self, measured: Sequence[bool]) -> list[Outcome]:
        """Return the outcome of each specification; goals that are ``measured`` have a margin."""
        results, world = self.results, self.results["world"]
        named = (results[name] for name in (*COUNTED, "margin", "nearest", "broken", "undetected"))
        columns = [each.tolist() for each in (*named, world["goals"]["count"])]
        applied, changed = (self._tallies[name].tolist() for name in ("applied", "changed"))
        states = zip(packed(world), packed(results["belief"]), strict=True)
        rows = zip(*columns, self._tallied, states, strict=True)
        return [
            digested(
                (*counts, samples, applied[faults], changed[faults]),
                zip(margin, nearest, measured, strict=True),
                zip(broken, undetected, strict=True),
                *both,
            )
            for *counts, margin, nearest, broken, undetected, samples, faults, both in rows
        ]

    def tallies_of(self, k: int) -> list[FaultTally]:
        """Return the tally of each fault of one specification."""
        return [FaultTally(*row) for row in self._tallies[self._tallied[k]].tolist()]


_IN_ROW = "".join("d" if kind is float else "q" for kind in get_args(InjectionRow))
_N_KEPT = len(fields(InjectionState)) - len(_IN_ROW)  # which begin as zeros
_INJECTION = Struct(f"<{_IN_ROW}{8 * _N_KEPT}x")


def _injections(lists: Iterable[Sequence[InjectionRow]]) -> Records:
    """Return the records of injections as ``_records`` would, but faster: a batch has thousands."""
    rows = starmap(_INJECTION.pack, chain.from_iterable(lists))
    return np.frombuffer(bytearray(b"".join(rows)), record_type(InjectionState))


def _records(layout: np.dtype[Any], lists: Iterable[Sequence[tuple[Any, ...]]]) -> Records:
    rows = [*chain.from_iterable(lists)]
    records: Records = np.zeros(len(rows), layout)
    for name, column in zip(layout.names or (), zip(*rows, strict=True), strict=False):
        records[name] = column
    return records


class Frame:
    """Three states, and the flights in them: of all ticks, unless ``keep`` sets others."""

    def __init__(
        self, fresh: FreshState, calls: Words, batch: Batch, span: tuple[int, int]
    ) -> None:
        n = fresh.n_changing
        self._fresh = fresh
        self._states = np.array([fresh.words] * 3)
        directories = np.array([fresh.directory(words, calls) for words in self._states])
        plans, held = batch.plans(*span)
        self._at = np.array([0, 0, len(fresh.samples)], np.int64)
        self._n_moments = np.zeros(1, np.int64)
        self._moments: Records = np.zeros(0, np.int64)
        arrays: list[npt.NDArray[Any]] = [
            self._n_moments,
            self._at,
            _addresses(directories),
            fresh.words[:n],
            *(words[:n] for words in self._states),
            fresh.samples,
            _addresses(plans),
            _addresses(batch.verdicts),
            batch.results,
            self._moments,
        ]
        sizes = [array.nbytes // (1 if array is fresh.samples else 8) for array in arrays]
        self._kept = (arrays, directories, plans, held, calls, batch)
        addresses = [array.ctypes.data for array in arrays]
        self.directory: Words = np.array(list(zip(addresses, sizes, strict=True)), np.int64)

    def keep(self, moments: Records, begin: int, end: int) -> None:
        """Fly next from ``begin`` to before ``end``; keep ticks as ``moments`` has room."""
        self._at[1:] = begin, end
        self._n_moments[0] = len(moments)
        self._moments = moments
        self.directory[-1] = moments.ctypes.data, moments.nbytes // 8

    @property
    def at(self) -> int:
        """Number of the specification that flies."""
        return int(self._at[0])

    @property
    def tick(self) -> int:
        """Tick of the mission that flies."""
        return int(self._states[0][self._fresh.tick])

    @property
    def has_written_to_tables(self) -> bool:
        """Whether a flight has changed a table, which none may change."""
        n = self._fresh.n_changing
        return bool((self._states[:, n:] != self._fresh.words[n:]).any())


def _addresses(rows: npt.NDArray[Any]) -> Words:
    return np.arange(len(rows), dtype=np.int64) * rows.strides[0] + rows.ctypes.data
