# Generated from mission undersea by mission_loader.py.j2.
# Edit inside protected regions only.
"""The mission as its model describes it."""

from mrsfi_runtime.api import (
    Area,
    Battery,
    Coordinates,
    GatherSamples,
    Goal,
    Message,
    MessageData,
    Mission,
    MotionSource,
    Robot,
    Sensor,
    Server,
    SufficientEnergy,
    Track,
)


def load_mission() -> Mission:
    """Return the mission."""
    return Mission(
        name="UNDERSEA",
        duration=1000,
        area=Area(
            id="whole",
            radius=150.0,
            center=Coordinates(x=80.0, y=-120.0, z=0.0),
        ),
        robots=(
            Robot(
                id="nautilus",
                name="nautilus",
                speed=2.25,
                max_speed=5.0,
                position=Coordinates(x=0.0, y=0.0, z=0.0),
                sensors=(
                    Sensor(
                        id="sensor1",
                        name="SENSOR1",
                        type="TEMPERATURE",
                        energy_per_sample=3.0,
                        samples_per_second=3,
                    ),
                    Sensor(
                        id="sensor2",
                        name="SENSOR2",
                        type="PRESSURE",
                        energy_per_sample=2.4,
                        samples_per_second=4,
                    ),
                    Sensor(
                        id="sensor3",
                        name="SENSOR3",
                        type="DEPTH",
                        energy_per_sample=2.1,
                        samples_per_second=3,
                    ),
                ),
                batteries=(
                    Battery(
                        id="nautilus_battery",
                        name="Battery of nautilus",
                        total_energy=27000.0,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="nautilus_motor",
                        name="Motor of nautilus",
                        energy_per_distance_unit=0.0,
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
                id="survey",
                name="Survey path",
                members=("nautilus",),
                task=Track(
                    trajectory=(
                        Coordinates(x=21.0, y=-39.0, z=0.0),
                        Coordinates(x=59.0, y=-22.0, z=0.0),
                        Coordinates(x=101.0, y=-22.0, z=0.0),
                        Coordinates(x=139.0, y=-39.0, z=0.0),
                        Coordinates(x=167.0, y=-70.0, z=0.0),
                        Coordinates(x=179.0, y=-110.0, z=0.0),
                        Coordinates(x=175.0, y=-151.0, z=0.0),
                        Coordinates(x=154.0, y=-187.0, z=0.0),
                        Coordinates(x=121.0, y=-211.0, z=0.0),
                        Coordinates(x=80.0, y=-220.0, z=0.0),
                        Coordinates(x=39.0, y=-211.0, z=0.0),
                        Coordinates(x=6.0, y=-187.0, z=0.0),
                        Coordinates(x=-15.0, y=-151.0, z=0.0),
                        Coordinates(x=-19.0, y=-110.0, z=0.0),
                        Coordinates(x=-7.0, y=-70.0, z=0.0),
                        Coordinates(x=21.0, y=-39.0, z=0.0),
                        Coordinates(x=59.0, y=-22.0, z=0.0),
                        Coordinates(x=101.0, y=-22.0, z=0.0),
                        Coordinates(x=139.0, y=-39.0, z=0.0),
                        Coordinates(x=167.0, y=-70.0, z=0.0),
                        Coordinates(x=179.0, y=-110.0, z=0.0),
                        Coordinates(x=175.0, y=-151.0, z=0.0),
                        Coordinates(x=154.0, y=-187.0, z=0.0),
                        Coordinates(x=121.0, y=-211.0, z=0.0),
                        Coordinates(x=80.0, y=-220.0, z=0.0),
                        Coordinates(x=39.0, y=-211.0, z=0.0),
                        Coordinates(x=6.0, y=-187.0, z=0.0),
                        Coordinates(x=-15.0, y=-151.0, z=0.0),
                        Coordinates(x=-19.0, y=-110.0, z=0.0),
                        Coordinates(x=-7.0, y=-70.0, z=0.0),
                        Coordinates(x=21.0, y=-39.0, z=0.0),
                        Coordinates(x=59.0, y=-22.0, z=0.0),
                        Coordinates(x=101.0, y=-22.0, z=0.0),
                        Coordinates(x=139.0, y=-39.0, z=0.0),
                        Coordinates(x=167.0, y=-70.0, z=0.0),
                        Coordinates(x=179.0, y=-110.0, z=0.0),
                        Coordinates(x=175.0, y=-151.0, z=0.0),
                        Coordinates(x=154.0, y=-187.0, z=0.0),
                        Coordinates(x=121.0, y=-211.0, z=0.0),
                        Coordinates(x=80.0, y=-220.0, z=0.0),
                        Coordinates(x=39.0, y=-211.0, z=0.0),
                        Coordinates(x=6.0, y=-187.0, z=0.0),
                        Coordinates(x=-15.0, y=-151.0, z=0.0),
                        Coordinates(x=-19.0, y=-110.0, z=0.0),
                        Coordinates(x=-7.0, y=-70.0, z=0.0),
                        Coordinates(x=21.0, y=-39.0, z=0.0),
                    ),
                    tolerance=15.0,
                ),
                messages=(
                    Message(
                        id="survey_nautilus",
                        header="h",
                        sender="nautilus",
                        receiver="shoreside",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="r2",
                name="R2",
                members=("nautilus",),
                task=SufficientEnergy(),
                messages=(
                    Message(
                        id="r2_nautilus",
                        header="h",
                        sender="nautilus",
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
                id="r1_temperatures",
                name="R1 of SENSOR1",
                members=("nautilus",),
                area=Area(
                    id="r1_temperatures_area",
                    radius=150.0,
                    center=Coordinates(x=80.0, y=-120.0, z=0.0),
                ),
                task=GatherSamples(target_sample_number=900, sensor="sensor1"),
                messages=(
                    Message(
                        id="r1_temperatures_m",
                        header="h",
                        sender="nautilus",
                        receiver="shoreside",
                        body=(MessageData(name="TEMPERATURE", type="Int"),),
                    ),
                ),
            ),
            Goal(
                id="r1_pressures",
                name="R1 of SENSOR2",
                members=("nautilus",),
                area=Area(
                    id="r1_pressures_area",
                    radius=150.0,
                    center=Coordinates(x=80.0, y=-120.0, z=0.0),
                ),
                task=GatherSamples(target_sample_number=900, sensor="sensor2"),
                messages=(
                    Message(
                        id="r1_pressures_m",
                        header="h",
                        sender="nautilus",
                        receiver="shoreside",
                        body=(MessageData(name="PRESSURE", type="Int"),),
                    ),
                ),
            ),
            Goal(
                id="r1_depths",
                name="R1 of SENSOR3",
                members=("nautilus",),
                area=Area(
                    id="r1_depths_area",
                    radius=150.0,
                    center=Coordinates(x=80.0, y=-120.0, z=0.0),
                ),
                task=GatherSamples(target_sample_number=900, sensor="sensor3"),
                messages=(
                    Message(
                        id="r1_depths_m",
                        header="h",
                        sender="nautilus",
                        receiver="shoreside",
                        body=(MessageData(name="DEPTH", type="Int"),),
                    ),
                ),
            ),
        ),
    )
