"""What compiled flights read and write, as they are called: arrays, and the directory of them."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from mrsfi_runtime.engine.compiled.batch import Batch
from mrsfi_runtime.engine.compiled.layout import StateLayout, Words, laid_out, sample_table
from mrsfi_runtime.engine.recording import Records
from mrsfi_runtime.kernel.state import State


class Fresh(NamedTuple):
    """What a seed decides: a state before the first tick, and the valid samples of each tick."""

    layout: StateLayout
    words: Words
    samples: npt.NDArray[np.uint8]


def fresh_of(state: State) -> Fresh:
    """Return what a state before the first tick decides."""
    return Fresh(*laid_out(state), sample_table(state))


class Frame:
    """Three states, and what is flown in them: all of the mission, unless ``keep`` says else."""

    def __init__(self, fresh: Fresh, calls: Words, batch: Batch, span: tuple[int, int]) -> None:
        layout = fresh.layout
        n = layout.n_changing
        self._fresh = fresh
        self._states = [fresh.words.copy() for _ in range(3)]
        directories = [layout.directory(words, calls) for words in self._states]
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
        sizes[0] = 1
        self._kept = (arrays, directories, plans, held, calls, batch)
        addresses = [array.ctypes.data for array in arrays]
        self.directory: Words = np.array(list(zip(addresses, sizes, strict=True)), np.int64)

    def keep(self, moments: Records, begin: int, end: int) -> None:
        """Fly from one tick on and before another next, and keep as many as there is room for."""
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
        return int(self._states[0][self._fresh.layout.tick])

    @property
    def has_written_to_tables(self) -> bool:
        """Whether a flight has changed what none may change."""
        n = self._fresh.layout.n_changing
        return any(not np.array_equal(words[n:], self._fresh.words[n:]) for words in self._states)


def _addresses(rows: Sequence[Words] | Words) -> Words:
    return np.array([row.ctypes.data for row in rows], np.int64)
