# Generated from mission undersea by fault_loader.py.j2.
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
        FaultType(
            "DecrementRemainingEnergyCapacityReport",
            Mode.DECREMENT_PERCENT,
            Struck.MESSAGE,
            (Field.ENERGY,),
            parameters=(Parameter("PERCENTAGE", Range.PERCENT),),
        ),
        FaultType(
            "IncrementSensorEnergyPerSample",
            Mode.INCREMENT_PERCENT,
            Struck.MESSAGE,
            (Field.COST,),
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
        FaultType("ZeroSampleRate", Mode.ZERO, Struck.MESSAGE, (Field.RATE,)),
        FaultType(
            "FixedSampleRate",
            Mode.FIXED,
            Struck.MESSAGE,
            (Field.RATE,),
            parameters=(Parameter("FIXED_VAL", Range.RATE, is_integer=True),),
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
                kind=TYPES["FixedSampleRate"],
                target="r1_temperatures_m",
                values=(2.0,),
            ),
            Fault(
                id="f2",
                name="f2",
                kind=TYPES["FixedSampleRate"],
                target="r1_pressures_m",
                values=(3.0,),
            ),
            Fault(
                id="f3",
                name="f3",
                kind=TYPES["ZeroSampleRate"],
                target="r1_depths_m",
            ),
            Fault(
                id="f4",
                name="f4",
                kind=TYPES["DeactivateSensor"],
                target="sensor1",
            ),
            Fault(
                id="f5",
                name="f5",
                kind=TYPES["DeactivateSensor"],
                target="sensor2",
            ),
            Fault(
                id="f6",
                name="f6",
                kind=TYPES["DeactivateSensor"],
                target="sensor3",
            ),
            Fault(
                id="f7",
                name="f7",
                kind=TYPES["DelayMessage"],
                target="r1_temperatures_m",
                values=(50.0,),
            ),
            Fault(
                id="f8",
                name="f8",
                kind=TYPES["DelayMessage"],
                target="r1_pressures_m",
                values=(50.0,),
            ),
            Fault(
                id="f9",
                name="f9",
                kind=TYPES["DelayMessage"],
                target="r1_depths_m",
                values=(50.0,),
            ),
            Fault(
                id="f10",
                name="f10",
                kind=TYPES["BlockMessage"],
                target="r1_temperatures_m",
                values=(50.0,),
            ),
            Fault(
                id="f11",
                name="f11",
                kind=TYPES["BlockMessage"],
                target="r1_pressures_m",
                values=(50.0,),
            ),
            Fault(
                id="f12",
                name="f12",
                kind=TYPES["BlockMessage"],
                target="r1_depths_m",
                values=(50.0,),
            ),
            Fault(
                id="f13",
                name="f13",
                kind=TYPES["IncrementSensorEnergyPerSample"],
                target="r1_temperatures_m",
                values=(20.0,),
            ),
            Fault(
                id="f14",
                name="f14",
                kind=TYPES["IncrementSensorEnergyPerSample"],
                target="r1_pressures_m",
                values=(20.0,),
            ),
            Fault(
                id="f15",
                name="f15",
                kind=TYPES["IncrementSensorEnergyPerSample"],
                target="r1_depths_m",
                values=(20.0,),
            ),
            Fault(
                id="f16",
                name="f16",
                kind=TYPES["FixedRobotCoordinates"],
                target="survey_nautilus",
                values=(80.0, -120.0, 0.0),
            ),
            Fault(
                id="f17",
                name="f17",
                kind=TYPES["RandomRobotCoordinates"],
                target="survey_nautilus",
            ),
            Fault(
                id="f18",
                name="f18",
                kind=TYPES["DelayMessage"],
                target="survey_nautilus",
                values=(20.0,),
            ),
            Fault(
                id="f19",
                name="f19",
                kind=TYPES["BlockMessage"],
                target="survey_nautilus",
                values=(20.0,),
            ),
            Fault(
                id="f20",
                name="f20",
                kind=TYPES["DecrementRemainingEnergyCapacityReport"],
                target="r2_nautilus",
                values=(10.0,),
            ),
            Fault(
                id="f21",
                name="f21",
                kind=TYPES["ZeroRemainingEnergyCapacityReport"],
                target="r2_nautilus",
            ),
            Fault(
                id="f22",
                name="f22",
                kind=TYPES["IncrementRemainingEnergyCapacityReport"],
                target="r2_nautilus",
                values=(10.0,),
            ),
            Fault(
                id="f23",
                name="f23",
                kind=TYPES["FixedSpeed"],
                target="r2_nautilus",
                values=(5.0,),
            ),
            Fault(
                id="f24",
                name="f24",
                kind=TYPES["ZeroSpeed"],
                target="r2_nautilus",
            ),
            Fault(
                id="f25",
                name="f25",
                kind=TYPES["StopRobot"],
                target="nautilus",
            ),
        ),
    )
