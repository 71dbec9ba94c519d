"""Errors in callbacks: the thread that runs those would log and drop them."""

from collections.abc import Callable
from typing import ParamSpec, TypeVar

from mrsfi_runtime.transport.topics import FailureListener

P = ParamSpec("P")
R = TypeVar("R")


class ListenedTransport:
    """A transport that tells a listener what goes wrong in its callbacks, or with its connection.

    ``lost`` is why it moves nothing any more, once it does not.
    """

    def __init__(self) -> None:
        self.lost: Exception | None = None
        self._listener: FailureListener | None = None

    def watch(self, listener: FailureListener) -> None:
        """Have a function told of a lost connection, and of errors in callbacks."""
        self._listener = listener
        if self.lost is not None:
            listener(self.lost)

    def require_open(self) -> None:
        """Raise ``TransportClosed`` if the connection is lost."""
        if self.lost is not None:
            raise self.lost

    def tell(self, error: Exception) -> None:
        """Tell the listener, if there is one."""
        if self._listener is not None:
            self._listener(error)

    def told(self, callback: Callable[P, R]) -> Callable[P, R]:
        """Return a callback whose errors reach the listener before they reach the caller."""

        def call(*args: P.args, **kwargs: P.kwargs) -> R:
            try:
                return callback(*args, **kwargs)
            except Exception as error:
                self.tell(error)
                raise

        return call
