"""The metamodels: documented throughout, and in step with the runtime's vocabulary."""

from typing import Any

import pytest

from m2t.metaclasses import conforms, features
from m2t.metamodels import load_metamodels
from m2t.models.check import RANGES
from tests.support.fault_types import FAULT_TYPES
from tests.support.features import reference_type
from tests.support.models.shapes import TASKS

PACKAGES = load_metamodels().packages
CLASSES = [
    kind
    for package in PACKAGES
    for kind in package.eClassifiers
    if hasattr(kind, "eStructuralFeatures")
]
AFFECTED = {"message": "Message", "robot": "Robot", "sensor": "Sensor", "obstacle": "Obstacle"}


def _documentation(element: Any) -> str:
    texts = [
        annotation.details.get("documentation", "")
        for annotation in element.eAnnotations
        if annotation.source == "http://www.eclipse.org/emf/2002/GenModel"
    ]
    return texts[0] if texts else ""


def _class(name: str) -> Any:
    return next(kind for kind in CLASSES if kind.name == name)


@pytest.mark.parametrize("kind", CLASSES, ids=lambda kind: kind.name)
def test_class_and_features_are_documented_in_sentences(kind):
    for element in (kind, *kind.eStructuralFeatures):
        text = _documentation(element)
        assert text[:1].isupper(), element.name
        assert text.endswith("."), element.name
        assert len(text.split()) >= 4, element.name


def test_there_are_nine_tasks():
    tasks = [kind.name for kind in CLASSES if conforms(kind, _class("GoalTask"))]

    assert tasks == ["GoalTask", *TASKS]


def test_a_fault_contains_each_fault_type_by_its_name():
    contained = {
        reference_type(feature).name: feature.name
        for feature in _class("Fault").eStructuralFeatures
        if getattr(feature, "containment", False)
    }

    assert contained == {name: name[0].lower() + name[1:] for name in FAULT_TYPES}


@pytest.mark.parametrize("name", FAULT_TYPES)
def test_fault_type_agrees_with_the_runtime(name):
    kind, fault_type = _class(name), FAULT_TYPES[name]
    references = [feature for feature in features(kind) if hasattr(feature, "containment")]
    own = [feature.name for feature in kind.eStructuralFeatures]
    expected = []
    for parameter in fault_type.parameters:
        bounds = [f"{parameter.name}_MIN", f"{parameter.name}_MAX"] if parameter.evolves else []
        expected += [parameter.name, *bounds]

    assert own == expected
    assert [reference_type(feature).name for feature in references] == [
        AFFECTED[fault_type.struck.value]
    ]


def test_required_numbers_can_be_told_from_absent_ones():
    for kind in CLASSES:
        for feature in kind.eStructuralFeatures:
            is_number = feature.eType.name in ("EInt", "EDouble", "SensorType")
            if is_number and feature.lowerBound:
                assert feature.unsettable, f"{kind.name}.{feature.name}"


def test_no_class_inherits_twice():
    for kind in CLASSES:
        assert len(kind.eSuperTypes) <= 1, kind.name


def test_ranges_speak_of_features_that_exist():
    names = {feature.name for kind in CLASSES for feature in kind.eStructuralFeatures}

    assert set(RANGES) <= names
