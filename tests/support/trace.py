"""The digest of every tick of a flight."""

import hashlib
from collections.abc import Sequence

from mrsfi_runtime.kernel.packing import state_bytes
from mrsfi_runtime.kernel.state import State


class TraceDigest:
    """Observer that digests every field of belief and truth at every tick."""

    def __init__(self) -> None:
        self._sha = hashlib.sha256()

    def __call__(
        self, world: State, belief: State, true: Sequence[bool], believed: Sequence[bool]
    ) -> None:
        """Add one tick."""
        self._sha.update(state_bytes(world))
        self._sha.update(state_bytes(belief))
        self._sha.update(bytes([*true, *believed]))

    def hexdigest(self) -> str:
        """Return the SHA-256 of all ticks so far."""
        return self._sha.hexdigest()
