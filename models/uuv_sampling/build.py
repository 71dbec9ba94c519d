"""Build the paper's mission and its fault pool with the static classes of the metamodels.

``python models/uuv_sampling/build.py`` writes ``mission.xmi`` and ``faults.xmi`` beside this
script, byte for byte as Eclipse would; another folder may be named as its only argument.

References
----------
Source paper, section IV-A, Figures 3 and 5, Tables I and II.
"""

import sys
from pathlib import Path

from generated.metamodel import faults as f
from generated.metamodel import mission as m
from m2t.models.write import dumps, write_atomically

GPS, DEPTH = m.SensorType.GPS_POSITION, m.SensorType.DEPTH
TEMPERATURE, PRESSURE = m.SensorType.TEMPERATURE, m.SensorType.PRESSURE


def area(identity: str, radius: float, x: float = 0, y: float = 0, z: float = 0) -> m.Area:
    """Return a disc around a centre."""
    return m.Area(ID=identity, radius=radius, center=m.Coordinates(x=x, y=y, z=z))


def sensor(identity: str, name: str, kind: m.SensorType) -> m.Sensor:
    """Return a sensor; all of them sample alike."""
    return m.Sensor(ID=identity, name=name, type=kind, energyPerSample=2, samplesPerSecond=5)


def batteries(robot: str, **energies: float) -> list[m.Battery]:
    """Return two batteries of a robot, by ID."""
    return [
        m.Battery(ID=identity, name=f"{order} battery of {robot}", totalEnergy=energy)
        for order, (identity, energy) in zip(("First", "Second"), energies.items(), strict=True)
    ]


def thruster(identity: str, robot: str) -> m.MotionSource:
    """Return the motion source of a robot."""
    return m.MotionSource(ID=identity, name=f"Thruster of {robot}", energyPerDistanceUnit=5)


len_ = m.Robot(
    ID="r1",
    name="LEN",
    speed=5,
    position=m.Coordinates(x=250, y=-250, z=1),
    sensors=[
        sensor("s1", "GPS sensor of LEN", GPS),
        pressure := sensor("s2", "Pressure sensor of LEN", PRESSURE),
    ],
    batteries=batteries("LEN", b1=20_000, b2=80_000),
    motionSources=[thruster("ms1", "LEN")],
)
jen = m.Robot(
    ID="r2",
    name="JEN",
    speed=4,
    position=m.Coordinates(x=-250, y=250, z=1),
    sensors=[
        sensor("s3", "GPS sensor of JEN", GPS),
        temperature := sensor("s4", "Temperature sensor of JEN", TEMPERATURE),
    ],
    batteries=batteries("JEN", b3=4_000, b4=60_000),
    motionSources=[thruster("ms2", "JEN")],
)
kal = m.Robot(
    ID="r3",
    name="KAL",
    speed=4,
    position=m.Coordinates(x=250, y=250, z=1),
    sensors=[
        kal_gps := sensor("s5", "GPS sensor of KAL", GPS),
        depth := sensor("s6", "Depth sensor of KAL", DEPTH),
    ],
    batteries=batteries("KAL", b5=50_000, b6=50_000),
    motionSources=[thruster("ms3", "KAL")],
)
team = [jen, kal, len_]
server = m.Server(ID="sv1", name="Offshore server")

obstacles = [
    m.Obstacle(ID="o1", area=area("a7", 50, 0, 500, 1)),
    o2 := m.Obstacle(ID="o2", area=area("a8", 40, 500, 500, 1)),
    m.Obstacle(ID="o3", area=area("a9", 45, 500, 0, 1)),
    m.Obstacle(ID="o4", area=area("a10", 25, 500, -500, 1)),
    o5 := m.Obstacle(ID="o5", area=area("a11", 30, 0, -500, 1)),
    m.Obstacle(ID="o6", area=area("a12", 28, -500, -500, 1)),
    m.Obstacle(ID="o7", area=area("a13", 45, -500, 0, 1)),
    m.Obstacle(ID="o8", area=area("a14", 15, -500, 500, 1)),
]


def message(identity: str, sender: m.Robot, **body: str) -> m.Message:
    """Return a report of a robot to the server; ``body`` gives names and types."""
    entries = [m.MessageData(name=name, type=type_) for name, type_ in body.items()]
    return m.Message(ID=identity, header="h", sender=sender, receiver=server, body=entries)


def position(identity: str, sender: m.Robot) -> m.Message:
    """Return a report of a robot's position."""
    return message(identity, sender, POSITION="Coordinates")


def state(identity: str, sender: m.Robot) -> m.Message:
    """Return a report of what the forecast of a robot's energy needs."""
    return message(identity, sender, POSITION="Coordinates", SPEED="Int", ENERGY="Double")


avoid_collision = m.Goal(
    ID="g1",
    name="AvoidCollision",
    members=team,
    area=area("a1", 4, 600, -200),
    task=m.AvoidCollision(robots=team, obstacles=obstacles),
    messages=[
        position("m1", jen),
        m2 := position("m2", kal),
        m3 := position("m3", len_),
    ],
)
stay_within = m.Goal(
    ID="g2",
    name="StayWithinMissionArea",
    members=team,
    area=area("a2", 11, -800, 450, 1),
    task=m.StayWithinMissionArea(),
    messages=[
        m4 := position("m4", jen),
        position("m5", kal),
        position("m6", len_),
    ],
)
sufficient_energy = m.Goal(
    ID="g3",
    name="SufficientEnergy",
    members=team,
    area=area("a3", 1000),
    task=m.SufficientEnergy(),
    messages=[m7 := state("m7", jen), m8 := state("m8", kal), m9 := state("m9", len_)],
)
gather_temperatures = m.Goal(
    ID="g4",
    name="GatherSamples",
    members=[jen],
    area=area("a4", 150, -250, 250, 1),
    task=m.GatherSamples(targetSampleNumber=250, sensor=temperature),
    messages=[m10 := message("m10", jen, TEMPERATURE="Int")],
)
gather_depths = m.Goal(
    ID="g5",
    name="GatherSamples",
    members=[kal],
    area=area("a5", 150, 250, 250, 1),
    task=m.GatherSamples(targetSampleNumber=400, sensor=depth),
    messages=[m11 := message("m11", kal, DEPTH="Double")],
)
gather_pressures = m.Goal(
    ID="g6",
    name="GatherSamples",
    members=[len_],
    area=area("a6", 150, 250, -250, 1),
    task=m.GatherSamples(targetSampleNumber=500, sensor=pressure),
    messages=[m12 := message("m12", len_, PRESSURE="Double")],
)

mission = m.Mission(
    name="1000",
    duration=1000,
    missionArea=area("a15", 2000),
    robots=[len_, jen, kal],
    servers=[server],
    obstacles=obstacles,
    goals=[
        avoid_collision,
        stay_within,
        sufficient_energy,
        gather_temperatures,
        gather_depths,
        gather_pressures,
    ],
)


def fault(identity: str, kind: f.FaultType) -> f.Fault:
    """Return a fault of the pool; its type stands in the containment named after it."""
    result = f.Fault(ID=identity, name=identity)
    class_name = type(kind).__name__
    setattr(result, class_name[0].lower() + class_name[1:], kind)
    return result


pool = [
    fault("f1", f.ActivateSensor(affectedSensor=pressure)),
    fault("f2", f.BlockMessage(affectedMessage=m4, BLOCK_DURATION=5)),
    fault("f3", f.DeactivateSensor(affectedSensor=kal_gps)),
    fault("f4", f.DecrementRemainingEnergyCapacityReport(affectedMessage=m8, PERCENTAGE=10)),
    fault("f5", f.DecrementSampleRate(affectedMessage=m11, VAL=2)),
    fault("f6", f.DecrementSensorEnergyPerSample(affectedMessage=m9, PERCENTAGE=10)),
    fault("f7", f.DecrementSpeed(affectedMessage=m7, VAL=1)),
    fault("f8", f.DelayMessage(affectedMessage=m10, DELAY=200)),
    fault("f9", f.FixedObstacleCoordinates(affectedObstacle=o5, NEW_X=200, NEW_Y=-450, NEW_Z=1)),
    fault("f10", f.FixedRemainingEnergyCapacityReport(affectedMessage=m8, FIXED_VAL=150)),
    fault("f11", f.FixedRobotCoordinates(affectedMessage=m2, NEW_X=1200, NEW_Y=-800, NEW_Z=1)),
    fault("f12", f.FixedSampleRate(affectedMessage=m8, FIXED_VAL=120)),
    fault("f13", f.FixedSensorEnergyPerSample(affectedMessage=m9, FIXED_VAL=10)),
    fault("f14", f.FixedSpeed(affectedMessage=m7, FIXED_VAL=50)),
    fault("f15", f.IncrementRemainingEnergyCapacityReport(affectedMessage=m8, PERCENTAGE=10)),
    fault("f16", f.IncrementSampleRate(affectedMessage=m11, VAL=25)),
    fault("f17", f.IncrementSensorEnergyPerSample(affectedMessage=m7, PERCENTAGE=22)),
    fault("f18", f.IncrementSpeed(affectedMessage=m7, VAL=10)),
    fault("f19", f.RandomObstacleCoordinates(affectedObstacle=o2)),
    fault(
        "f20",
        f.RandomRemainingEnergyCapacityReport(
            affectedMessage=m8, LOWER_BOUND=255, UPPER_BOUND=1000
        ),
    ),
    fault("f21", f.RandomRobotCoordinates(affectedMessage=m3)),
    fault("f22", f.RandomSampleRate(affectedMessage=m10, LOWER_BOUND=1, UPPER_BOUND=50)),
    fault("f23", f.RandomSensorEnergyPerSample(affectedMessage=m7, LOWER_BOUND=11, UPPER_BOUND=30)),
    fault("f24", f.RandomSpeed(affectedMessage=m8, LOWER_BOUND=-8, UPPER_BOUND=8)),
    fault("f25", f.StartRobot(affectedRobot=kal)),
    fault("f26", f.StopRobot(affectedRobot=len_)),
    fault("f27", f.ZeroRemainingEnergyCapacityReport(affectedMessage=m8)),
    fault("f28", f.ZeroSampleRate(affectedMessage=m12)),
    fault("f29", f.ZeroSensorEnergyPerSample(affectedMessage=m7)),
    fault("f30", f.ZeroSpeed(affectedMessage=m9)),
]
specification = f.FaultSpecification(ID="fs", faults=pool)


def main(folder: Path) -> None:
    """Write both models into a folder."""
    write_atomically(folder / "mission.xmi", dumps(mission))
    hrefs = {mission: "mission.xmi"}
    write_atomically(folder / "faults.xmi", dumps(specification, hrefs=hrefs))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
