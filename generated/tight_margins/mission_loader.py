# Generated from mission tight_margins by mission_loader.py.j2.
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
    Robot,
    Sensor,
    Server,
    Stay,
    StayWithinMissionArea,
    SufficientEnergy,
    Visit,
)


def load_mission() -> Mission:
    """Return the mission."""
    return Mission(
        name="tight margins",
        duration=200,
        area=Area(
            id="whole",
            radius=250.0,
            center=Coordinates(x=0.0, y=0.0, z=0.0),
        ),
        robots=(
            Robot(
                id="p1",
                name="ANN",
                speed=4.0,
                position=Coordinates(x=-120.0, y=0.0, z=0.0),
                sensors=(
                    Sensor(
                        id="p1_gps",
                        name="GPS sensor of ANN",
                        type="GPS_POSITION",
                        energy_per_sample=2.0,
                        samples_per_second=5,
                    ),
                    Sensor(
                        id="p1_depth",
                        name="Depth sensor of ANN",
                        type="DEPTH",
                        energy_per_sample=2.0,
                        samples_per_second=5,
                    ),
                ),
                batteries=(
                    Battery(
                        id="p1_battery",
                        name="Battery of ANN",
                        total_energy=8400.0,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="p1_drive",
                        name="Thruster of ANN",
                        energy_per_distance_unit=5.0,
                    ),
                ),
            ),
            Robot(
                id="p2",
                name="BEA",
                speed=4.0,
                position=Coordinates(x=120.0, y=0.0, z=0.0),
                sensors=(
                    Sensor(
                        id="p2_gps",
                        name="GPS sensor of BEA",
                        type="GPS_POSITION",
                        energy_per_sample=2.0,
                        samples_per_second=5,
                    ),
                    Sensor(
                        id="p2_pressure",
                        name="Pressure sensor of BEA",
                        type="PRESSURE",
                        energy_per_sample=2.0,
                        samples_per_second=5,
                    ),
                ),
                batteries=(
                    Battery(
                        id="p2_battery",
                        name="Battery of BEA",
                        total_energy=8400.0,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="p2_drive",
                        name="Thruster of BEA",
                        energy_per_distance_unit=5.0,
                    ),
                ),
            ),
            Robot(
                id="p3",
                name="CAY",
                speed=3.0,
                position=Coordinates(x=-90.0, y=-180.0, z=0.0),
                sensors=(
                    Sensor(
                        id="p3_gps",
                        name="GPS sensor of CAY",
                        type="GPS_POSITION",
                        energy_per_sample=2.0,
                        samples_per_second=5,
                    ),
                    Sensor(
                        id="p3_temperature",
                        name="Temperature sensor of CAY",
                        type="TEMPERATURE",
                        energy_per_sample=2.0,
                        samples_per_second=5,
                    ),
                ),
                batteries=(
                    Battery(
                        id="p3_battery",
                        name="Battery of CAY",
                        total_energy=9000.0,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="p3_drive",
                        name="Thruster of CAY",
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
                id="rock",
                area=Area(
                    id="rock_area",
                    radius=30.0,
                    center=Coordinates(x=0.0, y=150.0, z=0.0),
                ),
            ),
        ),
        goals=(
            Goal(
                id="clear",
                name="AvoidCollision",
                members=("p1", "p2", "p3"),
                task=AvoidCollision(robots=("p1", "p2", "p3"), obstacles=("rock",)),
                messages=(
                    Message(
                        id="clear_p1",
                        header="h",
                        sender="p1",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_p2",
                        header="h",
                        sender="p2",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_p3",
                        header="h",
                        sender="p3",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="within",
                name="StayWithinMissionArea",
                members=("p1", "p2", "p3"),
                task=StayWithinMissionArea(),
                messages=(
                    Message(
                        id="within_p1",
                        header="h",
                        sender="p1",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="energy",
                name="SufficientEnergy",
                members=("p1", "p2"),
                task=SufficientEnergy(),
                messages=(
                    Message(
                        id="energy_p1",
                        header="h",
                        sender="p1",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_p2",
                        header="h",
                        sender="p2",
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
                id="depths",
                name="GatherSamples",
                members=("p1",),
                area=Area(
                    id="depths_area",
                    radius=40.0,
                    center=Coordinates(x=-120.0, y=0.0, z=0.0),
                ),
                task=GatherSamples(target_sample_number=140, sensor="p1_depth"),
                messages=(
                    Message(
                        id="depths_p1",
                        header="h",
                        sender="p1",
                        receiver="base",
                        body=(MessageData(name="DEPTH", type="Double"),),
                    ),
                ),
            ),
            Goal(
                id="pressures",
                name="GatherSamples",
                members=("p2",),
                area=Area(
                    id="pressures_area",
                    radius=40.0,
                    center=Coordinates(x=120.0, y=0.0, z=0.0),
                ),
                task=GatherSamples(target_sample_number=25, sensor="p2_pressure"),
                messages=(
                    Message(
                        id="pressures_p2",
                        header="h",
                        sender="p2",
                        receiver="base",
                        body=(MessageData(name="PRESSURE", type="Double"),),
                    ),
                ),
            ),
            Goal(
                id="buoy",
                name="Visit",
                members=("p3",),
                task=Visit(
                    coordinates=Coordinates(x=90.0, y=-180.0, z=0.0),
                    tolerance=0.1,
                    deadline=100,
                ),
                messages=(
                    Message(
                        id="buoy_p3",
                        header="h",
                        sender="p3",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="moor",
                name="Stay",
                members=("p3",),
                task=Stay(
                    area=Area(
                        id="moor_area",
                        radius=20.0,
                        center=Coordinates(x=90.0, y=-180.0, z=0.0),
                    ),
                ),
                messages=(
                    Message(
                        id="moor_p3",
                        header="h",
                        sender="p3",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
        ),
    )
