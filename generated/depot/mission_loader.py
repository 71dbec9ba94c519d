# Generated from mission depot by mission_loader.py.j2.
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
    Requirement,
    Robot,
    Sensor,
    Server,
    Stay,
    StayWithinMissionArea,
    SufficientEnergy,
    Visit,
    polygon,
)


def load_mission() -> Mission:
    """Return the mission."""
    return Mission(
        name="Depot",
        duration=600,
        distance_unit="m",
        time_unit="s",
        energy_unit="J",
        area=Area(
            id="depot",
            radius=40.0,
            center=Coordinates(x=0.0, y=0.0, z=0.0),
        ),
        robots=(
            Robot(
                id="ada",
                name="Ada",
                speed=0.6,
                max_speed=1.0,
                turn_rate=60.0,
                position_noise=0.05,
                radius=0.6,
                position=Coordinates(x=-19.0, y=1.0, z=0.0),
                sensors=(
                    Sensor(
                        id="ada_positioning",
                        name="Positioning of Ada",
                        type="GPS_POSITION",
                        energy_per_sample=0.5,
                        samples_per_second=2,
                    ),
                ),
                batteries=(
                    Battery(
                        id="ada_battery",
                        name="Battery of Ada",
                        total_energy=24420.000000000004,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="ada_motor",
                        name="Motor of Ada",
                        energy_per_distance_unit=60.0,
                    ),
                ),
            ),
            Robot(
                id="ben",
                name="Ben",
                speed=0.6,
                max_speed=1.0,
                turn_rate=60.0,
                position_noise=0.05,
                radius=0.6,
                position=Coordinates(x=16.0, y=10.0, z=0.0),
                sensors=(
                    Sensor(
                        id="ben_positioning",
                        name="Positioning of Ben",
                        type="GPS_POSITION",
                        energy_per_sample=0.5,
                        samples_per_second=2,
                    ),
                ),
                batteries=(
                    Battery(
                        id="ben_battery",
                        name="Battery of Ben",
                        total_energy=24420.000000000004,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="ben_motor",
                        name="Motor of Ben",
                        energy_per_distance_unit=60.0,
                    ),
                ),
            ),
            Robot(
                id="cleo",
                name="Cleo",
                speed=0.6,
                max_speed=1.0,
                turn_rate=60.0,
                position_noise=0.05,
                radius=0.6,
                position=Coordinates(x=16.0, y=-31.0, z=0.0),
                sensors=(
                    Sensor(
                        id="cleo_positioning",
                        name="Positioning of Cleo",
                        type="GPS_POSITION",
                        energy_per_sample=0.5,
                        samples_per_second=2,
                    ),
                ),
                batteries=(
                    Battery(
                        id="cleo_battery",
                        name="Battery of Cleo",
                        total_energy=24420.000000000004,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="cleo_motor",
                        name="Motor of Cleo",
                        energy_per_distance_unit=60.0,
                    ),
                ),
            ),
            Robot(
                id="dan",
                name="Dan",
                speed=0.4,
                max_speed=1.0,
                radius=0.4,
                position=Coordinates(x=-8.0, y=20.0, z=0.0),
                sensors=(
                    Sensor(
                        id="dan_positioning",
                        name="Positioning of Dan",
                        type="GPS_POSITION",
                        energy_per_sample=0.5,
                        samples_per_second=2,
                    ),
                    Sensor(
                        id="dan_thermometer",
                        name="Thermometer of Dan",
                        type="TEMPERATURE",
                        energy_per_sample=1.0,
                        samples_per_second=3,
                    ),
                ),
                batteries=(
                    Battery(
                        id="dan_battery",
                        name="Battery of Dan",
                        total_energy=18480.0,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="dan_motor",
                        name="Motor of Dan",
                        energy_per_distance_unit=60.0,
                    ),
                ),
            ),
        ),
        servers=(
            Server(
                id="base",
                name="Depot server",
            ),
        ),
        obstacles=(
            Obstacle(
                id="rack_north",
                area=polygon(
                    id="rack_north_area",
                    corners=(
                        Coordinates(x=-12.0, y=3.0, z=0.0),
                        Coordinates(x=12.0, y=3.0, z=0.0),
                        Coordinates(x=12.0, y=7.0, z=0.0),
                        Coordinates(x=-12.0, y=7.0, z=0.0),
                    ),
                ),
            ),
            Obstacle(
                id="rack_south",
                area=polygon(
                    id="rack_south_area",
                    corners=(
                        Coordinates(x=-12.0, y=-7.0, z=0.0),
                        Coordinates(x=12.0, y=-7.0, z=0.0),
                        Coordinates(x=12.0, y=-3.0, z=0.0),
                        Coordinates(x=6.0, y=-3.0, z=0.0),
                        Coordinates(x=6.0, y=-5.0, z=0.0),
                        Coordinates(x=-6.0, y=-5.0, z=0.0),
                        Coordinates(x=-6.0, y=-3.0, z=0.0),
                        Coordinates(x=-12.0, y=-3.0, z=0.0),
                    ),
                ),
            ),
            Obstacle(
                id="dock_wall",
                area=polygon(
                    id="dock_wall_area",
                    corners=(
                        Coordinates(x=-22.0, y=-15.0, z=0.0),
                        Coordinates(x=-8.0, y=-15.0, z=0.0),
                        Coordinates(x=-8.0, y=-20.0, z=0.0),
                        Coordinates(x=-7.0, y=-20.0, z=0.0),
                        Coordinates(x=-7.0, y=-14.0, z=0.0),
                        Coordinates(x=-22.0, y=-14.0, z=0.0),
                    ),
                ),
            ),
            Obstacle(
                id="pillar_west",
                area=Area(
                    id="pillar_west_area",
                    radius=0.4,
                    center=Coordinates(x=-21.0, y=5.0, z=0.0),
                ),
            ),
            Obstacle(
                id="pillar_east",
                area=Area(
                    id="pillar_east_area",
                    radius=0.4,
                    center=Coordinates(x=21.0, y=-5.0, z=0.0),
                ),
            ),
        ),
        requirements=(
            Requirement(
                id="D1",
                text="No vehicle touches a rack, a wall or another vehicle.",
            ),
            Requirement(
                id="D2",
                text="Each truck goes on to the next crossing within 70 s.",
            ),
            Requirement(
                id="D3",
                text="The temperature of the cold store is known.",
            ),
        ),
        goals=(
            Goal(
                id="clear",
                name="Keep clear",
                members=("ada", "ben", "cleo", "dan"),
                requirements=("D1",),
                severity=9,
                integrity_level="SIL 2",
                rationale="Chosen for this example: people may stand behind a rack.",
                task=AvoidCollision(
                    robots=("ada", "ben", "cleo", "dan"),
                    obstacles=(
                        "rack_north",
                        "rack_south",
                        "dock_wall",
                        "pillar_west",
                        "pillar_east",
                    ),
                    clearance=0.3,
                ),
                messages=(
                    Message(
                        id="clear_ada",
                        sender="ada",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_ben",
                        sender="ben",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_cleo",
                        sender="cleo",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_dan",
                        sender="dan",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="within",
                name="Stay in the depot",
                members=("ada", "ben", "cleo", "dan"),
                grace=3,
                severity=7,
                rationale="Chosen for this example: a truck outside is in the traffic of the road.",
                task=StayWithinMissionArea(),
            ),
            Goal(
                id="handover",
                name="Handover to Cleo",
                members=("cleo",),
                severity=3,
                rationale="Chosen for this example: the next vehicle takes the pallet.",
                task=Visit(
                    coordinates=Coordinates(x=16.0, y=-22.0, z=0.0),
                    tolerance=1.5,
                    deadline=30,
                ),
                messages=(
                    Message(
                        id="handover_cleo",
                        sender="cleo",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="energy",
                name="Enough energy",
                members=("ada", "ben", "cleo", "dan"),
                severity=5,
                rationale="Chosen for this example: a truck without energy blocks an aisle.",
                task=SufficientEnergy(),
                messages=(
                    Message(
                        id="energy_ada",
                        sender="ada",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_ben",
                        sender="ben",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_cleo",
                        sender="cleo",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_dan",
                        sender="dan",
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
                id="round_ada",
                name="Round of Ada",
                members=("ada",),
                grace=10,
                requirements=("D2",),
                severity=4,
                rationale="Chosen for this example: a late pallet stops no production.",
                task=Patrol(
                    route=(
                        polygon(
                            id="round_ada_w",
                            corners=(
                                Coordinates(x=-18.0, y=-2.0, z=0.0),
                                Coordinates(x=-14.0, y=-2.0, z=0.0),
                                Coordinates(x=-14.0, y=2.0, z=0.0),
                                Coordinates(x=-18.0, y=2.0, z=0.0),
                            ),
                        ),
                        polygon(
                            id="round_ada_m",
                            corners=(
                                Coordinates(x=-2.0, y=-2.0, z=0.0),
                                Coordinates(x=2.0, y=-2.0, z=0.0),
                                Coordinates(x=2.0, y=2.0, z=0.0),
                                Coordinates(x=-2.0, y=2.0, z=0.0),
                            ),
                        ),
                        polygon(
                            id="round_ada_e",
                            corners=(
                                Coordinates(x=14.0, y=-2.0, z=0.0),
                                Coordinates(x=18.0, y=-2.0, z=0.0),
                                Coordinates(x=18.0, y=2.0, z=0.0),
                                Coordinates(x=14.0, y=2.0, z=0.0),
                            ),
                        ),
                        polygon(
                            id="round_ada_ne",
                            corners=(
                                Coordinates(x=14.0, y=8.0, z=0.0),
                                Coordinates(x=18.0, y=8.0, z=0.0),
                                Coordinates(x=18.0, y=12.0, z=0.0),
                                Coordinates(x=14.0, y=12.0, z=0.0),
                            ),
                        ),
                        polygon(
                            id="round_ada_nw",
                            corners=(
                                Coordinates(x=-18.0, y=8.0, z=0.0),
                                Coordinates(x=-14.0, y=8.0, z=0.0),
                                Coordinates(x=-14.0, y=12.0, z=0.0),
                                Coordinates(x=-18.0, y=12.0, z=0.0),
                            ),
                        ),
                    ),
                    period=60,
                ),
                messages=(
                    Message(
                        id="round_ada_ada",
                        sender="ada",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="round_ben",
                name="Round of Ben",
                members=("ben",),
                grace=10,
                requirements=("D2",),
                severity=4,
                rationale="Chosen for this example: a late pallet stops no production.",
                task=Patrol(
                    route=(
                        polygon(
                            id="round_ben_nw",
                            corners=(
                                Coordinates(x=-18.0, y=8.0, z=0.0),
                                Coordinates(x=-14.0, y=8.0, z=0.0),
                                Coordinates(x=-14.0, y=12.0, z=0.0),
                                Coordinates(x=-18.0, y=12.0, z=0.0),
                            ),
                        ),
                        polygon(
                            id="round_ben_w",
                            corners=(
                                Coordinates(x=-18.0, y=-2.0, z=0.0),
                                Coordinates(x=-14.0, y=-2.0, z=0.0),
                                Coordinates(x=-14.0, y=2.0, z=0.0),
                                Coordinates(x=-18.0, y=2.0, z=0.0),
                            ),
                        ),
                        polygon(
                            id="round_ben_m",
                            corners=(
                                Coordinates(x=-2.0, y=-2.0, z=0.0),
                                Coordinates(x=2.0, y=-2.0, z=0.0),
                                Coordinates(x=2.0, y=2.0, z=0.0),
                                Coordinates(x=-2.0, y=2.0, z=0.0),
                            ),
                        ),
                        polygon(
                            id="round_ben_e",
                            corners=(
                                Coordinates(x=14.0, y=-2.0, z=0.0),
                                Coordinates(x=18.0, y=-2.0, z=0.0),
                                Coordinates(x=18.0, y=2.0, z=0.0),
                                Coordinates(x=14.0, y=2.0, z=0.0),
                            ),
                        ),
                        polygon(
                            id="round_ben_ne",
                            corners=(
                                Coordinates(x=14.0, y=8.0, z=0.0),
                                Coordinates(x=18.0, y=8.0, z=0.0),
                                Coordinates(x=18.0, y=12.0, z=0.0),
                                Coordinates(x=14.0, y=12.0, z=0.0),
                            ),
                        ),
                    ),
                    period=60,
                ),
                messages=(
                    Message(
                        id="round_ben_ben",
                        sender="ben",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="round_cleo",
                name="Round of Cleo",
                members=("cleo",),
                grace=10,
                requirements=("D2",),
                severity=4,
                rationale="Chosen for this example: a late pallet stops no production.",
                task=Patrol(
                    route=(
                        polygon(
                            id="round_cleo_se",
                            corners=(
                                Coordinates(x=14.0, y=-12.0, z=0.0),
                                Coordinates(x=18.0, y=-12.0, z=0.0),
                                Coordinates(x=18.0, y=-8.0, z=0.0),
                                Coordinates(x=14.0, y=-8.0, z=0.0),
                            ),
                        ),
                        polygon(
                            id="round_cleo_dock",
                            corners=(
                                Coordinates(x=-18.0, y=-12.0, z=0.0),
                                Coordinates(x=-14.0, y=-12.0, z=0.0),
                                Coordinates(x=-14.0, y=-8.0, z=0.0),
                                Coordinates(x=-18.0, y=-8.0, z=0.0),
                            ),
                        ),
                        polygon(
                            id="round_cleo_w",
                            corners=(
                                Coordinates(x=-18.0, y=-2.0, z=0.0),
                                Coordinates(x=-14.0, y=-2.0, z=0.0),
                                Coordinates(x=-14.0, y=2.0, z=0.0),
                                Coordinates(x=-18.0, y=2.0, z=0.0),
                            ),
                        ),
                        polygon(
                            id="round_cleo_m",
                            corners=(
                                Coordinates(x=-2.0, y=-2.0, z=0.0),
                                Coordinates(x=2.0, y=-2.0, z=0.0),
                                Coordinates(x=2.0, y=2.0, z=0.0),
                                Coordinates(x=-2.0, y=2.0, z=0.0),
                            ),
                        ),
                        polygon(
                            id="round_cleo_e",
                            corners=(
                                Coordinates(x=14.0, y=-2.0, z=0.0),
                                Coordinates(x=18.0, y=-2.0, z=0.0),
                                Coordinates(x=18.0, y=2.0, z=0.0),
                                Coordinates(x=14.0, y=2.0, z=0.0),
                            ),
                        ),
                    ),
                    period=60,
                ),
                messages=(
                    Message(
                        id="round_cleo_cleo",
                        sender="cleo",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="temperatures",
                name="Temperatures of the cold store",
                members=("dan",),
                grace=5,
                requirements=("D3",),
                severity=6,
                rationale="Chosen for this example: food that was too warm is thrown away.",
                area=polygon(
                    id="temperatures_area",
                    corners=(
                        Coordinates(x=-14.0, y=17.0, z=0.0),
                        Coordinates(x=10.0, y=17.0, z=0.0),
                        Coordinates(x=10.0, y=23.0, z=0.0),
                        Coordinates(x=-2.0, y=23.0, z=0.0),
                        Coordinates(x=-2.0, y=29.0, z=0.0),
                        Coordinates(x=-14.0, y=29.0, z=0.0),
                    ),
                ),
                task=GatherSamples(target_sample_number=450, sensor="dan_thermometer"),
                messages=(
                    Message(
                        id="temperatures_dan",
                        sender="dan",
                        receiver="base",
                        body=(MessageData(name="TEMPERATURE", type="Int"),),
                    ),
                ),
            ),
            Goal(
                id="store",
                name="Stay in the cold store",
                members=("dan",),
                grace=5,
                requirements=("D3",),
                severity=3,
                rationale="Chosen for this example: open doors cost energy.",
                task=Stay(
                    area=polygon(
                        id="store_area",
                        corners=(
                            Coordinates(x=-14.0, y=17.0, z=0.0),
                            Coordinates(x=10.0, y=17.0, z=0.0),
                            Coordinates(x=10.0, y=23.0, z=0.0),
                            Coordinates(x=-2.0, y=23.0, z=0.0),
                            Coordinates(x=-2.0, y=29.0, z=0.0),
                            Coordinates(x=-14.0, y=29.0, z=0.0),
                        ),
                    ),
                ),
            ),
        ),
    )
