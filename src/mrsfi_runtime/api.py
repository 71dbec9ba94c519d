# mypy: implicit-reexport
# ruff: noqa: F401 - generated code imports these names from here
"""All names that generated code may import."""

from mrsfi_runtime import monitors
from mrsfi_runtime.cosimulation.lockstep import (
    RobotInterface,
    RobotTopics,
    SensorInterface,
    SensorTopics,
    SimulatedRobot,
    SimulatedSensor,
    initial_state,
    move,
)
from mrsfi_runtime.kernel import commands, forecast, geometry, goal_tasks, guidance, randomness
from mrsfi_runtime.kernel.goal_tasks.avoid_collision import AvoidCollision
from mrsfi_runtime.kernel.goal_tasks.fixed_distance_between_robots import FixedDistanceBetweenRobots
from mrsfi_runtime.kernel.goal_tasks.gather_samples import GatherSamples
from mrsfi_runtime.kernel.goal_tasks.patrol import Patrol
from mrsfi_runtime.kernel.goal_tasks.stay import Stay
from mrsfi_runtime.kernel.goal_tasks.stay_within_mission_area import StayWithinMissionArea
from mrsfi_runtime.kernel.goal_tasks.sufficient_energy import SufficientEnergy
from mrsfi_runtime.kernel.goal_tasks.table import OwnTask
from mrsfi_runtime.kernel.goal_tasks.track import Track
from mrsfi_runtime.kernel.goal_tasks.visit import Visit
from mrsfi_runtime.kernel.injections import OwnFault
from mrsfi_runtime.kernel.state import State, kernel
from mrsfi_runtime.model.fault_types import FaultType, Field, Mode, Parameter, Range, Struck
from mrsfi_runtime.model.faults import Event, Fault, FaultPool, Trigger
from mrsfi_runtime.model.mission import (
    Area,
    Battery,
    Coordinates,
    DoubleProperty,
    Goal,
    IntProperty,
    Message,
    MessageData,
    Mission,
    MotionSource,
    Obstacle,
    Requirement,
    Robot,
    Sensor,
    Server,
    StringProperty,
    polygon,
)
from mrsfi_runtime.monitors import Monitor
from mrsfi_runtime.transport.topics import PubSub
