"""Loaded models as objects of the static classes, for scripts that edit them."""

from dataclasses import replace
from types import ModuleType
from typing import Any

from pyecore.ecore import EEnum

from m2t.elements import contained, values
from m2t.load import LoadedModels
from m2t.metamodels import Slot, slots
from mrsfi_runtime.errors import ModelError


def with_classes(models: LoadedModels, *packages: ModuleType) -> LoadedModels:
    """Return a copy of loaded models whose objects belong to the static classes.

    Parameters
    ----------
    models
        The models, as ``m2t.load`` returns them; they are left as they are.
    packages
        Modules ``mission`` and ``faults`` of ``generated/metamodel``.

    Returns
    -------
    LoadedModels
        The copy; ``m2t.saving`` writes it as it writes the original. New elements of the same
        classes may be added to it.

    Raises
    ------
    ModelError
        If no package has the class of an object.

    Examples
    --------
    ``with_classes(load_mission_folder(folder), mission, faults)``
    """
    copying = _Copying(packages)
    for root in (models.mission, models.faults):
        if root is not None:
            copying.add(root)
    copying.fill()
    copies = copying.copies
    return replace(
        models,
        mission=copies[models.mission],
        faults=None if models.faults is None else copies[models.faults],
        nodes={copies[element]: node for element, node in models.nodes.items()},
        files=tuple(
            replace(file, roots=tuple(copies[root] for root in file.roots)) for file in models.files
        ),
        xmi_ids={copies[element]: identity for element, identity in models.xmi_ids.items()},
    )


class _Copying:
    """Copies models: first all objects, then their features, which may refer to any of them."""

    def __init__(self, packages: tuple[ModuleType, ...]) -> None:
        self.copies: dict[Any, Any] = {}
        self._classifiers: dict[tuple[str, str], Any] = {
            (package.nsURI, name): classifier
            for package in packages
            for name, classifier in package.eClassifiers.items()
        }

    def add(self, root: Any) -> None:
        """Make an empty copy of an element and of all that it contains."""
        for element in contained(root):
            self.copies[element] = self._classifier(element.eClass)()

    def fill(self) -> None:
        """Give all copies the values of their originals; what is unset stays unset."""
        for element, copy in self.copies.items():
            for slot in slots(element.eClass).values():
                if slot.many or element.eIsSet(slot.feature):
                    held = [self._value(slot, value) for value in values(element, slot)]
                    copy.eSet(slot.name, held if slot.many else next(iter(held), None))

    def _value(self, slot: Slot, value: Any) -> Any:
        if slot.holds_elements:
            return self.copies[value]
        if isinstance(slot.type, EEnum):
            return self._classifier(slot.type).getEEnumLiteral(value.name)
        return value

    def _classifier(self, classifier: Any) -> Any:
        key = (classifier.ePackage.nsURI, classifier.name)
        if key not in self._classifiers:
            raise ModelError(
                f"{classifier.name} of {key[0]} is no static class; expected the packages of the "
                "models; name them all, or run `python -m m2t.classes generated/metamodel`"
            )
        return self._classifiers[key]
