"""Visitor of ``simulation.py``: the simulation's side of the bus."""

from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import Any

from m2t.visitors.topics import TopicVisitor, methods


class SimulationVisitor(TopicVisitor):
    """Add the receivers of commands to what both sides share."""

    template = "simulation.py.j2"
    target = PurePosixPath("simulation.py")

    def visit_Mission(self, mission: Any) -> Mapping[str, Any]:
        """Return the template context of one mission."""
        context = super().visit_Mission(mission)
        callbacks = methods(context["robots"], ("on_{}_heading", "on_{}_speed"), ("on_{}_active",))
        return {**context, "callbacks": callbacks}
