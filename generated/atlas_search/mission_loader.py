# Generated from mission atlas_search by mission_loader.py.j2.
# Edit inside protected regions only.
"""The mission as its model describes it."""

from mrsfi_runtime.api import (
    Area,
    AvoidCollision,
    Battery,
    Coordinates,
    Goal,
    Message,
    MessageData,
    Mission,
    MotionSource,
    Robot,
    Sensor,
    Server,
    StayWithinMissionArea,
    Track,
    Visit,
)


def load_mission() -> Mission:
    """Return the mission."""
    return Mission(
        name="ATLAS search",
        duration=1200,
        area=Area(
            id="region",
            radius=243.0,
            center=Coordinates(x=47.5, y=-120.0, z=0.0),
        ),
        robots=(
            Robot(
                id="frank",
                name="frank",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-20.0, y=0.0, z=0.0),
                sensors=(
                    Sensor(
                        id="frank_gps",
                        name="GPS of frank",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="frank_battery",
                        name="Battery of frank",
                        total_energy=6000.0,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="frank_motor",
                        name="Motor of frank",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="henry",
                name="henry",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=0.0, y=0.0, z=0.0),
                sensors=(
                    Sensor(
                        id="henry_gps",
                        name="GPS of henry",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="henry_battery",
                        name="Battery of henry",
                        total_energy=6000.0,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="henry_motor",
                        name="Motor of henry",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="ella",
                name="ella",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=20.0, y=0.0, z=0.0),
                sensors=(
                    Sensor(
                        id="ella_gps",
                        name="GPS of ella",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="ella_battery",
                        name="Battery of ella",
                        total_energy=6000.0,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="ella_motor",
                        name="Motor of ella",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="gilda",
                name="gilda",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=40.0, y=0.0, z=0.0),
                sensors=(
                    Sensor(
                        id="gilda_gps",
                        name="GPS of gilda",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="gilda_battery",
                        name="Battery of gilda",
                        total_energy=6000.0,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="gilda_motor",
                        name="Motor of gilda",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
        ),
        servers=(
            Server(
                id="shoreside",
                name="shoreside",
            ),
        ),
        goals=(
            Goal(
                id="mutualAvoidance",
                name="mutualAvoidance",
                members=("frank", "henry", "ella", "gilda"),
                task=AvoidCollision(robots=("frank", "henry", "ella", "gilda")),
                messages=(
                    Message(
                        id="mutualAvoidance_frank",
                        header="h",
                        sender="frank",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="mutualAvoidance_henry",
                        header="h",
                        sender="henry",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="mutualAvoidance_ella",
                        header="h",
                        sender="ella",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="mutualAvoidance_gilda",
                        header="h",
                        sender="gilda",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="stayInRegion",
                name="stayInRegion",
                members=("frank", "henry", "ella", "gilda"),
                task=StayWithinMissionArea(),
                messages=(
                    Message(
                        id="stayInRegion_frank",
                        header="h",
                        sender="frank",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="stayInRegion_henry",
                        header="h",
                        sender="henry",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="stayInRegion_ella",
                        header="h",
                        sender="ella",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="stayInRegion_gilda",
                        header="h",
                        sender="gilda",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="sweep_frank",
                name="primarySensorSweep of frank",
                members=("frank",),
                task=Track(
                    trajectory=(
                        Coordinates(x=-50.0, y=-30.0, z=0.0),
                        Coordinates(x=12.5, y=-30.0, z=0.0),
                        Coordinates(x=12.5, y=-58.57, z=0.0),
                        Coordinates(x=-50.0, y=-58.57, z=0.0),
                        Coordinates(x=-50.0, y=-87.14, z=0.0),
                        Coordinates(x=12.5, y=-87.14, z=0.0),
                        Coordinates(x=12.5, y=-115.71, z=0.0),
                        Coordinates(x=-50.0, y=-115.71, z=0.0),
                        Coordinates(x=-50.0, y=-144.29, z=0.0),
                        Coordinates(x=12.5, y=-144.29, z=0.0),
                        Coordinates(x=12.5, y=-172.86, z=0.0),
                        Coordinates(x=-50.0, y=-172.86, z=0.0),
                        Coordinates(x=-50.0, y=-201.43, z=0.0),
                        Coordinates(x=12.5, y=-201.43, z=0.0),
                        Coordinates(x=12.5, y=-230.0, z=0.0),
                        Coordinates(x=-50.0, y=-230.0, z=0.0),
                    ),
                    tolerance=10.0,
                ),
                messages=(
                    Message(
                        id="sweep_frank_frank",
                        header="h",
                        sender="frank",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="sweep_henry",
                name="primarySensorSweep of henry",
                members=("henry",),
                task=Track(
                    trajectory=(
                        Coordinates(x=12.5, y=-30.0, z=0.0),
                        Coordinates(x=75.0, y=-30.0, z=0.0),
                        Coordinates(x=75.0, y=-58.57, z=0.0),
                        Coordinates(x=12.5, y=-58.57, z=0.0),
                        Coordinates(x=12.5, y=-87.14, z=0.0),
                        Coordinates(x=75.0, y=-87.14, z=0.0),
                        Coordinates(x=75.0, y=-115.71, z=0.0),
                        Coordinates(x=12.5, y=-115.71, z=0.0),
                        Coordinates(x=12.5, y=-144.29, z=0.0),
                        Coordinates(x=75.0, y=-144.29, z=0.0),
                        Coordinates(x=75.0, y=-172.86, z=0.0),
                        Coordinates(x=12.5, y=-172.86, z=0.0),
                        Coordinates(x=12.5, y=-201.43, z=0.0),
                        Coordinates(x=75.0, y=-201.43, z=0.0),
                        Coordinates(x=75.0, y=-230.0, z=0.0),
                        Coordinates(x=12.5, y=-230.0, z=0.0),
                    ),
                    tolerance=10.0,
                ),
                messages=(
                    Message(
                        id="sweep_henry_henry",
                        header="h",
                        sender="henry",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="sweep_ella",
                name="primarySensorSweep of ella",
                members=("ella",),
                task=Track(
                    trajectory=(
                        Coordinates(x=75.0, y=-30.0, z=0.0),
                        Coordinates(x=137.5, y=-30.0, z=0.0),
                        Coordinates(x=137.5, y=-58.57, z=0.0),
                        Coordinates(x=75.0, y=-58.57, z=0.0),
                        Coordinates(x=75.0, y=-87.14, z=0.0),
                        Coordinates(x=137.5, y=-87.14, z=0.0),
                        Coordinates(x=137.5, y=-115.71, z=0.0),
                        Coordinates(x=75.0, y=-115.71, z=0.0),
                        Coordinates(x=75.0, y=-144.29, z=0.0),
                        Coordinates(x=137.5, y=-144.29, z=0.0),
                        Coordinates(x=137.5, y=-172.86, z=0.0),
                        Coordinates(x=75.0, y=-172.86, z=0.0),
                        Coordinates(x=75.0, y=-201.43, z=0.0),
                        Coordinates(x=137.5, y=-201.43, z=0.0),
                        Coordinates(x=137.5, y=-230.0, z=0.0),
                        Coordinates(x=75.0, y=-230.0, z=0.0),
                    ),
                    tolerance=10.0,
                ),
                messages=(
                    Message(
                        id="sweep_ella_ella",
                        header="h",
                        sender="ella",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="sweep_gilda",
                name="primarySensorSweep of gilda",
                members=("gilda",),
                task=Track(
                    trajectory=(
                        Coordinates(x=137.5, y=-30.0, z=0.0),
                        Coordinates(x=200.0, y=-30.0, z=0.0),
                        Coordinates(x=200.0, y=-58.57, z=0.0),
                        Coordinates(x=137.5, y=-58.57, z=0.0),
                        Coordinates(x=137.5, y=-87.14, z=0.0),
                        Coordinates(x=200.0, y=-87.14, z=0.0),
                        Coordinates(x=200.0, y=-115.71, z=0.0),
                        Coordinates(x=137.5, y=-115.71, z=0.0),
                        Coordinates(x=137.5, y=-144.29, z=0.0),
                        Coordinates(x=200.0, y=-144.29, z=0.0),
                        Coordinates(x=200.0, y=-172.86, z=0.0),
                        Coordinates(x=137.5, y=-172.86, z=0.0),
                        Coordinates(x=137.5, y=-201.43, z=0.0),
                        Coordinates(x=200.0, y=-201.43, z=0.0),
                        Coordinates(x=200.0, y=-230.0, z=0.0),
                        Coordinates(x=137.5, y=-230.0, z=0.0),
                    ),
                    tolerance=10.0,
                ),
                messages=(
                    Message(
                        id="sweep_gilda_gilda",
                        header="h",
                        sender="gilda",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="object1",
                name="findTestObjects benign 1",
                members=("frank", "henry"),
                task=Visit(
                    coordinates=Coordinates(x=0.0, y=-160.0, z=0.0),
                    tolerance=10.0,
                    deadline=1199,
                ),
                messages=(
                    Message(
                        id="object1_frank",
                        header="h",
                        sender="frank",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="object1_henry",
                        header="h",
                        sender="henry",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="object3",
                name="findTestObjects benign 3",
                members=("ella", "henry"),
                task=Visit(
                    coordinates=Coordinates(x=80.0, y=-130.0, z=0.0),
                    tolerance=10.0,
                    deadline=1199,
                ),
                messages=(
                    Message(
                        id="object3_ella",
                        header="h",
                        sender="ella",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="object3_henry",
                        header="h",
                        sender="henry",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="object2",
                name="findTestObjects hazard 2",
                members=("gilda", "ella", "frank"),
                task=Visit(
                    coordinates=Coordinates(x=185.0, y=-100.0, z=0.0),
                    tolerance=10.0,
                    deadline=1199,
                ),
                messages=(
                    Message(
                        id="object2_gilda",
                        header="h",
                        sender="gilda",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="object2_ella",
                        header="h",
                        sender="ella",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="object2_frank",
                        header="h",
                        sender="frank",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
        ),
    )
