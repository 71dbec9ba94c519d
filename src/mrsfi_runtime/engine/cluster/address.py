"""Where a dask cluster is, as a user says it; usable without dask."""

from importlib.util import find_spec
from urllib.parse import urlsplit

from mrsfi_runtime.errors import UsageError

LOCAL = "local"
"""In place of an address: a cluster of processes on this machine, for this command only."""


def require_address(text: str) -> None:
    """Refuse what is no address of a scheduler, and any while dask is not installed."""
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
