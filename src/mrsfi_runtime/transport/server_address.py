"""How a rosbridge server is named and joined, for whoever does not join it."""

from typing import Literal, TypeAlias

Client: TypeAlias = Literal["wire", "asyncio", "twisted"]
"""Kind of connection: ours, or one of roslibpy's; ``twisted`` goes with none other in a process."""

CLIENTS: tuple[Client, ...] = ("wire", "asyncio", "twisted")


def without_token(url: str) -> str:
    """Return a URL as it may be shown: a query may hold a token."""
    return url.partition("?")[0]
