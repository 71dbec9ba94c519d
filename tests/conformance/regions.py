"""Regions of the paper's mission with other bodies, run by Python and by numba."""

import itertools
import warnings
from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
from numba import njit

from mrsfi_runtime.engine.compiled.compiler import Checked, compiled_region, register
from mrsfi_runtime.engine.compiled.layout import entries, laid_out
from mrsfi_runtime.engine.compiled.regions import Reached, Region
from mrsfi_runtime.engine.compiled.views import view_at
from mrsfi_runtime.generated_code import load_code, load_module
from mrsfi_runtime.kernel.flight import initial_state
from mrsfi_runtime.kernel.state import State
from tests.support.edited import COLLECTIVE
from tests.support.tree import ROOT

GENERATED = ROOT / "generated" / "uuv_sampling"
_numbers = itertools.count()
_state = view_at(State)


def compiled(region: Any) -> Any:
    """Return a region as numba runs it, on the address of a state's directory."""
    register(Reached([region]).functions)

    @njit(boundscheck=True, pipeline_class=Checked)
    def run(address):  # type: ignore[no-untyped-def]
        return region(_state(address))

    return run


class LaidOut:
    """A state as compiled code has it."""

    def __init__(self, state: Any) -> None:
        self._layout = laid_out(state)
        self._words = self._layout.words
        self._directory = self._layout.directory(self._words, np.zeros(0, np.int64))

    @property
    def address(self) -> int:
        """Where its directory is."""
        return int(self._directory.ctypes.data)

    def __getattr__(self, name: str) -> Any:
        entry = entries(State)[name]
        first, n = self._layout.places[entry.place]
        return self._words[first : first + n * entry.layout.itemsize // 8].view(entry.layout)


def outcomes(folder: Path, n_states: int = 40) -> Iterator[tuple[Any, Any]]:
    """Run the region on drawn states, and yield what Python and numba make of each.

    What a run makes of a state is what the region returns and what it leaves in the state, or
    the kind of error that it ends with.
    """
    module = load_module(f"region_{next(_numbers)}", folder / COLLECTIVE)
    plain = module.check_g1
    run = compiled(plain)
    rng = Random(4)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # numba's, of what it reflects or finds slow
        run.compile("(int64,)")
        for _ in range(n_states):
            state = drawn_state(rng)
            laid = LaidOut(state)
            yield _outcome(plain, state, state), _outcome(run, laid.address, laid)


def compile_alone(folder: Path) -> None:
    """Compile the region as the engine does."""
    function = load_module(f"region_{next(_numbers)}", folder / COLLECTIVE).check_g1
    compiled_region(folder, Region(function, "check", 1), Reached([function]))


def _outcome(function: Any, argument: Any, state: Any) -> Any:
    try:
        returned = function(argument)
    except Exception as error:  # noqa: BLE001 - of any kind, in a region of any body
        return type(error).__name__
    return returned, _values(state)


def _values(state: Any) -> Any:
    """Return what a region may write: commands, switches, goals and chances."""
    records = [_numbers_of(state, name) for name in ("commands", "switches", "goals")]
    return records, [int(chance) for chance in state.chances]


def _numbers_of(state: Any, name: str) -> list[list[float]]:
    """Return the numbers of every record of a list, those of its memory included."""
    names = type(getattr(_FIRST, name)[0]).__slots__
    return [
        [number for field in names for number in np.atleast_1d(_part(record, field)).tolist()]
        for record in getattr(state, name)
    ]


def _part(record: Any, name: str) -> Any:
    return record[name] if isinstance(record, np.void) else getattr(record, name)


def drawn_state(rng: Random) -> Any:
    """Return the mission's first state with other positions, speeds, energies and counts."""
    state = deepcopy(_FIRST, {id(_FIRST.directions): _FIRST.directions})  # nobody writes those
    state.mission.tick = rng.randint(1, 999)
    for robot in state.robots:
        robot.x, robot.y = rng.uniform(-500.0, 500.0), rng.uniform(-500.0, 500.0)
        robot.speed, robot.energy = rng.uniform(0.0, 9.0), rng.uniform(1.0, 1e4)
    for sensor in state.sensors:
        sensor.count, sensor.active = rng.randint(0, 2000), rng.randint(0, 1)
    return state


_FIRST = initial_state(load_code(GENERATED).mission, 3)
