"""Dispatch on the metaclass, and the order of features."""

import pytest
from pyecore.ecore import EAttribute, EClass, EString

from m2t.metamodels import features, lineage
from m2t.visitors.base import ModelVisitor
from mrsfi_runtime.errors import GenerationError


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


def test_nearer_supertype_goes_before_the_supertypes_of_one_named_earlier():
    top = EClass("GoalTask", abstract=True)
    team = EClass("TeamTask", superclass=(top,), abstract=True)
    stay = EClass("Stay")
    own = EClass("Own", superclass=(team, stay))

    class Visitor(ModelVisitor):
        def visit_GoalTask(self, element):  # noqa: N802 - named after the metaclass
            return "far"

        def visit_Stay(self, element):  # noqa: N802 - named after the metaclass
            return "near"

    assert Visitor().visit(own()) == "near"


def test_element_goes_to_the_method_of_the_nearest_supertype(metaclasses):
    class Visitor(ModelVisitor):
        def visit_FaultType(self, element):  # noqa: N802 - named after the metaclass
            return "far"

        def visit_MessageFault(self, element):  # noqa: N802 - named after the metaclass
            return "near"

    assert Visitor().visit(metaclasses[2]()) == "near"


def test_unknown_metaclass_is_an_error_that_says_what_to_write(metaclasses):
    with pytest.raises(GenerationError, match="write visit_ZeroSpeed"):
        ModelVisitor().visit(metaclasses[2]())
