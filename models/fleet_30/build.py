"""Build a fleet of squads of ten robots, and its fault pool, with the static classes.

``python models/fleet_30/build.py`` writes ``mission.xmi`` and ``faults.xmi`` beside this script,
byte for byte as Eclipse would; a folder and a number of robots may be named as its arguments:
``python models/fleet_30/build.py models/fleet_300 300`` makes ten times as large a fleet.

Each squad patrols an area of its own around a reef; one robot of it gathers samples, and one
visits a buoy first. No robot of one squad comes near another squad unless a fault leads it there.
"""

import sys
from math import ceil, sqrt
from pathlib import Path

from generated.metamodel import faults as f
from generated.metamodel import mission as m
from m2t.models.write import dumps, write_atomically

DURATION = 300
SQUAD = 10
SPACING = 480.0  # between the centres of neighbouring squads
RADIUS = 200.0  # of a squad's area
SPEED, MAX_SPEED = 1.5, 5.0
PER_DISTANCE = 3.0
NEED = DURATION * SPEED * PER_DISTANCE
RESERVE = 1.1
BASE = m.Server(ID="base", name="Base")


def area(identity: str, radius: float, x: float, y: float) -> m.Area:
    """Return a disc around a centre."""
    return m.Area(ID=identity, radius=radius, center=m.Coordinates(x=x, y=y))


def sensor(robot: str, kind: m.SensorType) -> m.Sensor:
    """Return a sensor; what it costs is in the reserve."""
    identity = f"{robot}_{kind.name.lower()}"
    return m.Sensor(ID=identity, name=identity, type=kind, energyPerSample=0, samplesPerSecond=1)


def robot(squad: int, place: int, x: float, y: float) -> m.Robot:
    """Return a robot of a squad; the first one can measure temperatures."""
    identity = f"q{squad}r{place}"
    kinds = [m.SensorType.GPS_POSITION, m.SensorType.TEMPERATURE][: 1 if place else 2]
    return m.Robot(
        ID=identity,
        name=f"robot {place} of squad {squad}",
        speed=SPEED,
        maxSpeed=MAX_SPEED,
        position=m.Coordinates(x=x, y=y),
        sensors=[sensor(identity, kind) for kind in kinds],
        batteries=[m.Battery(ID=f"{identity}_battery", name="battery", totalEnergy=NEED * RESERVE)],
        motionSources=[
            m.MotionSource(ID=f"{identity}_motor", name="motor", energyPerDistanceUnit=PER_DISTANCE)
        ],
    )


def report(goal: str, sender: m.Robot, **body: str) -> m.Message:
    """Return a report of a robot to the base; ``body`` gives names and types."""
    entries = [m.MessageData(name=name, type=type_) for name, type_ in body.items()]
    return m.Message(ID=f"{goal}_{sender.ID}", sender=sender, receiver=BASE, body=entries)


def positions(goal: str, senders: list[m.Robot]) -> list[m.Message]:
    """Return reports of where robots are."""
    return [report(goal, each, POSITION="Coordinates") for each in senders]


def squad_goals(squad: int, team: list[m.Robot], x: float, y: float) -> list[m.Goal]:
    """Return the goals of one squad; what visits comes before what never lets go of a robot."""
    first, second = team[:2]
    buoy, samples, rounds = (f"q{squad}_{name}" for name in ("buoy", "samples", "rounds"))
    return [
        m.Goal(
            ID=buoy,
            name=f"Buoy of squad {squad}",
            members=[second],
            task=m.Visit(coordinates=m.Coordinates(x=x, y=y + 120), tolerance=15, deadline=200),
            messages=positions(buoy, [second]),
        ),
        m.Goal(
            ID=rounds,
            name=f"Rounds of squad {squad}",
            members=team,
            task=m.Patrol(area=area(f"{rounds}_area", RADIUS, x, y), period=20),
            messages=positions(rounds, team),
        ),
        m.Goal(
            ID=samples,
            name=f"Samples of squad {squad}",
            members=[first],
            area=area(f"{samples}_area", 1.2 * RADIUS, x, y),
            task=m.GatherSamples(targetSampleNumber=DURATION // 2, sensor=first.sensors[1]),
            messages=[report(samples, first, TEMPERATURE="Int")],
        ),
    ]


def kind(place: int, robot: m.Robot, move: m.Message, state: m.Message) -> f.FaultType:
    """Return the fault of a robot, of ten types in turn."""
    types: list[f.FaultType] = [
        f.FixedRobotCoordinates(affectedMessage=move, NEW_X=0, NEW_Y=0),
        f.DeactivateSensor(affectedSensor=robot.sensors[0]),
        f.StopRobot(affectedRobot=robot),
        f.RandomRobotCoordinates(affectedMessage=move),
        f.DelayMessage(affectedMessage=move, DELAY=30),
        f.BlockMessage(affectedMessage=move, BLOCK_DURATION=30),
        f.FixedSpeed(affectedMessage=state, FIXED_VAL=5),
        f.ZeroSpeed(affectedMessage=state),
        f.ZeroRemainingEnergyCapacityReport(affectedMessage=state),
        f.IncrementRemainingEnergyCapacityReport(affectedMessage=state, PERCENTAGE=50),
    ]
    return types[place % len(types)]


def models(n_robots: int) -> tuple[m.Mission, f.FaultSpecification]:
    """Return the mission of so many robots, in whole squads, and its pool."""
    side = ceil(sqrt(n_robots / SQUAD))
    half = (side - 1) / 2 * SPACING
    robots, obstacles, goals = [], [], []
    for squad in range(n_robots // SQUAD):
        x, y = SPACING * (squad % side) - half, SPACING * (squad // side) - half
        team = [
            robot(squad, k, x + 40 * (k % 5) - 80, y + (80 if k < 5 else 40)) for k in range(SQUAD)
        ]
        robots += team
        obstacles.append(
            m.Obstacle(ID=f"q{squad}_reef", area=area(f"q{squad}_reef_area", 10, x, y))
        )
        goals += squad_goals(squad, team, x, y)
    moves = positions("clear", robots)
    states = [
        report("energy", each, POSITION="Coordinates", SPEED="Int", ENERGY="Double")
        for each in robots
    ]
    clear = m.AvoidCollision(robots=robots, obstacles=obstacles)
    mission = m.Mission(
        name=f"Fleet of {n_robots}",
        duration=DURATION,
        missionArea=area("whole", sqrt(2) * half + 2 * RADIUS, 0, 0),
        robots=robots,
        servers=[BASE],
        obstacles=obstacles,
        goals=[
            m.Goal(ID="clear", name="AvoidCollision", members=robots, task=clear, messages=moves),
            m.Goal(
                ID="within",
                name="StayWithinMissionArea",
                members=robots,
                task=m.StayWithinMissionArea(),
            ),
            m.Goal(
                ID="energy",
                name="SufficientEnergy",
                members=robots,
                task=m.SufficientEnergy(),
                messages=states,
            ),
            *goals,
        ],
    )
    pool = []
    for number, each in enumerate(zip(robots, moves, states, strict=True)):
        # One squad's types are shifted against the next one's, so that they strike other places.
        struck = kind(number + number // SQUAD, *each)
        fault = f.Fault(ID=f"f{number + 1}", name=f"f{number + 1}")
        class_name = type(struck).__name__
        setattr(fault, class_name[0].lower() + class_name[1:], struck)
        pool.append(fault)
    return mission, f.FaultSpecification(ID="pool", faults=pool)


def main(folder: Path, n_robots: int) -> None:
    """Write both models into a folder, which is made."""
    folder.mkdir(parents=True, exist_ok=True)
    mission, pool = models(n_robots)
    write_atomically(folder / "mission.xmi", dumps(mission))
    write_atomically(folder / "faults.xmi", dumps(pool, hrefs={mission: "mission.xmi"}))


if __name__ == "__main__":
    given = sys.argv[1:]
    main(
        Path(given[0]) if given else Path(__file__).parent, int(given[1]) if len(given) > 1 else 30
    )
