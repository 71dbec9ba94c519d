"""Write, check, fly and search a warehouse of six robots, eleven goals and all nine tasks."""

import os
import sys

import mrsfi
from generated.metamodel import faults as f
from generated.metamodel import mission as m

POSITION = {"POSITION": "Coordinates"}
STATE = {**POSITION, "SPEED": "Int", "ENERGY": "Double"}
SAMPLES = {**POSITION, "TEMPERATURE": "Int"}
HEAT = m.SensorType.TEMPERATURE
PLACES = [(0, 0), (-60, 0), (0, 60), (60, 0), (-30, -60), (-10, -60)]


def at(x: float, y: float) -> m.Coordinates:
    """Return a place on the floor."""
    return m.Coordinates(x=x, y=y)


def disc(name: str, x: float, y: float, radius: float) -> m.Area:
    """Return a part of the floor."""
    return m.Area(ID=name, center=at(x, y), radius=radius)


def robot(k: int) -> m.Robot:
    """Return a carrier with a thermometer."""
    carrier = m.Robot(ID=f"carrier_{k}", name=f"Carrier {k}", speed=1, position=at(*PLACES[k - 1]))
    carrier.sensors.append(m.Sensor(ID=f"heat_{k}", name="Heat", type=HEAT, samplesPerSecond=1))
    carrier.batteries.append(m.Battery(ID=f"battery_{k}", name="Battery", totalEnergy=5_000))
    source = m.MotionSource(ID=f"wheels_{k}", name="Wheels", energyPerDistanceUnit=1)
    carrier.motionSources.append(source)
    return carrier


team = [robot(k) for k in range(1, 7)]
desk = m.Server(ID="desk", name="Dispatcher's desk")
racks = [m.Obstacle(ID=f"rack_{y}", area=disc(f"shelves_{y}", 30, y, 4)) for y in (25, 50)]
goals: list[m.Goal] = []


def goal(
    name: str, task: m.GoalTask, body: dict[str, str], *members: m.Robot, area: m.Area | None = None
) -> None:
    """Add a goal, to which each of its members reports."""
    goals.append(m.Goal(ID=name, name=name, members=members, task=task, area=area))
    for member in members:
        report = m.Message(ID=f"{name}_of_{member.ID}", sender=member, receiver=desk)
        report.body.extend(m.MessageData(name=field, type=kind) for field, kind in body.items())
        goals[-1].messages.append(report)


def samples(of: m.Robot) -> m.GatherSamples:
    """Return the task to measure how warm it is."""
    return m.GatherSamples(sensor=of.sensors[0], targetSampleNumber=20)


one, two, three, four, five, six = team
dock, cold = disc("dock_area", 0, 0, 25), disc("cold_room", 0, 60, 10)
goal("collide", m.AvoidCollision(robots=team, obstacles=racks), POSITION, *team)
goal("floor", m.StayWithinMissionArea(), POSITION, *team)
goal("charge", m.SufficientEnergy(), STATE, *team)
goal("warm", samples(one), SAMPLES, one, area=dock)
goal("dock", m.Patrol(area=disc("ramp", 0, 0, 25), period=200), POSITION, one)
goal("shelf", m.Visit(coordinates=at(-60, 40), tolerance=2, deadline=200), POSITION, two)
goal("bell", m.Visit(coordinates=at(-60, -40), tolerance=2, deadline=450), POSITION, two)
goal("cold", samples(three), SAMPLES, three, area=cold)
goal("guard", m.Stay(area=disc("gate", 0, 60, 10)), POSITION, three)
goal("aisle", m.Track(trajectory=[at(60, 0), at(60, 60)], tolerance=5), POSITION, four)
goal("tow", m.FixedDistanceBetweenRobots(fixedDistance=20, tolerance=2), POSITION, five, six)
warehouse = m.Mission(
    name="warehouse",
    duration=500,
    missionArea=disc("hall", 0, 0, 100),
    robots=team,
    servers=[desk],
    obstacles=racks,
    goals=goals,
)
pool = f.FaultSpecification(ID="pool", faults=[])
for each in team:
    stop = f.StopRobot(affectedRobot=each)
    pool.faults.append(f.Fault(ID=f"stop_{each.ID}", name="Stop", stopRobot=stop))
for message in goals[0].messages:
    late = f.DelayMessage(affectedMessage=message, DELAY=20)
    pool.faults.append(f.Fault(ID=f"late_{message.sender.ID}", name="Late", delayMessage=late))

os.chdir(sys.argv[1])
mrsfi.write_models("models/warehouse", warehouse, pool)
mission = mrsfi.load("warehouse")
mission.generate()
for found in mission.validate():
    print(found)
print(mission.fly().violations("true"))
campaign = mission.evolve(population=10, generations=4, faults=4)
print(*(f"{weakness.goal}: {' '.join(weakness.faults)}" for weakness in campaign.ways), sep="\n")
