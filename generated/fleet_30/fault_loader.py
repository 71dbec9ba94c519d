# Generated from mission fleet_30 by fault_loader.py.j2.
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
        FaultType("ZeroRemainingEnergyCapacityReport", Mode.ZERO, Struck.MESSAGE, (Field.ENERGY,)),
        FaultType(
            "IncrementRemainingEnergyCapacityReport",
            Mode.INCREMENT_PERCENT,
            Struck.MESSAGE,
            (Field.ENERGY,),
            parameters=(Parameter("PERCENTAGE", Range.PERCENT),),
        ),
        FaultType("ZeroSpeed", Mode.ZERO, Struck.MESSAGE, (Field.SPEED,)),
        FaultType(
            "FixedSpeed",
            Mode.FIXED,
            Struck.MESSAGE,
            (Field.SPEED,),
            parameters=(Parameter("FIXED_VAL", Range.SPEED, is_integer=True),),
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
                target="clear_q0r0",
                values=(0.0, 0.0, 0.0),
            ),
            Fault(
                id="f2",
                name="f2",
                kind=TYPES["DeactivateSensor"],
                target="q0r1_gps_position",
            ),
            Fault(
                id="f3",
                name="f3",
                kind=TYPES["StopRobot"],
                target="q0r2",
            ),
            Fault(
                id="f4",
                name="f4",
                kind=TYPES["RandomRobotCoordinates"],
                target="clear_q0r3",
            ),
            Fault(
                id="f5",
                name="f5",
                kind=TYPES["DelayMessage"],
                target="clear_q0r4",
                values=(30.0,),
            ),
            Fault(
                id="f6",
                name="f6",
                kind=TYPES["BlockMessage"],
                target="clear_q0r5",
                values=(30.0,),
            ),
            Fault(
                id="f7",
                name="f7",
                kind=TYPES["FixedSpeed"],
                target="energy_q0r6",
                values=(5.0,),
            ),
            Fault(
                id="f8",
                name="f8",
                kind=TYPES["ZeroSpeed"],
                target="energy_q0r7",
            ),
            Fault(
                id="f9",
                name="f9",
                kind=TYPES["ZeroRemainingEnergyCapacityReport"],
                target="energy_q0r8",
            ),
            Fault(
                id="f10",
                name="f10",
                kind=TYPES["IncrementRemainingEnergyCapacityReport"],
                target="energy_q0r9",
                values=(50.0,),
            ),
            Fault(
                id="f11",
                name="f11",
                kind=TYPES["DeactivateSensor"],
                target="q1r0_gps_position",
            ),
            Fault(
                id="f12",
                name="f12",
                kind=TYPES["StopRobot"],
                target="q1r1",
            ),
            Fault(
                id="f13",
                name="f13",
                kind=TYPES["RandomRobotCoordinates"],
                target="clear_q1r2",
            ),
            Fault(
                id="f14",
                name="f14",
                kind=TYPES["DelayMessage"],
                target="clear_q1r3",
                values=(30.0,),
            ),
            Fault(
                id="f15",
                name="f15",
                kind=TYPES["BlockMessage"],
                target="clear_q1r4",
                values=(30.0,),
            ),
            Fault(
                id="f16",
                name="f16",
                kind=TYPES["FixedSpeed"],
                target="energy_q1r5",
                values=(5.0,),
            ),
            Fault(
                id="f17",
                name="f17",
                kind=TYPES["ZeroSpeed"],
                target="energy_q1r6",
            ),
            Fault(
                id="f18",
                name="f18",
                kind=TYPES["ZeroRemainingEnergyCapacityReport"],
                target="energy_q1r7",
            ),
            Fault(
                id="f19",
                name="f19",
                kind=TYPES["IncrementRemainingEnergyCapacityReport"],
                target="energy_q1r8",
                values=(50.0,),
            ),
            Fault(
                id="f20",
                name="f20",
                kind=TYPES["FixedRobotCoordinates"],
                target="clear_q1r9",
                values=(0.0, 0.0, 0.0),
            ),
            Fault(
                id="f21",
                name="f21",
                kind=TYPES["StopRobot"],
                target="q2r0",
            ),
            Fault(
                id="f22",
                name="f22",
                kind=TYPES["RandomRobotCoordinates"],
                target="clear_q2r1",
            ),
            Fault(
                id="f23",
                name="f23",
                kind=TYPES["DelayMessage"],
                target="clear_q2r2",
                values=(30.0,),
            ),
            Fault(
                id="f24",
                name="f24",
                kind=TYPES["BlockMessage"],
                target="clear_q2r3",
                values=(30.0,),
            ),
            Fault(
                id="f25",
                name="f25",
                kind=TYPES["FixedSpeed"],
                target="energy_q2r4",
                values=(5.0,),
            ),
            Fault(
                id="f26",
                name="f26",
                kind=TYPES["ZeroSpeed"],
                target="energy_q2r5",
            ),
            Fault(
                id="f27",
                name="f27",
                kind=TYPES["ZeroRemainingEnergyCapacityReport"],
                target="energy_q2r6",
            ),
            Fault(
                id="f28",
                name="f28",
                kind=TYPES["IncrementRemainingEnergyCapacityReport"],
                target="energy_q2r7",
                values=(50.0,),
            ),
            Fault(
                id="f29",
                name="f29",
                kind=TYPES["FixedRobotCoordinates"],
                target="clear_q2r8",
                values=(0.0, 0.0, 0.0),
            ),
            Fault(
                id="f30",
                name="f30",
                kind=TYPES["DeactivateSensor"],
                target="q2r9_gps_position",
            ),
        ),
    )
