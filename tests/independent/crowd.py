"""A crowd: so many robots and obstacles that nobody looks at all of them, and hardly any room.

What a look-up leaves out that is near, or puts where it is not, shows in a crowd at once.
"""

from itertools import cycle
from random import Random

from generated.metamodel import faults as f
from generated.metamodel import mission as m
from tests.support.models.builder import area, fault, goal, message, point, pool, robot


def draw_crowd(rng: Random, n_robots: int, room: float) -> tuple[m.Mission, f.FaultSpecification]:
    """Draw a mission, and faults that move all of it in belief; each robot has so much room.

    Members of AvoidCollision are shuffled, so that none stands at its own number. A second goal
    concerns some of the robots and obstacles only.
    """
    side = room * n_robots**0.5 / 2

    def place() -> m.Coordinates:
        x, y = (rng.uniform(-side, side) for _ in "xy")
        return point(round(x - 40, 3), round(y + 25, 3))

    turns = cycle(({"turnRate": 12.5, "positionNoise": 0.8}, {}, {"turnRate": 90.0}, {}))
    widths = cycle(({}, {"radius": 0.25}, {"radius": 3.5}, {}, {"radius": 1.0}))
    robots = []
    for n in range(n_robots):
        speed = rng.choice((0.0, 1.0, 2.5, 4.0))
        odd = next(turns) | next(widths)
        robots.append(robot(f"r{n}", place(), speed, 900.0, 1.0, maxSpeed=6.0, **odd))
    base = m.Server(ID="base", name="")

    def rock(name: str) -> m.Area:
        far, at = rng.choice((0.5, 2.0, 7.0)), place()
        if rng.random() < 0.8:
            return area(name, far, at)
        spots = ((-far, -far), (far, -far), (far, far), (0.25 * far, 0.0), (-far, far))
        return m.Area(ID=name, corners=[point(at.x + x, at.y + y) for x, y in spots])

    hazards = [m.Obstacle(ID=f"o{n}", area=rock(f"o{n}a")) for n in range(20)]
    reports = [message(f"m{r.ID}", r, base, POSITION="Coordinates", SPEED="Double") for r in robots]
    goals = []
    for n, share in enumerate((1.0, 0.9, 0.3)):
        some, near = (rng.sample(each, round(share * len(each))) for each in (robots, hazards))
        task = m.AvoidCollision(robots=some, obstacles=near, **({"clearance": 1.5} if n else {}))
        goals.append(goal(f"clear{n}", task, robots, messages=[] if n else reports))
    most = n_robots - 2
    goals += [goal("inside", m.StayWithinMissionArea(), robots, requiredMembers=most)]
    goals += [goal("energy", m.SufficientEnergy(), robots, requiredMembers=most // 2)]
    mission = m.Mission(
        name="crowd",
        duration=40,
        missionArea=area("whole", 1.2 * side, point(-40.0, 25.0)),
        robots=robots,
        servers=[base],
        obstacles=hazards,
        goals=goals,
    )

    def moved() -> dict[str, float]:
        at = place()
        return {"NEW_X": at.x, "NEW_Y": at.y}

    false = [("RandomRobotCoordinates", {}), ("ZeroSpeed", {})]
    false += [("BlockMessage", {"BLOCK_DURATION": 8.0}), ("DelayMessage", {"DELAY": 3.0})]
    false += [("FixedRobotCoordinates", moved()) for _ in range(3)]
    struck = [(kind, rng.choice(reports), values) for kind, values in false]
    false = [("RandomObstacleCoordinates", {})]
    false += [("FixedObstacleCoordinates", moved()) for _ in range(4)]
    struck += [(kind, rng.choice(hazards), values) for kind, values in (*false, false[0])]
    faults = (fault(f"f{n}", kind, at, **values) for n, (kind, at, values) in enumerate(struck))
    return mission, pool(faults)
