# Generated from mission atlas_crossing by mission_loader.py.j2.
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
    Obstacle,
    Robot,
    Sensor,
    Server,
    StayWithinMissionArea,
    SufficientEnergy,
    Track,
)


def load_mission() -> Mission:
    """Return the mission."""
    return Mission(
        name="ATLAS crossing",
        duration=1050,
        area=Area(
            id="region",
            radius=170.0,
            center=Coordinates(x=67.0, y=-50.0, z=0.0),
        ),
        robots=(
            Robot(
                id="gilda",
                name="gilda",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=15.0, y=0.0, z=0.0),
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
                        total_energy=5000.0,
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
            Robot(
                id="henry",
                name="henry",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-8.0, y=0.0, z=0.0),
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
                        total_energy=5000.0,
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
        ),
        servers=(
            Server(
                id="shoreside",
                name="shoreside",
            ),
        ),
        obstacles=(
            Obstacle(
                id="ob_0",
                area=Area(
                    id="ob_0_area",
                    radius=9.2,
                    center=Coordinates(x=103.5, y=-109.5, z=0.0),
                ),
            ),
            Obstacle(
                id="ob_1",
                area=Area(
                    id="ob_1_area",
                    radius=6.8,
                    center=Coordinates(x=47.0, y=-36.0, z=0.0),
                ),
            ),
            Obstacle(
                id="ob_2",
                area=Area(
                    id="ob_2_area",
                    radius=8.6,
                    center=Coordinates(x=79.0, y=-73.0, z=0.0),
                ),
            ),
            Obstacle(
                id="ob_3",
                area=Area(
                    id="ob_3_area",
                    radius=8.8,
                    center=Coordinates(x=56.0, y=-108.5, z=0.0),
                ),
            ),
            Obstacle(
                id="ob_4",
                area=Area(
                    id="ob_4_area",
                    radius=9.0,
                    center=Coordinates(x=104.0, y=-46.0, z=0.0),
                ),
            ),
        ),
        goals=(
            Goal(
                id="mutualAvoidance",
                name="mutualAvoidance",
                members=("gilda", "henry"),
                task=AvoidCollision(
                    robots=("gilda", "henry"),
                    obstacles=("ob_0", "ob_1", "ob_2", "ob_3", "ob_4"),
                ),
                messages=(
                    Message(
                        id="mutualAvoidance_gilda",
                        header="h",
                        sender="gilda",
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
                ),
            ),
            Goal(
                id="within",
                name="Stay within the area",
                members=("gilda", "henry"),
                task=StayWithinMissionArea(),
                messages=(
                    Message(
                        id="within_gilda",
                        header="h",
                        sender="gilda",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="within_henry",
                        header="h",
                        sender="henry",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="returnOnLowEnergy",
                name="returnOnLowEnergy",
                members=("gilda", "henry"),
                task=SufficientEnergy(),
                messages=(
                    Message(
                        id="returnOnLowEnergy_gilda",
                        header="h",
                        sender="gilda",
                        receiver="shoreside",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="returnOnLowEnergy_henry",
                        header="h",
                        sender="henry",
                        receiver="shoreside",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                ),
            ),
            Goal(
                id="gilda_sweep1",
                name="multipleSensorSweeps 1 of gilda",
                members=("gilda",),
                task=Track(
                    trajectory=(
                        Coordinates(x=170.0, y=-70.0, z=0.0),
                        Coordinates(x=209.0, y=-70.0, z=0.0),
                        Coordinates(x=209.0, y=-80.0, z=0.0),
                        Coordinates(x=170.0, y=-80.0, z=0.0),
                        Coordinates(x=170.0, y=-90.0, z=0.0),
                        Coordinates(x=209.0, y=-90.0, z=0.0),
                        Coordinates(x=209.0, y=-100.0, z=0.0),
                        Coordinates(x=170.0, y=-100.0, z=0.0),
                    ),
                    tolerance=5.0,
                ),
                messages=(
                    Message(
                        id="gilda_sweep1_gilda",
                        header="h",
                        sender="gilda",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="gilda_sweep2",
                name="multipleSensorSweeps 2 of gilda",
                members=("gilda",),
                task=Track(
                    trajectory=(
                        Coordinates(x=-75.0, y=-70.0, z=0.0),
                        Coordinates(x=-35.0, y=-70.0, z=0.0),
                        Coordinates(x=-35.0, y=-80.0, z=0.0),
                        Coordinates(x=-75.0, y=-80.0, z=0.0),
                        Coordinates(x=-75.0, y=-90.0, z=0.0),
                        Coordinates(x=-35.0, y=-90.0, z=0.0),
                        Coordinates(x=-35.0, y=-100.0, z=0.0),
                        Coordinates(x=-75.0, y=-100.0, z=0.0),
                    ),
                    tolerance=5.0,
                ),
                messages=(
                    Message(
                        id="gilda_sweep2_gilda",
                        header="h",
                        sender="gilda",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="henry_sweep1",
                name="multipleSensorSweeps 1 of henry",
                members=("henry",),
                task=Track(
                    trajectory=(
                        Coordinates(x=-75.0, y=-70.0, z=0.0),
                        Coordinates(x=-35.0, y=-70.0, z=0.0),
                        Coordinates(x=-35.0, y=-80.0, z=0.0),
                        Coordinates(x=-75.0, y=-80.0, z=0.0),
                        Coordinates(x=-75.0, y=-90.0, z=0.0),
                        Coordinates(x=-35.0, y=-90.0, z=0.0),
                        Coordinates(x=-35.0, y=-100.0, z=0.0),
                        Coordinates(x=-75.0, y=-100.0, z=0.0),
                    ),
                    tolerance=5.0,
                ),
                messages=(
                    Message(
                        id="henry_sweep1_henry",
                        header="h",
                        sender="henry",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="henry_sweep2",
                name="multipleSensorSweeps 2 of henry",
                members=("henry",),
                task=Track(
                    trajectory=(
                        Coordinates(x=170.0, y=-70.0, z=0.0),
                        Coordinates(x=209.0, y=-70.0, z=0.0),
                        Coordinates(x=209.0, y=-80.0, z=0.0),
                        Coordinates(x=170.0, y=-80.0, z=0.0),
                        Coordinates(x=170.0, y=-90.0, z=0.0),
                        Coordinates(x=209.0, y=-90.0, z=0.0),
                        Coordinates(x=209.0, y=-100.0, z=0.0),
                        Coordinates(x=170.0, y=-100.0, z=0.0),
                    ),
                    tolerance=5.0,
                ),
                messages=(
                    Message(
                        id="henry_sweep2_henry",
                        header="h",
                        sender="henry",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
        ),
    )
