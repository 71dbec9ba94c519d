# Generated from mission tight_energy by mission_loader.py.j2.
# Edit inside protected regions only.
"""The mission as its model describes it."""

from mrsfi_runtime.api import (
    Area,
    AvoidCollision,
    Battery,
    Coordinates,
    GatherSamples,
    Goal,
    Message,
    MessageData,
    Mission,
    MotionSource,
    Obstacle,
    Patrol,
    Robot,
    Sensor,
    Server,
    StayWithinMissionArea,
    SufficientEnergy,
)


def load_mission() -> Mission:
    """Return the mission."""
    return Mission(
        name="tight energy",
        duration=400,
        area=Area(
            id="whole",
            radius=500.0,
            center=Coordinates(x=0.0, y=0.0, z=0.0),
        ),
        robots=(
            Robot(
                id="e1",
                name="ADA",
                speed=4.0,
                position=Coordinates(x=-200.0, y=0.0, z=0.0),
                sensors=(
                    Sensor(
                        id="e1_gps_position",
                        name="GPS_POSITION sensor of ADA",
                        type="GPS_POSITION",
                        energy_per_sample=2.0,
                        samples_per_second=5,
                    ),
                    Sensor(
                        id="e1_temperature",
                        name="TEMPERATURE sensor of ADA",
                        type="TEMPERATURE",
                        energy_per_sample=2.0,
                        samples_per_second=5,
                    ),
                ),
                batteries=(
                    Battery(
                        id="e1_battery",
                        name="Battery of ADA",
                        total_energy=16400.0,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="e1_drive",
                        name="Thruster of ADA",
                        energy_per_distance_unit=5.0,
                    ),
                ),
            ),
            Robot(
                id="e2",
                name="BOB",
                speed=4.0,
                position=Coordinates(x=200.0, y=0.0, z=0.0),
                sensors=(
                    Sensor(
                        id="e2_gps_position",
                        name="GPS_POSITION sensor of BOB",
                        type="GPS_POSITION",
                        energy_per_sample=2.0,
                        samples_per_second=5,
                    ),
                    Sensor(
                        id="e2_depth",
                        name="DEPTH sensor of BOB",
                        type="DEPTH",
                        energy_per_sample=2.0,
                        samples_per_second=5,
                    ),
                ),
                batteries=(
                    Battery(
                        id="e2_battery",
                        name="Battery of BOB",
                        total_energy=16400.0,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="e2_drive",
                        name="Thruster of BOB",
                        energy_per_distance_unit=5.0,
                    ),
                ),
            ),
            Robot(
                id="e3",
                name="CEM",
                speed=4.0,
                position=Coordinates(x=0.0, y=200.0, z=0.0),
                sensors=(
                    Sensor(
                        id="e3_gps_position",
                        name="GPS_POSITION sensor of CEM",
                        type="GPS_POSITION",
                        energy_per_sample=2.0,
                        samples_per_second=5,
                    ),
                    Sensor(
                        id="e3_pressure",
                        name="PRESSURE sensor of CEM",
                        type="PRESSURE",
                        energy_per_sample=2.0,
                        samples_per_second=5,
                    ),
                ),
                batteries=(
                    Battery(
                        id="e3_battery",
                        name="Battery of CEM",
                        total_energy=16400.0,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="e3_drive",
                        name="Thruster of CEM",
                        energy_per_distance_unit=5.0,
                    ),
                ),
            ),
        ),
        servers=(
            Server(
                id="base",
                name="Base",
            ),
        ),
        obstacles=(
            Obstacle(
                id="reef",
                area=Area(
                    id="reef_area",
                    radius=40.0,
                    center=Coordinates(x=0.0, y=0.0, z=0.0),
                ),
            ),
            Obstacle(
                id="wreck",
                area=Area(
                    id="wreck_area",
                    radius=25.0,
                    center=Coordinates(x=0.0, y=-250.0, z=0.0),
                ),
            ),
        ),
        goals=(
            Goal(
                id="clear",
                name="AvoidCollision",
                members=("e1", "e2", "e3"),
                task=AvoidCollision(robots=("e1", "e2", "e3"), obstacles=("reef", "wreck")),
                messages=(
                    Message(
                        id="clear_e1",
                        header="h",
                        sender="e1",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_e2",
                        header="h",
                        sender="e2",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="within",
                name="StayWithinMissionArea",
                members=("e1", "e2", "e3"),
                task=StayWithinMissionArea(),
                messages=(
                    Message(
                        id="within_e3",
                        header="h",
                        sender="e3",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="energy",
                name="SufficientEnergy",
                members=("e1", "e2", "e3"),
                task=SufficientEnergy(),
                messages=(
                    Message(
                        id="energy_e1",
                        header="h",
                        sender="e1",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_e2",
                        header="h",
                        sender="e2",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_e3",
                        header="h",
                        sender="e3",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                ),
            ),
            Goal(
                id="temperatures",
                name="GatherSamples",
                members=("e1",),
                area=Area(
                    id="temperatures_area",
                    radius=80.0,
                    center=Coordinates(x=-200.0, y=0.0, z=0.0),
                ),
                task=GatherSamples(target_sample_number=300, sensor="e1_temperature"),
                messages=(
                    Message(
                        id="temperatures_e1",
                        header="h",
                        sender="e1",
                        receiver="base",
                        body=(MessageData(name="TEMPERATURE", type="Int"),),
                    ),
                ),
            ),
            Goal(
                id="depths",
                name="GatherSamples",
                members=("e2",),
                area=Area(
                    id="depths_area",
                    radius=80.0,
                    center=Coordinates(x=200.0, y=0.0, z=0.0),
                ),
                task=GatherSamples(target_sample_number=340, sensor="e2_depth"),
                messages=(
                    Message(
                        id="depths_e2",
                        header="h",
                        sender="e2",
                        receiver="base",
                        body=(MessageData(name="DEPTH", type="Double"),),
                    ),
                ),
            ),
            Goal(
                id="rounds",
                name="Patrol",
                members=("e3",),
                task=Patrol(
                    area=Area(
                        id="rounds_area",
                        radius=60.0,
                        center=Coordinates(x=0.0, y=200.0, z=0.0),
                    ),
                    period=40,
                ),
                messages=(
                    Message(
                        id="rounds_e3",
                        header="h",
                        sender="e3",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
        ),
    )
