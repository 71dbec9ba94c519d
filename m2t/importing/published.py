"""The format of the models that were published for the paper's prototype.

One XMI file, whose root ``Setup`` holds a mission and fault specifications. Most features have
the names of ours; this module has those that differ, and what to put where the old format says
nothing.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType

SETUP_NAMESPACE = "acs_project_setup"
NAMESPACES = frozenset({"", SETUP_NAMESPACE, "acs_project_mission", "acs_project_fault"})
ROOT = "Setup"

RENAMED: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {"Message": MappingProxyType({"from": "sender", "to": "receiver"})}
)
"""Old names of features by class, with ours."""

WRAPPED: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {
        "Goal": MappingProxyType(
            {"members": "goalMembers", "dependentGoals": "dependencies", "area": "goalArea"}
        )
    }
)
"""Features that the old format holds one level deeper, by class, with their name there."""

BACK_REFERENCES = frozenset({"parentID", "goal_ID"})
"""Attributes that repeat the ID of the container."""

ZERO_VALUES = frozenset({"VAL", "CAPACITY"})
"""Attributes of the old Zero types, whose value can only be zero."""

OPTIONAL = frozenset({"header", "name", "maxSpeed", "start", "finish", "likelihood"})
"""Attributes that stay unset if the file does not give them; bounds of search do as well."""

USUAL: Mapping[str, str] = MappingProxyType({"EDouble": "0.0", "EInt": "0", "EString": ""})
"""What any other absent attribute means, by its type."""

DEFAULTS: Mapping[tuple[str, str], Callable[[int], str]] = MappingProxyType(
    {
        ("Patrol", "period"): lambda duration: str(max(1, duration // 10)),
        ("Visit", "deadline"): lambda duration: str(max(1, duration - 1)),
        ("Visit", "tolerance"): lambda _: "1.0",
        ("Track", "tolerance"): lambda _: "10.0",
        ("FixedDistanceBetweenRobots", "tolerance"): lambda _: "1.0",
        ("Sensor", "type"): lambda _: "GPS_POSITION",
    }
)
"""Values of attributes that the old format lacks or leaves out, given the mission's duration.

Patrol: a tenth of the mission. Visit: by its last tick, within the radius of a robot. Track:
ten distance units off. FixedDistanceBetweenRobots: one unit off. A sensor without type has the
first literal, as in Eclipse. Any other absent number is 0, as in Eclipse.
"""
