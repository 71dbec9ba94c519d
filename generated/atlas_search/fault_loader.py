# Generated from mission atlas_search by fault_loader.py.j2.
# Edit inside protected regions only.
"""The faults that could strike the mission, in model order, and what their types mean."""

from mrsfi_runtime.api import (
    Fault,
    FaultPool,
    FaultType,
    Field,
    Mode,
    Parameter,
    Range,
    Struck,
)

TYPES = {
    kind.name: kind
    for kind in (
        FaultType(
            "DelayMessage",
            Mode.DELAY,
            Struck.MESSAGE,
            parameters=(Parameter("DELAY", Range.TICKS, is_integer=True),),
        ),
        FaultType(
            "BlockMessage",
            Mode.BLOCK,
            Struck.MESSAGE,
            parameters=(Parameter("BLOCK_DURATION", Range.TICKS, is_integer=True),),
        ),
        FaultType(
            "FixedRobotCoordinates",
            Mode.FIXED,
            Struck.MESSAGE,
            (Field.POSITION,),
            parameters=(
                Parameter("NEW_X", Range.X),
                Parameter("NEW_Y", Range.Y),
                Parameter("NEW_Z", Range.Z, evolves=False),
            ),
        ),
        FaultType("RandomRobotCoordinates", Mode.RANDOM, Struck.MESSAGE, (Field.POSITION,)),
        FaultType("StopRobot", Mode.STOP, Struck.ROBOT, (Field.MOTION,)),
        FaultType("DeactivateSensor", Mode.DEACTIVATE, Struck.SENSOR, (Field.ACTIVATION,)),
    )
}


def load_faults() -> FaultPool:
    """Return the fault pool."""
    return FaultPool(
        id="pool",
        faults=(
            Fault(
                id="f1",
                name="f1",
                kind=TYPES["FixedRobotCoordinates"],
                target="mutualAvoidance_frank",
                values=(10.0, 10.0, 0.0),
            ),
            Fault(
                id="f2",
                name="f2",
                kind=TYPES["RandomRobotCoordinates"],
                target="mutualAvoidance_frank",
            ),
            Fault(
                id="f3",
                name="f3",
                kind=TYPES["DelayMessage"],
                target="mutualAvoidance_frank",
                values=(50.0,),
            ),
            Fault(
                id="f4",
                name="f4",
                kind=TYPES["BlockMessage"],
                target="mutualAvoidance_frank",
                values=(50.0,),
            ),
            Fault(
                id="f5",
                name="f5",
                kind=TYPES["StopRobot"],
                target="frank",
            ),
            Fault(
                id="f6",
                name="f6",
                kind=TYPES["DeactivateSensor"],
                target="frank_gps",
            ),
            Fault(
                id="f7",
                name="f7",
                kind=TYPES["FixedRobotCoordinates"],
                target="mutualAvoidance_henry",
                values=(10.0, 10.0, 0.0),
            ),
            Fault(
                id="f8",
                name="f8",
                kind=TYPES["RandomRobotCoordinates"],
                target="mutualAvoidance_henry",
            ),
            Fault(
                id="f9",
                name="f9",
                kind=TYPES["DelayMessage"],
                target="mutualAvoidance_henry",
                values=(50.0,),
            ),
            Fault(
                id="f10",
                name="f10",
                kind=TYPES["BlockMessage"],
                target="mutualAvoidance_henry",
                values=(50.0,),
            ),
            Fault(
                id="f11",
                name="f11",
                kind=TYPES["StopRobot"],
                target="henry",
            ),
            Fault(
                id="f12",
                name="f12",
                kind=TYPES["DeactivateSensor"],
                target="henry_gps",
            ),
            Fault(
                id="f13",
                name="f13",
                kind=TYPES["FixedRobotCoordinates"],
                target="mutualAvoidance_ella",
                values=(10.0, 10.0, 0.0),
            ),
            Fault(
                id="f14",
                name="f14",
                kind=TYPES["RandomRobotCoordinates"],
                target="mutualAvoidance_ella",
            ),
            Fault(
                id="f15",
                name="f15",
                kind=TYPES["DelayMessage"],
                target="mutualAvoidance_ella",
                values=(50.0,),
            ),
            Fault(
                id="f16",
                name="f16",
                kind=TYPES["BlockMessage"],
                target="mutualAvoidance_ella",
                values=(50.0,),
            ),
            Fault(
                id="f17",
                name="f17",
                kind=TYPES["StopRobot"],
                target="ella",
            ),
            Fault(
                id="f18",
                name="f18",
                kind=TYPES["DeactivateSensor"],
                target="ella_gps",
            ),
            Fault(
                id="f19",
                name="f19",
                kind=TYPES["FixedRobotCoordinates"],
                target="mutualAvoidance_gilda",
                values=(10.0, 10.0, 0.0),
            ),
            Fault(
                id="f20",
                name="f20",
                kind=TYPES["RandomRobotCoordinates"],
                target="mutualAvoidance_gilda",
            ),
            Fault(
                id="f21",
                name="f21",
                kind=TYPES["DelayMessage"],
                target="mutualAvoidance_gilda",
                values=(50.0,),
            ),
            Fault(
                id="f22",
                name="f22",
                kind=TYPES["BlockMessage"],
                target="mutualAvoidance_gilda",
                values=(50.0,),
            ),
            Fault(
                id="f23",
                name="f23",
                kind=TYPES["StopRobot"],
                target="gilda",
            ),
            Fault(
                id="f24",
                name="f24",
                kind=TYPES["DeactivateSensor"],
                target="gilda_gps",
            ),
        ),
    )
