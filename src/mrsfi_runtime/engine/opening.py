"""Opens the engine that settings name, and finds out which one ``auto`` stands for.

The function that opens an engine imports it, because each needs packages that others do not.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, TypeAlias

from mrsfi_runtime.errors import LIMITED, EvaluationError, UsageError
from mrsfi_runtime.record.engine_settings import (
    AUTO,
    CI,
    COMPILED,
    INJECTOR,
    REFERENCE,
    EngineSettings,
    Workers,
)

if TYPE_CHECKING:
    from mrsfi_runtime.engine.flights import Engine
    from mrsfi_runtime.generated_code import MissionCode

Tell: TypeAlias = Callable[[str], None]

_MEANWHILE = 6_000  # ticks of robots that the reference engine flies while the compiled one opens


def open_engine(
    settings: EngineSettings, code: "MissionCode", seed: int, n_threads: int = 1
) -> "Engine":
    """Return the engine, ready to evaluate, or raise why it cannot open; the caller closes it."""
    settings.require_sense()
    settings = named(settings, code, seed, lambda _: None)
    if settings.name == REFERENCE:
        from mrsfi_runtime.engine.flights import ReferenceEngine  # noqa: PLC0415 - for flights

        return ReferenceEngine(code, seed)
    if settings.name == COMPILED:
        try:
            from mrsfi_runtime.engine.compiled.engine import CompiledEngine  # noqa: PLC0415 - numpy

            return CompiledEngine(code, seed, n_threads)
        except (ImportError, MemoryError, OSError) as error:
            lacking = str(error) or "no more memory"
            message = f"the compiled engine cannot be loaded: {lacking}; {LIMITED}"
            raise EvaluationError(message) from error
    if settings.side == INJECTOR:
        from mrsfi_runtime.engine.external import InjectorEngine  # noqa: PLC0415 - a server

        return InjectorEngine(code, seed, settings)
    from mrsfi_runtime.engine.rosbridge import RosbridgeEngine  # noqa: PLC0415 - brings a server

    return RosbridgeEngine(code, seed, settings)


def named(settings: EngineSettings, code: "MissionCode", seed: int, tell: Tell) -> EngineSettings:
    """Return settings that name an engine: auto becomes compiled, if all of it compiles.

    Otherwise it becomes reference, and ``tell`` receives the reason.
    """
    if settings.name != AUTO:
        return settings
    compiled = replace(settings, name=COMPILED)
    try:
        open_engine(compiled, code, seed).close()
    except (UsageError, EvaluationError) as error:
        tell(f"not compiled: {error}; mrsfi uses the reference engine, about 100 times slower")
        return replace(settings, name=REFERENCE)
    return compiled


def quickest(
    settings: EngineSettings,
    workers: Workers,
    code: "MissionCode",
    seed: int,
    tell: Tell,
    n_flights: int,
) -> tuple[EngineSettings, Workers]:
    """Return settings as ``named`` does; few short flights begin at once, in this process."""
    n_ticks = n_flights * code.mission.duration * len(code.mission.robots)
    if settings.name == AUTO and workers.dask is None and n_ticks <= _MEANWHILE:
        return replace(settings, name=REFERENCE), Workers(1)
    return named(settings, code, seed, tell), workers


def tried(settings: EngineSettings, code: "MissionCode", seed: int, tell: Tell) -> EngineSettings:
    """Fly the mission without faults, and return settings that name an engine, as ``named`` does.

    An external simulation does not fly.
    """
    settings = named(settings, code, seed, tell)
    if settings.side != CI:
        with open_engine(settings, code, seed) as engine:
            engine.evaluate(())
    return settings
