"""The node of a running system, as far as its topics tell: a table ``[node]`` to begin with."""

from collections.abc import Iterator, Mapping
from contextlib import closing
from typing import Any

from mrsfi_bridge.settings import full_name
from mrsfi_runtime.cosimulation.bus_topics import Completion
from mrsfi_runtime.errors import TransportTimeout, UsageError
from mrsfi_runtime.model.fault_types import plain_name
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.transport.rosbridge import RosbridgeTransport
from mrsfi_runtime.transport.topics import Service

_PATIENCE_S = 10.0
_POSE = {"position.x": "x", "position.y": "y", "orientation.z": "qz", "orientation.w": "qw"}
_TWIST = {"linear.x": "speed", "angular.z": "turn"}


def _below(path: str, fields: Mapping[str, str]) -> dict[str, str]:
    return {f"{path}.{field}": of for field, of in fields.items()}


_TELLS = {
    "nav_msgs/Odometry": {**_below("pose.pose", _POSE), "twist.twist.linear.x": "speed"},
    "geometry_msgs/PoseStamped": _below("pose", _POSE),
    "sensor_msgs/BatteryState": {"percentage": "energy"},
}
_OBEYS = {
    "geometry_msgs/Twist": _TWIST,
    "geometry_msgs/TwistStamped": _below("twist", _TWIST),
}
"""What messages hold that a robot as a rule tells or obeys, by their types."""

_KNOWN = {"tells": _TELLS, "obeys": _OBEYS}


def topics_of(url: str) -> dict[str, str]:
    """Return the topics of a rosbridge server and their types, spelled as it does."""
    completion = Completion()
    with closing(RosbridgeTransport(url)) as transport:
        transport.call(Service("/rosapi/topics", "rosapi/Topics"), {}, completion.end)
        late = TransportTimeout(f"{url}: /rosapi/topics gave no answer; start rosapi there")
        completion.wait(lambda silence: late if silence > _PATIENCE_S else None)
    values = completion.result.values
    return dict(zip(values.get("topics", ()), values.get("types", ()), strict=False))


def node_table(topics: Mapping[str, str], mission: Mission) -> str:
    """Return the text of ``[node]`` for the topics of a running system, to be looked through.

    Robots are matched in the order of the model and of their names. Topics of types that are no
    robot's as a rule stand below, as comments. Without any other it is a ``UsageError``.
    """
    of_robots = {name: kind for name, kind in topics.items() if _role(kind) is not None}
    if not of_robots:
        raise UsageError(
            f"--node: found {', '.join(sorted(topics)) or 'no topic'}; expected a topic of one of "
            f"{', '.join((*_TELLS, *_OBEYS))}: start the robots first"
        )
    found = sorted({_parted(name)[0] for name in of_robots} - {""})
    ids = [plain_name(robot.id) for robot in mission.robots]
    names = dict(zip(ids, found, strict=False))
    lines = ["[node]"]
    if names and names != {each: each for each in names}:
        lines.append(f"names = {_inline(names)}")
    energy = sum(battery.total_energy for battery in mission.robots[0].batteries)
    for role, known in _KNOWN.items():
        rules = {
            _rule(name, kind, ids[0], energy)
            for name, kind in of_robots.items()
            if full_name(kind) in known
        }
        for topic, kind, fields in sorted(rules):
            lines += ["", f"[[node.{role}]]", f'topic = "{topic}"', f'type = "{kind}"', fields]
    others = sorted(f"# {name} {kind}" for name, kind in topics.items() if name not in of_robots)
    return "\n".join([*lines, "", "# Topics that are not mapped:", *others, ""])


def _role(kind: str) -> str | None:
    return next((role for role, known in _KNOWN.items() if full_name(kind) in known), None)


def _parted(topic: str) -> tuple[str, str]:
    """Return the name of a robot, or nothing, and the rest of its topic."""
    robot, slash, rest = topic.removeprefix("/").partition("/")
    return (robot, f"/{rest}") if slash else ("", topic)


def _rule(topic: str, kind: str, first: str, energy: float) -> tuple[str, str, str]:
    """Return topic, type and fields of a rule, as text."""
    robot, rest = _parted(topic)
    kind = full_name(kind)
    fields: dict[str, Any] = {**_TELLS.get(kind, {}), **_OBEYS.get(kind, {})}
    if not robot:
        fields = {field: f"{first}.{of}" for field, of in fields.items()}
    if "percentage" in fields:
        fields["percentage"] = {"of": fields["percentage"], "scale": 1.0 / energy}
    return (f"/{{robot}}{rest}" if robot else topic), kind, f"fields = {_inline(fields)}"


def _inline(values: Mapping[str, Any]) -> str:
    """Return an inline table of TOML."""
    return f"{{ {', '.join(_entries(values))} }}"


def _entries(values: Mapping[str, Any]) -> Iterator[str]:
    for name, value in values.items():
        text = _inline(value) if isinstance(value, Mapping) else repr(value).replace("'", '"')
        yield f'"{name}" = {text}' if "." in name else f"{name} = {text}"
