"""Random metamodels: what Ecore offers and Eclipse's editor writes, without generic types."""

import random
from collections.abc import Iterator
from typing import Any

from pyecore import ecore
from pyecore.ecore import (
    EAnnotation,
    EAttribute,
    EClass,
    EDataType,
    EEnum,
    EEnumLiteral,
    EOperation,
    EPackage,
    EParameter,
    EReference,
)

from tests.support.models.random_models import ODD_TEXTS

_DEFAULTS = {
    ecore.EInt: ("0", "-7", "2147483647"),
    ecore.EDouble: ("0.0", "1.0E-5", "-2.5"),
    ecore.EString: ("", 'a<b>&"c"\tü'),
    ecore.EBoolean: ("true", "false"),
}
_CLASS_NAMES = ("java.lang.Integer", "java.util.Date", "double", "org.example.Point")
_WORDS = ("a", "robot", "energyPerSample", "aNameThatIsSoLongThatTheLineHasToBreakSomewhere")


def draw_metamodel(seed: int) -> Any:
    """Return a root package; the same seed draws the same."""
    return _Drawer(random.Random(seed)).package("p", depth=1)


class _Drawer:
    """Draws packages; references wait until all classes are there."""

    def __init__(self, rng: random.Random) -> None:
        self._rng = rng
        self._n_names = 0
        self._classes: list[Any] = []

    def package(self, name: str, depth: int) -> Any:
        """Return a package with classifiers and, down to a depth, subpackages."""
        drawn = EPackage(name, nsURI=f"http://example.org/{name}/1.0", nsPrefix=name)
        self._annotate(drawn)
        kinds = [self._class, self._class, self._class, self._enum, self._data_type]
        for _ in range(self._rng.randint(1, 6)):
            drawn.eClassifiers.append(self._rng.choice(kinds)())
        for number in range(self._rng.randint(0, 2) if depth else 0):
            drawn.eSubpackages.append(self.package(f"{name}{number}", depth - 1))
        for metaclass in [found for found in drawn.eClassifiers if isinstance(found, EClass)]:
            self._fill(metaclass)
        return drawn

    def _name(self) -> str:
        self._n_names += 1
        return f"{self._rng.choice(_WORDS)}{self._n_names}"

    def _is(self, chance: float = 0.3) -> bool:
        return self._rng.random() < chance

    def _annotate(self, element: Any) -> None:
        for source in self._rng.sample(["http://www.eclipse.org/emf/2002/GenModel", "own"], 2):
            if self._is(0.2):
                annotation = EAnnotation(source)
                annotation.details["documentation"] = self._rng.choice(ODD_TEXTS)
                if self._is():
                    annotation.details["a longer key, so that the line breaks"] = "x" * 60
                element.eAnnotations.append(annotation)

    def _class(self) -> Any:
        kind = self._rng.choice(["plain", "plain", "abstract", "interface"])
        drawn = EClass(self._name(), abstract=kind != "plain")
        drawn.interface = kind == "interface"
        self._annotate(drawn)
        parents = [known for known in self._classes if not known.eSuperTypes]
        if parents and self._is(0.5):
            drawn.eSuperTypes.append(self._rng.choice(parents))
        self._classes.append(drawn)
        return drawn

    def _enum(self) -> Any:
        drawn = EEnum(self._name())
        self._annotate(drawn)
        for number in range(self._rng.randint(1, 4)):
            literal = EEnumLiteral(self._name(), value=number * self._rng.choice([1, 7, -3]))
            self._annotate(literal)
            drawn.eLiterals.append(literal)
        return drawn

    def _data_type(self) -> Any:
        drawn = EDataType(self._name(), instanceClassName=self._rng.choice(_CLASS_NAMES))
        self._annotate(drawn)
        if self._is():
            drawn.serializable = False
        return drawn

    def _fill(self, metaclass: Any) -> None:
        for draw in self._rng.choices([self._attribute, self._reference, self._operation], k=4):
            draw(metaclass)

    def _attribute(self, metaclass: Any) -> None:
        kind = self._rng.choice(list(_DEFAULTS))
        drawn = EAttribute(self._name(), kind)
        if self._is(0.4):
            drawn.defaultValueLiteral = self._rng.choice(_DEFAULTS[kind])
        elif self._is():
            drawn.upperBound = self._rng.choice([-1, 3])
        has_id = any(getattr(known, "iD", False) for known in _all_features(metaclass))
        drawn.iD = kind is ecore.EString and not drawn.many and not has_id and self._is(0.2)
        self._switch(drawn)
        metaclass.eStructuralFeatures.append(drawn)

    def _reference(self, metaclass: Any) -> None:
        target = self._rng.choice(self._classes)
        drawn = EReference(self._name(), target)
        drawn.containment = self._is(0.4)
        drawn.lowerBound, drawn.upperBound = self._rng.choice([(0, 1), (1, 1), (0, -1), (2, 5)])
        if self._is():
            drawn.resolveProxies = False
        if self._is():
            drawn.unique = drawn.many
        self._switch(drawn)
        metaclass.eStructuralFeatures.append(drawn)
        if self._is(0.4):
            opposite = EReference(self._name(), metaclass, transient=drawn.transient)
            target.eStructuralFeatures.append(opposite)
            opposite.eOpposite = drawn
            drawn.eOpposite = opposite

    def _switch(self, feature: Any) -> None:
        self._annotate(feature)
        feature.changeable = not self._is(0.1)
        feature.ordered = not self._is(0.2)
        feature.unsettable = self._is(0.2)
        feature.transient = feature.volatile = feature.derived = self._is(0.1)

    def _operation(self, metaclass: Any) -> None:
        drawn = EOperation(self._name())
        self._annotate(drawn)
        if self._is(0.6):
            drawn.eType = self._rng.choice([ecore.EInt, ecore.EString, *self._classes])
            drawn.upperBound = self._rng.choice([1, -1])
        for _ in range(self._rng.randint(0, 2)):
            drawn.eParameters.append(EParameter(self._name(), self._rng.choice(list(_DEFAULTS))))
        metaclass.eOperations.append(drawn)


def _all_features(metaclass: Any) -> Iterator[Any]:
    yield from metaclass.eStructuralFeatures
    for parent in metaclass.eSuperTypes:
        yield from _all_features(parent)
