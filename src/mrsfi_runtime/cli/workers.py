"""The options that say where a search is evaluated: processes of this machine, or a cluster."""

import os
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import click

from mrsfi_runtime.cli.options import options_as
from mrsfi_runtime.engine.cluster.address import LOCAL, require_address
from mrsfi_runtime.engine.pools import WorkerPool
from mrsfi_runtime.engine.settings import ROSBRIDGE, EngineSettings
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.mission import MissionCode
from mrsfi_runtime.search.resumable_record import EvaluateMany

if TYPE_CHECKING:
    from mrsfi_runtime.engine.cluster.connection import Cluster

_N_PROCESSORS = os.cpu_count() or 1


@dataclass(frozen=True, slots=True)
class WorkerOptions:
    """What the command line says of the workers; ``None`` where it says nothing."""

    workers: int | None = None
    dask: str | None = None

    def require_sense(self, engine: EngineSettings) -> None:
        """Refuse options that contradict each other or the engine.

        Raises
        ------
        UsageError
            If they do, or dask is not installed.
        """
        engine.require_workers(self.workers or 1)
        if self.dask is None:
            return
        require_address(self.dask)
        if engine.name == ROSBRIDGE:
            raise UsageError(
                f"--dask makes no sense with --engine {ROSBRIDGE}, whose flights need a server "
                "beside them; expected another engine, or --workers"
            )
        if self.dask != LOCAL and self.workers is not None:
            raise UsageError(
                f"--workers {self.workers}: makes no sense with --dask {self.dask}, which has the "
                "workers that were started for it; leave --workers out"
            )

    @contextmanager
    def reached(self) -> Iterator["Processes | ClusterWorkers"]:
        """Reach the cluster, if there is to be one, and yield workers while the body runs.

        Raises
        ------
        TransportError
            If the cluster cannot be reached, or has no workers.
        """
        with ExitStack() as stack:
            if self.dask is None:
                yield Processes(stack, self.workers)
                return
            from mrsfi_runtime.engine.cluster.connection import Cluster  # noqa: PLC0415 - optional

            yield ClusterWorkers(
                stack.enter_context(Cluster(self.dask, self.workers or _N_PROCESSORS))
            )


@dataclass(frozen=True, slots=True)
class Processes:
    """Processes or threads of this machine."""

    stack: ExitStack
    number: int | None

    def told(self, engine: EngineSettings) -> str:
        """Return who they are, for a message."""
        return f"{self._number(engine)} workers"

    def evaluators(
        self, code: MissionCode, mission_seeds: Sequence[int], engine: EngineSettings
    ) -> list[EvaluateMany]:
        """Return a function for each mission seed that evaluates.

        Raises
        ------
        MrsfiError
            If the engine cannot be opened.
        """
        pool = WorkerPool(code, mission_seeds[0], self._number(engine), engine)
        self.stack.enter_context(pool)
        return [partial(pool.evaluate_many, seed=seed) for seed in mission_seeds]

    def _number(self, engine: EngineSettings) -> int:
        return self.number or (1 if engine.url else _N_PROCESSORS)


@dataclass(frozen=True, slots=True)
class ClusterWorkers:
    """The workers of a cluster."""

    cluster: "Cluster"

    def told(self, engine: EngineSettings) -> str:  # noqa: ARG002 - any engine has all of them
        """Return who they are, for a message."""
        return f"{self.cluster.n_workers()} workers of {self.cluster.address}"

    def evaluators(
        self, code: MissionCode, mission_seeds: Sequence[int], engine: EngineSettings
    ) -> list[EvaluateMany]:
        """Return a function for each mission seed that evaluates.

        Raises
        ------
        MrsfiError
            If the engine cannot be opened.
        """
        from mrsfi_runtime.engine.cluster.pool import ClusterPool  # noqa: PLC0415 - optional

        pool = ClusterPool(self.cluster, code, mission_seeds[0], engine)
        return [partial(pool.evaluate_many, seed=seed) for seed in mission_seeds]


worker_options = options_as(
    "workers",
    WorkerOptions,
    (
        click.option(
            "--workers",
            type=click.IntRange(1),
            help="Processes that evaluate [default: as many as this machine has processors].",
        ),
        click.option(
            "--dask",
            metavar="tcp://…|local",
            help="Evaluate on a dask cluster: its scheduler, or a local one of --workers.",
        ),
    ),
)
"""Gives a command the options of the workers; it receives them as ``workers``."""
