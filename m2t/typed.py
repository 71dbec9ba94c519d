"""Loaded models as objects of the static classes, for scripts that edit them."""

from dataclasses import replace
from types import ModuleType
from typing import Any

from m2t.load import LoadedModels
from m2t.metaclasses import copies
from mrsfi_runtime.errors import ModelError


def with_classes(models: LoadedModels, *packages: ModuleType) -> LoadedModels:
    """Return a copy of loaded models whose objects belong to the static classes.

    ``packages`` are the modules ``mission`` and ``faults`` of ``generated/metamodel``; if none has
    the class of an object, that is a ``ModelError``. ``m2t.saving`` writes the copy as it writes
    the original, with new elements of the same classes that were added to it.
    """
    classifiers = {
        (package.nsURI, name): classifier
        for package in packages
        for name, classifier in package.eClassifiers.items()
    }

    def known(classifier: Any) -> Any:
        key = (classifier.ePackage.nsURI, classifier.name)
        if key not in classifiers:
            raise ModelError(
                f"{classifier.name} of {key[0]} is no static class; expected the packages of the "
                "models; name them all, or run `python -m m2t.classes generated/metamodel`"
            )
        return classifiers[key]

    made = copies([root for root in (models.mission, models.faults) if root is not None], known)
    return replace(
        models,
        mission=made[models.mission],
        faults=None if models.faults is None else made[models.faults],
        nodes={made[element]: node for element, node in models.nodes.items()},
        files=tuple(
            replace(file, roots=tuple(made[root] for root in file.roots)) for file in models.files
        ),
    )
