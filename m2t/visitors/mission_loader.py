"""Visitor of ``mission_loader.py``: the mission as one nested expression."""

from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import Any

from m2t.environment import Call, Expression, Name
from m2t.metamodels import base_class
from m2t.visitors.base import ModelVisitor

_PROPERTY_FEATURES = ("stringProperties", "intProperties", "doubleProperties")


class MissionLoaderVisitor(ModelVisitor):
    """Turn a mission into calls of the runtime's vocabulary, in model order."""

    template = "mission_loader.py.j2"
    target = PurePosixPath("mission_loader.py")

    def visit_Mission(self, mission: Any) -> Mapping[str, Any]:
        """Return the template context of one mission."""
        expression = Call(
            "Mission",
            (
                ("name", mission.name),
                ("duration", mission.duration),
                ("area", self.visit(mission.missionArea)),
                ("robots", self._all(mission.robots)),
                ("servers", self._all(mission.servers)),
                ("obstacles", self._all(mission.obstacles)),
                ("goals", self._all(mission.goals)),
            ),
        )
        return {"imports": functions(expression), "result": expression}

    def visit_Robot(self, robot: Any) -> Call:
        """Return a robot with its parts; lists that are empty are left out."""
        return Call(
            "Robot",
            (
                ("id", robot.ID),
                ("name", robot.name),
                ("position", self._point(robot.position)),
                ("speed", float(robot.speed)),
                *_given("sensors", self._all(robot.sensors)),
                *_given("batteries", self._all(robot.batteries)),
                *_given("motion_sources", self._all(robot.motionSources)),
                *_given("properties", _properties(robot)),
            ),
        )

    def visit_Sensor(self, sensor: Any) -> Call:
        """Return a sensor."""
        return Call(
            "Sensor",
            (
                ("id", sensor.ID),
                ("name", sensor.name),
                ("type", sensor.type.name),
                ("energy_per_sample", float(sensor.energyPerSample)),
                ("samples_per_second", sensor.samplesPerSecond),
            ),
        )

    def visit_Battery(self, battery: Any) -> Call:
        """Return a battery."""
        energy = float(battery.totalEnergy)
        return Call(
            "Battery", (("id", battery.ID), ("name", battery.name), ("total_energy", energy))
        )

    def visit_MotionSource(self, source: Any) -> Call:
        """Return a motion source."""
        return Call(
            "MotionSource",
            (
                ("id", source.ID),
                ("name", source.name),
                ("energy_per_distance_unit", float(source.energyPerDistanceUnit)),
            ),
        )

    def visit_Server(self, server: Any) -> Call:
        """Return a server."""
        return Call(
            "Server",
            (
                ("id", server.ID),
                ("name", server.name),
                *_given("properties", _properties(server)),
            ),
        )

    def visit_Obstacle(self, obstacle: Any) -> Call:
        """Return an obstacle."""
        return Call("Obstacle", (("id", obstacle.ID), ("area", self.visit(obstacle.area))))

    def visit_Area(self, area: Any) -> Call:
        """Return an area; its centre is the origin where the model gives none."""
        return Call(
            "Area",
            (
                ("id", area.ID),
                ("center", self._point(area.center)),
                ("radius", float(area.radius)),
            ),
        )

    def visit_Coordinates(self, point: Any) -> Call:
        """Return a point."""
        axes = (("x", float(point.x)), ("y", float(point.y)), ("z", float(point.z)))
        return Call("Coordinates", axes, is_flat=True)

    def visit_Goal(self, goal: Any) -> Call:
        """Return a goal with its task and messages."""
        area = () if goal.area is None else (("area", self.visit(goal.area)),)
        return Call(
            "Goal",
            (
                ("id", goal.ID),
                ("name", goal.name),
                ("members", _ids(goal.members)),
                ("task", self.visit(goal.task)),
                *area,
                *_given("messages", self._all(goal.messages)),
                *_given("dependent_goals", _ids(goal.dependentGoals)),
            ),
        )

    def visit_Message(self, message: Any) -> Call:
        """Return a message."""
        return Call(
            "Message",
            (
                ("id", message.ID),
                ("sender", message.sender.ID),
                ("receiver", message.receiver.ID),
                ("body", self._all(message.body)),
            ),
        )

    def visit_MessageData(self, entry: Any) -> Call:
        """Return an entry of a message body."""
        return Call("MessageField", (("name", entry.name), ("type", entry.type)), is_flat=True)

    def visit_GoalTask(self, task: Any) -> Call:
        """Return a task that has no features: its members and goal say everything."""
        return Call(base_class(task.eClass).name)

    def visit_AvoidCollision(self, task: Any) -> Call:
        """Return an AvoidCollision task."""
        hazards = (("robots", _ids(task.robots)), *_given("obstacles", _ids(task.obstacles)))
        return Call("AvoidCollision", hazards)

    def visit_GatherSamples(self, task: Any) -> Call:
        """Return a GatherSamples task."""
        return Call(
            "GatherSamples",
            (("target_sample_number", task.targetSampleNumber), ("sensor", task.sensor.ID)),
        )

    def visit_Patrol(self, task: Any) -> Call:
        """Return a Patrol task."""
        return Call("Patrol", (("area", self.visit(task.area)), ("period", task.period)))

    def visit_Visit(self, task: Any) -> Call:
        """Return a Visit task."""
        return Call(
            "Visit",
            (
                ("coordinates", self.visit(task.coordinates)),
                ("tolerance", float(task.tolerance)),
                ("deadline", task.deadline),
            ),
        )

    def visit_Track(self, task: Any) -> Call:
        """Return a Track task."""
        return Call(
            "Track",
            (("trajectory", self._all(task.trajectory)), ("tolerance", float(task.tolerance))),
        )

    def visit_Stay(self, task: Any) -> Call:
        """Return a Stay task."""
        return Call("Stay", (("area", self.visit(task.area)),))

    def visit_FixedDistanceBetweenRobots(self, task: Any) -> Call:
        """Return a FixedDistanceBetweenRobots task."""
        return Call(
            "FixedDistanceBetweenRobots",
            (
                ("fixed_distance", float(task.fixedDistance)),
                ("tolerance", float(task.tolerance)),
            ),
        )

    def _all(self, elements: Any) -> tuple[Call, ...]:
        return tuple(self.visit(element) for element in elements)

    def _point(self, point: Any) -> Call:
        if point is None:
            return Call("Coordinates", (("x", 0.0), ("y", 0.0), ("z", 0.0)), is_flat=True)
        found: Call = self.visit(point)
        return found


def functions(expression: Expression) -> tuple[str, ...]:
    """Return the names that an expression calls or takes members of, sorted: its imports."""
    found: dict[str, None] = {}
    pending = [expression]
    for value in pending:
        if isinstance(value, Call):
            found[value.function] = None
            pending.extend(argument for _, argument in value.arguments)
        elif isinstance(value, tuple):
            pending.extend(value)
        elif isinstance(value, Name) and "." in value.text:
            found[value.text.partition(".")[0]] = None
    return tuple(sorted(found))


def _ids(elements: Any) -> tuple[str, ...]:
    return tuple(element.ID for element in elements)


def _given(name: str, values: tuple[Expression, ...]) -> tuple[tuple[str, Expression], ...]:
    return ((name, values),) if values else ()


def _properties(owner: Any) -> tuple[Call, ...]:
    return tuple(
        Call("Property", (("name", entry.name), ("value", entry.value)), is_flat=True)
        for feature in _PROPERTY_FEATURES
        for entry in getattr(owner, feature)
    )
