"""What a client uses, how many times, and no more than it may."""

from typing import Generic, TypeVar

from mrsfi_bridge.errors import ProtocolError

V = TypeVar("V")


class Uses(Generic[V]):
    """Topics that a client uses, each under the identifiers that it gave.

    Parameters
    ----------
    limit
        Uses at a time.
    """

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._n_uses = 0
        self._uses: dict[str, dict[str | int | None, V]] = {}

    def __contains__(self, name: str) -> bool:
        return name in self._uses

    def of(self, name: str) -> dict[str | int | None, V]:
        """Return the uses of a topic by identifier."""
        return self._uses.get(name, {})

    def check(self, name: str, use_id: str | int | None) -> None:
        """Refuse one use too many.

        Raises
        ------
        ProtocolError
            If it is.
        """
        if self._n_uses >= self._limit and use_id not in self.of(name):
            raise ProtocolError(f"you have {self._n_uses} uses of topics, the limit")

    def add(self, name: str, use_id: str | int | None, value: V) -> None:
        """Note a use, in the place of one with the same identifier."""
        uses = self._uses.setdefault(name, {})
        self._n_uses += use_id not in uses
        uses[use_id] = value

    def remove(self, name: str, use_id: str | int | None) -> bool:
        """Forget a use, or all of a topic without an identifier; return whether it was the last."""
        uses = self._uses[name]
        for each in tuple(uses):
            if use_id is None or each == use_id:
                del uses[each]
                self._n_uses -= 1
        if not uses:
            del self._uses[name]
        return not uses


class Budget:
    """Bytes that all clients share.

    Parameters
    ----------
    limit
        How many.
    """

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self.used = 0

    def take(self, n_bytes: int) -> bool:
        """Use some; return whether there are as many left."""
        if self.used + n_bytes > self._limit:
            return False
        self.used += n_bytes
        return True

    def give_back(self, n_bytes: int) -> None:
        """Have used some."""
        self.used -= n_bytes
