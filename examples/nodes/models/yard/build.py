"""Build the mission of the huskies and its pool of faults: mission.xmi and faults.xmi beside it."""

from pathlib import Path

import mrsfi
from generated.metamodel import faults as f
from generated.metamodel import mission as m

FIELDS = {"POSITION": "Coordinates", "SPEED": "Int", "ENERGY": "Double"}


def disc(name: str, x: float, y: float, radius: float) -> m.Area:
    """Return a part of the yard."""
    return m.Area(ID=name, center=m.Coordinates(x=x, y=y), radius=radius)


def husky(number: int, x: float, y: float) -> m.Robot:
    """Return a robot that gets 400 metres far on one charge."""
    name = f"husky{number}"
    return m.Robot(
        ID=name,
        name=name,
        speed=1,
        position=m.Coordinates(x=x, y=y),
        batteries=[m.Battery(ID=f"{name}_battery", name="Battery", totalEnergy=400)],
        motionSources=[m.MotionSource(ID=f"{name}_wheels", name="Wheels", energyPerDistanceUnit=1)],
    )


def report(sender: m.Robot) -> m.Message:
    """Return what the office hears of a robot."""
    body = [m.MessageData(name=name, type=kind) for name, kind in FIELDS.items()]
    return m.Message(ID=f"report_{sender.ID}", sender=sender, receiver=office, body=body)


one, two, three = team = [husky(1, -40, 0), husky(2, 40, 0), husky(3, 0, -45)]
office = m.Server(ID="office", name="Office")
silos = [
    m.Obstacle(ID="silo1", area=disc("silo1_base", 0, 0, 10)),
    m.Obstacle(ID="silo2", area=disc("silo2_base", -15, 25, 5)),
]
energy = [report(each) for each in team]
goals = [
    m.Goal(
        ID="collide",
        name="Collide with nothing",
        members=team,
        task=m.AvoidCollision(robots=team, obstacles=silos),
    ),
    m.Goal(ID="fence", name="Stay inside the fence", members=team, task=m.StayWithinMissionArea()),
    m.Goal(
        ID="energy",
        name="Last until the end of the shift",
        members=team,
        task=m.SufficientEnergy(),
        messages=energy,
    ),
    m.Goal(
        ID="gate",
        name="Look after the gate",
        members=[one],
        task=m.Patrol(area=disc("gate_area", -40, -20, 6), period=180),
    ),
    m.Goal(
        ID="dock",
        name="Look after the dock",
        members=[two],
        task=m.Patrol(area=disc("dock_area", 40, -20, 6), period=180),
    ),
    m.Goal(
        ID="depot",
        name="Be at the depot in time",
        members=[three],
        task=m.Visit(coordinates=m.Coordinates(x=0, y=40), tolerance=5, deadline=160),
    ),
]
mission = m.Mission(
    name="yard",
    duration=300,
    missionArea=disc("yard_area", 0, 0, 60),
    robots=team,
    servers=[office],
    obstacles=silos,
    goals=goals,
)

first, second, third = energy
faults = f.FaultSpecification(
    ID="pool",
    faults=[
        f.Fault(
            ID="f1",
            name="GPS of husky1 sticks",
            fixedRobotCoordinates=f.FixedRobotCoordinates(
                affectedMessage=first, NEW_X=-20, NEW_Y=-40, NEW_Z=0
            ),
        ),
        f.Fault(
            ID="f2",
            name="GPS of husky2 jumps",
            randomRobotCoordinates=f.RandomRobotCoordinates(affectedMessage=second),
        ),
        f.Fault(
            ID="f3",
            name="GPS of husky3 sticks",
            fixedRobotCoordinates=f.FixedRobotCoordinates(
                affectedMessage=third, NEW_X=10, NEW_Y=-40, NEW_Z=0
            ),
        ),
        f.Fault(
            ID="f4",
            name="Reports of husky1 are late",
            delayMessage=f.DelayMessage(affectedMessage=first, DELAY=10),
        ),
        f.Fault(
            ID="f5",
            name="Reports of husky2 are lost",
            blockMessage=f.BlockMessage(affectedMessage=second, BLOCK_DURATION=40),
        ),
        f.Fault(
            ID="f6",
            name="Reports of husky3 are lost",
            blockMessage=f.BlockMessage(affectedMessage=third, BLOCK_DURATION=20),
        ),
        f.Fault(
            ID="f7",
            name="Battery of husky1 seems empty",
            zeroRemainingEnergyCapacityReport=f.ZeroRemainingEnergyCapacityReport(
                affectedMessage=first
            ),
        ),
        f.Fault(
            ID="f8",
            name="Battery of husky2 seems fuller",
            incrementRemainingEnergyCapacityReport=f.IncrementRemainingEnergyCapacityReport(
                affectedMessage=second, PERCENTAGE=50
            ),
        ),
        f.Fault(
            ID="f9",
            name="Husky3 seems faster",
            incrementSpeed=f.IncrementSpeed(affectedMessage=third, VAL=1),
        ),
        f.Fault(ID="f10", name="Husky2 stops", stopRobot=f.StopRobot(affectedRobot=two)),
    ],
)

mrsfi.write_models(Path(__file__).parent, mission, faults)
