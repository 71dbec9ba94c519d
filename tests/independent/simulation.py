"""A second simulation of a mission, written from the documents and not from the code.

``docs/semantics.md`` (S) and ``docs/faults.md`` (F) promise that with them, the metamodels and a
mission's models "somebody who never saw our code can write the same simulation". This is it. It
imports nothing of the product and has nothing from it; it is plain and slow on purpose. Sections
and paragraphs that it follows are named in brackets, their sentences quoted.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations, product
from pathlib import Path
from typing import Any, NamedTuple

from lxml import etree

from tests.independent.polygon import middle, off_edges, off_way

METAMODEL = Path(__file__).parents[2] / "metamodels" / "faults.ecore"
WORD = 0xFFFFFFFF
DIRECTIONS = [(math.cos(math.radians(d)), math.sin(math.radians(d))) for d in range(360)]
FIRST_HEADING, SAMPLES, ROAMING, NOISE = 1, 2, 3, 13
PURPOSES = {"ENERGY": 4, "COST": 5, "SPEED": 6, "RATE": 7, "POSITION": 8, "OBSTACLE": 10}
PURPOSES["COUNT"] = 12
"""By the table of all draws in [S Randomness]; directions of places have the number after."""

Place = tuple[float, float, float]
Direction = tuple[float, float]


def added(numbers: Iterable[float]) -> float:
    total = 0.0  # "Sums are added in the order of the model, beginning with 0"
    for number in numbers:
        total += number
    return total


def mixed(v: int) -> int:
    v ^= v >> 16
    v = v * 0x7FEB352D & WORD
    v ^= v >> 15
    v = v * 0x846CA68B & WORD
    return v ^ v >> 16


class Weather:
    """Every draw is "a hash of mission seed, tick, entity and purpose" [S Randomness]."""

    def __init__(self, seed: int) -> None:
        self.key = mixed(seed & WORD) ^ 0x9E3779B9
        while seed := seed >> 32:  # "For each 32 bits of the seed, the lowest first"
            self.key = mixed(self.key ^ seed & WORD) ^ 0x9E3779B9

    def draw(self, tick: int, entity: int, purpose: int) -> int:
        return mixed(mixed(self.key ^ tick) ^ (256 * entity + purpose))

    def uniform(self, *key: int) -> float:
        return self.draw(*key) * 2.0**-32

    def choice(self, n: int, *key: int) -> int:
        return self.draw(*key) * n >> 32

    def between(self, low: float, high: float, tick: int, entity: int, prop: str) -> float:
        """Return a random value: [F Random values]."""
        key = tick, entity, PURPOSES[prop]
        if prop in ("ENERGY", "COST"):
            return low + (high - low) * self.uniform(*key)
        first, last = math.ceil(low), math.floor(high)
        return first + self.choice(max(last - first + 1, 1), *key)

    def direction(self, *key: int) -> Direction:
        return DIRECTIONS[self.choice(360, *key)]

    def scattered(self, place: Place, far: float, tick: int, entity: int, purpose: int) -> Place:
        """Return where something is put: "position + noise × √u × direction", and likewise."""
        far *= math.sqrt(self.uniform(tick, entity, purpose))
        return ahead(place, far, self.direction(tick, entity, purpose + 1))


def bounds_of_samples(n: int) -> list[int]:
    """Return the bounds of [S Motion, "Valid samples"], which each draw is held against."""
    bounds: list[int] = []
    p = total = (1 - 1 / n) ** n
    for k in range(n):
        if round(total * 2.0**32) >= 2**32:
            break
        bounds.append(round(total * 2.0**32))
        p *= (n - k) / ((k + 1) * (n - 1))
        total += p
    return bounds


def exceeds(value: float, limit: float) -> bool:
    return value - limit > 1e-9 * limit  # [S What counts as equal]


def falls_short(value: float, limit: float) -> bool:
    return limit - value > 1e-9 * limit


def distance(a: Sequence[float], b: Sequence[float]) -> float:
    dx, dy = b[0] - a[0], b[1] - a[1]
    return math.sqrt(dx * dx + dy * dy)


def within(value: float, low: float, high: float) -> float:
    return max(low, min(value, high))


def ahead(place: Place, way: float, direction: Direction) -> Place:
    return place[0] + way * direction[0], place[1] + way * direction[1], place[2]


class Disc(NamedTuple):  # or polygon, with its corners as offsets from the centre
    center: Place
    radius: float
    corners: Sequence[Direction] = ()

    def off(self, place: Sequence[float], center: Place | None = None) -> float:
        """Return "the distance from the centre", as [S Polygons] counts it."""
        x, y, _ = center or self.center
        if not self.corners:
            return distance((x, y), place)
        return self.radius + off_edges(self.corners, place[0] - x, place[1] - y)

    def has(self, place: Place) -> bool:
        return not exceeds(self.off(place), self.radius)

    def has_well(self, place: Place, leeway: float = 0.0) -> bool:
        if self.corners:
            return self.radius - self.off(place) >= 0.001 * -off_edges(self.corners, 0, 0) + leeway
        return distance(self.center, place) <= 0.999 * self.radius - leeway


class Sensor:  # absent features have "the default of their metamodel, 0 if that names none"
    def __init__(self, element: Any, index: int, robot: int) -> None:
        self.id, self.index, self.robot = element.get("ID"), index, robot
        self.type = element.get("type")
        self.cost = float(element.get("energyPerSample", 0))
        self.rate = int(element.get("samplesPerSecond", 0))
        self.bounds = [] if self.rate == 1 else bounds_of_samples(self.rate)


class Robot:  # [S What the model says]
    def __init__(self, element: Any, index: int, first_sensor: int) -> None:
        self.id, self.index = element.get("ID"), index
        self.speed = float(element.get("speed", 0))
        self.max_speed = float(element.get("maxSpeed", 2 * self.speed))
        self.turn_rate = float(element.get("turnRate", 180))
        self.noise = float(element.get("positionNoise", 0))
        half = math.sin(0.5 * math.radians(self.turn_rate))  # "1 / sin(turn rate / 2)"
        self.width = 1.0 if self.turn_rate == 180 else 1.0 / max(half, 1e-12)
        self.radius = float(element.get("radius", 1))
        self.position = place_of(element.find("position"))
        self.energy = added(float(each.get("totalEnergy", 0)) for each in element.iter("batteries"))
        drives = element.iter("motionSources")
        self.cost = added(float(each.get("energyPerDistanceUnit", 0)) for each in drives)
        sensors = enumerate(element.iter("sensors"), first_sensor)
        self.sensors = [Sensor(each, k, index) for k, each in sensors]
        self.gps = next((each for each in self.sensors if each.type == "GPS_POSITION"), None)


def turned(last: Direction, wanted: Direction, rate: float) -> Direction:
    """ "turned towards it by as much", and to the left for what is "straight behind"."""
    sine = last[0] * wanted[1] - last[1] * wanted[0]
    cosine = last[0] * wanted[0] + last[1] * wanted[1]
    angle = math.degrees(math.atan2(sine, cosine))
    if abs(angle) <= rate:
        return wanted
    is_behind = cosine < 0 and abs(sine) <= 1e-9
    way = math.radians(rate)
    c, s = math.cos(way), math.sin(way) if is_behind or angle > 0 else -math.sin(way)
    x, y = last[0] * c - last[1] * s, last[1] * c + last[0] * s
    length = distance((0, 0), (x, y))
    return x / length, y / length


def place_of(element: Any) -> Place:
    """ "a robot without `position` and a disc without `center` are at the origin"."""
    x, y, z = (0.0 if element is None else float(element.get(axis, 0)) for axis in "xyz")
    return x, y, z


def disc_of(element: Any) -> Disc:
    if element is None:
        return Disc((0.0, 0.0, 0.0), 0.0)
    corners = [place_of(each) for each in element.findall("corners")]
    given = element.find("center")
    center = place_of(given) if given is not None or not corners else middle(corners)
    offsets = [(x - center[0], y - center[1]) for x, y, _ in corners]
    far = max((distance((0, 0), each) for each in offsets), default=0.0)
    return Disc(center, float(element.get("radius", far)), offsets)


class Mission:
    """What mission.xmi says: all "numbered from 0, in the order of the model"."""

    def __init__(self, path: Path) -> None:
        root = etree.parse(path).getroot()
        self.duration = int(root.get("duration"))
        self.area = disc_of(root.find("missionArea"))
        self.areas = {
            each.get("ID"): disc_of(each) for each in root.iter("missionArea", "area", "route")
        }
        self.robots: list[Robot] = []
        self.sensors: list[Sensor] = []
        for element in root.findall("robots"):
            self.robots.append(Robot(element, len(self.robots), len(self.sensors)))
            self.sensors += self.robots[-1].sensors
        self.obstacles = [disc_of(each.find("area")) for each in root.findall("obstacles")]
        hazards = enumerate(root.findall("obstacles"))
        self.number = {each.id: each.index for each in (*self.robots, *self.sensors)}
        self.number |= {each.get("ID"): k for k, each in hazards}  # IDs are unique in a file
        self.goals = [Goal(self, each, k) for k, each in enumerate(root.findall("goals"))]
        self.messages = {each.get("ID"): each for each in root.iter("messages")}


class Goal:
    def __init__(self, mission: Mission, goal: Any, index: int) -> None:
        task = goal.find("task")
        self.id, self.index = goal.get("ID"), index
        self.task = task.get("{http://www.w3.org/2001/XMLSchema-instance}type").split(":")[1]
        self.members = [mission.number[name] for name in goal.get("members").split()]
        self.required = int(goal.get("requiredMembers", 0)) or len(self.members)
        self.grace = int(goal.get("grace", 0))
        # "AvoidCollision concerns the `robots` and `obstacles` of its task"
        self.robots = [mission.number[name] for name in task.get("robots", "").split()]
        self.obstacles = [mission.number[name] for name in task.get("obstacles", "").split()]
        # "GatherSamples uses the area of its goal, Patrol and Stay that of their task"
        area = (goal if self.task == "GatherSamples" else task).find("area")
        self.area = mission.area if area is None else disc_of(area)
        self.route = [disc_of(each) for each in task.findall("route")] or [self.area]
        self.sensor = mission.number.get(task.get("sensor"), -1)
        self.target = int(task.get("targetSampleNumber", 0))
        self.period = int(task.get("period", 0))
        self.deadline = int(task.get("deadline", 0))
        has_tolerance = self.task in ("Visit", "Track", "FixedDistanceBetweenRobots")
        self.tolerance = float(task.get("tolerance", has_tolerance))
        self.point = Disc(place_of(task.find("coordinates")), self.tolerance)
        self.trajectory = [place_of(each) for each in task.findall("trajectory")]
        self.distance = float(task.get("fixedDistance", 0))
        self.clearance = float(task.get("clearance", 0))
        own = (
            self.area if area is not None else self.route[0],
            disc_of(goal.find("area")),
            Disc(self.point.center, 0.0),
        )
        self.place = own[{"GatherSamples": 0, "Patrol": 0, "Stay": 0, "Visit": 2}.get(self.task, 1)]


class Notes:  # "Progress of goals is noted in belief and in truth on their own" [S Belief]
    def __init__(self, goal: Goal) -> None:
        self.count = 0  # of samples
        self.seen = 0  # count of the sensor, "when progress was noted last"
        self.counted_at: tuple[float, ...] = ()
        self.since = dict.fromkeys(goal.members, -1)
        self.reached = dict.fromkeys(goal.members, False)
        self.waypoint = dict.fromkeys(goal.members, 0)
        self.surely = dict.fromkeys(goal.members, 0)
        self.memory = [0.0] * 8


class View:  # what one side, truth or belief, knows at a tick
    def __init__(self, mission: Mission) -> None:
        """ "Both truth and belief are what the model says" [S Before tick 0]."""
        self.mission = mission
        self.tick, self.left = -1, mission.duration
        self.position = [robot.position for robot in mission.robots]
        self.speed = [robot.speed for robot in mission.robots]
        self.energy = [robot.energy for robot in mission.robots]
        self.count = [0 for _ in mission.sensors]
        self.active = [True for _ in mission.sensors]
        self.notes = [Notes(goal) for goal in mission.goals]
        self.broken: list[list[bool]] = [[] for _ in mission.goals]  # rules, at each tick
        self.forget()
        self.before = [*self.position], [*self.obstacle]
        self.jumped: tuple[set[int], set[int]] = set(), set()

    def forget(self) -> None:
        """ "What travels in no message starts anew from the model at every tick" [S Belief]."""
        self.obstacle = [disc.center for disc in self.mission.obstacles]
        self.rate: list[float] = [sensor.rate for sensor in self.mission.sensors]
        self.cost = [sensor.cost for sensor in self.mission.sensors]

    def look_back(self) -> None:
        """Note "what jumps" in belief [S Goals, "Gap"]."""
        robots = enumerate(zip(self.mission.robots, *(self.before[0], self.position), strict=True))
        ways = enumerate(zip(self.before[1], self.obstacle, strict=True))
        self.jumped = (
            {k for k, (r, a, b) in robots if exceeds(distance(a, b), r.max_speed + 2 * r.noise)},
            {k for k, (a, b) in ways if a[:2] != b[:2]},
        )

    def of(self, prop: str) -> list[Any]:
        """Return the values of a property, in words of the metamodel."""
        return getattr(self, prop.lower())

    def reports(self) -> dict[str, list[Any]]:
        """Return a copy of what messages say: [S Belief], first sentence."""
        return {p: list(self.of(p)) for p in ("POSITION", "SPEED", "ENERGY", "COUNT", "ACTIVE")}

    def sensing(self, robot: int) -> float:  # "Σ over active sensors of rate × cost"
        own = [sensor.index for sensor in self.mission.robots[robot].sensors]
        return added(self.rate[k] * self.cost[k] for k in own if self.active[k])

    def power(self, robot: int) -> float:
        return self.speed[robot] * self.mission.robots[robot].cost + self.sensing(robot)


class Intelligence(View):  # the belief, and commands as they stand [S Reference reactions]
    def __init__(self, mission: Mission, weather: Weather) -> None:
        super().__init__(mission)
        self.weather = weather
        n_robots = range(len(mission.robots))
        self.heading = [weather.direction(0, robot, FIRST_HEADING) for robot in n_robots]
        self.command = list(self.speed)
        self.switch = list(self.active)
        self.sent_heading = list(self.heading)  # "The first heading counts as sent"
        self.sent_speed = list(self.command)
        self.sent_switch = list(self.switch)
        self.taken: set[tuple[str, int]] = set()
        self.denied: dict[int, tuple[int, Direction | None]] = {}

    def take(self, channel: str, index: int) -> bool:
        """ "The first goal that commands a channel in this tick keeps it" [S The story]."""
        is_free = (channel, index) not in self.taken
        self.taken.add((channel, index))
        return is_free

    def head(self, robot: int, x: float, y: float) -> None:
        """ "One of length 1e-9 or less commands nothing, and leaves the channel free"."""
        length = distance((0, 0), (x, y))
        if length > 1e-9:
            way = x / length, y / length
            if self.take("heading", robot):
                self.heading[robot] = way
            elif self.denied.get(robot) == (self.tick, None):
                self.denied[robot] = self.tick, way

    def head_to(self, robot: int, place: Place) -> None:
        self.head(robot, place[0] - self.position[robot][0], place[1] - self.position[robot][1])

    def set_speed(self, robot: int, speed: float) -> None:
        """ "A speed is set within 0 and the robot's maximum, when it is commanded"."""
        if self.take("speed", robot):
            self.command[robot] = within(speed, 0.0, self.mission.robots[robot].max_speed)

    def pace(self, robot: int) -> float:
        """ "the larger of the CI's own speed command, as it stands now, and its nominal speed"."""
        return max(self.command[robot], self.mission.robots[robot].speed)

    def leeway(self, robot: int) -> float:
        """ "2 × noise + pace × (turn width + 0.5)", without what it does not need."""
        model = self.mission.robots[robot]
        turning = self.pace(robot) * (model.width + 0.5) if model.turn_rate < 180 else 0.0
        return 2 * model.noise + turning

    def berth(self, robot: int) -> float:
        """Return "noise + pace × (turn width - 1) / 2"."""
        model = self.mission.robots[robot]
        return model.noise + self.pace(robot) * (model.width - 1) / 2

    def after(self, steps: int, robot: int, direction: Direction) -> Place:
        return ahead(self.position[robot], steps * self.pace(robot), direction)


def note(goal: Goal, view: View) -> None:
    """Second column of the table of [S Goals]."""
    notes = view.notes[goal.index]
    if goal.task == "GatherSamples":
        note_samples(goal, view, notes)
    for robot in goal.members:
        place = view.position[robot]
        match goal.task:
            case "Patrol":  # "it enters at most one a tick, in order"
                if goal.route[notes.waypoint[robot]].has(place):
                    notes.since[robot], notes.reached[robot] = view.tick, True
                    notes.waypoint[robot] = (notes.waypoint[robot] + 1) % len(goal.route)
            case "Visit" | "Stay":
                if (goal.point if goal.task == "Visit" else goal.area).has(place):
                    notes.since[robot], notes.reached[robot] = view.tick, True
            case "Track":  # "it may pass several in one tick"
                for waypoint in goal.trajectory[notes.waypoint[robot] :]:
                    if exceeds(distance(place, waypoint), goal.tolerance):
                        break
                    notes.waypoint[robot] += 1


def note_samples(goal: Goal, view: View, notes: Notes) -> None:
    """The item "Samples that count" of [S Goals]."""
    new = view.count[goal.sensor] - notes.seen
    notes.seen = view.count[goal.sensor]
    place = view.position[view.mission.sensors[goal.sensor].robot]
    has_moved = notes.count == 0 or place[:2] != notes.counted_at
    if new > 0 and goal.area.has(place) and has_moved:
        notes.count += new
        notes.counted_at = place[:2]


def gaps(goal: Goal, view: View) -> Iterator[tuple[float, float]]:
    """Yield for each pair its least distance and "the sum of both radii and the clearance"."""

    def discs(own: list[int], kind: int, shapes: list[Any]) -> list[tuple[Any, ...]]:
        now = (view.position, view.obstacle)[kind]
        return [(now[k], view.before[kind][k], shapes[k], k in view.jumped[kind]) for k in own]

    robots = discs(goal.robots, 0, [Disc(r.position, r.radius) for r in view.mission.robots])
    rocks = discs(goal.obstacles, 1, view.mission.obstacles)
    for one, other in (*combinations(robots, 2), *product(robots, rocks)):
        (a, a_was, (_, radius, _), has_jumped), (b, b_was, its, it_has) = one, other
        x, y = b[0] - a[0], b[1] - a[1]
        was_x, was_y = b_was[0] - a_was[0], b_was[1] - a_was[1]
        wx, wy = (0.0, 0.0) if has_jumped or it_has else (was_x - x, was_y - y)
        square = wx * wx + wy * wy
        s = within(-(x * wx + y * wy) / square, 0, 1) if square else 0
        least = distance((0, 0), (x + s * wx, y + s * wy))
        if its.corners:
            least = its.radius + off_way(its.corners, (-x, -y), (-x - wx, -y - wy))
        yield least, radius + its.radius + goal.clearance


def too_few(goal: Goal, keeping: Iterable[bool]) -> bool:  # "fewer than k members"
    return sum(keeping) < goal.required


def is_violated(goal: Goal, view: View) -> bool:
    """ "at each of the ticks `t - grace` … `t`" [S Grace]; false before tick `grace`."""
    lasting = view.broken[goal.index][-goal.grace - 1 :]
    return len(lasting) > goal.grace and all(lasting)


def is_broken(goal: Goal, view: View) -> bool:
    """Third column of the table of [S Goals]."""
    notes = view.notes[goal.index]
    places = [view.position[robot] for robot in goal.robots or goal.members]
    match goal.task:
        case "AvoidCollision":
            found = any(falls_short(*each) for each in gaps(goal, view))
        case "StayWithinMissionArea":
            found = too_few(goal, (view.mission.area.has(place) for place in places))
        case "SufficientEnergy":
            energies = [(view.energy[k], view.left * view.power(k)) for k in goal.members]
            found = too_few(goal, (not falls_short(*each) and each[0] != 0 for each in energies))
        case "GatherSamples":
            sensor = view.mission.sensors[goal.sensor]
            forecast = notes.count + view.left * (view.rate[goal.sensor] / sensor.rate)
            is_there = view.active[goal.sensor] and goal.area.has(view.position[sensor.robot])
            is_failing = not is_there or falls_short(forecast, goal.target)
            found = notes.count < goal.target and is_failing
        case "Patrol":
            found = too_few(goal, (view.tick - k < goal.period for k in notes.since.values()))
        case "Visit":
            found = view.tick >= goal.deadline and too_few(goal, notes.reached.values())
        case "Track":
            off = [off_track(goal, view, k) for k in goal.members]
            found = too_few(goal, (not exceeds(each, goal.tolerance) for each in off))
        case "Stay":
            inside = [goal.area.has(view.position[robot]) for robot in goal.members]
            before = notes.reached.values()
            found = too_few(goal, (k or not was for k, was in zip(inside, before, strict=True)))
        case "FixedDistanceBetweenRobots":
            off = [abs(distance(a, b) - goal.distance) for a, b in combinations(places, 2)]
            found = any(exceeds(each, goal.tolerance) for each in off)
    return found


def off_track(goal: Goal, view: View, robot: int) -> float:
    """Return how far "a member that has passed a waypoint and not the last" is off; else -1."""
    place, n = view.position[robot], view.notes[goal.index].waypoint[robot]
    if not 0 < n < len(goal.trajectory):
        return -1.0
    one, two = goal.trajectory[n - 1 : n + 1]
    dx, dy = two[0] - one[0], two[1] - one[1]
    square = dx * dx + dy * dy
    along = ((place[0] - one[0]) * dx + (place[1] - one[1]) * dy) / square if square else 0
    along = within(along, 0, 1)
    return distance(place, (one[0] + along * dx, one[1] + along * dy))


def is_missed(goal: Goal, truth: View) -> bool:
    """Second table of [S Measures]; of one tick, "whatever is true in between"."""
    notes = truth.notes[goal.index]
    if goal.task == "SufficientEnergy":
        return too_few(goal, (truth.energy[robot] != 0 for robot in goal.members))
    if goal.task == "GatherSamples":
        sensor = truth.mission.sensors[goal.sensor]
        is_over = truth.energy[sensor.robot] == 0
        most = notes.count + truth.left * sensor.rate
        return notes.count < goal.target and (is_over or most < goal.target)
    is_short = False
    if goal.task == "Stay":  # "a member is not inside"
        is_short = too_few(goal, (goal.area.has(truth.position[k]) for k in goal.members))
    if goal.task == "Track":
        is_short = too_few(goal, (n == len(goal.trajectory) for n in notes.waypoint.values()))
    return is_violated(goal, truth) or (truth.left == 0 and is_short)


def react(goal: Goal, ci: Intelligence) -> None:
    """The table of [S What each task does], "one after the other, in model order"."""
    notes = ci.notes[goal.index]
    if goal.task == "GatherSamples":
        if ci.take("sensor", goal.sensor):
            ci.switch[goal.sensor] = notes.count < goal.target
        roam(ci, ci.mission.sensors[goal.sensor].robot, goal.area)
    for robot in goal.robots:
        evade(goal, ci, robot)
    for before, robot in zip([-1, *goal.members], goal.members, strict=False):
        match goal.task:
            case "StayWithinMissionArea":
                place = ci.after(2, robot, ci.heading[robot])
                if not ci.mission.area.has_well(place, ci.leeway(robot)):
                    ci.head_to(robot, ci.mission.area.center)
            case "SufficientEnergy":
                regulate(ci, robot)
            case "Patrol":
                roam(ci, robot, goal.route[notes.waypoint[robot]])
            case "Stay":
                roam(ci, robot, goal.area)
            case "Visit":
                n_passed = passed(ci, goal, robot, [goal.point.center], int(notes.reached[robot]))
                approach(ci, robot, [goal.point.center][n_passed:])
            case "Track":
                n_passed = passed(ci, goal, robot, goal.trajectory, notes.waypoint[robot])
                approach(ci, robot, goal.trajectory[n_passed:])
            case "FixedDistanceBetweenRobots" if before >= 0:
                keep_distance(goal, ci, robot, before)


def passed(ci: Intelligence, goal: Goal, robot: int, points: list[Place], noted: int) -> int:
    """Return the points passed; with noise, only those that the robot was "surely at"."""
    surely, noise = ci.notes[goal.index].surely, ci.mission.robots[robot].noise
    reach = max(goal.tolerance - noise, goal.tolerance / 2)
    for point in points[surely[robot] : noted]:
        if exceeds(distance(ci.position[robot], point), reach):
            break
        surely[robot] += 1
    return surely[robot] if noise > 0 else noted


def approach(ci: Intelligence, robot: int, points: list[Place]) -> None:
    """ "towards it, at the smaller of nominal speed and distance / turn width"; then nominal."""
    speed = ci.mission.robots[robot].speed
    for point in points[:1]:
        ci.head_to(robot, point)
        speed = min(speed, distance(ci.position[robot], point) / ci.mission.robots[robot].width)
    ci.set_speed(robot, speed)


def keep_distance(goal: Goal, ci: Intelligence, robot: int, before: int) -> None:
    (x, y, _), (to_x, to_y, _) = ci.position[robot], ci.position[before]
    gap = distance((x, y), (to_x, to_y))
    if exceeds(gap - goal.distance, goal.tolerance / 2):
        ci.head(robot, to_x - x, to_y - y)
    elif exceeds(goal.distance - gap, goal.tolerance / 2):
        ci.head(robot, x - to_x, y - to_y)
    else:
        ci.head(robot, *ci.heading[before])


def regulate(ci: Intelligence, robot: int) -> None:
    """The paragraph "Regulating speed"."""
    wanted, cost = ci.mission.robots[robot].speed, ci.mission.robots[robot].cost
    if ci.left > 0 and cost > 0:
        affordable = (0.999 * ci.energy[robot] / ci.left - ci.sensing(robot)) / cost
        wanted = within(affordable, 0.0, wanted)
    ci.set_speed(robot, ci.sent_speed[robot] + wanted - ci.speed[robot])


def roam(ci: Intelligence, robot: int, area: Disc) -> None:
    """The paragraph "Roaming"."""
    leeway = ci.leeway(robot)
    if not area.has_well(ci.position[robot], leeway):
        ci.head_to(robot, area.center)
    elif not area.has_well(ci.after(1, robot, ci.heading[robot]), leeway):
        for attempt in range(8):
            direction = ci.weather.direction(ci.tick, 8 * robot + attempt, ROAMING)
            if area.has_well(ci.after(2, robot, direction), leeway):
                ci.head(robot, *direction)
                return
        ci.head_to(robot, area.center)


def evade(goal: Goal, ci: Intelligence, robot: int) -> None:
    """The paragraph "Evading"."""
    radius = ci.mission.robots[robot].radius
    tick, denied = ci.denied.get(robot, (-2, None))
    ways = [ci.heading[robot]]
    if denied is not None and tick == ci.tick - 1:
        ways.append(denied)
    if not any(falls_short(gap_along(goal, ci, robot, way, radius), radius) for way in ways):
        return
    best: tuple[float, Direction] | None = None
    for direction in DIRECTIONS[::15]:
        if ci.mission.area.has_well(ci.after(10, robot, direction), ci.leeway(robot)):
            gap = gap_along(goal, ci, robot, direction, 20 * ci.pace(robot))
            if best is None or gap - best[0] > 1e-9:
                best = gap, direction
    if best is not None and ("heading", robot) not in ci.taken:
        ci.denied[robot] = ci.tick, None
        ci.head(robot, *best[1])


def gap_along(goal: Goal, ci: Intelligence, robot: int, way: Direction, limit: float) -> float:
    """Return the gap: "every robot and obstacle of the goal counts"."""
    place, pace = ci.position[robot], ci.pace(robot)
    x, y = pace * way[0], pace * way[1]
    gap, own = limit, ci.mission.robots[robot].radius + goal.clearance + ci.berth(robot)
    for k in goal.obstacles:
        shape = ci.mission.obstacles[k]
        if shape.corners:
            if distance(ci.obstacle[k], place) - shape.radius - own - 10 * pace > gap:
                continue  # no way leads as near
            away = closest_to_polygon(shape, place, ci.obstacle[k], x, y) - own
        else:
            away = closest(place, ci.obstacle[k], -x, -y) - (shape.radius + own)
        gap = min(gap, away)
    for other in goal.robots:
        if other != robot:
            its_x, its_y = (ci.pace(other) * part for part in ci.heading[other])
            size = own + (ci.mission.robots[other].radius + ci.berth(other))
            gap = min(gap, closest(place, ci.position[other], its_x - x, its_y - y) - size)
    return gap


def closest_to_polygon(shape: Disc, own: Place, center: Place, vx: float, vy: float) -> float:
    """ "if that is where it is now, the least on the way from tick 1 to tick 10"."""
    x, y = own[0] - center[0], own[1] - center[1]
    end = x + 10 * vx, y + 10 * vy
    least = off_way(shape.corners, (x, y), end)
    if least < off_edges(shape.corners, x, y):
        return least
    return off_way(shape.corners, (x + vx, y + vy), end)


def closest(own: Place, other: Place, vx: float, vy: float) -> float:
    """ "|Δ + s·v| with s = -(Δ·v)/(v·v), at most 10, and 1 if that is not above 0 or v·v = 0"."""
    dx, dy = other[0] - own[0], other[1] - own[1]
    square = vx * vx + vy * vy
    s = -(dx * vx + dy * vy) / square if square else 0
    s = min(s, 10) if s > 0 else 1
    return distance((0, 0), (dx + s * vx, dy + s * vy))


def fault_types(metamodel: Path) -> Iterable[tuple[str, tuple[str, str, list[str]]]]:
    """Yield name in XMI, mode, property and parameters: [F Types in the metamodel]."""
    for each in etree.parse(metamodel).getroot().findall("eClassifiers"):
        path = "eAnnotations[@source='http://mrsfi.org/meaning']/details"
        meaning = {detail.get("key"): detail.get("value") for detail in each.findall(path)}
        names = [feature.get("name") for feature in each.findall("eStructuralFeatures")]
        parameters = [name for name in names if not name.endswith(("_MIN", "_MAX"))]
        name = each.get("name")[0].lower() + each.get("name")[1:]
        yield name, (meaning.get("mode", ""), meaning.get("property", ""), parameters)


TYPES = dict(fault_types(METAMODEL))


class Fault:
    """A fault of the pool, or, with start and finish, of a specification in XMI."""

    def __init__(self, mission: Mission, element: Any) -> None:
        (content,) = element.iterchildren("*")
        (struck,) = content.iterchildren("*")
        self.id, self.type = element.get("ID"), content.tag
        self.mode, self.property, parameters = TYPES[self.type]
        self.values = [float(content.get(name, 0)) for name in parameters]
        self.start, self.finish = (int(element.get(name, 0)) for name in ("start", "finish"))
        self.trigger = element.get("trigger")
        touched = self._targets(mission, struck.tag, struck.get("href").split("#")[1])
        once = dict.fromkeys(touched)  # "Each target is touched once"
        # of types of mode OWN, "a message that does not carry all of it is left alone"
        props = self.property.split()
        self.targets = [(p, k) for p, k in once if all((each, k) in once for each in props)]

    def _targets(self, mission: Mission, tag: str, name: str) -> Iterable[tuple[str, int]]:
        """Yield what the fault touches: [F What a fault touches]."""
        props = self.property.split()
        if tag != "affectedMessage":
            yield from ((prop, mission.number[name]) for prop in props)
            return
        message = mission.messages[name]
        if message.get("sender") not in mission.number:
            return  # "A message whose sender is a server reports nothing of a robot"
        sender = mission.robots[mission.number[message.get("sender")]]
        for prop in set(props) & {"RATE", "COST"}:
            # "If the task of the goal that contains the message is GatherSamples and its sensor
            # is one of the sender's, that sensor is touched; otherwise all sensors of the sender"
            gathering = message.getparent().find("task").get("sensor")
            own = [each for each in sender.sensors if each.id == gathering]
            yield from ((prop, each.index) for each in own or sender.sensors)
        for field in (each.get("name") for each in message.findall("body")):
            same = [each.index for each in sender.sensors if each.type == field]
            reported = [("COUNT", k) for k in same]
            if field in ("POSITION", "SPEED", "ENERGY"):
                reported = [(field, sender.index)]
            yield from (each for each in reported if not props or each[0] in props)


class Trigger:
    """What faults wait for: [F Triggers]."""

    def __init__(self, mission: Mission, element: Any) -> None:
        parts = {each.tag: each for each in element.iterchildren("*")}
        self.id, self.event = element.get("ID"), element.get("event")
        self.faults = element.get("faults", "").split()
        self.delay, self.duration = int(element.get("delay", 0)), element.get("duration")
        refers = {tag: parts[tag].get("href").split("#")[1] for tag in parts if tag != "area"}
        at = refers.pop("at", None)
        names = [*refers.values()]
        self.goal = next((each for each in mission.goals if [each.id] == names), None)
        self.robot = mission.number[names[0]] if self.event == "ENTERED" else -1
        self.area = disc_of(parts["area"]) if "area" in parts else mission.areas.get(at)

    def happens(self, flight: "Flight") -> bool:
        """The third column of the table."""
        goal = self.goal
        match self.event:
            case "VIOLATED":
                return flight.true[goal.index]
            case "ENTERED":
                return self.area.has(flight.truth.position[self.robot])
            case "EFFECT":
                return any(each.changed for each in flight.faults if each.id in self.faults)
        notes = flight.truth.notes[goal.index]
        return {
            "GatherSamples": notes.count >= goal.target,
            "Visit": not too_few(goal, notes.reached.values()),
            "Track": not too_few(
                goal, (n == len(goal.trajectory) for n in notes.waypoint.values())
            ),
        }[goal.task]


class Timed:
    """A timed fault with its values, and at how many ticks it was applied and changed something."""

    def __init__(
        self,
        fault: Fault,
        start: int,
        finish: int,
        values: Sequence[float],
        trigger: Trigger | None = None,
    ) -> None:
        self.id, self.type, self.mode, self.targets = (
            fault.id,
            fault.type,
            fault.mode,
            fault.targets,
        )
        self.window, self.trigger = (start, finish), trigger
        self.memory = {k: [0.0] * 8 for _, k in self.targets}
        self.is_forged = fault.property in ("MOTION", "ACTIVATION")
        self.values = values
        self.applied = self.changed = 0
        self.begin(start)
        if trigger is not None:
            self.finish = -1  # "If that is no tick, or nothing happens, it is never active"

    def begin(self, start: int) -> None:
        """Be active from a tick on, as far as that is in the window."""
        self.start, self.finish = start, self.window[1]
        if self.trigger is not None and self.trigger.duration is not None:
            self.finish = min(self.finish, start + int(self.trigger.duration) - 1)
        if self.mode in ("DELAY", "BLOCK"):
            self.late = int(self.values[0])  # "Numbers of ticks are whole"
            if self.late < 1 or self.mode == "BLOCK":
                self.finish = min(self.finish, start + self.late - 1)

    def count(self, delivered: list[Any], found: list[Any]) -> None:
        """Count a tick: [F Windows, repetition, conflicts, "What it did"]."""
        pairs = zip(delivered, found, strict=True)  # "a number or a place (x or y)"
        self.applied += bool(delivered)
        self.changed += any(v[:2] != w[:2] if isinstance(v, tuple) else v != w for v, w in pairs)


def read_faults(mission: Mission, path: Path) -> dict[str, Fault]:
    faults = (Fault(mission, each) for each in etree.parse(path).getroot().findall("faults"))
    return {fault.id: fault for fault in faults}


def read_triggers(mission: Mission, path: Path) -> dict[str, Trigger]:
    found = (Trigger(mission, each) for each in etree.parse(path).getroot().findall("triggers"))
    return {trigger.id: trigger for trigger in found}


def read_specification(mission: Mission, path: Path) -> list[Timed]:
    triggers = read_triggers(mission, path)
    return [
        Timed(fault, fault.start, fault.finish, fault.values, triggers.get(fault.trigger))
        for fault in read_faults(mission, path).values()
    ]


class Flight:
    """One flight; afterwards it has the counts.

    ``regions`` has what a team does itself: the reaction of a goal by its ID, the effect of a fault
    type by its name in XMI.
    """

    def __init__(self, mission: Mission, faults: Sequence[Timed], seed: int, regions: Any) -> None:
        self.mission, self.faults, self.regions = mission, faults, regions
        self.weather = Weather(seed)
        self.truth = View(mission)
        self.belief = Intelligence(mission, self.weather)
        self.happened: dict[Trigger, int] = {}
        self.published = [self.truth.reports()]  # "as if every message had arrived once"
        measures = ("believed", "true", "phantom", "masked", "missed")
        self.counts = {name: [0 for _ in mission.goals] for name in measures}
        self.shown: list[list[bool]] = [[] for _ in mission.goals]

    def detection(self) -> list[tuple[int, int]]:
        """Return the two numbers of [S Detection] of each goal."""
        return [
            (len(shown), shown.index(True) if True in shown else len(shown)) for shown in self.shown
        ]

    def fly(self) -> Iterator[int]:
        """Fly tick by tick, in the order of [S The story], and yield the end of each."""
        self.send(0)
        for tick in range(self.mission.duration):
            self.truth.tick = self.belief.tick = tick
            self.truth.left = self.belief.left = self.mission.duration - 1 - tick  # [S Goals]
            for view in (self.truth, self.belief):
                view.before = [*view.position], [*view.obstacle]
            for robot in self.mission.robots:
                self.move(robot)
            self.publish()
            self.true = self.judge(self.truth)
            self.deliver()
            self.belief.look_back()
            self.believed = self.judge(self.belief)
            self.set_off(tick)
            self.belief.taken = set()
            for goal in self.mission.goals:
                self.regions.get(goal.id, react)(goal, self.belief)
            self.send(tick + 1)
            self.tally()
            yield tick

    def set_off(self, tick: int) -> None:
        """ "active from the largest of `start` and `e + 1 + delay`" [F Triggers]."""
        for fault in self.faults:
            trigger = fault.trigger
            if trigger is None:
                continue
            if trigger not in self.happened and trigger.happens(self):
                self.happened[trigger] = tick
            due = max(fault.window[0], self.happened.get(trigger, tick) + 1 + trigger.delay)
            if trigger in self.happened and due == tick + 1:
                fault.begin(due)

    def move(self, robot: Robot) -> None:
        """[S Motion, energy and samples]"""
        truth, k = self.truth, robot.index
        if truth.energy[k] == 0:  # "stands still from now on"
            truth.speed[k] = 0.0
            for sensor in robot.sensors:
                truth.active[sensor.index] = False
            return
        truth.speed[k] = within(self.belief.sent_speed[k], 0.0, robot.max_speed)
        truth.position[k] = ahead(truth.position[k], truth.speed[k], self.belief.sent_heading[k])
        for sensor in robot.sensors:
            truth.active[sensor.index] = self.belief.sent_switch[sensor.index]
            if truth.active[sensor.index]:
                draw = self.weather.draw(truth.tick, sensor.index, SAMPLES)
                n_valid = sum(draw >= bound for bound in sensor.bounds)
                truth.count[sensor.index] += 1 if sensor.rate == 1 else n_valid
        spent = truth.speed[k] * robot.cost  # "the motion first, then sensor after sensor"
        for sensor in robot.sensors:
            spent += sensor.rate * sensor.cost if truth.active[sensor.index] else 0.0
        rest = truth.energy[k] - spent
        truth.energy[k] = 0.0 if rest <= 1e-9 * spent else rest

    def publish(self) -> None:
        """[S Motion, "Position"]: without its first GPS sensor, the newest is an earlier one."""
        reports = self.truth.reports()
        for robot in self.mission.robots:
            k, tick = robot.index, self.truth.tick
            place = self.weather.scattered(self.truth.position[k], robot.noise, tick, k, NOISE)
            if robot.gps is not None and not self.truth.active[robot.gps.index]:
                place = self.published[-1]["POSITION"][k]
            reports["POSITION"][k] = place
        self.published.append(reports)

    def judge(self, view: View) -> list[bool]:
        """ "every goal notes its progress, then every goal is checked"."""
        for goal in self.mission.goals:
            note(goal, view)
        for goal in self.mission.goals:
            view.broken[goal.index].append(is_broken(goal, view))
        return [is_violated(goal, view) for goal in self.mission.goals]

    def deliver(self) -> None:
        """Messages become belief [S Belief], and faults act on it [F All types]."""
        was = self.belief.reports()
        for prop, values in self.published[-1].items():
            self.belief.of(prop)[:] = values
        self.belief.forget()
        # "after all reports were falsified, by start and then in the order of the specification"
        for fault in sorted(self.faults, key=lambda each: (each.mode == "OWN", each.window[0])):
            if fault.start <= self.belief.tick <= fault.finish and not fault.is_forged:
                delivered = [self.belief.of(prop)[k] for prop, k in fault.targets]
                for k in {k: 0 for _, k in fault.targets} if fault.mode == "OWN" else ():
                    self.regions[fault.type](self.belief, self.published[-1], fault, k)
                for (prop, k), v in zip(fault.targets, delivered, strict=True):
                    if fault.mode != "OWN":
                        self.belief.of(prop)[k] = self.false_value(fault, prop, k, v, was)
                fault.count(delivered, [self.belief.of(prop)[k] for prop, k in fault.targets])

    def false_value(self, fault: Timed, prop: str, k: int, v: Any, was: dict[str, Any]) -> Any:
        """Return what a fault makes of "v", what was delivered; ``was``: "as it was"."""
        tick, mode, values = self.belief.tick, fault.mode, fault.values
        if mode in ("DELAY", "BLOCK"):
            is_there = mode == "DELAY" and tick - fault.late >= fault.start
            return (self.published[tick - fault.late + 1] if is_there else was)[prop][k]
        if prop in ("POSITION", "OBSTACLE"):
            if mode == "FIXED":
                return tuple(values)
            # "C + R × √u × direction"; "a robot keeps its reported z" [F Random values]
            center, radius, _ = self.mission.area
            return *self.weather.scattered(center, radius, tick, k, PURPOSES[prop])[:2], v[2]
        number = {
            "ZERO": lambda: 0,
            "FIXED": lambda: values[0],
            "RANDOM": lambda: self.weather.between(*values, tick, k, prop),
            "INCREMENT": lambda: v + values[0],
            "DECREMENT": lambda: v - values[0],
            "INCREMENT_PERCENT": lambda: (1 + values[0] / 100) * v,
            "DECREMENT_PERCENT": lambda: (1 - values[0] / 100) * v,
        }[mode]()
        number = (
            int(number) if prop == "COUNT" else number
        )  # "loses what follows the decimal point"
        return max(0, number)  # "Whatever comes out is 0 if it is below 0, places excepted."

    def send(self, tick: int) -> None:
        """Send the commands for the motion of a tick: [S Forged commands], [F Forged commands]."""
        ci = self.belief
        ci.sent_speed, ci.sent_switch = list(ci.command), list(ci.switch)
        for k, robot in enumerate(self.mission.robots):
            ci.sent_heading[k] = turned(ci.sent_heading[k], ci.heading[k], robot.turn_rate)
        for fault in self.faults:
            is_flown = fault.start <= tick <= fault.finish and tick < self.mission.duration
            if fault.is_forged and is_flown:
                ((prop, k),) = fault.targets
                own, sent = ci.switch, ci.sent_switch
                forged = fault.mode == "ACTIVATE"
                if prop == "MOTION":
                    own, sent = ci.command, ci.sent_speed
                    forged = self.mission.robots[k].speed if fault.mode == "START" else 0.0
                sent[k] = forged
                fault.count([own[k]], [sent[k]])

    def tally(self) -> None:
        """Count what was found, "once per goal and tick" [S Measures]."""
        for goal, true, believed in zip(self.mission.goals, self.true, self.believed, strict=True):
            k = goal.index
            self.counts["believed"][k] += believed
            self.counts["true"][k] += true
            self.counts["phantom"][k] += believed and not true
            self.counts["masked"][k] += true and not believed
            # "counts from the tick at which it first holds to the last of the mission"
            self.counts["missed"][k] += self.counts["missed"][k] > 0 or is_missed(goal, self.truth)
            # "the ticks from the first true violation on"
            if true or self.counts["missed"][k] or self.shown[k]:
                self.shown[k].append(bool(believed))
