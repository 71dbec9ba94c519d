"""The names that generated code may import, and nothing else."""

from mrsfi_runtime.hosting.truth import true_values
from mrsfi_runtime.kernel import commands, randomness, reactions, tasks
from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.initial import initial_state
from mrsfi_runtime.kernel.motion import advance, reports_position
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.faults import Fault, FaultPool
from mrsfi_runtime.model.mission import (
    Area,
    AvoidCollision,
    Battery,
    Coordinates,
    FixedDistanceBetweenRobots,
    GatherSamples,
    Goal,
    Message,
    MessageField,
    Mission,
    MotionSource,
    Obstacle,
    Patrol,
    Property,
    Robot,
    Sensor,
    Server,
    Stay,
    StayWithinMissionArea,
    SufficientEnergy,
    Track,
    Visit,
)
from mrsfi_runtime.transport.topics import Payload, Publisher, Topic, Transport

__all__ = [
    "Area",
    "AvoidCollision",
    "Battery",
    "Coordinates",
    "Fault",
    "FaultPool",
    "FixedDistanceBetweenRobots",
    "GatherSamples",
    "Goal",
    "Message",
    "MessageField",
    "Mission",
    "MotionSource",
    "Obstacle",
    "Patrol",
    "Payload",
    "Property",
    "Publisher",
    "Robot",
    "Sensor",
    "Server",
    "State",
    "Stay",
    "StayWithinMissionArea",
    "SufficientEnergy",
    "Topic",
    "Track",
    "Transport",
    "Visit",
    "advance",
    "commands",
    "initial_state",
    "kernel",
    "randomness",
    "reactions",
    "reports_position",
    "tasks",
    "true_values",
]
