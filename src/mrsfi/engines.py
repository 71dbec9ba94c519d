"""Engines and evaluators, opened as their settings say; imported when they are."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields
from typing import TYPE_CHECKING, TypeAlias, cast

from mrsfi.project import project
from mrsfi_runtime.cosimulation.waiting import Patience
from mrsfi_runtime.engine.node_settings import NodeSettings
from mrsfi_runtime.engine.settings import (
    AUTO,
    LOCAL,
    REFERENCE,
    ROSBRIDGE,
    EngineSettings,
    require_address,
)
from mrsfi_runtime.errors import ReplayMismatch, UsageError
from mrsfi_runtime.record.manifest import BOTH, INJECTOR, EngineRecord
from mrsfi_runtime.transport.topics import CLIENTS, Client, without_token

if TYPE_CHECKING:
    from mrsfi_runtime.engine.flights import Engine, Evaluator
    from mrsfi_runtime.generated_code import MissionCode

Tell: TypeAlias = Callable[[str], None]
"""Takes one line about how things go."""

Choice: TypeAlias = Callable[[EngineRecord], EngineSettings]
"""Says what flies a campaign again, of what it was begun with."""

_N_PROCESSORS = os.cpu_count() or 1


def silent(_: str) -> None:
    """Tell nobody."""


@dataclass(frozen=True, slots=True)
class Workers:
    """Who evaluates: so many processes of this machine, as many as it has processors by default.

    Or a cluster: ``dask`` is the address of its scheduler, or ``local`` for one of this machine.
    """

    number: int | None = None
    dask: str | None = None

    def require_sense(self, engine: EngineSettings) -> None:
        """Refuse what contradicts itself or the engine, or dask where it is missing."""
        engine.require_workers(self.number or 1)
        if self.dask is None:
            return
        require_address(self.dask)
        if engine.name == ROSBRIDGE:
            raise UsageError(
                f"--dask makes no sense with --engine {ROSBRIDGE}, whose flights need a server "
                "beside them; expected another engine, or --workers"
            )
        if self.dask != LOCAL and self.number is not None:
            raise UsageError(
                f"--workers {self.number}: makes no sense with --dask {self.dask}, which has the "
                "workers that were started for it; leave --workers out"
            )


@dataclass(frozen=True, slots=True)
class EngineOptions:
    """What the command line says of the engine; ``None`` where it says nothing."""

    engine: str | None = None
    url: str | None = None
    ros: str | None = None
    client: str | None = None
    side: str | None = None
    timeout: float | None = None
    bundle: bool | None = None
    world_prefix: str | None = None
    node: str | None = None
    node_pace: str | None = None
    node_reset: str | None = None
    node_prefix: str | None = None

    def again(self, recorded: EngineRecord, default: str = AUTO) -> EngineSettings:
        """Return what flies a campaign again: any engine of ours, or the external parts that did.

        If these do not repeat themselves, nothing can: a ``ReplayMismatch``.
        """
        if recorded.unrepeated:
            raise ReplayMismatch(
                f"this campaign cannot be flown again: {recorded.unrepeated}; to fly one of its "
                "specifications as a flight of its own: mrsfi simulate MISSION --faults FILE"
            )
        return self.settings(recorded if recorded.is_foreign else EngineRecord(), default)

    def settings(
        self, recorded: EngineRecord | None = None, default: str = REFERENCE
    ) -> EngineSettings:
        """Return the settings: as the command line says, or else a record, or else the default.

        Options that make no sense together, or other parts than a record's, are a ``UsageError``.
        """
        known = recorded or EngineRecord()
        implied = ROSBRIDGE if self.side == INJECTOR else None
        name = self.engine or implied or known.name or default
        given = [each.name for each in fields(self)[1:] if getattr(self, each.name) is not None]
        if name != ROSBRIDGE and given:
            raise UsageError(
                f"{_spelled(given[0])} needs --engine {ROSBRIDGE}; the {name} engine has no bus"
            )
        bus = known if name == ROSBRIDGE else EngineRecord()
        side, url = self.side or bus.side, self.url or bus.url
        parts = EngineRecord(url=url, side=side).parts
        if recorded is not None and parts != recorded.parts:
            again = f"--engine {ROSBRIDGE} --side {recorded.side} --url URL, or none of them"
            raise UsageError(
                f"this campaign was flown with {recorded.parts}; found {parts}, whose counts do "
                f"not belong to it; expected {again if recorded.is_foreign else 'no --side'}"
            )
        if side not in {BOTH, INJECTOR} and url is None:
            raise UsageError(f"--side {side} needs --url: the server on which the sides meet")
        world_prefix = self.world_prefix or bus.world_prefix
        if world_prefix and url is None:
            raise UsageError("--world-prefix needs --url: the server on which the world is")
        usual = Patience()
        timeout = self.timeout or bus.timeout or usual.tick
        return EngineSettings(
            name=name,
            url=url,
            ros=int(self.ros or bus.ros or (project().ros if name == ROSBRIDGE else 1)),
            client=cast("Client", self.client or bus.client or CLIENTS[0]),
            has_simulation=side == BOTH or url is None,
            is_bundled=bus.is_bundled if self.bundle is None else self.bundle,
            patience=Patience(timeout, max(timeout, usual.handshake)),
            node=self._node(known, side, url),
            world_prefix=world_prefix,
        )

    def _node(self, recorded: EngineRecord, side: str, url: str | None) -> NodeSettings | None:
        """Return how the node is started and reached, if there is one.

        Another node than that of a record is a ``RecordError``.
        """
        if side != INJECTOR:
            for name in ("node", "node_pace", "node_reset", "node_prefix"):
                if getattr(self, name) is not None:
                    raise UsageError(f"{_spelled(name)} needs --side {INJECTOR}")
            return None
        known = recorded.node or {}
        found = NodeSettings.of(
            self.node or known.get("command"),
            project().node,
            url=url,
            pace=self.node_pace or known.get("pace"),
            reset=self.node_reset or known.get("reset"),
            prefix=self.node_prefix or known.get("prefix", ""),
        )
        return found.again(recorded.node) if recorded.node is not None else found


as_recorded: Choice = EngineOptions().again
"""What flies a campaign again where nobody names an engine."""


def _spelled(option: str) -> str:
    """Return an option as it is written."""
    return f"--{option.replace('_', '-')}"


def recorded_engine(settings: EngineSettings) -> EngineRecord:
    """Return what a campaign records of its engine."""
    if settings.name != ROSBRIDGE:
        return EngineRecord(settings.name)
    return EngineRecord(
        settings.name,
        url=None if settings.url is None else without_token(settings.url),
        ros=settings.ros,
        client=settings.client,
        side=settings.side,
        is_bundled=settings.is_bundled,
        world_prefix=settings.world_prefix,
        timeout=None if settings.patience == Patience() else settings.patience.tick,
        node=None if settings.node is None else asdict(settings.node),
    )


def opened(code: "MissionCode", seed: int, engine: EngineSettings, tell: Tell = silent) -> "Engine":
    """Return an engine of this process; auto is compiled, or else says what does not compile."""
    return engine.named(code, seed, tell).open(code, seed)


@contextmanager
def own_engine(
    evaluator: "Evaluator", code: "MissionCode", seed: int, settings: EngineSettings
) -> "Iterator[Engine]":
    """Yield an engine of this process: that of an evaluator, or else another one like it."""
    if evaluator.engine is not None:
        yield evaluator.engine
        return
    with settings.open(code, seed) as engine:
        yield engine


@contextmanager
def evaluator(
    code: "MissionCode",
    seed: int,
    engine: EngineSettings,
    workers: Workers,
    tell: Tell = silent,
    on_reached: Tell = silent,
) -> "Iterator[Evaluator]":
    """Yield what evaluates specifications of a mission, as long as the body runs.

    ``seed`` is the mission seed of what is evaluated without naming one. Where a server is named
    there is one worker by default. ``tell`` is told what does not compile, ``on_reached`` who
    evaluates, before the mission is handed out. A cluster that is out of reach or without workers
    is a ``TransportError``.
    """
    if workers.dask is None:
        n_workers = workers.number or (1 if engine.url else _N_PROCESSORS)
        on_reached(f"{n_workers} workers")
        from mrsfi_runtime.engine.pools import WorkerPool  # noqa: PLC0415 - not for --help

        with WorkerPool(code, seed, n_workers, engine.named(code, seed, tell)) as pool:
            yield pool
        return
    from mrsfi_runtime.engine.cluster.connection import Cluster  # noqa: PLC0415 - optional
    from mrsfi_runtime.engine.cluster.pool import ClusterPool  # noqa: PLC0415 - optional

    with Cluster(workers.dask, workers.number or _N_PROCESSORS) as cluster:
        on_reached(f"{cluster.n_workers()} workers of {cluster.address}")
        yield ClusterPool(cluster, code, seed, engine)


@contextmanager
def flying(
    code: "MissionCode", seed: int, engine: EngineSettings, workers: Workers, tell: Tell = silent
) -> "Iterator[tuple[Evaluator, Engine]]":
    """Yield what evaluates specifications, and an engine of this process, for what it alone can."""
    with (
        evaluator(code, seed, engine, workers, tell) as many,
        own_engine(many, code, seed, engine) as own,
    ):
        yield many, own
