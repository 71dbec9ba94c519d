"""Every tick of a flight, in one layout for all engines.

A tick is a record of truth, belief and verdicts, as ``moment_type`` lays it out; every quantity is
a word of 8 bytes. A ``Recording`` keeps chunks of ticks. All but the last chunk are compressed,
quantity by quantity: most change little from tick to tick, so the differences of words are kept,
and a word that never changes only once. ``Recorder`` is the observer that fills a recording on
plain Python objects; the compiled engine writes the records itself.
"""

import weakref
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, MutableSequence, Sequence
from contextlib import suppress
from functools import cache, cached_property
from tempfile import SpooledTemporaryFile
from typing import Any, NamedTuple, TypeAlias, get_args, get_type_hints

import numpy as np
import numpy.typing as npt

from mrsfi_runtime.files import temporary_files_writable
from mrsfi_runtime.kernel.flight import Verdicts
from mrsfi_runtime.kernel.injections import FaultTally
from mrsfi_runtime.kernel.state import COLUMNS, N_MEMORY, State, state_bytes
from mrsfi_runtime.model.faults import Specification, Target

Records: TypeAlias = npt.NDArray[Any]
"""A structured array."""

CHUNK = 8 << 20
"""Bytes of ticks that are recorded, compressed and read in one go."""

_IN_MEMORY = 16 << 20  # bytes of what is compressed before it goes to a file

_MADE_ANEW = {"_columns", "_stream"}  # where a recording comes from another process

SIDES = ("world", "belief")
"""The states of a tick: truth and belief."""

VERDICTS = get_type_hints(Verdicts)
"""The verdicts and counts of each goal, with their types."""

KINDS: Mapping[Any, Any] = {int: "<i8", float: "<f8", MutableSequence[float]: ("<f8", (N_MEMORY,))}
"""Layout of the fields of records, by their types; each takes words of 8 bytes."""


@cache
def record_type(record: type) -> np.dtype[Any]:
    """Return the layout of a record of integers, floats and arrays of floats."""
    return np.dtype([(name, KINDS[hint]) for name, hint in get_type_hints(record).items()])


def recorded_type(state: State) -> np.dtype[Any]:
    """Return the layout of the recorded part of a state; compiled states begin with it."""
    return np.dtype(
        [
            (name, record_type(get_args(hint)[0]), (len(getattr(state, name)),))
            for name, hint in get_type_hints(State).items()
            if name in COLUMNS
        ]
    )


def moment_type(state: State) -> np.dtype[Any]:
    """Return the layout of a tick: truth and belief as recorded, then the verdicts."""
    recorded, n_goals = recorded_type(state), len(state.goals)
    return np.dtype(
        [
            *((side, recorded) for side in SIDES),
            *((name, KINDS[get_args(hint)[0]], (n_goals,)) for name, hint in VERDICTS.items()),
        ]
    )


class _Column(NamedTuple):
    """A quantity of all of a kind, and which words of a tick hold it."""

    layout: np.dtype[Any]
    words: npt.NDArray[np.uint64]


class Recording:
    """All ticks of a flight.

    ``recording["world"]`` and ``recording["belief"]`` have the lists of ``kernel.state.COLUMNS``:
    ``recording["world"]["robots"]["x"]`` is an array of shape ``(n_ticks, n_robots)``, and
    ``recording["world"]["goals"]["memory"]`` of ``(n_ticks, n_goals, N_MEMORY)``. The names of
    ``Verdicts`` lead to arrays of ``(n_ticks, n_goals)``. An array is read anew each time; a number
    in place of a name asks for that tick. ``dtype`` is the layout of a tick, ``moment_type``;
    ``tallies`` say what each timed fault did. ``received`` are the properties in the belief that a
    node received; ``None`` for all.
    """

    def __init__(self, dtype: np.dtype[Any]) -> None:
        self.dtype = dtype
        self.tallies: list[FaultTally] = []
        self.received: frozenset[Target] | None = None
        self.chunk = max(8, CHUNK // dtype.itemsize)
        self._last: Records = np.zeros(0, dtype)
        self._n_before = 0
        self._places: list[dict[tuple[str, ...], tuple[int, int]]] = []
        self._decoded: tuple[int, Records] | None = None

    def __getstate__(self) -> dict[str, Any]:
        kept = {name: each for name, each in vars(self).items() if name not in _MADE_ANEW}
        if self._places:
            with temporary_files_writable():
                self._stream.seek(0)
                kept["compressed"] = self._stream.read()
        return kept | {"_decoded": None}

    def __setstate__(self, kept: dict[str, Any]) -> None:
        compressed = kept.pop("compressed", b"")
        vars(self).update(kept)
        with temporary_files_writable():
            self._stream.write(compressed)

    def __len__(self) -> int:
        return self._n_before + len(self._last)

    def __getitem__(self, which: str | int) -> Any:
        return Part(self, (), self.dtype)[which]

    def append(self, moments: Records) -> None:
        """Add ticks, ``chunk`` of them unless they are the last."""
        if len(self._last):
            self._places.append({path: self._keep(path) for path in self._columns})
            self._n_before += len(self._last)
        self._last = moments

    def moments(self) -> Iterator[Records]:
        """Yield all ticks, ``chunk`` after ``chunk``."""
        for chunk in range(len(self._places)):
            yield self._decode(chunk)
        yield self._last

    def moment(self, tick: int) -> Any:
        """Return a tick; one after the other is fast."""
        chunk, place = divmod(range(len(self))[tick], self.chunk)
        if chunk == len(self._places):
            return self._last[place]
        if self._decoded is None or self._decoded[0] != chunk:
            self._decoded = chunk, self._decode(chunk)
        return self._decoded[1][place]

    def column(self, path: tuple[str, ...]) -> Records:
        """Return a quantity at all ticks, by the names that lead to it."""
        last = self._last
        for name in path:
            last = last[name]
        if not self._places:
            return last
        layout, words = self._columns[path]
        before = [self._read(chunk, path).view(layout) for chunk in range(len(self._places))]
        return np.concatenate([*(part.reshape(self.chunk, *words.shape) for part in before), last])

    @cached_property
    def _columns(self) -> Mapping[tuple[str, ...], _Column]:
        words = np.arange(self.dtype.itemsize // 8, dtype=np.uint64).view(self.dtype)
        return dict(_leaves((), words[0]))

    @cached_property
    def _stream(self) -> "SpooledTemporaryFile[bytes]":
        stream = SpooledTemporaryFile(_IN_MEMORY)  # noqa: SIM115 - closed with the recording
        weakref.finalize(self, _close, stream)
        return stream

    def _keep(self, path: tuple[str, ...]) -> tuple[int, int]:
        """Compress a quantity of the last chunk, and return where it is kept."""
        words = _as_words(self._last)[:, self._columns[path].words.ravel()]
        steps = np.diff(words, axis=0)
        is_changing = steps.any(axis=0)
        kept = words[0].tobytes() + is_changing.tobytes() + steps[:, is_changing].T.tobytes()
        with temporary_files_writable():
            return self._stream.seek(0, 2), self._stream.write(zlib.compress(kept, 1))

    def _read(self, chunk: int, path: tuple[str, ...]) -> npt.NDArray[np.uint64]:
        """Return the words of a quantity in a compressed chunk, shape ``(chunk, n_words)``."""
        place, size = self._places[chunk][path]
        with temporary_files_writable():
            self._stream.seek(place)
            kept = zlib.decompress(self._stream.read(size))
        n = self._columns[path].words.size
        is_changing = np.frombuffer(kept, np.bool_, n, 8 * n)
        steps = np.frombuffer(kept, np.uint64, offset=9 * n).reshape(-1, self.chunk - 1)
        words = np.empty((self.chunk, n), np.uint64)
        words[:] = np.frombuffer(kept, np.uint64, n)
        words[1:, is_changing] += np.cumsum(steps, axis=1, dtype=np.uint64).T
        return words

    def _decode(self, chunk: int) -> Records:
        moments = np.zeros(self.chunk, self.dtype)
        words = _as_words(moments)
        for path, column in self._columns.items():
            words[:, column.words.ravel()] = self._read(chunk, path)
        return moments


class Part:
    """A named part of each tick of a recording, which has named parts itself."""

    def __init__(self, whole: Recording, path: tuple[str, ...], dtype: np.dtype[Any]) -> None:
        self.dtype = dtype
        self._whole = whole
        self._path = path

    def __len__(self) -> int:
        return len(self._whole)

    def __getitem__(self, which: str | int) -> Any:
        if isinstance(which, str):
            path, dtype = (*self._path, which), self.dtype[which].base
            if dtype.names is None:
                return self._whole.column(path)
            return Part(self._whole, path, dtype)
        records = self._whole.moment(which)
        for name in self._path:
            records = records[name]
        return records


def _close(stream: "SpooledTemporaryFile[bytes]") -> None:
    with suppress(OSError):  # if the disk is full, closing tries to write again
        stream.close()


def _leaves(path: tuple[str, ...], words: Records) -> Iterator[tuple[tuple[str, ...], _Column]]:
    """Yield the columns of records; ``words`` has the numbers of words in place of values."""
    if words.dtype.names is None:
        yield path, _Column(words.dtype, words.view(np.uint64))
    else:
        for name in words.dtype.names:
            yield from _leaves((*path, name), words[name])


def _as_words(moments: Records) -> npt.NDArray[np.uint64]:
    return moments.view(np.uint64).reshape(len(moments), -1)


Record: TypeAlias = Callable[[Specification], Recording]
"""Flies fault specifications, all of one mission seed, and returns every tick."""

RecordMany: TypeAlias = Callable[[Iterable[Specification]], Iterable[Recording]]
"""Does the same for many, which come in order."""


class Recorder:
    """Observer that records a flight, in the layout of a state of the mission."""

    def __init__(self, state: State) -> None:
        self._recording = Recording(moment_type(state))
        self._n_ticks = min(self._recording.chunk, state.mission.duration)
        self._moments: Records = np.zeros(self._n_ticks, self._recording.dtype)
        n_words = recorded_type(state).itemsize // 8
        self._packed = np.zeros((len(SIDES), self._n_ticks, n_words))
        self._n_seen = 0

    def __call__(self, world: State, belief: State, verdicts: Verdicts) -> None:
        """Record a tick."""
        if self._n_seen == self._n_ticks:
            self._flush()
        for rows, state in zip(self._packed, (world, belief), strict=True):
            numbers = np.frombuffer(state_bytes(state))
            rows[self._n_seen, : len(numbers)] = numbers
            rows[self._n_seen, len(numbers) :] = 0.0
        for name in VERDICTS:
            self._moments[name][self._n_seen] = getattr(verdicts, name)
        self._n_seen += 1

    def recording(self, tallies: Sequence[FaultTally] = ()) -> Recording:
        """Return all ticks until now, with what each timed fault did."""
        self._flush()
        self._recording.tallies = [*tallies]
        return self._recording

    def _flush(self) -> None:
        moments = self._moments[: self._n_seen].copy()
        for rows, side in zip(self._packed, SIDES, strict=True):
            _unpack(rows[: self._n_seen], moments[side])
        self._recording.append(moments)
        self._n_seen = 0


def _unpack(rows: npt.NDArray[np.float64], states: Records) -> None:
    """Write packed states, as ``kernel.packing.state_bytes`` returns them, into records."""
    for name, columns in COLUMNS.items():
        shape = (*states[name].shape, len(columns))
        values, rows = np.split(rows, [shape[1] * shape[2]], axis=1)
        for place, column in enumerate(columns):
            states[name][column] = values.reshape(shape)[:, :, place]
    memories = states["goals"]["memory"]
    memories[:] = rows.reshape(memories.shape)
