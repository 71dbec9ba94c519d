"""Build a mission that is tight on energy, and its fault pool, with the static classes.

``python models/tight_energy/build.py`` writes ``mission.xmi`` and ``faults.xmi`` beside this
script, byte for byte as Eclipse would; another folder may be named as its only argument.

Each of three robots has energy for the whole mission and two and a half per cent more: who flies
faster than nominal for long is truly exhausted before the end.
"""

import sys
from pathlib import Path

from generated.metamodel import faults as f
from generated.metamodel import mission as m
from m2t.models.write import dumps, write_atomically

DURATION = 400
SPEED = 4
PER_DISTANCE, PER_SAMPLE, SAMPLES, N_SENSORS = 5, 2, 5, 2
NEED = DURATION * (SPEED * PER_DISTANCE + N_SENSORS * SAMPLES * PER_SAMPLE)
RESERVE = 1.025


def area(identity: str, radius: float, x: float = 0, y: float = 0) -> m.Area:
    """Return a disc around a centre."""
    return m.Area(ID=identity, radius=radius, center=m.Coordinates(x=x, y=y))


def robot(identity: str, name: str, kind: m.SensorType, x: float, y: float) -> m.Robot:
    """Return a robot with a GPS and one other sensor; all of them cost alike."""
    sensors = [
        m.Sensor(
            ID=f"{identity}_{kind_.name.lower()}",
            name=f"{kind_.name} sensor of {name}",
            type=kind_,
            energyPerSample=PER_SAMPLE,
            samplesPerSecond=SAMPLES,
        )
        for kind_ in (m.SensorType.GPS_POSITION, kind)
    ]
    return m.Robot(
        ID=identity,
        name=name,
        speed=SPEED,
        position=m.Coordinates(x=x, y=y),
        sensors=sensors,
        batteries=[
            m.Battery(
                ID=f"{identity}_battery", name=f"Battery of {name}", totalEnergy=NEED * RESERVE
            )
        ],
        motionSources=[
            m.MotionSource(
                ID=f"{identity}_drive",
                name=f"Thruster of {name}",
                energyPerDistanceUnit=PER_DISTANCE,
            )
        ],
    )


ada = robot("e1", "ADA", m.SensorType.TEMPERATURE, -200, 0)
bob = robot("e2", "BOB", m.SensorType.DEPTH, 200, 0)
cem = robot("e3", "CEM", m.SensorType.PRESSURE, 0, 200)
team = [ada, bob, cem]
base = m.Server(ID="base", name="Base")
reef = m.Obstacle(ID="reef", area=area("reef_area", 40))
wreck = m.Obstacle(ID="wreck", area=area("wreck_area", 25, 0, -250))


def message(goal: str, sender: m.Robot, **body: str) -> m.Message:
    """Return a report of a robot to the server; ``body`` gives names and types."""
    entries = [m.MessageData(name=name, type=type_) for name, type_ in body.items()]
    return m.Message(
        ID=f"{goal}_{sender.ID}", header="h", sender=sender, receiver=base, body=entries
    )


def position(goal: str, sender: m.Robot) -> m.Message:
    """Return a report of a robot's position."""
    return message(goal, sender, POSITION="Coordinates")


def state(goal: str, sender: m.Robot) -> m.Message:
    """Return a report of what the forecast of a robot's energy needs."""
    return message(goal, sender, POSITION="Coordinates", SPEED="Int", ENERGY="Double")


clear = m.Goal(
    ID="clear",
    name="AvoidCollision",
    members=team,
    task=m.AvoidCollision(robots=team, obstacles=[reef, wreck]),
    messages=[clear_ada := position("clear", ada), clear_bob := position("clear", bob)],
)
within = m.Goal(
    ID="within",
    name="StayWithinMissionArea",
    members=team,
    task=m.StayWithinMissionArea(),
    messages=[position("within", cem)],
)
energy = m.Goal(
    ID="energy",
    name="SufficientEnergy",
    members=team,
    task=m.SufficientEnergy(),
    messages=[
        energy_ada := state("energy", ada),
        energy_bob := state("energy", bob),
        energy_cem := state("energy", cem),
    ],
)
temperatures = m.Goal(
    ID="temperatures",
    name="GatherSamples",
    members=[ada],
    area=area("temperatures_area", 80, -200),
    task=m.GatherSamples(targetSampleNumber=300, sensor=ada.sensors[1]),
    messages=[temperatures_ada := message("temperatures", ada, TEMPERATURE="Int")],
)
depths = m.Goal(
    ID="depths",
    name="GatherSamples",
    members=[bob],
    area=area("depths_area", 80, 200),
    task=m.GatherSamples(targetSampleNumber=340, sensor=bob.sensors[1]),
    messages=[depths_bob := message("depths", bob, DEPTH="Double")],
)
rounds = m.Goal(
    ID="rounds",
    name="Patrol",
    members=[cem],
    task=m.Patrol(area=area("rounds_area", 60, 0, 200), period=40),
    messages=[position("rounds", cem)],
)

mission = m.Mission(
    name="tight energy",
    duration=DURATION,
    missionArea=area("whole", 500),
    robots=team,
    servers=[base],
    obstacles=[reef, wreck],
    goals=[clear, within, energy, temperatures, depths, rounds],
)

KINDS: list[f.FaultType] = [
    f.ActivateSensor(affectedSensor=ada.sensors[1]),
    f.BlockMessage(affectedMessage=energy_cem, BLOCK_DURATION=100),
    f.DeactivateSensor(affectedSensor=bob.sensors[1]),
    f.DecrementRemainingEnergyCapacityReport(affectedMessage=energy_ada, PERCENTAGE=10),
    f.DecrementSampleRate(affectedMessage=depths_bob, VAL=3),
    f.DecrementSensorEnergyPerSample(affectedMessage=energy_cem, PERCENTAGE=20),
    f.DecrementSpeed(affectedMessage=energy_cem, VAL=1),
    f.DelayMessage(affectedMessage=temperatures_ada, DELAY=90),
    f.FixedObstacleCoordinates(affectedObstacle=wreck, NEW_X=-200, NEW_Y=0),
    f.FixedRemainingEnergyCapacityReport(affectedMessage=energy_bob, FIXED_VAL=150),
    f.FixedRobotCoordinates(affectedMessage=clear_ada, NEW_X=100, NEW_Y=-100),
    f.FixedSampleRate(affectedMessage=energy_bob, FIXED_VAL=50),
    f.FixedSensorEnergyPerSample(affectedMessage=energy_cem, FIXED_VAL=10),
    f.FixedSpeed(affectedMessage=energy_ada, FIXED_VAL=20),
    f.IncrementRemainingEnergyCapacityReport(affectedMessage=energy_cem, PERCENTAGE=10),
    f.IncrementSampleRate(affectedMessage=temperatures_ada, VAL=25),
    f.IncrementSensorEnergyPerSample(affectedMessage=energy_ada, PERCENTAGE=22),
    f.IncrementSpeed(affectedMessage=energy_bob, VAL=2),
    f.RandomObstacleCoordinates(affectedObstacle=reef),
    f.RandomRemainingEnergyCapacityReport(
        affectedMessage=energy_ada, LOWER_BOUND=255, UPPER_BOUND=20_000
    ),
    f.RandomRobotCoordinates(affectedMessage=clear_bob),
    f.RandomSampleRate(affectedMessage=depths_bob, LOWER_BOUND=1, UPPER_BOUND=50),
    f.RandomSensorEnergyPerSample(affectedMessage=energy_bob, LOWER_BOUND=1, UPPER_BOUND=30),
    f.RandomSpeed(affectedMessage=energy_cem, LOWER_BOUND=-8, UPPER_BOUND=8),
    f.StartRobot(affectedRobot=ada),
    f.StopRobot(affectedRobot=bob),
    f.ZeroRemainingEnergyCapacityReport(affectedMessage=energy_cem),
    f.ZeroSampleRate(affectedMessage=temperatures_ada),
    f.ZeroSensorEnergyPerSample(affectedMessage=energy_ada),
    f.ZeroSpeed(affectedMessage=energy_bob),
]


def fault(identity: str, kind: f.FaultType) -> f.Fault:
    """Return a fault of the pool; its type stands in the containment named after it."""
    result = f.Fault(ID=identity, name=identity)
    class_name = type(kind).__name__
    setattr(result, class_name[0].lower() + class_name[1:], kind)
    return result


specification = f.FaultSpecification(
    ID="pool", faults=[fault(f"f{number}", kind) for number, kind in enumerate(KINDS, 1)]
)


def main(folder: Path) -> None:
    """Write both models into a folder."""
    write_atomically(folder / "mission.xmi", dumps(mission))
    write_atomically(folder / "faults.xmi", dumps(specification, hrefs={mission: "mission.xmi"}))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
