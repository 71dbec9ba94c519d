"""A crowd: so many robots and obstacles that nobody looks at all of them, and hardly any room.

What a look-up leaves out that is near, or puts where it is not, shows in a crowd at once.
"""

from itertools import cycle
from random import Random

_XMI = 'xmi:version="2.0" xmlns:xmi="http://www.omg.org/XMI"'
MISSION = f"""<?xml version="1.0" encoding="ASCII"?>
<mission:Mission {_XMI} xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" \
xmlns:mission="http://mrsfi.org/mission/1.0" name="crowd" duration="{{duration}}">
<missionArea ID="whole" radius="{{radius}}"><center x="{{x}}" y="{{y}}"/></missionArea>
{{content}}</mission:Mission>
"""
FAULTS = f"""<?xml version="1.0" encoding="ASCII"?>
<faults:FaultSpecification {_XMI} xmlns:faults="http://mrsfi.org/faults/1.0" ID="pool">
{{content}}</faults:FaultSpecification>
"""
_GOAL = (
    '<goals ID="{id}" name="" members="{members}"><task xsi:type="mission:{task}"{more}/>'
    "{messages}</goals>\n"
)


def draw_crowd(rng: Random, n_robots: int, room: float) -> tuple[str, str]:
    """Draw a mission, and faults that move all of it in belief; each robot has so much room.

    Members of AvoidCollision are shuffled, so that none stands at its own number. A second goal
    concerns some of the robots and obstacles only.
    """
    side = room * n_robots**0.5 / 2

    def place() -> str:
        x, y = (rng.uniform(-side, side) for _ in "xy")
        return f'x="{x - 40:.3f}" y="{y + 25:.3f}"'

    robots, hazards = [f"r{n}" for n in range(n_robots)], [f"o{n}" for n in range(20)]
    turns = cycle((' turnRate="12.5" positionNoise="0.8"', "", ' turnRate="90.0"', ""))
    text = "".join(
        f'<robots ID="{robot}" name="" speed="{rng.choice((0.0, 1.0, 2.5, 4.0))}" maxSpeed="6.0"'
        f"{next(turns)}>"
        f'<position {place()}/><batteries ID="{robot}b" name="" totalEnergy="900.0"/>'
        f'<motionSources ID="{robot}d" name="" energyPerDistanceUnit="1.0"/></robots>\n'
        for robot in robots
    )
    text += '<servers ID="base" name=""/>\n'
    text += "".join(
        f'<obstacles ID="{hazard}"><area ID="{hazard}a" radius="{rng.choice((0.5, 2.0, 7.0))}">'
        f"<center {place()}/></area></obstacles>\n"
        for hazard in hazards
    )
    messages = "".join(
        f'<messages ID="m{robot}" sender="{robot}" receiver="base">'
        '<body name="POSITION" type="Coordinates"/><body name="SPEED" type="Double"/></messages>'
        for robot in robots
    )
    for n, share in enumerate((1.0, 0.9, 0.3)):
        some = [rng.sample(each, round(share * len(each))) for each in (robots, hazards)]
        more = f' robots="{" ".join(some[0])}" obstacles="{" ".join(some[1])}"'
        text += _GOAL.format(
            id=f"clear{n}", members=" ".join(robots), task="AvoidCollision", more=more,
            messages="" if n else messages,
        )  # fmt: skip
    for task in ("StayWithinMissionArea", "SufficientEnergy"):
        text += _GOAL.format(id=task, members=" ".join(robots), task=task, more="", messages="")
    mission = MISSION.format(x=-40.0, y=25.0, duration=40, radius=1.2 * side, content=text)

    kinds = ["randomRobotCoordinates", "zeroSpeed", 'blockMessage BLOCK_DURATION="8.0"']
    kinds += ['delayMessage DELAY="3.0"', *(f"fixedRobotCoordinates {place()}" for _ in range(3))]
    struck = [(f"{kind}", "Message", f"m{rng.choice(robots)}") for kind in kinds]
    kinds = [
        "randomObstacleCoordinates",
        *(f"fixedObstacleCoordinates {place()}" for _ in range(4)),
    ]
    struck += [(kind, "Obstacle", rng.choice(hazards)) for kind in (*kinds, kinds[0])]
    pool = "".join(
        f'<faults ID="f{n}" name=""><{_upper(kind)}><affected{what} href="mission.xmi#{target}"/>'
        f"</{kind.split()[0]}></faults>\n"
        for n, (kind, what, target) in enumerate(struck)
    )
    return mission, FAULTS.format(content=pool)


def _upper(kind: str) -> str:
    """Return the start of an element, its place in the words of faults."""
    return kind.replace(' x="', ' NEW_X="').replace(' y="', ' NEW_Y="')
