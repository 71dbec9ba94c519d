"""Which engine evaluates, and how it is reached."""

from dataclasses import dataclass, field

from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.reference import ReferenceEngine
from mrsfi_runtime.engine.rosbridge import RosbridgeEngine
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.hosting.progress import Patience
from mrsfi_runtime.mission import MissionCode
from mrsfi_runtime.transport.rosbridge import Client

REFERENCE, ROSBRIDGE = "reference", "rosbridge"
ENGINES = (REFERENCE, ROSBRIDGE)
"""Ways to evaluate a fault specification."""


@dataclass(frozen=True, slots=True)
class EngineSettings:
    """What makes an engine; all but the name belongs to the engine over rosbridge.

    Attributes
    ----------
    name
        One of ``ENGINES``.
    url
        The rosbridge server; one is embedded if left out.
    client
        Kind of roslibpy's connection.
    has_simulation
        Whether to start the simulation; otherwise somebody else's is behind the topics.
    patience
        How long the other side may take.
    """

    name: str = REFERENCE
    url: str | None = None
    client: Client = "asyncio"
    has_simulation: bool = True
    patience: Patience = field(default_factory=Patience)

    def open(self, code: MissionCode, seed: int) -> Engine:
        """Return the engine, ready to evaluate; the caller closes it.

        Raises
        ------
        UsageError
            If the settings make no sense together.
        TransportError
            If the server or the simulation cannot be reached.
        """
        if self.name == REFERENCE:
            return ReferenceEngine(code, seed)
        return RosbridgeEngine(
            code,
            seed,
            url=self.url,
            client=self.client,
            has_simulation=self.has_simulation,
            patience=self.patience,
        )

    def require_workers(self, n_workers: int) -> None:
        """Refuse more workers than the engine can have.

        Raises
        ------
        UsageError
            If several would share one server, and with it one set of topics.
        """
        if self.url is not None and n_workers > 1:
            message = (
                f"--workers {n_workers}: found a server at --url, whose topics belong to one "
                "flight at a time; expected --workers 1, or no --url, so that every worker "
                "embeds its own server"
            )
            raise UsageError(message)
