"""A mission in which everything stands at a limit, or a hair's breadth from it."""

from tests.independent.crowd import FAULTS, MISSION

_ROBOTS = """
<robots ID="{id}" name="" speed="{speed}"><position x="{x!r}" y="{y!r}"/>
<sensors ID="{id}_sensor" name="" type="DEPTH" energyPerSample="1.0" samplesPerSecond="1"/>
<batteries ID="{id}_battery" name="" totalEnergy="{energy!r}"/></robots>
"""
_GOAL = """
<goals ID="{id}" name="" members="{members}">{area}
<task xsi:type="mission:{task}"{more}>{content}</task>
<messages ID="m_{id}" sender="{sender}" receiver="base">
<body name="POSITION" type="Coordinates"/></messages></goals>
"""
_FALSE = """
<faults ID="f_{id}" name=""><fixedRobotCoordinates NEW_X="{x!r}" NEW_Y="{y!r}">
<affectedMessage href="mission.xmi#m_{id}"/></fixedRobotCoordinates></faults>
"""
DURATION = 12


def limits(off: float) -> tuple[str, str]:
    """Write a mission of robots that stand still, and a pool that moves some in belief.

    Parameters
    ----------
    off
        How far everything is beyond its limit: a share of the limit, below 0 if short of it.
    """
    f = 1 + off
    places = {
        "near": (0.0, 0.0), "nearer": (2 * f, 0.0),  # discs that touch
        "beside": (-50.0, 6 * f),  # an obstacle of radius 5
        "edge": (0.0, 100 * f), "brink": (99.9 * f, 0.0),  # the mission area, and well inside
        "guard": (30 + 10 * f, 30.0), "warden": (30.0, 30 + 9.99 * f),
        "guest": (60.0, 2 * f), "still": (70.0, 1e-9 * f),
        "walker": (-30.0, -30.0), "dweller": (30.0, -30.0),
        "left": (-80.0, 40.0), "right": (-60 + 5 * f, 40.0),
        "over": (-80.0, 50.0), "under": (-60 + 2.5 * f, 50.0), "short": (-80.0, 68 + off - 0.5 * f),
        "diver": (-60 + 10 * f, -60.0), "drained": (20.0, -70.0), "mover": (0.0, -40.0),
        "calm": (0.0, 60.0), "wary": (3.0 + off, 60.0),
        "star": (-20.0, 0.0),
    }  # fmt: skip
    speeds = {"mover": 1.0, "star": 1.0}
    robots = "".join(
        _ROBOTS.format(
            id=name, x=x, y=y, speed=speeds.get(name, 0.0),
            energy=DURATION * f if name == "drained" else 1000.0,
        )
        for name, (x, y) in places.items()
    )  # fmt: skip
    rocks = {"rock": (-50.0, 0.0, 5.0)} | {
        f"ray{n}": (-20.0 + dx, dy, 2.0)
        for n, (dx, dy) in enumerate(((7, 0), (0, 7), (-7, 0), (0, -7)))
    }
    obstacles = "".join(
        f'<obstacles ID="{name}"><area ID="{name}_area" radius="{radius}">'
        f'<center x="{x}" y="{y}"/></area></obstacles>'
        for name, (x, y, radius) in rocks.items()
    )

    def area(x: float, y: float, radius: float, name: str) -> str:
        return f'<area ID="{name}" radius="{radius}"><center x="{x}" y="{y}"/></area>'

    goals = [
        ("touch", "AvoidCollision", "near nearer", ' robots="near nearer"', "", ""),
        ("graze", "AvoidCollision", "beside", ' robots="beside" obstacles="rock"', "", ""),
        ("shy", "AvoidCollision", "calm wary", ' robots="calm wary"', "", ""),
        ("rays", "AvoidCollision", "star",
         ' robots="star" obstacles="ray0 ray1 ray2 ray3"', "", ""),
        ("inside", "StayWithinMissionArea", "edge brink", "", "", ""),
        ("round", "Patrol", "guard warden", ' period="3"', area(30, 30, 10, "beat"), ""),
        ("call", "Visit", "guest", ' tolerance="2.0" deadline="4"', '<coordinates x="60.0"/>', ""),
        ("dot", "Visit", "still",
         ' tolerance="1e-12" deadline="12"', '<coordinates x="70.0"/>', ""),
        ("path", "Track", "walker", ' tolerance="3.0"',
         '<trajectory x="-30.0" y="-30.0"/><trajectory x="-10.0" y="-30.0"/>', ""),
        ("home", "Stay", "dweller", "", area(30, -30, 10, "hearth"), ""),
        ("rod", "FixedDistanceBetweenRobots", "left right",
         ' fixedDistance="20.0" tolerance="5.0"', "", ""),
        ("rods", "FixedDistanceBetweenRobots", "over under",
         ' fixedDistance="20.0" tolerance="5.0"', "", ""),
        ("rodlet", "FixedDistanceBetweenRobots", "over short",
         ' fixedDistance="20.0" tolerance="5.0"', "", ""),
        ("sound", "GatherSamples", "diver", ' targetSampleNumber="1" sensor="diver_sensor"', "",
         area(-60, -60, 10, "deep")),
        ("all", "GatherSamples", "mover",
         f' targetSampleNumber="{DURATION}" sensor="mover_sensor"', "", area(0, -40, 50, "wide")),
        ("fuel", "SufficientEnergy", "drained near", "", "", ""),
    ]  # fmt: skip
    text = "".join(
        _GOAL.format(
            id=name, task=task, members=members, more=more, content=content, area=place,
            sender=members.split()[0],
        )
        for name, task, members, more, content, place in goals
    )  # fmt: skip
    content = f'{robots}<servers ID="base" name=""/>{obstacles}{text}'
    false = [("path", -20.0, -30 + 3 * f), ("home", 30 + 10 * f, -30.0), ("sound", -60.0, -50.0)]
    pool = "".join(_FALSE.format(id=name, x=x, y=y) for name, x, y in false)
    mission = MISSION.format(duration=DURATION, radius=100.0, x=0.0, y=0.0, content=content)
    return mission, FAULTS.format(content=pool)
