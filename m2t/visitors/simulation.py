"""Visitor of ``simulation.py``: the simulation's side of the bus."""

from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import Any

from m2t.visitors.topics import TopicView, TopicVisitor, methods


class SimulationVisitor(TopicVisitor):
    """Add the true state and the receivers of commands to what both sides share."""

    template = "simulation.py.j2"
    target = PurePosixPath("simulation.py")

    def visit_Mission(self, mission: Any) -> Mapping[str, Any]:
        """Return the template context of one mission."""
        context = super().visit_Mission(mission)
        callbacks = methods(context["robots"], ("on_{}_heading", "on_{}_speed"), ("on_{}_active",))
        truths = tuple(
            TopicView(robot.truth_topic, "std_msgs/Float64MultiArray")
            for robot in context["robots"]
        )
        return {**context, "truths": truths, "callbacks": callbacks}
