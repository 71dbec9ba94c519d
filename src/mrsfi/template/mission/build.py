"""Build the mission and its pool of faults: two carriers, a rack between them and their goals.

``make models`` runs it, and writes ``mission.xmi`` and ``faults.xmi`` beside it.
"""

from pathlib import Path

import mrsfi
from generated.metamodel import faults as f
from generated.metamodel import mission as m


def disc(name: str, x: float, y: float, radius: float) -> m.Area:
    """Return a part of the floor."""
    return m.Area(ID=name, center=m.Coordinates(x=x, y=y), radius=radius)


def carrier(name: str, x: float, y: float) -> m.Robot:
    """Return a robot that is driven by a battery."""
    return m.Robot(
        ID=name,
        name=name,
        speed=1,
        position=m.Coordinates(x=x, y=y),
        batteries=[m.Battery(ID=f"{name}_battery", name="Battery", totalEnergy=400)],
        motionSources=[m.MotionSource(ID=f"{name}_wheels", name="Wheels", energyPerDistanceUnit=1)],
    )


def report(name: str, sender: m.Robot, **fields: str) -> m.Message:
    """Return what a robot tells the desk for a goal."""
    body = [m.MessageData(name=field, type=kind) for field, kind in fields.items()]
    return m.Message(ID=f"{name}_{sender.ID}", sender=sender, receiver=desk, body=body)


left, right = team = [carrier("left", -60, 0), carrier("right", 60, 0)]
desk = m.Server(ID="desk", name="Desk")
rack = m.Obstacle(ID="rack", area=disc("shelves", 0, 0, 8))
goals = [
    m.Goal(
        ID="collide",
        name="Collide with nobody",
        members=team,
        task=m.AvoidCollision(robots=team, obstacles=[rack]),
        messages=[report("collide", robot, POSITION="Coordinates") for robot in team],
    ),
    m.Goal(
        ID="floor",
        name="Stay on the floor",
        members=team,
        task=m.StayWithinMissionArea(),
        messages=[report("floor", robot, POSITION="Coordinates") for robot in team],
    ),
    m.Goal(
        ID="energy",
        name="Have enough energy",
        members=team,
        task=m.SufficientEnergy(),
        messages=[
            report("energy", robot, POSITION="Coordinates", SPEED="Int", ENERGY="Double")
            for robot in team
        ],
    ),
    m.Goal(
        ID="deliver",
        name="Bring the left load to the right",
        members=[left],
        task=m.Visit(coordinates=m.Coordinates(x=60, y=20), tolerance=2, deadline=200),
        messages=[report("deliver", left, POSITION="Coordinates")],
    ),
    m.Goal(
        ID="fetch",
        name="Fetch the right load to the left",
        members=[right],
        task=m.Visit(coordinates=m.Coordinates(x=-60, y=-20), tolerance=2, deadline=200),
        messages=[report("fetch", right, POSITION="Coordinates")],
    ),
]
mission = m.Mission(
    name="@name@",
    duration=300,
    missionArea=disc("hall", 0, 0, 100),
    robots=team,
    servers=[desk],
    obstacles=[rack],
    goals=goals,
)

collide, _, energy, deliver, _ = goals
faults = f.FaultSpecification(
    ID="pool",
    faults=[
        f.Fault(ID="f1", name="Left stops", stopRobot=f.StopRobot(affectedRobot=left)),
        f.Fault(ID="f2", name="Right stops", stopRobot=f.StopRobot(affectedRobot=right)),
        f.Fault(
            ID="f3",
            name="Left is believed elsewhere",
            fixedRobotCoordinates=f.FixedRobotCoordinates(
                affectedMessage=collide.messages[0], NEW_X=0, NEW_Y=60, NEW_Z=0
            ),
        ),
        f.Fault(
            ID="f4",
            name="Reports of right are late",
            delayMessage=f.DelayMessage(affectedMessage=collide.messages[1], DELAY=20),
        ),
        f.Fault(
            ID="f5",
            name="Reports of left are lost",
            blockMessage=f.BlockMessage(affectedMessage=deliver.messages[0], BLOCK_DURATION=50),
        ),
        f.Fault(
            ID="f6",
            name="Left seems slow",
            decrementSpeed=f.DecrementSpeed(affectedMessage=energy.messages[0], VAL=1),
        ),
        f.Fault(
            ID="f7",
            name="Right seems exhausted",
            zeroRemainingEnergyCapacityReport=f.ZeroRemainingEnergyCapacityReport(
                affectedMessage=energy.messages[1]
            ),
        ),
        f.Fault(
            ID="f8",
            name="The rack is believed elsewhere",
            fixedObstacleCoordinates=f.FixedObstacleCoordinates(
                affectedObstacle=rack, NEW_X=0, NEW_Y=80, NEW_Z=0
            ),
        ),
    ],
)

mrsfi.write_models(Path(__file__).parent, mission, faults)
