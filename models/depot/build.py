"""Build the depot, a mission of four vehicles among racks, and its fault pool.

``python models/depot/build.py`` writes ``mission.xmi`` and ``faults.xmi`` beside this script, byte
for byte as Eclipse would; another folder may be named as its argument. A unit of distance is a
metre, a tick a second.

Three trucks go round the two blocks of racks, one way: Ada and Ben round the north block, Cleo
round the south block and past the dock. All three pass the middle aisle eastwards, 18 s or more
apart. No straight way from one area of a route to the next meets a rack. Dan measures temperatures
in the cold store.
"""

import sys
from pathlib import Path

from generated.metamodel import faults as f
from generated.metamodel import mission as m
from m2t.models.write import dumps, write_atomically

DURATION = 600
PACE, MAX_SPEED = 0.6, 1.0  # m/s, of a truck
SLOW = 0.4  # m/s, of the cold store's vehicle
PER_METRE = 60.0  # J
RESERVE = 1.1
BASE = m.Server(ID="base", name="Depot server")

Corners = list[tuple[float, float]]

WALLS: dict[str, Corners] = {
    "rack_north": [(-12, 3), (12, 3), (12, 7), (-12, 7)],
    # Open to the middle aisle, where goods are picked.
    "rack_south": [
        (-12, -7),
        (12, -7),
        (12, -3),
        (6, -3),
        (6, -5),
        (-6, -5),
        (-6, -3),
        (-12, -3),
    ],
    "dock_wall": [(-22, -15), (-8, -15), (-8, -20), (-7, -20), (-7, -14), (-22, -14)],
}
PILLARS = {"pillar_west": (-21.0, 5.0), "pillar_east": (21.0, -5.0)}
GATES = {"w": (-16, 0), "m": (0, 0), "e": (16, 0), "ne": (16, 10), "nw": (-16, 10), "se": (16, -10)}
"""Places in aisles and where they cross: squares of 4 m about these points."""

DOCK: Corners = [(-18, -12), (-14, -12), (-14, -8), (-18, -8)]
COLD: Corners = [(-14, 17), (10, 17), (10, 23), (-2, 23), (-2, 29), (-14, 29)]

WHY = "Chosen for this example: "


def polygon(identity: str, corners: Corners) -> m.Area:
    """Return a polygon."""
    return m.Area(ID=identity, corners=[m.Coordinates(x=x, y=y) for x, y in corners])


def disc(identity: str, radius: float, x: float, y: float) -> m.Area:
    """Return a disc around a centre."""
    return m.Area(ID=identity, radius=radius, center=m.Coordinates(x=x, y=y))


def route(goal: str, names: str) -> list[m.Area]:
    """Return areas to enter in order, of their names with blanks between."""
    areas = []
    for name in names.split():
        if name == "dock":
            corners = DOCK
        else:
            x, y = GATES[name]
            corners = [(x + dx, y + dy) for dx, dy in ((-2, -2), (2, -2), (2, 2), (-2, 2))]
        areas.append(polygon(f"{goal}_{name}", corners))
    return areas


def obstacles() -> list[m.Obstacle]:
    """Return racks, wall and pillars."""
    walls = [
        m.Obstacle(ID=name, area=polygon(f"{name}_area", corners))
        for name, corners in WALLS.items()
    ]
    pillars = [
        m.Obstacle(ID=name, area=disc(f"{name}_area", 0.4, x, y))
        for name, (x, y) in PILLARS.items()
    ]
    return walls + pillars


def sensor(identity: str, name: str, kind: m.SensorType, cost: float, rate: int) -> m.Sensor:
    """Return a sensor."""
    return m.Sensor(ID=identity, name=name, type=kind, energyPerSample=cost, samplesPerSecond=rate)


def vehicle(name: str, x: float, y: float, **features: float) -> m.Robot:
    """Return a vehicle with positioning and a battery; only Dan's has a thermometer."""
    identity = name.lower()
    positioning = sensor(
        f"{identity}_positioning", f"Positioning of {name}", m.SensorType.GPS_POSITION, 0.5, 2
    )
    sensors = [positioning]
    power = features["speed"] * PER_METRE + 1.0
    if identity == "dan":
        kind = m.SensorType.TEMPERATURE
        sensors.append(sensor("dan_thermometer", "Thermometer of Dan", kind, 1.0, 3))
        power += 3.0
    battery = m.Battery(
        ID=f"{identity}_battery", name=f"Battery of {name}", totalEnergy=DURATION * power * RESERVE
    )
    motor = m.MotionSource(
        ID=f"{identity}_motor", name=f"Motor of {name}", energyPerDistanceUnit=PER_METRE
    )
    robot = m.Robot(
        ID=identity,
        name=name,
        position=m.Coordinates(x=x, y=y),
        sensors=sensors,
        batteries=[battery],
        motionSources=[motor],
    )
    for feature, value in features.items():
        setattr(robot, feature, value)
    return robot


def report(goal: str, sender: m.Robot, **body: str) -> m.Message:
    """Return a report of a vehicle to the server; ``body`` gives names and types."""
    entries = [m.MessageData(name=name, type=type_) for name, type_ in body.items()]
    return m.Message(ID=f"{goal}_{sender.ID}", sender=sender, receiver=BASE, body=entries)


def round_of(truck: m.Robot, names: str, requirement: m.Requirement) -> m.Goal:
    """Return the goal of a truck to go round, from area to area."""
    identity = f"round_{truck.ID}"
    return m.Goal(
        ID=identity,
        name=f"Round of {truck.name}",
        members=[truck],
        grace=10,
        task=m.Patrol(route=route(identity, names), period=60),
        messages=[report(identity, truck, POSITION="Coordinates")],
        requirements=[requirement],
        severity=4,
        rationale=WHY + "a late pallet stops no production.",
    )


def build() -> m.Mission:
    """Return the mission."""
    truck = {
        "speed": PACE,
        "maxSpeed": MAX_SPEED,
        "turnRate": 60.0,
        "positionNoise": 0.05,
        "radius": 0.6,
    }
    ada = vehicle("Ada", -19, 1, **truck)
    ben = vehicle("Ben", 16, 10, **truck)
    cleo = vehicle("Cleo", 16, -31, **truck)
    dan = vehicle("Dan", -8, 20, speed=SLOW, maxSpeed=1.0, radius=0.4)
    everyone = [ada, ben, cleo, dan]
    safe = m.Requirement(ID="D1", text="No vehicle touches a rack, a wall or another vehicle.")
    flow = m.Requirement(ID="D2", text="Each truck goes on to the next crossing within 70 s.")
    cold = m.Requirement(ID="D3", text="The temperature of the cold store is known.")
    hazards = obstacles()
    cold_area = polygon("temperatures_area", COLD)
    goals = [
        m.Goal(
            ID="clear",
            name="Keep clear",
            members=everyone,
            task=m.AvoidCollision(robots=everyone, obstacles=hazards, clearance=0.3),
            messages=[report("clear", each, POSITION="Coordinates") for each in everyone],
            requirements=[safe],
            severity=9,
            integrityLevel="SIL 2",
            rationale=WHY + "people may stand behind a rack.",
        ),
        m.Goal(
            ID="within",
            name="Stay in the depot",
            members=everyone,
            grace=3,
            task=m.StayWithinMissionArea(),
            severity=7,
            rationale=WHY + "a truck outside is in the traffic of the road.",
        ),
        m.Goal(
            ID="handover",
            name="Handover to Cleo",
            members=[cleo],
            task=m.Visit(coordinates=m.Coordinates(x=16, y=-22), tolerance=1.5, deadline=30),
            messages=[report("handover", cleo, POSITION="Coordinates")],
            severity=3,
            rationale=WHY + "the next vehicle takes the pallet.",
        ),
        m.Goal(
            ID="energy",
            name="Enough energy",
            members=everyone,
            task=m.SufficientEnergy(),
            messages=[
                report("energy", each, POSITION="Coordinates", SPEED="Int", ENERGY="Double")
                for each in everyone
            ],
            severity=5,
            rationale=WHY + "a truck without energy blocks an aisle.",
        ),
        round_of(ada, "w m e ne nw", flow),
        round_of(ben, "nw w m e ne", flow),
        round_of(cleo, "se dock w m e", flow),
        m.Goal(
            ID="temperatures",
            name="Temperatures of the cold store",
            members=[dan],
            area=cold_area,
            grace=5,
            task=m.GatherSamples(targetSampleNumber=450, sensor=dan.sensors[1]),
            messages=[report("temperatures", dan, TEMPERATURE="Int")],
            requirements=[cold],
            severity=6,
            rationale=WHY + "food that was too warm is thrown away.",
        ),
        m.Goal(
            ID="store",
            name="Stay in the cold store",
            members=[dan],
            grace=5,
            task=m.Stay(area=polygon("store_area", COLD)),
            requirements=[cold],
            severity=3,
            rationale=WHY + "open doors cost energy.",
        ),
    ]
    return m.Mission(
        name="Depot",
        duration=DURATION,
        distanceUnit="m",
        timeUnit="s",
        energyUnit="J",
        missionArea=disc("depot", 40, 0, 0),
        robots=everyone,
        servers=[BASE],
        obstacles=hazards,
        requirements=[safe, flow, cold],
        goals=goals,
    )


def pool(mission: m.Mission) -> f.FaultSpecification:
    """Return the faults that could strike the depot."""
    messages = {message.ID: message for goal in mission.goals for message in goal.messages}
    ada, ben, cleo, dan = mission.robots
    racks = {obstacle.ID: obstacle for obstacle in mission.obstacles}
    types: list[tuple[f.FaultType, float | None]] = [
        (f.FixedRobotCoordinates(affectedMessage=messages["clear_ada"], NEW_X=-20, NEW_Y=-9), None),
        (f.RandomRobotCoordinates(affectedMessage=messages["clear_ben"]), None),
        (f.DelayMessage(affectedMessage=messages["clear_ada"], DELAY=10), 0.05),
        (f.DelayMessage(affectedMessage=messages["clear_cleo"], DELAY=10), 0.05),
        (f.BlockMessage(affectedMessage=messages["clear_ben"], BLOCK_DURATION=20), 0.05),
        (f.BlockMessage(affectedMessage=messages["clear_dan"], BLOCK_DURATION=20), 0.05),
        (f.DeactivateSensor(affectedSensor=ada.sensors[0]), 0.01),
        (f.DeactivateSensor(affectedSensor=cleo.sensors[0]), 0.01),
        (f.StopRobot(affectedRobot=ada), 0.02),
        (f.StopRobot(affectedRobot=ben), 0.02),
        (f.StopRobot(affectedRobot=dan), 0.02),
        (f.StartRobot(affectedRobot=cleo), None),
        (f.FixedObstacleCoordinates(affectedObstacle=racks["rack_north"], NEW_X=0, NEW_Y=6), 0.001),
        (f.RandomObstacleCoordinates(affectedObstacle=racks["pillar_west"]), None),
        (f.FixedSpeed(affectedMessage=messages["energy_ada"], FIXED_VAL=2), None),
        (f.ZeroSpeed(affectedMessage=messages["energy_ben"]), None),
        (f.IncrementSpeed(affectedMessage=messages["energy_cleo"], VAL=1), None),
        (f.RandomSpeed(affectedMessage=messages["energy_dan"], LOWER_BOUND=0, UPPER_BOUND=3), None),
        (f.ZeroRemainingEnergyCapacityReport(affectedMessage=messages["energy_ada"]), 0.005),
        (
            f.IncrementRemainingEnergyCapacityReport(
                affectedMessage=messages["energy_ben"], PERCENTAGE=50
            ),
            None,
        ),
        (
            f.DecrementRemainingEnergyCapacityReport(
                affectedMessage=messages["energy_cleo"], PERCENTAGE=20
            ),
            None,
        ),
        (f.DeactivateSensor(affectedSensor=dan.sensors[1]), 0.01),
        (f.ZeroSampleRate(affectedMessage=messages["temperatures_dan"]), None),
        (f.DecrementSampleRate(affectedMessage=messages["temperatures_dan"], VAL=2), None),
        (
            f.IncrementSensorEnergyPerSample(
                affectedMessage=messages["temperatures_dan"], PERCENTAGE=50
            ),
            None,
        ),
        (f.DelayMessage(affectedMessage=messages["temperatures_dan"], DELAY=50), None),
    ]
    faults = []
    for number, (struck, likelihood) in enumerate(types, 1):
        fault = f.Fault(ID=f"f{number}", name=f"f{number}")
        if likelihood is not None:
            fault.likelihood = likelihood
        class_name = type(struck).__name__
        setattr(fault, class_name[0].lower() + class_name[1:], struck)
        faults.append(fault)
    return f.FaultSpecification(ID="pool", faults=faults)


def main(folder: Path) -> None:
    """Write both models into a folder, which is made."""
    folder.mkdir(parents=True, exist_ok=True)
    mission = build()
    write_atomically(folder / "mission.xmi", dumps(mission))
    write_atomically(folder / "faults.xmi", dumps(pool(mission), hrefs={mission: "mission.xmi"}))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if sys.argv[1:] else Path(__file__).parent)
