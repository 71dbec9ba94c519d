"""What a team has added to the metamodels, for generated code: nothing of a model is lost."""

from collections.abc import Container
from typing import Any

from pyecore.ecore import EEnumLiteral

from m2t.environment import Expression, Table
from m2t.metamodels import features, is_contained, is_reference


def own_features(element: Any, known: Container[str] = ()) -> Table:
    """Return the features that a model or a default gives an element, by name.

    Parameters
    ----------
    element
        Element of a model.
    known
        Names of features that generated code has by other ways.

    Returns
    -------
    Table
        Values; of a part its own features with its class as ``eClass``, of a reference an ID.
    """
    given = (
        feature
        for feature in features(element.eClass)
        if feature.name not in known
        and (element.eIsSet(feature) or getattr(feature, "defaultValueLiteral", None) is not None)
    )
    return Table(tuple((str(feature.name), _values(element, feature)) for feature in given))


def _values(element: Any, feature: Any) -> Expression:
    value = element.eGet(feature)
    if feature.many:
        return tuple(_value(entry, feature) for entry in value)
    return _value(value, feature)


def _value(value: Any, feature: Any) -> Expression:
    if value is not None and is_contained(feature):
        return Table((("eClass", str(value.eClass.name)), *own_features(value).entries))
    if value is not None and is_reference(feature):
        return str(getattr(value, "ID", None) or value.eURIFragment())
    if isinstance(value, EEnumLiteral):
        return str(value.name)
    return value if value is None or isinstance(value, int | float) else str(value)
