"""What all visitors share: dispatch on the metaclass."""

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
        metaclasses = [element.eClass]
        for metaclass in metaclasses:
            method = getattr(self, f"visit_{metaclass.name}", None)
            if method is not None:
                return method(element)
            metaclasses.extend(metaclass.eSuperTypes)
        raise GenerationError(
            f"{type(self).__name__} has no method for metaclass '{element.eClass.name}'; "
            f"write visit_{element.eClass.name}"
        )
