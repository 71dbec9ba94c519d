"""Visitor of ``sim_interface.py``: the collective intelligence's side of the bus."""

from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import Any

from m2t.visitors.base import ModelVisitor


class SimInterfaceVisitor(ModelVisitor):
    """Collect nothing: the file goes through the rows of ``topics.py``."""

    template = "sim_interface.py.j2"
    target = PurePosixPath("sim_interface.py")

    def visit_Mission(self, _mission: Any) -> Mapping[str, Any]:
        """Return the template context of one mission."""
        return {}
