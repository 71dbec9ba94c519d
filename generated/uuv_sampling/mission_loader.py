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
    MessageField,
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
            center=Coordinates(x=0.0, y=0.0, z=0.0),
            radius=2000.0,
        ),
        robots=(
            Robot(
                id="r1",
                name="LEN",
                position=Coordinates(x=250.0, y=-250.0, z=1.0),
                speed=5.0,
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
                position=Coordinates(x=-250.0, y=250.0, z=1.0),
                speed=4.0,
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
                position=Coordinates(x=250.0, y=250.0, z=1.0),
                speed=4.0,
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
                    center=Coordinates(x=0.0, y=500.0, z=1.0),
                    radius=50.0,
                ),
            ),
            Obstacle(
                id="o2",
                area=Area(
                    id="a8",
                    center=Coordinates(x=500.0, y=500.0, z=1.0),
                    radius=40.0,
                ),
            ),
            Obstacle(
                id="o3",
                area=Area(
                    id="a9",
                    center=Coordinates(x=500.0, y=0.0, z=1.0),
                    radius=45.0,
                ),
            ),
            Obstacle(
                id="o4",
                area=Area(
                    id="a10",
                    center=Coordinates(x=500.0, y=-500.0, z=1.0),
                    radius=25.0,
                ),
            ),
            Obstacle(
                id="o5",
                area=Area(
                    id="a11",
                    center=Coordinates(x=0.0, y=-500.0, z=1.0),
                    radius=30.0,
                ),
            ),
            Obstacle(
                id="o6",
                area=Area(
                    id="a12",
                    center=Coordinates(x=-500.0, y=-500.0, z=1.0),
                    radius=28.0,
                ),
            ),
            Obstacle(
                id="o7",
                area=Area(
                    id="a13",
                    center=Coordinates(x=-500.0, y=0.0, z=1.0),
                    radius=45.0,
                ),
            ),
            Obstacle(
                id="o8",
                area=Area(
                    id="a14",
                    center=Coordinates(x=-500.0, y=500.0, z=1.0),
                    radius=15.0,
                ),
            ),
        ),
        goals=(
            Goal(
                id="g1",
                name="AvoidCollision",
                members=("r2", "r3", "r1"),
                task=AvoidCollision(
                    robots=("r2", "r3", "r1"),
                    obstacles=("o1", "o2", "o3", "o4", "o5", "o6", "o7", "o8"),
                ),
                area=Area(
                    id="a1",
                    center=Coordinates(x=600.0, y=-200.0, z=0.0),
                    radius=4.0,
                ),
                messages=(
                    Message(
                        id="m1",
                        sender="r2",
                        receiver="sv1",
                        body=(MessageField(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="m2",
                        sender="r3",
                        receiver="sv1",
                        body=(MessageField(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="m3",
                        sender="r1",
                        receiver="sv1",
                        body=(MessageField(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="g2",
                name="StayWithinMissionArea",
                members=("r2", "r3", "r1"),
                task=StayWithinMissionArea(),
                area=Area(
                    id="a2",
                    center=Coordinates(x=-800.0, y=450.0, z=1.0),
                    radius=11.0,
                ),
                messages=(
                    Message(
                        id="m4",
                        sender="r2",
                        receiver="sv1",
                        body=(MessageField(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="m5",
                        sender="r3",
                        receiver="sv1",
                        body=(MessageField(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="m6",
                        sender="r1",
                        receiver="sv1",
                        body=(MessageField(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="g3",
                name="SufficientEnergy",
                members=("r2", "r3", "r1"),
                task=SufficientEnergy(),
                area=Area(
                    id="a3",
                    center=Coordinates(x=0.0, y=0.0, z=0.0),
                    radius=1000.0,
                ),
                messages=(
                    Message(
                        id="m7",
                        sender="r2",
                        receiver="sv1",
                        body=(
                            MessageField(name="POSITION", type="Coordinates"),
                            MessageField(name="SPEED", type="Int"),
                            MessageField(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="m8",
                        sender="r3",
                        receiver="sv1",
                        body=(
                            MessageField(name="POSITION", type="Coordinates"),
                            MessageField(name="SPEED", type="Int"),
                            MessageField(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="m9",
                        sender="r1",
                        receiver="sv1",
                        body=(
                            MessageField(name="POSITION", type="Coordinates"),
                            MessageField(name="SPEED", type="Int"),
                            MessageField(name="ENERGY", type="Double"),
                        ),
                    ),
                ),
            ),
            Goal(
                id="g4",
                name="GatherSamples",
                members=("r2",),
                task=GatherSamples(
                    target_sample_number=250,
                    sensor="s4",
                ),
                area=Area(
                    id="a4",
                    center=Coordinates(x=-250.0, y=250.0, z=1.0),
                    radius=150.0,
                ),
                messages=(
                    Message(
                        id="m10",
                        sender="r2",
                        receiver="sv1",
                        body=(MessageField(name="TEMPERATURE", type="Int"),),
                    ),
                ),
            ),
            Goal(
                id="g5",
                name="GatherSamples",
                members=("r3",),
                task=GatherSamples(
                    target_sample_number=400,
                    sensor="s6",
                ),
                area=Area(
                    id="a5",
                    center=Coordinates(x=250.0, y=250.0, z=1.0),
                    radius=150.0,
                ),
                messages=(
                    Message(
                        id="m11",
                        sender="r3",
                        receiver="sv1",
                        body=(MessageField(name="DEPTH", type="Double"),),
                    ),
                ),
            ),
            Goal(
                id="g6",
                name="GatherSamples",
                members=("r1",),
                task=GatherSamples(
                    target_sample_number=500,
                    sensor="s2",
                ),
                area=Area(
                    id="a6",
                    center=Coordinates(x=250.0, y=-250.0, z=1.0),
                    radius=150.0,
                ),
                messages=(
                    Message(
                        id="m12",
                        sender="r1",
                        receiver="sv1",
                        body=(MessageField(name="PRESSURE", type="Double"),),
                    ),
                ),
            ),
        ),
    )
