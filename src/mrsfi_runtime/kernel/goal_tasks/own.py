"""A goal task of a team's own: what it asks for stands in the regions of its goals."""

from dataclasses import dataclass

from mrsfi_runtime.model.mission import GoalTask


@dataclass(frozen=True, slots=True)
class OwnTask(GoalTask):
    """A task of which the runtime knows the name of its class in the metamodel, and no more."""

    class_name: str

    @property
    def name(self) -> str:
        """Name of its class in the metamodel."""
        return self.class_name
