"""Which faults reach a node: those of what it is told, and of the commands of its robots.

Commands are forged behind the node, which need not know; where it commands no speed but something
that is passed on, they are held back at most.
"""

from mrsfi_runtime.cosimulation.node.relay import robot_held
from mrsfi_runtime.cosimulation.node.speech import Speech
from mrsfi_runtime.model.fault_types import Field
from mrsfi_runtime.model.faults import FaultPool, describe, touched
from mrsfi_runtime.model.mission import Mission


def out_of_reach(mission: Mission, pool: FaultPool, speech: Speech) -> dict[str, str]:
    """Return the faults of a pool that cannot be injected, by ID, and what each touches."""
    told, passed_on = speech.told, {each.robot for each in speech.relayed}
    found = {}
    for fault in pool:
        targets = touched(mission, fault)
        is_forged = any(
            target[0] is Field.ACTIVATION
            or (target[0] is Field.MOTION and target[1] not in passed_on)
            for target in targets
        )
        is_held = robot_held(mission, pool, fault.id) in passed_on
        if not (is_forged or is_held or told.intersection(targets)):
            found[fault.id] = ", ".join(describe(mission, target) for target in targets)
    return found
