"""Visitor of ``sim_interface.py``: the collective intelligence's side of the bus."""

from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import Any

from m2t.visitors.topics import TopicVisitor, methods


class SimInterfaceVisitor(TopicVisitor):
    """Add the getters and setters by topic, robot and sensor to what both sides share."""

    template = "sim_interface.py.j2"
    target = PurePosixPath("sim_interface.py")

    def visit_Mission(self, mission: Any) -> Mapping[str, Any]:
        """Return the template context of one mission."""
        context = super().visit_Mission(mission)
        robots = context["robots"]
        return {
            **context,
            "readers": methods(robots, ("read_{}",), ("read_{}",)),
            "heading_setters": methods(robots, ("set_{}_heading",), ()),
            "speed_setters": methods(robots, ("set_{}_speed",), ()),
            "active_setters": methods(robots, (), ("set_{}_active",)),
        }
