"""Every error of the server, and the exit code it ends a command with.

::

    BridgeError              1  a defect of the server
    ├── SettingsError        2  invalid settings or definitions
    ├── NotRunningError      8  a server that cannot listen, was not started, or has ended
    └── ProtocolError        8  an operation of a client that is not allowed
"""

from typing import ClassVar


class BridgeError(Exception):
    """Base of all errors of the server."""

    exit_code: ClassVar[int] = 1


class SettingsError(BridgeError):
    """A setting or a definition is invalid."""

    exit_code = 2


class NotRunningError(BridgeError):
    """The server's address cannot be bound, or it was not started, or has ended."""

    exit_code = 8


class ProtocolError(BridgeError):
    """A client sends something that the protocol, a type or a limit does not allow."""

    exit_code = 8
