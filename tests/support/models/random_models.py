"""Random missions and faults: every class and feature, valid for our validator and for EMF."""

import random
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from pyecore.ecore import EClass, EEnum

from m2t.metaclasses import conforms, features
from m2t.metamodels import load_metamodels
from m2t.models.check import POLYGONS, RANGES
from tests.support.features import is_contained, is_reference, reference_type
from tests.support.models.shapes import JOINT

FIELDS = ("POSITION", "SPEED", "ENERGY", "GPS_POSITION", "DEPTH", "TEMPERATURE", "PRESSURE")
FIELD_TYPES = ("Coordinates", "Int", "Double", "String")
ODD_TEXTS = (
    "",
    " ",
    "  two  spaces ",
    "a<b>c&d",
    "&amp; &lt; ]]>",
    "\"double\" 'single'",
    "tab\tand\nnew\r\nlines\r",
    "Ärger mit Größe",
    "naïve café ÿ",
    "ΑΒΓ Жизнь 深海",
    "\U0001f916 robot \U00010348",
    "\x7f\x85\xa0\u2028\ufeff",
    "<!-- no comment --> <?no instruction?>",
    "{curly} %percent $dollar \\backslash",
    "//@robots.0",
    "-0.0",
)
DOUBLES = (
    *(0.0, 1.0, 0.1, 1 / 3, 0.30000000000000004, 100.0, 9999999.0, 12345678.9, 1e7, 1e12),
    *(1e-3, 9.999e-4, 1e-5, 1.5e-7, 1e-300, 2.2250738585072014e-308),
)
INTEGERS = (0, 1, 7, 1000, 2**31 - 1)


@dataclass(frozen=True, slots=True)
class Drawn:
    """A mission and the faults that refer to it, as pyecore objects."""

    mission: Any
    faults: Any


def draw(seed: int) -> Drawn:
    """Return a mission with faults; the same seed draws the same."""
    rng = random.Random(seed)
    drawer, mission = _referable_mission(rng)
    drawer.refer()
    _make_sense(mission, rng)
    faults = drawer.element(load_metamodels().faults.getEClassifier("FaultSpecification"))
    drawer.refer()
    _make_triggers_sense(faults, mission, rng)
    return Drawn(mission, faults)


def _referable_mission(rng: random.Random) -> tuple["_Drawer", Any]:
    """Return a mission that has something of all that tasks and faults refer to."""
    while True:
        drawer = _Drawer(rng)
        mission = drawer.element(load_metamodels().mission.getEClassifier("Mission"))
        drawn = {element.eClass.name for element in elements(mission)}
        if drawn >= {"Sensor", "Message", "Obstacle"}:
            return drawer, mission


def everything() -> Iterator[str]:
    """Yield every concrete class and every feature of both metamodels, by name."""
    for package in load_metamodels().packages:
        for metaclass in package.eClassifiers:
            if isinstance(metaclass, EClass) and not metaclass.abstract:
                yield metaclass.name
                yield from (f"{metaclass.name}.{feature.name}" for feature in features(metaclass))


def coverage(root: Any) -> Counter[str]:
    """Return how often a model uses each class and gives each feature."""
    counts: Counter[str] = Counter()
    for element in elements(root):
        name = element.eClass.name
        counts[name] += 1
        for feature in features(element.eClass):
            value = element.eGet(feature)
            is_given = len(value) > 0 if feature.many else element.eIsSet(feature)
            counts[f"{name}.{feature.name}"] += bool(is_given)
    return counts


def elements(root: Any) -> Iterator[Any]:
    """Yield an element and everything that it contains, in the order of the file."""
    yield root
    for feature in filter(is_contained, features(root.eClass)):
        value = root.eGet(feature)
        for child in value if feature.many else [value] if value is not None else []:
            yield from elements(child)


class _Drawer:
    """Draws elements; references wait until everything that they may lead to is there."""

    def __init__(self, rng: random.Random) -> None:
        self._rng = rng
        self._drawn: list[Any] = []
        self._waiting: list[tuple[Any, Any]] = []

    def element(self, metaclass: Any, omitted: tuple[str, ...] = ("corners",)) -> Any:
        """Return an element with its attributes and all that it contains."""
        drawn = metaclass()
        self._drawn.append(drawn)
        kept = [each for each in self._features(metaclass) if each.name not in omitted]
        for feature in kept:
            if is_reference(feature):
                self._waiting.append((drawn, feature))
            elif is_contained(feature):
                self._contain(drawn, feature)
            else:
                self._assign(drawn, feature)
        _order_bounds(drawn)
        return drawn

    def refer(self) -> None:
        """Draw the references that wait."""
        for source, feature in self._waiting:
            wanted = reference_type(feature)
            targets = [known for known in self._drawn if conforms(known.eClass, wanted)]
            if feature.many:
                source.eGet(feature).extend(self._sample(feature, targets))
            else:
                source.eSet(feature, self._rng.choice(targets))
        self._waiting.clear()

    def _sample(self, feature: Any, targets: list[Any]) -> list[Any]:
        n_targets = self._rng.randint(feature.lowerBound, min(4, len(targets)))
        return self._rng.sample(targets, n_targets)

    def _features(self, metaclass: Any) -> list[Any]:
        """Return the features to fill: required ones and some of the others."""
        kept = [feature for feature in features(metaclass) if self._is_kept(feature)]
        if metaclass.name == "Area":
            return [each for each in features(metaclass) if each.name == "radius" or each in kept]
        if metaclass.name != "Fault":
            return kept
        kinds = [feature for feature in features(metaclass) if is_contained(feature)]
        is_timed = self._rng.random() < 0.5
        plain = [
            feature
            for feature in features(metaclass)
            if feature.name in ("ID", "name") or (is_timed and feature.name in _OPTIONAL)
        ]
        return [*plain, self._rng.choice(kinds)]

    def _is_kept(self, feature: Any) -> bool:
        return feature.lowerBound > 0 or self._rng.random() < 0.6

    def _contain(self, drawn: Any, feature: Any) -> None:
        kinds = _concrete(reference_type(feature))
        if not feature.many:
            drawn.eSet(feature, self._child(drawn, feature, self._rng.choice(kinds)))
            return
        n_children = self._rng.randint(*_MANY.get(feature.name, (feature.lowerBound, 3)))
        for _ in range(n_children):
            drawn.eGet(feature).append(self._child(drawn, feature, self._rng.choice(kinds)))

    def _child(self, drawn: Any, feature: Any, kind: Any) -> Any:
        """Return an element to contain: in place of a disc a polygon, where that is allowed."""
        if (drawn.eClass.name, feature.name) not in POLYGONS or self._rng.random() < 0.6:
            return self.element(kind)
        area = self.element(kind, ("radius", "center", "corners"))
        far = self._rng.choice((0.3, 1 / 3, 12345678.9, 1e-5))
        for x, y in ((0.0, -0.0), (far, 0.1 * far), (far, 2.0 * far), (0.7 * far, far)):
            corner = kind.ePackage.getEClassifier("Coordinates")()
            corner.x, corner.y = x, y
            area.corners.append(corner)
        return area

    def _assign(self, drawn: Any, feature: Any) -> None:
        if isinstance(feature.eType, EEnum):
            value: Any = self._rng.choice(list(feature.eType.eLiterals))
        elif feature.eType.name == "EString":
            value = self._text(drawn, feature)
        else:
            value = self._number(feature)
        drawn.eSet(feature, value)

    def _text(self, drawn: Any, feature: Any) -> str:
        if feature.name == "ID":
            letters = self._rng.choice(["r", "Area", "m_", "x-", "o.", "G"])
            return f"{letters}{len(self._drawn)}"
        if drawn.eClass.name == "MessageData":
            return self._rng.choice(FIELDS if feature.name == "name" else FIELD_TYPES)
        if drawn.eClass.name.endswith("Property") and feature.name == "name":
            return f"{self._rng.choice(ODD_TEXTS)}{len(self._drawn)}"
        return self._rng.choice(ODD_TEXTS)

    def _number(self, feature: Any) -> float | int:
        is_integer = feature.eType.name == "EInt"
        allowed = RANGES.get(feature.name)
        while True:
            value = self._integer() if is_integer else self._double()
            if _is_in_ticks(feature.name):
                value = float(self._rng.randint(0, 10 ** self._rng.randint(0, 9)))
            if allowed is None or value in allowed:
                return value

    def _integer(self) -> int:
        some = self._rng.choice([*INTEGERS, self._rng.randint(0, 10 ** self._rng.randint(0, 9))])
        return self._rng.choice([-1, 1, 1]) * some

    def _double(self) -> float:
        some = self._rng.random()
        if some < 0.4:
            value = self._rng.choice(DOUBLES)
        elif some < 0.7:
            value = round(self._rng.uniform(0, 1000), self._rng.randint(0, 4))
        else:
            digits = self._rng.randint(1, 10 ** self._rng.randint(1, 15))
            value = float(f"{digits}e{self._rng.randint(-40, -4)}")
        return self._rng.choice([-1.0, 1.0, 1.0]) * value


_OPTIONAL = ("start", "finish", "likelihood", "reference")
_MANY = {"robots": (2, 4), "faults": (0, 20), "goals": (1, 8), "trajectory": (2, 4)}
"""Numbers of children, from and to, by feature; a distance needs two robots."""
_BOUNDS = (("speed", "maxSpeed"), ("start", "finish"), ("LOWER_BOUND", "UPPER_BOUND"))


def _is_in_ticks(name: str) -> bool:
    return name.startswith(("DELAY", "BLOCK_DURATION"))


def _concrete(metaclass: Any) -> list[Any]:
    package = metaclass.ePackage
    return [
        known
        for known in package.eClassifiers
        if isinstance(known, EClass) and not known.abstract and conforms(known, metaclass)
    ]


def _order_bounds(drawn: Any) -> None:
    """Exchange bounds that came out the wrong way round."""
    names = {feature.name for feature in features(drawn.eClass)}
    ranges = [(f"{name}_MIN", f"{name}_MAX") for name in names if f"{name}_MIN" in names]
    for lowest, highest in (*_BOUNDS, *sorted(ranges)):
        if lowest in names and drawn.eIsSet(lowest) and drawn.eIsSet(highest):
            low, high = sorted((drawn.eGet(lowest), drawn.eGet(highest)))
            drawn.eSet(lowest, low)
            drawn.eSet(highest, high)


def _make_sense(mission: Any, rng: random.Random) -> None:
    """Mend what only our constraints refuse."""
    for goal in mission.goals:
        if goal in goal.dependentGoals:
            goal.dependentGoals.remove(goal)
        for robot in mission.robots:
            if len(goal.members) < 2 and robot not in goal.members:
                goal.members.append(robot)
        for message in goal.messages:
            stations = [*mission.robots, *mission.servers]
            if message.receiver is message.sender:
                stations.remove(message.sender)
                message.receiver = rng.choice(stations)
        if goal.task.eClass.name == "GatherSamples":
            owner = goal.task.sensor.eContainer()
            if owner not in goal.members:
                goal.members.append(owner)
            _give_area(goal, goal.ID)
        if goal.task.eClass.name == "Patrol" and goal.task.route:
            goal.task.area = None
        elif goal.task.eClass.name == "Patrol":
            _give_area(goal.task, goal.ID)
        if goal.eIsSet("grace"):
            goal.grace = rng.randrange(mission.duration)
        if goal.eIsSet("requiredMembers"):
            is_joint = goal.task.eClass.name in JOINT
            goal.requiredMembers = 0 if is_joint else rng.randint(0, len(goal.members))


def _give_area(element: Any, name: str) -> None:
    if element.area is None:
        element.area = load_metamodels().mission.getEClassifier("Area")()
        element.area.ID, element.area.radius = f"area-of-{name}", 2.5


_REFERRED = {"VIOLATED": ("goal",), "REACHED": ("goal",), "ENTERED": ("robot", "at", "area")}
_REACHABLE = ("GatherSamples", "Visit", "Track")


def _make_triggers_sense(faults: Any, mission: Any, rng: random.Random) -> None:
    """Have triggers refer to what their events are about, and some timed faults wait for them."""
    metaclasses = load_metamodels()
    for trigger in faults.triggers:
        goals = [*mission.goals]
        if trigger.event.name == "REACHED":
            goals = [each for each in goals if each.task.eClass.name in _REACHABLE]
            if not goals:
                trigger.event = metaclasses.faults.getEClassifier("TriggerEvent").eLiterals[0]
                goals = [*mission.goals]
        wanted = _REFERRED.get(trigger.event.name, ("faults",))
        wanted = rng.choice((wanted, tuple(name for name in wanted if name != "at")))[:2]
        area = trigger.area or metaclasses.mission.getEClassifier("Area")()
        area.ID, area.radius = area.ID or f"area-of-{trigger.ID}", area.radius or 2.5
        for name, value in (
            ("goal", rng.choice(goals)),
            ("robot", rng.choice(mission.robots)),
            ("area", area),
            ("at", mission.missionArea),
        ):
            trigger.eSet(name, value if name in wanted else None)
        if "faults" not in wanted:
            trigger.faults.clear()
    for fault in faults.faults:
        if faults.triggers and fault.eIsSet("start") and rng.random() < 0.5:
            fault.trigger = rng.choice(faults.triggers)
