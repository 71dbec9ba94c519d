"""What an error of the embedded server is to a mission."""

from mrsfi_bridge import errors as bridge
from mrsfi_runtime.errors import (
    MrsfiError,
    ProtocolError,
    TransportClosed,
    TransportError,
    UsageError,
)

_OURS: tuple[tuple[type[bridge.BridgeError], type[MrsfiError]], ...] = (
    (bridge.SettingsError, UsageError),
    (bridge.ListenError, TransportError),
    (bridge.NotRunningError, TransportClosed),
    (bridge.ProtocolError, ProtocolError),
)


def as_ours(error: bridge.BridgeError) -> MrsfiError:
    """Return the runtime's error with the same message and exit code."""
    return next((ours for theirs, ours in _OURS if isinstance(error, theirs)), MrsfiError)(
        str(error)
    )
