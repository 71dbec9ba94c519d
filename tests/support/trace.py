"""Every tick of a flight: its digest, and its numbers by name."""

import hashlib
from collections.abc import Iterator
from typing import Any

from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.recording import Part, Recording
from mrsfi_runtime.kernel.flight import Verdicts
from mrsfi_runtime.kernel.state import State, state_bytes
from mrsfi_runtime.model.fault_types import Field
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import Outcome


class TraceDigest:
    """Observer that digests every field of belief and truth, and what is judged, at every tick."""

    def __init__(self) -> None:
        self._sha = hashlib.sha256()

    def __call__(self, world: State, belief: State, verdicts: Verdicts) -> None:
        """Add one tick."""
        is_missed = (ticks > 0 for ticks in verdicts.missed)
        self._sha.update(state_bytes(world))
        self._sha.update(state_bytes(belief))
        self._sha.update(bytes([*verdicts.is_true, *verdicts.is_believed, *is_missed]))

    def hexdigest(self) -> str:
        """Return the SHA-256 of all ticks so far."""
        return self._sha.hexdigest()


def traced(engine: Engine, specification: Specification) -> tuple[Outcome, str]:
    """Return the outcome of a flight, and the digest of all its ticks."""
    digest = TraceDigest()
    return engine.evaluate(specification, observer=digest), digest.hexdigest()


def fields_of(state: Any) -> dict[tuple[Field, int], Any]:
    """Return what faults may falsify of a state, by property and index."""
    values: dict[tuple[Field, int], Any] = {}
    for i, robot in enumerate(state.robots):
        values[Field.POSITION, i] = (robot.x, robot.y, robot.z)
        values[Field.SPEED, i] = robot.speed
        values[Field.ENERGY, i] = robot.energy
    for k, sensor in enumerate(state.sensors):
        values[Field.COUNT, k] = sensor.count
        values[Field.RATE, k] = sensor.rate
        values[Field.COST, k] = sensor.cost
        values[Field.ACTIVATION, k] = sensor.active
    for o, obstacle in enumerate(state.obstacles):
        values[Field.OBSTACLE, o] = (obstacle.x, obstacle.y)
    return values


def columns(records: Recording | Part, name: str = "") -> Iterator[tuple[str, list[object]]]:
    """Yield all numbers of a recording, field by field."""
    for field in records.dtype.names or ():
        found = records[field]
        if isinstance(found, Part):
            yield from columns(found, f"{name}.{field}")
        else:
            yield f"{name}.{field}", found.tolist()
