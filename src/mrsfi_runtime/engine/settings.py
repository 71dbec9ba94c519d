"""Which engine evaluates, how it is reached, and on which cluster it may work."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from importlib.util import find_spec
from typing import TYPE_CHECKING, Self
from urllib.parse import urlsplit

from mrsfi_runtime.cosimulation.waiting import Patience
from mrsfi_runtime.engine.node_settings import NodeSettings
from mrsfi_runtime.errors import LIMITED, EvaluationError, UsageError, expected
from mrsfi_runtime.record.manifest import BOTH, CI, INJECTOR
from mrsfi_runtime.transport.topics import CLIENTS, Client

if TYPE_CHECKING:
    from mrsfi_runtime.engine.flights import Engine
    from mrsfi_runtime.generated_code import MissionCode

AUTO, REFERENCE, COMPILED, ROSBRIDGE = "auto", "reference", "compiled", "rosbridge"
ENGINES = (AUTO, REFERENCE, COMPILED, ROSBRIDGE)
"""Ways to evaluate a fault specification; auto is compiled where that is possible."""

LOCAL = "local"
"""In place of a cluster's address: processes on this machine, for this command only."""

ON_REFERENCE = "the reference engine evaluates, about 100 times slower"


@dataclass(frozen=True, slots=True)
class EngineSettings:
    """What makes an engine; all but the name, of ``ENGINES``, belongs to the engine over rosbridge.

    ``url`` is that of the server, one is embedded without; ``ros`` the version of ROS that it
    speaks, ``client`` the kind of connection. ``has_simulation`` says whether to start the
    simulation, which is somebody else's otherwise, ``is_bundled`` whether the messages of a tick
    travel as one, ``patience`` how long the other side may take. A ``node`` is the collective
    intelligence in place of the generated one. All topics of the simulation at ``url`` are below
    ``world_prefix``.
    """

    name: str = REFERENCE
    url: str | None = None
    ros: int = 1
    client: Client = CLIENTS[0]
    has_simulation: bool = True
    is_bundled: bool = False
    patience: Patience = field(default_factory=Patience)
    node: NodeSettings | None = None
    world_prefix: str = ""

    def __post_init__(self) -> None:
        if self.name not in ENGINES:
            raise UsageError(f"engine: found {self.name!r}; {expected(self.name, ENGINES)}")

    @property
    def words(self) -> str:
        """Which engine flies, in words."""
        return f"{self.name} engine{'' if self.node is None else ', your node'}"

    @property
    def side(self) -> str:
        """Which side of the bus this is."""
        if self.node is not None:
            return INJECTOR
        return BOTH if self.has_simulation else CI

    def named(self, code: "MissionCode", seed: int, tell: Callable[[str], None]) -> Self:
        """Return settings that name an engine: auto becomes compiled, if all of it compiles.

        Otherwise it becomes reference, and ``tell`` is told what does not.
        """
        if self.name != AUTO:
            return self
        try:
            replace(self, name=COMPILED).open(code, seed).close()
        except (UsageError, EvaluationError) as error:
            tell(f"not compiled: {error}; {ON_REFERENCE}")
            return replace(self, name=REFERENCE)
        return replace(self, name=COMPILED)

    def tried(self, code: "MissionCode", seed: int, tell: Callable[[str], None]) -> Self:
        """Fly the mission without faults, and return settings that name an engine; as ``named``.

        Somebody else's simulation is not asked to fly.
        """
        settings = self.named(code, seed, tell)
        if self.side != CI:
            with settings.open(code, seed) as opened:
                opened.evaluate(())
        return settings

    def open(self, code: "MissionCode", seed: int, n_threads: int = 1) -> "Engine":
        """Return the engine, ready to evaluate, or raise why it cannot be; the caller closes it."""
        if self.name == AUTO:
            return self.named(code, seed, lambda _: None).open(code, seed, n_threads)
        if self.name == REFERENCE:
            from mrsfi_runtime.engine.reference import ReferenceEngine  # noqa: PLC0415 - for flights

            return ReferenceEngine(code, seed)
        if self.name == COMPILED:
            try:
                from mrsfi_runtime.engine.compiled.engine import CompiledEngine  # noqa: PLC0415 - numpy

                return CompiledEngine(code, seed, n_threads)
            except (ImportError, MemoryError, OSError) as error:
                lacking = str(error) or "no more memory"
                told = f"the compiled engine cannot be loaded: {lacking}; {LIMITED}"
                raise EvaluationError(told) from error
        if self.node is not None:
            from mrsfi_runtime.engine.injector import InjectorEngine  # noqa: PLC0415 - a server

            return InjectorEngine(code, seed, self)
        from mrsfi_runtime.engine.rosbridge import RosbridgeEngine  # noqa: PLC0415 - brings a server

        return RosbridgeEngine(code, seed, self)

    def require_workers(self, n_workers: int) -> None:
        """Refuse several workers that would share one server, and with it one set of topics."""
        if self.url is not None and n_workers > 1:
            raise UsageError(
                f"--workers {n_workers}: found a server at --url, whose topics belong to one "
                "flight at a time; expected --workers 1, or no --url, so that every worker "
                "embeds its own server"
            )


def require_address(text: str) -> None:
    """Refuse what is no address of a dask scheduler, and any while dask is not installed."""
    if find_spec("distributed") is None:
        raise UsageError(
            "--dask needs dask.distributed; install it with: pip install 'mrsfi[dask]'"
        )
    if text != LOCAL and not _is_address(text):
        raise UsageError(
            f"--dask: found '{text}'; expected tcp://HOST:PORT or tls://HOST:PORT, as "
            f"`dask scheduler` prints it, or {LOCAL}"
        )


def _is_address(text: str) -> bool:
    try:
        parts = urlsplit(text)
        has_port = parts.port is not None
    except ValueError:
        return False
    return parts.scheme in {"tcp", "tls"} and bool(parts.hostname) and has_port
