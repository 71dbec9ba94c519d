"""The objects that loading builds are those of pyecore, and the writer follows Eclipse's rules.

Compared on what pyecore's reader gets right: it crashes on comments, takes a misspelt literal for
none, and leaves a proxy in the place of a part that stands in a file of its own.
"""

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyecore.ecore import EEnumLiteral, EObject, EProxy
from pyecore.resources import ResourceSet

from m2t.metaclasses import features
from m2t.metamodels import load_metamodels
from m2t.models.load import load_mission_folder, save
from m2t.models.write import dumps, java_double
from mrsfi_runtime.errors import ModelError
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


def test_writing_is_a_fixpoint_for_every_kind_of_task(folder):
    tasks = [
        '<task xsi:type="mission:Patrol" period="7"><area ID="p1" radius="0.001"/></task>',
        '<task xsi:type="mission:Visit" tolerance="1.0" deadline="9"><coordinates x="1"/></task>',
        '<task xsi:type="mission:Track" tolerance="2"><trajectory/><trajectory y="1E-5"/></task>',
        '<task xsi:type="mission:Stay"><area radius="12345678.9" ID="p2"/></task>',
        '<task xsi:type="mission:FixedDistanceBetweenRobots" fixedDistance="1e7"/>',
    ]
    goals = "".join(
        f'<goals name="n" ID="n{index}" members="r1 r2" dependentGoals="g1">{task}</goals>'
        for index, task in enumerate(tasks)
    )
    edit(folder / MISSION, "</mission:Mission>", f"{goals}</mission:Mission>")
    edit(folder / MISSION, "Offshore server", "&#x9;&lt;a&gt; &amp; &quot;b&quot;&#xA;\N{SNOWMAN}")
    edit(folder / MISSION, '"ASCII"', '"UTF-8"')

    first = dumps(load_mission_folder(folder).mission)
    (folder / MISSION).write_bytes(first)
    second = dumps(load_mission_folder(folder).mission)

    assert second == first
    lines = first.decode("ascii").splitlines()
    start = next(index for index, line in enumerate(lines) if 'ID="n0"' in line)
    assert lines[start : start + 12] == [
        '  <goals ID="n0" name="n" members="r1 r2" dependentGoals="g1">',
        '    <task xsi:type="mission:Patrol" period="7">',
        '      <area ID="p1" radius="0.001"/>',
        "    </task>",
        "  </goals>",
        '  <goals ID="n1" name="n" members="r1 r2" dependentGoals="g1">',
        '    <task xsi:type="mission:Visit" deadline="9">',
        '      <coordinates x="1.0"/>',
        "    </task>",
        "  </goals>",
        '  <goals ID="n2" name="n" members="r1 r2" dependentGoals="g1">',
        '    <task xsi:type="mission:Track" tolerance="2.0">',
    ]
    assert '      <trajectory y="1.0E-5"/>' in lines
    assert '      <area ID="p2" radius="1.23456789E7"/>' in lines
    assert 'name="&#x9;&lt;a> &amp; &quot;b&quot;&#xA;&#x2603;"' in lines[29]


def test_set_value_is_written_although_it_equals_the_type_default(folder):
    edit(folder / MISSION, 'speed="5.0"', 'speed="0.0"')

    assert b'name="LEN" speed="0.0"' in dumps(load_mission_folder(folder).mission)


def test_encoding_keeps_the_characters_that_it_has(folder):
    edit(folder / MISSION, '"ASCII"', '"UTF-8"')
    edit(folder / MISSION, "LEN", "L\xe9\N{SNOWMAN}")
    mission = load_mission_folder(folder).mission

    assert b'"L&#xe9;&#x2603;"' in dumps(mission, "ASCII")
    assert b'"L\xe9&#x2603;"' in dumps(mission, "ISO-8859-1")
    assert '"L\xe9\N{SNOWMAN}"'.encode() in dumps(mission, "UTF-8")


def test_id_with_a_space_is_referred_to_by_path(folder):
    edit(folder / MISSION, 'ID="s4"', 'ID="s 4"')
    edit(folder / MISSION, 'sensor="s4"', 'sensor="//@robots.1/@sensors.1"')

    written = dumps(load_mission_folder(folder).mission)

    assert b'sensor="//@robots.1/@sensors.1"' in written


def test_reference_to_an_unknown_file_is_an_error(refused):
    models = load_mission_folder(MODELS)

    with refused(ModelError):
        dumps(models.faults)


def test_character_that_xml_lacks_is_an_error(refused):
    specification = load_metamodels().faults.getEClassifier("FaultSpecification")()
    specification.ID = "a\x00b"

    with refused(ModelError):
        dumps(specification)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0.0"),
        (-0.0, "-0.0"),
        (1.0, "1.0"),
        (-250.0, "-250.0"),
        (0.001, "0.001"),
        (0.00099, "9.9E-4"),
        (9999999.0, "9999999.0"),
        (1e7, "1.0E7"),
        (1.25e22, "1.25E22"),
        (5e-324, "4.9E-324"),
        (1.7976931348623157e308, "1.7976931348623157E308"),
    ],
)
def test_doubles_are_spelled_as_in_java(value, text):
    assert java_double(value) == text


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_spelled_doubles_are_read_back_bit_by_bit(value):
    assert struct.pack("<d", float(java_double(value))) == struct.pack("<d", value)


@pytest.mark.parametrize("encoding", ["UTF-8", "ISO-8859-1", "UTF-16", "ASCII"])
def test_saving_keeps_the_encoding_of_each_file(folder, encoding):
    text = (folder / MISSION).read_text(encoding="ascii").replace('"ASCII"', f'"{encoding}"')
    name = "L&#xe9;N" if encoding == "ASCII" else "L\xe9N"
    content = text.replace("LEN", name, 1).encode(encoding)
    if encoding == "UTF-16":  # Java writes it big-endian, Python here as the machine does
        content = b"\xfe\xff" + text.replace("LEN", name, 1).encode("UTF-16-BE")
    (folder / MISSION).write_bytes(content)
    models = load_mission_folder(folder)

    models.mission.robots[1].speed = 6.0
    written = save(models)

    assert written == (folder / MISSION,)
    changed = text.replace("LEN", name, 1).replace('speed="4.0"', 'speed="6.0"', 1)
    assert (folder / MISSION).read_bytes().decode(encoding) == changed


def test_encoding_is_written_in_capitals_as_eclipse_does(folder):
    edit(folder / MISSION, '"ASCII"', '"utf-8"')

    save(load_mission_folder(folder))

    assert (folder / MISSION).read_bytes().startswith(b'<?xml version="1.0" encoding="UTF-8"?>\n')


def test_xmi_ids_are_kept_and_named_by_references(folder):
    edit(folder / MISSION, 'name="1000"', 'xmi:id="_m" name="1000"')
    edit(folder / MISSION, '<sensors ID="s4"', '<sensors xmi:id="_s4" ID="s4"')
    edit(folder / MISSION, '<messages ID="m4"', '<messages xmi:id="_m4" ID="m4"')
    edit(folder / MISSION, 'sensor="s4"', 'sensor="_s4"')
    edit(folder / FAULTS, "mission.xmi#m4", "mission.xmi#_m4")
    models = load_mission_folder(folder)

    assert save(models) == ()
    models.mission.goals[4].task.sensor = models.mission.robots[1].sensors[1]
    assert save(models) == (folder / MISSION,)
    assert (folder / MISSION).read_bytes().count(b'sensor="_s4"') == 2


def test_saving_what_did_not_change_touches_no_file(folder):
    before = {path: path.stat().st_mtime_ns for path in folder.iterdir()}

    assert save(load_mission_folder(folder)) == ()

    assert {path: path.stat().st_mtime_ns for path in folder.iterdir()} == before


def test_element_that_an_earlier_one_refers_to_is_written_in_place(folder):
    edit(
        folder / MISSION,
        'name="AvoidCollision" members="r2 r3 r1"',
        'name="AvoidCollision" members="r2 r3 r1" dependentGoals="g2"',
    )

    assert save(load_mission_folder(folder)) == ()


def test_who_refers_to_what_was_deleted_is_named(folder, refused):
    models = load_mission_folder(folder)
    before = (folder / MISSION).read_bytes()
    models.mission.robots.remove(models.mission.robots[0])

    with refused(ModelError) as told:
        save(models)

    assert str(told.value).startswith("Goal 'g1' refers")
    assert (folder / MISSION).read_bytes() == before
