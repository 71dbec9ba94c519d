"""The flight of a mission: the kernel, compiled once, and the regions that a team wrote."""

import ctypes
import logging
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np

from mrsfi_runtime.engine.compiled.batch import Frame
from mrsfi_runtime.engine.compiled.cache import forget
from mrsfi_runtime.engine.compiled.machine_code import (
    FLIGHT,
    Library,
    MachineCode,
    kept_code,
    kernel_key,
    key_of,
    prebuilt_kernel,
    sources_key,
)
from mrsfi_runtime.engine.compiled.reach import Reached
from mrsfi_runtime.engine.compiled.regions import ROLES, Region, own_regions
from mrsfi_runtime.errors import EvaluationError, WorkerLost
from mrsfi_runtime.fence import TimeLimitReached, fenced, in_thread, words
from mrsfi_runtime.generated_code import MissionCode


class CompiledFlight:
    """Flies a mission compiled; all of it was found in the cache unless it ``is_new``."""

    def __init__(self, code: MissionCode) -> None:
        self._directory = code.directory
        self._regions = [(each, Reached([each.function])) for each in own_regions(code)]
        self._keys = [
            key_of(kernel_key(), each.role, reached.text) for each, reached in self._regions
        ]
        self._n_calls = len(ROLES) * len(code.mission.goals) + 1 + len(ROLES)
        self.key = key_of(sources_key(), *self._keys)
        self._compile()

    def _compile(self) -> None:
        compiled, self.is_new = kernel()
        flight, *by_task = compiled.addresses()
        self._fly: Any = FLIGHT(flight)
        self.calls = np.zeros(self._n_calls, np.int64)
        self.calls[-len(by_task) :] = by_task
        for (region, reached), key in zip(self._regions, self._keys, strict=True):
            found, is_new = kept_code(key, partial(self._compiled, region, reached))
            self.calls[region.place] = found.addresses()[0]
            self.is_new |= is_new

    def _compiled(self, region: Region, reached: Reached) -> MachineCode:
        from mrsfi_runtime.engine.compiled.compiler import compiled_region  # noqa: PLC0415 - slow

        return compiled_region(self._directory, region, reached)

    def forget(self) -> None:
        """Compile its regions anew, or the kernel if there are none and none was prebuilt."""
        for key in self._keys or ([] if prebuilt_kernel() else [kernel_key()]):
            forget(key)
        self._compile()

    def __call__(self, frame: Frame, first: int, last: int) -> None:
        """Fly the specifications ``first … last - 1`` of a frame."""

        def told(error: BaseException) -> EvaluationError:
            if not isinstance(error, TimeLimitReached):
                return EvaluationError(words(error))
            return WorkerLost(
                f"{self._directory}: compiled, the mission stays at "
                f"tick {frame.tick}: {error}; --engine reference tells the line"
            )

        with fenced(told, lambda: (frame.at, frame.tick)):
            in_thread(partial(self._call, frame, first, last))

    def _call(self, frame: Frame, first: int, last: int) -> None:
        result, error = ctypes.c_int64(), ctypes.c_void_p()
        status = self._fly(result, error, frame.directory.ctypes.data, first, last)
        if status:
            raise EvaluationError(f"{self._directory}: a compiled flight failed")


def kernel() -> tuple[MachineCode | Library, bool]:
    """Return the kernel: prebuilt, or of the cache, compiled if need be, and whether it was."""
    prebuilt = prebuilt_kernel()
    return (prebuilt, False) if prebuilt else kept_code(kernel_key(), _compiled_kernel)


def _compiled_kernel() -> MachineCode:
    from mrsfi_runtime.engine.compiled.compiler import compiled_kernel  # noqa: PLC0415 - slow

    log = logging.getLogger(__name__)
    log.warning("compiling the kernel, once for this installation; it takes some ten seconds")
    began = perf_counter()
    found = compiled_kernel()
    log.warning("compiled the kernel in %.1f s", perf_counter() - began)
    return found
