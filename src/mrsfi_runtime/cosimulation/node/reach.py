"""Which faults reach a node: those of what it is told, and of the commands of its robots."""

from mrsfi_runtime.cosimulation.node.speech import Speech
from mrsfi_runtime.model.fault_types import Field
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.targets import describe, touched

_ON_THE_WAY = (Field.MOTION, Field.ACTIVATION)
"""What faults forge behind the node, which need not know."""


def out_of_reach(mission: Mission, pool: FaultPool, speech: Speech) -> dict[str, str]:
    """Return the faults of a pool that cannot be injected, by ID, and what each touches."""
    told = speech.told
    found = {}
    for fault in pool:
        targets = touched(mission, fault)
        if not any(target in told or target[0] in _ON_THE_WAY for target in targets):
            found[fault.id] = ", ".join(describe(mission, target) for target in targets)
    return found
