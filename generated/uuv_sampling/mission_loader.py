# Generated from mission uuv_sampling by mission_loader.py.j2.
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
    StayWithinMissionArea,
    SufficientEnergy,
)


def load_mission() -> Mission:
    """Return the mission."""
    return Mission(
        name="1000",
        duration=1000,
        area=Area(
            id="a15",
            radius=2000.0,
            center=Coordinates(x=0.0, y=0.0, z=0.0),
        ),
        robots=(
            Robot(
                id="r1",
                name="LEN",
                speed=5.0,
                position=Coordinates(x=250.0, y=-250.0, z=1.0),
                sensors=(
                    Sensor(
                        id="s1",
                        name="GPS sensor of LEN",
                        type="GPS_POSITION",
                        energy_per_sample=2.0,
                        samples_per_second=5,
                    ),
                    Sensor(
                        id="s2",
                        name="Pressure sensor of LEN",
                        type="PRESSURE",
                        energy_per_sample=2.0,
                        samples_per_second=5,
                    ),
                ),
                batteries=(
                    Battery(
                        id="b1",
                        name="First battery of LEN",
                        total_energy=20000.0,
                    ),
                    Battery(
                        id="b2",
                        name="Second battery of LEN",
                        total_energy=80000.0,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="ms1",
                        name="Thruster of LEN",
                        energy_per_distance_unit=5.0,
                    ),
                ),
            ),
            Robot(
                id="r2",
                name="JEN",
                speed=4.0,
                position=Coordinates(x=-250.0, y=250.0, z=1.0),
                sensors=(
                    Sensor(
                        id="s3",
                        name="GPS sensor of JEN",
                        type="GPS_POSITION",
                        energy_per_sample=2.0,
                        samples_per_second=5,
                    ),
                    Sensor(
                        id="s4",
                        name="Temperature sensor of JEN",
                        type="TEMPERATURE",
                        energy_per_sample=2.0,
                        samples_per_second=5,
                    ),
                ),
                batteries=(
                    Battery(
                        id="b3",
                        name="First battery of JEN",
                        total_energy=4000.0,
                    ),
                    Battery(
                        id="b4",
                        name="Second battery of JEN",
                        total_energy=60000.0,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="ms2",
                        name="Thruster of JEN",
                        energy_per_distance_unit=5.0,
                    ),
                ),
            ),
            Robot(
                id="r3",
                name="KAL",
                speed=4.0,
                position=Coordinates(x=250.0, y=250.0, z=1.0),
                sensors=(
                    Sensor(
                        id="s5",
                        name="GPS sensor of KAL",
                        type="GPS_POSITION",
                        energy_per_sample=2.0,
                        samples_per_second=5,
                    ),
                    Sensor(
                        id="s6",
                        name="Depth sensor of KAL",
                        type="DEPTH",
                        energy_per_sample=2.0,
                        samples_per_second=5,
                    ),
                ),
                batteries=(
                    Battery(
                        id="b5",
                        name="First battery of KAL",
                        total_energy=50000.0,
                    ),
                    Battery(
                        id="b6",
                        name="Second battery of KAL",
                        total_energy=50000.0,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="ms3",
                        name="Thruster of KAL",
                        energy_per_distance_unit=5.0,
                    ),
                ),
            ),
        ),
        servers=(
            Server(
                id="sv1",
                name="Offshore server",
            ),
        ),
        obstacles=(
            Obstacle(
                id="o1",
                area=Area(
                    id="a7",
                    radius=50.0,
                    center=Coordinates(x=0.0, y=500.0, z=1.0),
                ),
            ),
            Obstacle(
                id="o2",
                area=Area(
                    id="a8",
                    radius=40.0,
                    center=Coordinates(x=500.0, y=500.0, z=1.0),
                ),
            ),
            Obstacle(
                id="o3",
                area=Area(
                    id="a9",
                    radius=45.0,
                    center=Coordinates(x=500.0, y=0.0, z=1.0),
                ),
            ),
            Obstacle(
                id="o4",
                area=Area(
                    id="a10",
                    radius=25.0,
                    center=Coordinates(x=500.0, y=-500.0, z=1.0),
                ),
            ),
            Obstacle(
                id="o5",
                area=Area(
                    id="a11",
                    radius=30.0,
                    center=Coordinates(x=0.0, y=-500.0, z=1.0),
                ),
            ),
            Obstacle(
                id="o6",
                area=Area(
                    id="a12",
                    radius=28.0,
                    center=Coordinates(x=-500.0, y=-500.0, z=1.0),
                ),
            ),
            Obstacle(
                id="o7",
                area=Area(
                    id="a13",
                    radius=45.0,
                    center=Coordinates(x=-500.0, y=0.0, z=1.0),
                ),
            ),
            Obstacle(
                id="o8",
                area=Area(
                    id="a14",
                    radius=15.0,
                    center=Coordinates(x=-500.0, y=500.0, z=1.0),
                ),
            ),
        ),
        goals=(
            Goal(
                id="g1",
                name="AvoidCollision",
                members=("r2", "r3", "r1"),
                area=Area(
                    id="a1",
                    radius=4.0,
                    center=Coordinates(x=600.0, y=-200.0, z=0.0),
                ),
                task=AvoidCollision(
                    robots=("r2", "r3", "r1"),
                    obstacles=("o1", "o2", "o3", "o4", "o5", "o6", "o7", "o8"),
                ),
                messages=(
                    Message(
                        id="m1",
                        header="h",
                        sender="r2",
                        receiver="sv1",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="m2",
                        header="h",
                        sender="r3",
                        receiver="sv1",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="m3",
                        header="h",
                        sender="r1",
                        receiver="sv1",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="g2",
                name="StayWithinMissionArea",
                members=("r2", "r3", "r1"),
                area=Area(
                    id="a2",
                    radius=11.0,
                    center=Coordinates(x=-800.0, y=450.0, z=1.0),
                ),
                task=StayWithinMissionArea(),
                messages=(
                    Message(
                        id="m4",
                        header="h",
                        sender="r2",
                        receiver="sv1",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="m5",
                        header="h",
                        sender="r3",
                        receiver="sv1",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="m6",
                        header="h",
                        sender="r1",
                        receiver="sv1",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="g3",
                name="SufficientEnergy",
                members=("r2", "r3", "r1"),
                area=Area(
                    id="a3",
                    radius=1000.0,
                    center=Coordinates(x=0.0, y=0.0, z=0.0),
                ),
                task=SufficientEnergy(),
                messages=(
                    Message(
                        id="m7",
                        header="h",
                        sender="r2",
                        receiver="sv1",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="m8",
                        header="h",
                        sender="r3",
                        receiver="sv1",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="m9",
                        header="h",
                        sender="r1",
                        receiver="sv1",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                ),
            ),
            Goal(
                id="g4",
                name="GatherSamples",
                members=("r2",),
                area=Area(
                    id="a4",
                    radius=150.0,
                    center=Coordinates(x=-250.0, y=250.0, z=1.0),
                ),
                task=GatherSamples(target_sample_number=250, sensor="s4"),
                messages=(
                    Message(
                        id="m10",
                        header="h",
                        sender="r2",
                        receiver="sv1",
                        body=(MessageData(name="TEMPERATURE", type="Int"),),
                    ),
                ),
            ),
            Goal(
                id="g5",
                name="GatherSamples",
                members=("r3",),
                area=Area(
                    id="a5",
                    radius=150.0,
                    center=Coordinates(x=250.0, y=250.0, z=1.0),
                ),
                task=GatherSamples(target_sample_number=400, sensor="s6"),
                messages=(
                    Message(
                        id="m11",
                        header="h",
                        sender="r3",
                        receiver="sv1",
                        body=(MessageData(name="DEPTH", type="Double"),),
                    ),
                ),
            ),
            Goal(
                id="g6",
                name="GatherSamples",
                members=("r1",),
                area=Area(
                    id="a6",
                    radius=150.0,
                    center=Coordinates(x=250.0, y=-250.0, z=1.0),
                ),
                task=GatherSamples(target_sample_number=500, sensor="s2"),
                messages=(
                    Message(
                        id="m12",
                        header="h",
                        sender="r1",
                        receiver="sv1",
                        body=(MessageData(name="PRESSURE", type="Double"),),
                    ),
                ),
            ),
        ),
    )
