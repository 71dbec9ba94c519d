"""Visitor of ``simulation.py``: the simulation's side of the bus."""

from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import Any

from m2t.visitors.base import ModelVisitor


class SimulationVisitor(ModelVisitor):
    """Collect nothing: the file goes through the rows of ``topics.py``."""

    template = "simulation.py.j2"
    target = PurePosixPath("simulation.py")

    def visit_Mission(self, _mission: Any) -> Mapping[str, Any]:
        """Return the template context of one mission."""
        return {}
