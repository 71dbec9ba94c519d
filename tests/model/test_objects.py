"""The objects that loading builds are those that pyecore's own reader makes of the same files.

Compared on what that reader gets right: it crashes on comments, takes a misspelt literal for none,
and leaves a proxy in the place of a part that stands in a file of its own.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pyecore.ecore import EEnumLiteral, EObject, EProxy
from pyecore.resources import ResourceSet

from m2t.metaclasses import features
from m2t.metamodels import load_metamodels
from m2t.models.load import load_mission_folder
from m2t.models.write import dumps
from tests.support.features import is_contained
from tests.support.models.copies import FAULTS, MISSION, MODELS, copy_models, edit
from tests.support.models.random_models import draw
from tests.tiers import seeds

N_DRAWN = 150

FOLDERS = sorted(path.parent for path in MODELS.parent.glob(f"*/{MISSION}"))
"""Mission folders of the repository."""


def _of_pyecore(path: Path) -> Any:
    """Return the root that pyecore makes of a file, alone."""
    resources = ResourceSet()
    for package in load_metamodels().packages:
        resources.metamodel_registry[package.nsURI] = package
    return resources.get_resource(str(path)).contents[0]


def _described(root: Any) -> Iterator[tuple[str, object]]:
    """Yield what an object and all in it hold: path, feature and value, in model order."""
    yield root.eURIFragment(), (root.eClass.name, type(root))
    for feature in features(root.eClass):
        value = root.eGet(feature)
        entries = list(value) if feature.many else [value]
        shown = [_shown(entry) for entry in entries]
        yield f"{root.eURIFragment()} {feature.name}", (bool(root.eIsSet(feature)), shown)
        if is_contained(feature):
            for entry in filter(None, entries):
                assert entry.eContainer() is root
                assert entry.eContainmentFeature() is feature
                yield from _described(entry)


def _shown(value: Any) -> object:
    """Return a value that can be compared: an object by class and by place in its file."""
    if isinstance(value, EProxy):
        value.force_resolve()
        value = value._wrapped
    if isinstance(value, float):
        return repr(value)  # tells -0.0 from 0.0
    if isinstance(value, EEnumLiteral) or not isinstance(value, EObject):
        return value
    return value.eClass, value.eRoot().eClass.name, value.eURIFragment()


def _require_equal(folder: Path) -> None:
    models = load_mission_folder(folder)

    for name, root in ((MISSION, models.mission), (FAULTS, models.faults)):
        if root is not None:
            assert list(_described(root)) == list(_described(_of_pyecore(folder / name)))


def test_there_are_models():
    assert len(FOLDERS) >= 3


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.name)
def test_models_of_the_repository_are_loaded_as_pyecore_loads_them(folder):
    _require_equal(folder)


@pytest.mark.parametrize("seed", seeds(range(N_DRAWN), 10, 40))
def test_random_models_are_loaded_as_pyecore_loads_them(tmp_path, seed):
    models = draw(seed)
    (tmp_path / MISSION).write_bytes(dumps(models.mission))
    (tmp_path / FAULTS).write_bytes(dumps(models.faults, hrefs={models.mission: MISSION}))

    _require_equal(tmp_path)


def test_attribute_as_an_element_is_loaded_as_pyecore_loads_it(folder):
    edit(folder / MISSION, '<robots ID="r1" name="LEN"', '<robots ID="r1"')
    edit(folder / MISSION, '<position x="250.0" y="-250.0"', "<name>L&amp;N</name>\n<position")

    _require_equal(folder)


def test_objects_stand_in_a_resource_that_finds_them_by_id_and_by_path(tmp_path):
    mission = load_mission_folder(copy_models(tmp_path)).mission

    resource = mission.eResource

    assert mission.robots[1].sensors[0].eResource is resource
    assert resource.resolve("s4") is resource.resolve("//@robots.1/@sensors.1")
    assert resource.resolve("s4").ID == "s4"
