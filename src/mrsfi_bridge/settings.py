"""What a server is started with: address, access, limits."""

import ipaddress
import re
from dataclasses import dataclass, field

from mrsfi_bridge.errors import SettingsError
from mrsfi_bridge.type_table import TypeTable

_MEBI = 1 << 20
_TOKEN = re.compile(r"[A-Za-z0-9_-]{16,}")


@dataclass(frozen=True, slots=True)
class Limits:
    """What clients may use of the server's memory and time.

    Parameters
    ----------
    clients
        Connections at a time.
    frame_bytes
        Longest message of a client, also when it comes in fragments.
    queue_bytes
        What may wait for one client that reads too slowly.
    total_bytes
        What may wait for all clients and from all clients together.
    latched_bytes
        What the last messages of latched topics take together.
    topics, services
        Topics and services at a time.
    uses
        Topics that a client advertises or subscribes to, each, and its calls under way.
    parameters
        Parameters at a time.
    parameter_bytes
        Longest parameter, as JSON text.
    handshake_s, ping_s, pong_s, close_s
        Time for the opening handshake; silence after which a client is pinged; further
        silence after which it counts as gone; time for a closing handshake.
    service_s
        Time that a provider has for its answer.
    """

    clients: int = 256
    frame_bytes: int = 10 * _MEBI
    queue_bytes: int = 24 * _MEBI
    total_bytes: int = 256 * _MEBI
    latched_bytes: int = 64 * _MEBI
    topics: int = 20_000
    services: int = 5_000
    uses: int = 20_000
    parameters: int = 10_000
    parameter_bytes: int = 1 << 16
    handshake_s: float = 10.0
    ping_s: float = 15.0
    pong_s: float = 30.0
    close_s: float = 3.0
    service_s: float = 30.0


@dataclass(frozen=True, slots=True)
class ServerSettings:
    """Address of a server and who may use it.

    Parameters
    ----------
    host, port
        Address to bind; port 0 takes any free one.
    is_public
        Whether ``host`` may be one that other machines reach.
    token
        What clients must show; required for a public server.
    origins
        Origins of web pages that may connect, beside those of this machine.
    types
        Types that clients may use.
    limits
        What clients may use of the server.
    """

    host: str = "127.0.0.1"
    port: int = 0
    is_public: bool = False
    token: str | None = field(default=None, repr=False)
    origins: tuple[str, ...] = ()
    types: TypeTable = field(default_factory=TypeTable)
    limits: Limits = Limits()

    def check(self) -> None:
        """Refuse, as a ``SettingsError``, settings that would open the server to strangers."""
        if not is_loopback(self.host):
            if not self.is_public:
                raise SettingsError(
                    f"{self.host} is an address that other machines may reach: "
                    "add --public and --token, or bind 127.0.0.1"
                )
            if self.token is None:
                raise SettingsError(
                    "a public server needs a token that its clients must show: add --token"
                )
        if self.token is not None and not _TOKEN.fullmatch(self.token):
            raise SettingsError("a token has at least 16 letters, digits, '-' or '_'")


def is_loopback(host: str) -> bool:
    """Return whether only this machine reaches an address."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
