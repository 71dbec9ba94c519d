"""A mission in which everything stands at a limit, or a hair's breadth from it."""

from typing import Any

from generated.metamodel import faults as f
from generated.metamodel import mission as m
from tests.support.models.builder import area, fault, goal, message, point, pool, robot, sensor

DURATION = 12


def limits(off: float) -> tuple[m.Mission, f.FaultSpecification]:
    """Write a mission of robots that stand still, and a pool that moves some in belief.

    Parameters
    ----------
    off
        How far everything is beyond its limit: a share of the limit, below 0 if short of it.
    """
    by = 1 + off
    places = {
        "near": (0.0, 0.0), "nearer": (2 * by, 0.0),  # discs that touch
        "beside": (-50.0, 6 * by),  # an obstacle of radius 5
        "edge": (0.0, 100 * by), "brink": (99.9 * by, 0.0),  # the mission area, and well inside
        "guard": (30 + 10 * by, 30.0), "warden": (30.0, 30 + 9.99 * by),
        "guest": (60.0, 2 * by), "still": (70.0, 1e-9 * by),
        "walker": (-30.0, -30.0), "dweller": (30.0, -30.0),
        "left": (-80.0, 40.0), "right": (-60 + 5 * by, 40.0),
        "over": (-80.0, 50.0), "under": (-60 + 2.5 * by, 50.0),
        "short": (-80.0, 68 + off - 0.5 * by),
        "diver": (-60 + 10 * by, -60.0), "drained": (20.0, -70.0), "mover": (0.0, -40.0),
        "calm": (0.0, 60.0), "wary": (3.0 + off, 60.0),
        "star": (-20.0, 0.0),
        "broad": (-40.0, -80.0), "thin": (-40.0, -80 + 4 * by), "aside": (-50.0, -7.75 * by),
    }  # fmt: skip
    radii = {"broad": 2.0, "thin": 0.5, "aside": 1.25}
    speeds = {"mover": 1.0, "star": 1.0}
    robots = {
        name: robot(
            name, point(x, y), speeds.get(name, 0.0),
            DURATION * by if name == "drained" else 1000.0,
            sensors=[sensor(f"{name}_sensor", "DEPTH")],
            **({"radius": radii[name]} if name in radii else {}),
        )
        for name, (x, y) in places.items()
    }  # fmt: skip
    rocks = {"rock": (-50.0, 0.0, 5.0)} | {
        f"ray{n}": (-20.0 + dx, dy, 2.0)
        for n, (dx, dy) in enumerate(((7.0, 0.0), (0.0, 7.0), (-7.0, 0.0), (0.0, -7.0)))
    }
    obstacles = {
        name: m.Obstacle(ID=name, area=area(f"{name}_area", radius, point(x, y)))
        for name, (x, y, radius) in rocks.items()
    }

    def near(names: str, *hazards: str, **more: float) -> m.AvoidCollision:
        some, rocks = [robots[name] for name in names.split()], [obstacles[n] for n in hazards]
        return m.AvoidCollision(robots=some, obstacles=rocks, **more)

    def keep(tolerance: float = 5.0) -> m.FixedDistanceBetweenRobots:
        return m.FixedDistanceBetweenRobots(fixedDistance=20.0, tolerance=tolerance)

    def sampled(name: str, number: int) -> m.GatherSamples:
        return m.GatherSamples(targetSampleNumber=number, sensor=robots[name].sensors[0])

    goals: list[tuple[str, str, Any, m.Area | None]] = [
        ("touch", "near nearer", near("near nearer"), None),
        ("graze", "beside", near("beside", "rock"), None),
        ("shy", "calm wary", near("calm wary"), None),
        ("room", "broad thin", near("broad thin", clearance=1.5), None),
        ("berth", "aside", near("aside", "rock", clearance=1.5), None),
        ("rays", "star", near("star", "ray0", "ray1", "ray2", "ray3"), None),
        ("inside", "edge brink", m.StayWithinMissionArea(), None),
        ("round", "guard warden", m.Patrol(period=3, area=area("beat", 10.0, point(30.0, 30.0))),
         None),
        ("call", "guest", m.Visit(tolerance=2.0, deadline=4, coordinates=point(60.0)), None),
        ("dot", "still", m.Visit(tolerance=1e-12, deadline=12, coordinates=point(70.0)), None),
        ("path", "walker",
         m.Track(tolerance=3.0, trajectory=[point(-30.0, -30.0), point(-10.0, -30.0)]), None),
        ("home", "dweller", m.Stay(area=area("hearth", 10.0, point(30.0, -30.0))), None),
        ("rod", "left right", keep(), None),
        ("rods", "over under", keep(), None),
        ("rodlet", "over short", keep(), None),
        ("sound", "diver", sampled("diver", 1), area("deep", 10.0, point(-60.0, -60.0))),
        ("all", "mover", sampled("mover", DURATION), area("wide", 50.0, point(0.0, -40.0))),
        ("fuel", "drained near", m.SufficientEnergy(), None),
    ]  # fmt: skip
    base = m.Server(ID="base", name="")
    made = {}
    for name, words, task, place in goals:
        members = [robots[each] for each in words.split()]
        report = message(f"m_{name}", members[0], base, POSITION="Coordinates")
        made[name] = goal(name, task, members, area=place, messages=[report])
    mission = m.Mission(
        name="limits",
        duration=DURATION,
        missionArea=area("whole", 100.0),
        robots=[*robots.values()],
        servers=[base],
        obstacles=[*obstacles.values()],
        goals=[*made.values()],
    )
    false = [("path", -20.0, -30 + 3 * by), ("home", 30 + 10 * by, -30.0), ("sound", -60.0, -50.0)]
    return mission, pool(
        fault(f"by{name}", "FixedRobotCoordinates", made[name].messages[0], NEW_X=x, NEW_Y=y)
        for name, x, y in false
    )
