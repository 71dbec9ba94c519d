"""What all visitors share: dispatch on the metaclass, and features in a fixed order."""

from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any, ClassVar

from mrsfi_runtime.errors import GenerationError

if TYPE_CHECKING:
    from m2t.load import LoadedModels


class ModelVisitor:
    """Compute the template context of one generated file.

    A subclass names its template and target and has a method ``visit_<Metaclass>`` for the
    metaclasses that it knows; an element of a subclass goes to the method of the nearest
    supertype, so that nobody lists thirty fault types.
    """

    template: ClassVar[str]
    target: ClassVar[PurePosixPath]

    def context(self, models: "LoadedModels") -> Mapping[str, Any]:
        """Return what the template needs, free of metamodel objects."""
        context: Mapping[str, Any] = self.visit(models.mission)
        return context

    def visit(self, element: Any) -> Any:
        """Return what the method for an element's metaclass makes of it.

        Raises
        ------
        GenerationError
            If the visitor has no method for the metaclass and its supertypes.
        """
        for metaclass in lineage(element.eClass):
            method = getattr(self, f"visit_{metaclass.name}", None)
            if method is not None:
                return method(element)
        raise GenerationError(
            f"{type(self).__name__} has no method for metaclass '{element.eClass.name}'; "
            f"write visit_{element.eClass.name}"
        )


def lineage(metaclass: Any) -> list[Any]:
    """Return a metaclass and its supertypes, nearest first, each once."""
    found = [metaclass]
    for known in found:
        found.extend(parent for parent in known.eSuperTypes if parent not in found)
    return found


def features(element: Any) -> list[Any]:
    """Return the features of an element in the order of the metamodel, inherited ones first.

    Notes
    -----
    pyecore's own collections of features are sets, whose order differs from run to run.
    """
    metaclasses = reversed(lineage(element.eClass))
    return [feature for metaclass in metaclasses for feature in metaclass.eStructuralFeatures]
