"""The order of features."""

import pytest
from pyecore.ecore import EAttribute, EClass, EString

from m2t.metaclasses import features, lineage


@pytest.fixture
def metaclasses():
    base = EClass("FaultType", abstract=True)
    middle = EClass("MessageFault", superclass=(base,), abstract=True)
    leaf = EClass("ZeroSpeed", superclass=(middle,))
    for owner, names in ((base, "ab"), (middle, "cd"), (leaf, "fe")):
        for name in names:
            owner.eStructuralFeatures.append(EAttribute(name, EString))
    return base, middle, leaf


def test_lineage_ends_with_the_class_itself(metaclasses):
    base, middle, leaf = metaclasses

    assert lineage(leaf) == (base, middle, leaf)


def test_features_are_in_metamodel_order_inherited_ones_first(metaclasses):
    leaf = metaclasses[2]

    assert [feature.name for feature in features(leaf)] == ["a", "b", "c", "d", "f", "e"]


def test_features_of_two_supertypes_come_in_the_order_of_the_supertypes():
    one, other = EClass("One"), EClass("Other")
    one.eStructuralFeatures.append(EAttribute("a", EString))
    other.eStructuralFeatures.append(EAttribute("b", EString))
    both = EClass("Both", superclass=(one, other))

    assert [feature.name for feature in features(both)] == ["a", "b"]
