"""The digest of every tick of a flight."""

import hashlib
from collections.abc import Sequence

from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.kernel.packing import state_bytes
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.outcome import Outcome


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


def traced(engine: Engine, specification: Specification) -> tuple[Outcome, str]:
    """Return the outcome of a flight, and the digest of all its ticks."""
    digest = TraceDigest()
    return engine.evaluate(specification, observer=digest), digest.hexdigest()
