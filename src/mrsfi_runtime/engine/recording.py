"""Every tick of a flight as arrays, in one layout for all engines."""

from collections.abc import Callable, Mapping, MutableSequence
from typing import Any, TypeAlias, get_args, get_type_hints

import numpy as np
import numpy.typing as npt

from mrsfi_runtime.kernel.flight import Verdicts
from mrsfi_runtime.kernel.packing import COLUMNS, state_bytes
from mrsfi_runtime.kernel.state import N_MEMORY, State
from mrsfi_runtime.model.faults import Specification

Records: TypeAlias = npt.NDArray[Any]
"""A structured array."""

Recording: TypeAlias = Records
"""A flight, shape ``(n_ticks,)``, of ``moment_type``.

``recording["world"]`` and ``recording["belief"]`` have the lists of ``kernel.packing.COLUMNS``:
``recording["world"]["robots"]["x"]`` has shape ``(n_ticks, n_robots)``. What goals remember is in
``recording["world"]["goals"]["memory"]``, shape ``(n_ticks, n_goals, N_MEMORY)``. The verdicts are
named as those of ``Verdicts``; ``recording["is_true"]`` has shape ``(n_ticks, n_goals)``.
"""

Record: TypeAlias = Callable[[Specification], Recording]
"""Flies fault specifications, all in the weather of one mission seed, and returns every tick."""

SIDES = ("world", "belief")
"""The states of a tick: truth and belief."""

VERDICTS = tuple(get_type_hints(Verdicts))
"""What is judged and counted for each goal."""

KINDS: Mapping[Any, Any] = {int: "<i8", float: "<f8", MutableSequence[float]: ("<f8", (N_MEMORY,))}
"""Layout of the fields of records, by their types; each takes words of 8 bytes."""


def record_type(record: type) -> np.dtype[Any]:
    """Return the layout of a record of integers, floats and arrays of floats."""
    return np.dtype([(name, KINDS[hint]) for name, hint in get_type_hints(record).items()])


def recorded_type(state: State) -> np.dtype[Any]:
    """Return the layout of what is recorded of a state; compiled ones begin with it."""
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
            *((name, "<i8", (n_goals,)) for name in VERDICTS),
        ]
    )


class Recorder:
    """Observer that records a flight, like that of a state of the mission."""

    def __init__(self, state: State) -> None:
        self._recording: Recording = np.zeros(state.mission.duration, moment_type(state))
        n_words = recorded_type(state).itemsize // 8
        self._packed = np.zeros((len(SIDES), state.mission.duration, n_words))

    def __call__(self, world: State, belief: State, verdicts: Verdicts) -> None:
        """Record a tick."""
        tick = world.mission.tick
        for rows, state in zip(self._packed, (world, belief), strict=True):
            numbers = np.frombuffer(state_bytes(state))
            rows[tick, : len(numbers)] = numbers
        for name in VERDICTS:
            self._recording[name][tick] = getattr(verdicts, name)

    def recording(self) -> Recording:
        """Return what was seen until now."""
        for rows, side in zip(self._packed, SIDES, strict=True):
            _unpack(rows, self._recording[side])
        return self._recording


def _unpack(rows: npt.NDArray[np.float64], states: Records) -> None:
    """Bring what ``kernel.packing.state_bytes`` returned of some states into records."""
    begin = 0
    for name, columns in COLUMNS.items():
        shape = (*states[name].shape, len(columns))
        end = begin + shape[1] * shape[2]
        values = rows[:, begin:end].reshape(shape)
        for place, column in enumerate(columns):
            states[name][column] = values[:, :, place]
        begin = end
    memories = states["goals"]["memory"]
    memories[:] = rows[:, begin:].reshape(memories.shape)
