"""Identifiers, constants, features, discs of constraints, and lines in which texts differ."""

import difflib
import keyword
import math
import random
import re
import sys
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyecore.ecore import EAttribute, EClass, EString

from m2t.metaclasses import PROGRESSING, constant, features, identifier, lineage, snake_case
from m2t.models import constraints, write
from m2t.models.constraints import Discs, Point, distance
from m2t.models.write import SHORT, unified_difference
from mrsfi_runtime.errors import ModelError
from mrsfi_runtime.kernel.goal_tasks.table import TASKS

SPREADS = (0.0, 1.0, 5.0, 100.0, 1e12)
RADII = (2.0, 1.5, 3.0, 50.0, 4e11, math.nextafter(2.0, 0.0))
LINES = st.lists(st.sampled_from("abcdefg"), max_size=60)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("r1", "r1"),
        ("R1", "r1"),
        ("Scout-1", "scout_1"),
        ("scout 1", "scout_1"),
        ("sensor.depth__2", "sensor_depth_2"),
        ("r1_", "r1"),
    ],
)
def test_id_becomes_lower_case_identifier(text, expected):
    assert identifier(text) == expected


@pytest.mark.parametrize(
    "text",
    ["", "1r", "_", "-", "class", "Class", "topics", "truth", "r\n1", "r1\n", "rö1", "a;b", 'x")'],
)
def test_id_that_cannot_be_a_name_is_refused(text, refused):
    with refused(ModelError):
        identifier(text)


@given(st.text())
def test_identifier_is_a_python_and_ros_name_or_refused(text):
    try:
        name = identifier(text)
    except ModelError:
        return
    assert re.fullmatch(r"[a-z]([a-z0-9]|_(?=[a-z0-9]))*", name)
    assert not keyword.iskeyword(name)
    assert identifier(name) == name


def test_refusal_of_a_huge_id_stays_short():
    with pytest.raises(ModelError) as caught:
        identifier("é" * 10_000_000)

    assert len(str(caught.value)) < 1000


def test_constant_is_the_identifier_in_upper_case():
    assert constant("Scout-1") == "SCOUT_1"


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("AvoidCollision", "avoid_collision"),
        ("StayWithinMissionArea", "stay_within_mission_area"),
        ("SufficientEnergy", "sufficient_energy"),
        ("GatherSamples", "gather_samples"),
        ("Patrol", "patrol"),
        ("FixedDistanceBetweenRobots", "fixed_distance_between_robots"),
        ("GPSTask", "gps_task"),
    ],
)
def test_class_name_becomes_snake_case(name, expected):
    assert snake_case(name) == expected


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


def test_a_progress_region_is_generated_for_tasks_whose_module_has_progress():
    remembering = {
        task.__name__ for task in TASKS if hasattr(sys.modules[task.__module__], "progress")
    }

    assert remembering == PROGRESSING


def _first(discs: list[tuple[Point, float]], point: Point) -> int | None:
    found = (n for n, (center, radius) in enumerate(discs) if distance(point, center) < radius)
    return next(found, None)


@pytest.mark.parametrize("spread", SPREADS)
def test_first_disc_is_that_of_asking_all_in_order(spread):
    draw = random.Random(f"discs {spread}")
    found = Discs()
    discs: list[tuple[Point, float]] = []

    for number in range(400):
        point = (draw.uniform(-spread, spread), draw.uniform(-spread, spread))

        assert found.first_around(point) == _first(discs, point)

        radius = draw.choice(RADII)
        found.add(number, point, radius)
        discs.append((point, radius))


@pytest.mark.parametrize("step", [(2.0, 0.0), (0.0, -2.0), (-1.2, 1.6)])
def test_point_on_the_edge_lies_outside(step):
    found = Discs()
    found.add("disc", (1.0, 1.0), 2.0)

    assert found.first_around((1.0 + step[0], 1.0 + step[1])) is None
    assert found.first_around((1.0 + 0.99 * step[0], 1.0 + 0.99 * step[1])) == "disc"


def test_asks_few_discs_of_many_that_lie_apart(monkeypatch):
    n_asked = 0

    def counted(one: Point, other: Point) -> float:
        nonlocal n_asked
        n_asked += 1
        return distance(one, other)

    monkeypatch.setattr(constraints, "distance", counted)
    found = Discs()
    for number in range(2_000):
        point = (10.0 * (number % 50), 10.0 * (number // 50))
        found.first_around(point)
        found.add(number, point, 2.0)

    assert n_asked < 2_000


def _reference(old, new):
    return [*difflib.unified_diff(old, new, "old", "new", lineterm="")]


def _found(old, new):
    return [*unified_difference(old, new, "old", "new", "")]


def _applied(old, difference):
    """Return what a unified difference makes of lines."""
    new, at = [], 0
    for line in difference[2:]:
        if line.startswith("@@"):
            first, _, length = line.split()[1][1:].partition(",")
            begin = int(first) - (length != "0")
            new += old[at:begin]
            at = begin
        elif line.startswith("+"):
            new.append(line[1:])
        else:
            assert old[at] == line[1:]
            at += 1
            new += [line[1:]] if line.startswith(" ") else []
    return new + old[at:]


def _model(n_faults, *, every=1):
    """Return lines of a fault pool before and after the window of every nth fault is mended."""
    versions = []
    for window in ('start="9" finish="8"', 'start="8" finish="9"'):
        lines = []
        for n in range(n_faults):
            shown = window if n % every == 0 else ""
            lines += [
                f'  <faults ID="f{n}" name="fault {n}" {shown}>',
                "    <zeroSpeed>",
                f'      <affectedMessage href="mission.xmi#m{n % 100}"/>',
                "    </zeroSpeed>",
                "  </faults>",
            ]
        versions.append(lines)
    return versions


def _work(monkeypatch, old, new):
    """Return how many lines difflib looked at in its searches for the longest match."""
    looked_at = []

    class Counting(difflib.SequenceMatcher):
        def find_longest_match(self, alo=0, ahi=None, blo=0, bhi=None):
            looked_at.append(ahi - alo)
            return super().find_longest_match(alo, ahi, blo, bhi)

    monkeypatch.setattr(write, "SequenceMatcher", Counting)
    for _ in unified_difference(old, new, "old", "new"):
        pass
    return sum(looked_at)


@given(LINES, LINES)
def test_short_files_differ_as_difflib_says(old, new):
    assert _found(old, new) == _reference(old, new)


@given(st.integers(0, 2**32), st.sampled_from([2, 30, 5000]))
def test_the_difference_of_long_files_makes_the_new_of_the_old(seed, n_kinds):
    rng = Random(seed)
    old = [str(rng.randrange(n_kinds)) for _ in range(3 * SHORT)]
    new = old[:]
    for _ in range(40):
        first = rng.randrange(len(new))
        fresh = [str(rng.randrange(n_kinds)) for _ in range(rng.randrange(4))]
        new[first : first + rng.randrange(4)] = fresh
    new[SHORT:SHORT] = old[:100]

    assert _applied(old, _found(old, new)) == new


def test_mended_faults_differ_in_their_own_lines_only():
    old, new = _model(2000)

    found = _found(old, new)

    assert [line for line in found[2:] if line.startswith("-")] == [
        f"-{line}" for line in old if "start" in line
    ]
    assert _applied(old, found) == new


def test_a_long_insertion_is_one_hunk():
    old, _ = _model(600)
    new = [*old[:1000], *(f"new {n}" for n in range(5 * SHORT)), *old[1000:]]

    found = _found(old, new)

    assert sum(line.startswith("@@") for line in found) == 1
    assert sum(line.startswith("-") for line in found[2:]) == 0


@pytest.mark.parametrize("every", [1, 2])
def test_work_grows_as_the_number_of_defects(monkeypatch, every):
    some = _work(monkeypatch, *_model(1000, every=every))
    more = _work(monkeypatch, *_model(4000, every=every))

    assert 0 < more < 5 * some


def test_files_with_nothing_in_common_are_replaced_as_a_whole():
    old, new = [f"a{n}" for n in range(5 * SHORT)], [f"b{n}" for n in range(5 * SHORT)]

    found = _found(old, new)

    assert found[3:] == [*(f"-{line}" for line in old), *(f"+{line}" for line in new)]
