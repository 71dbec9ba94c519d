"""The static classes of the metamodels: faithful, deterministic, typed, and good for models."""

import ast
import inspect
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from pyecore.ecore import EAttribute, ENamedElement, EString

from generated.metamodel import elements, faults, mission
from m2t.classes import class_files, main, write_classes
from m2t.metamodels import load_metamodels
from m2t.models.load import LoadedFile, LoadedModels, load_mission_folder, save, saved, with_classes
from m2t.models.write import dumps
from m2t.read import Spelling
from mrsfi_runtime.errors import ModelError
from tests.integration.metamodels import HOSTILE, load_generated, metaclass, odd_package, package
from tests.support.models.copies import MODELS, copy_models, edit
from tests.support.models.generation import ROOT, contents
from tests.support.models.random_models import draw
from tests.tiers import slow

STATIC = ROOT / "generated" / "metamodel"
FACTS = ("lowerBound", "upperBound", "ordered", "unique", "unsettable", "changeable", "transient")


@pytest.fixture
def copied(tmp_path):
    return copy_models(tmp_path, "uuv_sampling")


def facts(feature: Any) -> dict[str, Any]:
    """Return all that a metamodel says about a feature."""
    return {
        "name": feature.name,
        "type": feature.eType.name,
        "id": getattr(feature, "iD", None),
        "containment": getattr(feature, "containment", None),
        "default": getattr(feature, "defaultValueLiteral", None),
        "annotations": annotations(feature),
        **{name: getattr(feature, name) for name in FACTS},
    }


def annotations(element: Any) -> list[tuple[str, dict[str, str]]]:
    return [(entry.source, dict(entry.details)) for entry in element.eAnnotations]


def dynamic_classes(package: Any) -> dict[str, Any]:
    return {entry.name: entry for entry in package.eClassifiers if hasattr(entry, "abstract")}


def test_committed_classes_are_those_of_the_metamodels():
    assert contents(STATIC) == class_files(load_metamodels().packages)


@pytest.mark.parametrize("module", [mission, faults], ids=["mission", "faults"])
def test_classes_keep_all_that_the_metamodel_says(module):
    package = getattr(load_metamodels(), module.name)

    static = {
        entry.name: entry for entry in module.eClass.eClassifiers if hasattr(entry, "abstract")
    }

    assert list(static) == list(dynamic_classes(package))
    assert annotations(module.eClass) == annotations(package)
    for name, wanted in dynamic_classes(package).items():
        found = static[name]
        assert found.abstract == wanted.abstract
        assert annotations(found) == annotations(wanted)
        parents = [parent.name for parent in wanted.eSuperTypes]
        assert [parent.name for parent in found.eSuperTypes] == parents
        assert [facts(feature) for feature in found.eStructuralFeatures] == [
            facts(feature) for feature in wanted.eStructuralFeatures
        ]


def test_enumeration_keeps_its_values():
    values = {entry.name: entry.value for entry in mission.SensorType.eLiterals}

    assert values == {"GPS_POSITION": 1, "DEPTH": 2, "TEMPERATURE": 3, "PRESSURE": 4}


@pytest.mark.parametrize("mission", ["uuv_sampling", "tight_energy", "fleet_30", "depot"])
def test_build_script_writes_the_committed_models(tmp_path, mission):
    models = ROOT / "models" / mission

    subprocess.run([sys.executable, models / "build.py", tmp_path], check=True, cwd=ROOT)

    for name in ("mission.xmi", "faults.xmi"):
        assert (tmp_path / name).read_bytes() == (models / name).read_bytes()


@pytest.mark.parametrize("name", ["uuv_sampling", "tight_margins"])
def test_loaded_models_become_static_objects_with_the_same_bytes(name):
    models = load_mission_folder(ROOT / "models" / name)

    typed = with_classes(models, mission, faults)

    assert isinstance(typed.mission, mission.Mission)
    assert isinstance(typed.faults, faults.FaultSpecification)
    assert saved(typed) == saved(models)
    assert len(typed.nodes) == len(models.nodes)


@slow
def test_random_models_of_static_objects_have_the_same_bytes():
    for seed in range(25):
        drawn = draw(seed)
        files = (
            LoadedFile(Path("mission.xmi"), Spelling("UTF-8"), (drawn.mission,)),
            LoadedFile(Path("faults.xmi"), Spelling("UTF-8"), (drawn.faults,)),
        )
        models = LoadedModels(drawn.mission, drawn.faults, files[0].path, nodes={}, files=files)

        typed = with_classes(models, mission, faults)

        assert saved(typed) == saved(models), f"seed {seed}"


def test_new_static_elements_join_a_loaded_mission(copied):
    models = with_classes(load_mission_folder(copied), mission, faults)
    spare = mission.Battery(ID="b9", name="Spare battery", totalEnergy=500)

    models.mission.robots[0].batteries.append(spare)
    changed = save(models)

    assert changed == (copied / "mission.xmi",)
    batteries = load_mission_folder(copied).mission.robots[0].batteries
    assert [(entry.ID, entry.totalEnergy) for entry in batteries][-1] == ("b9", 500.0)


def test_mission_without_faults_becomes_static_objects(copied):
    (copied / "faults.xmi").unlink()

    typed = with_classes(load_mission_folder(copied), mission, faults)

    assert typed.faults is None
    assert [robot.ID for robot in typed.mission.robots] == ["r1", "r2", "r3"]


def test_split_mission_keeps_its_files(copied):
    content = 'ID="b1" name="First battery of LEN" totalEnergy="20000.0"/>'
    edit(copied / "mission.xmi", f"<batteries {content}", '<batteries href="b1.xmi#b1"/>')
    (copied / "b1.xmi").write_text(
        '<?xml version="1.0" encoding="ASCII"?>\n<mission:Battery xmi:version="2.0" '
        'xmlns:xmi="http://www.omg.org/XMI" xmlns:mission="http://mrsfi.org/mission/1.0" '
        f"{content}\n"
    )

    typed = with_classes(load_mission_folder(copied), mission, faults)
    typed.mission.robots[0].batteries[0].totalEnergy = 7

    assert save(typed) == (copied / "b1.xmi",)


def test_models_of_other_packages_are_refused(refused):
    models = load_mission_folder(MODELS)

    with refused(ModelError):
        with_classes(models, mission)


def test_whole_numbers_are_accepted_for_doubles():
    robot = mission.Robot(speed=5)

    robot.eSet("speed", 6)

    assert repr(robot.speed) == "6.0"


def test_misspelt_features_are_refused(refused):
    robot = mission.Robot()

    with refused(AttributeError):
        robot.spede = 6.0
    with refused(TypeError):
        mission.Robot(eClass=None)


@pytest.mark.parametrize(
    "made",
    [
        lambda: mission.Sensor(type="TEMP"),
        lambda: mission.Sensor(type="DEPHT"),
        lambda: mission.Robot(speed="5"),
        lambda: mission.Robot(ID=5),
        lambda: mission.Mission(duration=True),
        lambda: mission.Mission(duration=1.5),
        lambda: mission.Mission(robots=mission.Robot(ID="r")),
        lambda: mission.Mission().robots.append("r1"),
        lambda: faults.StopRobot(affectedRobot=mission.Goal()),
    ],
)
def test_values_of_another_kind_are_refused(made, refused):
    with refused(TypeError):
        made()


def test_a_literal_may_be_given_by_its_name():
    assert mission.Sensor(type="DEPTH").type is mission.SensorType.DEPTH


def test_abstract_classes_have_no_objects(refused):
    with refused(TypeError):
        mission.GoalTask()


def test_stub_of_lists_promises_what_lists_have():
    stub = (STATIC / "elements.pyi").read_text()
    methods = [
        line.split("(")[0].removeprefix("    def ")
        for line in stub.splitlines()
        if "    def " in line
    ]

    listed = mission.Robot().sensors
    assert methods
    assert [
        name for name in methods if not hasattr(listed, name) and not hasattr(mission.Robot, name)
    ] == []


def test_lists_of_objects_keep_order_and_change_in_place():
    first, second, third = (mission.Sensor(ID=identity) for identity in ("a", "b", "c"))
    robot = mission.Robot(sensors=[first])

    robot.sensors.extend([third])
    robot.sensors.insert(1, second)
    last = robot.sensors.pop()
    robot.sensors.remove(first)

    assert list(robot.sensors) == [second]
    assert (last, robot.sensors[0], robot.sensors.index(second)) == (third, second, 0)


def test_type_checker_accepts_right_scripts_and_finds_misspelt_features(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "from generated.metamodel import faults, mission\n"
        "robot = mission.Robot(ID='r1', speed=5, sensors=[mission.Sensor(ID='s1')])\n"
        "robot.sensors.append(mission.Sensor(type=mission.SensorType.DEPTH))\n"
        "names: list[str] = [sensor.type.name for sensor in robot.sensors]\n"
        "goal = mission.Goal(members=[robot], task=mission.Stay())\n"
        "stop = faults.Fault(stopRobot=faults.StopRobot(affectedRobot=robot), start=3)\n"
        "robot.spede = 6.0\n"
        "mission.Robot(speed='fast')\n"
        "goal.task = robot\n"
        "mission.SensorType.SONAR\n"
    )

    options = ["--strict", "--config-file=", f"--cache-dir={tmp_path}"]
    options += ["--namespace-packages", "--explicit-package-bases"]

    checked = subprocess.run(
        [sys.executable, "-m", "mypy", *options, script],
        cwd=tmp_path,
        env={**os.environ, "MYPYPATH": str(ROOT)},
        check=False,
        capture_output=True,
        text=True,
    )

    lines = [line.split(":", 3)[1] for line in checked.stdout.splitlines() if ": error:" in line]
    assert lines == ["7", "8", "9", "10"], checked.stdout + checked.stderr


def test_odd_metamodels_become_classes_that_write_what_they_should(tmp_path):
    odd = load_generated(tmp_path / "odd_classes", odd_package())["odd"]

    child = odd.Node(class_="leaf", level=odd.Level.HIGH)
    root = odd.Node(class_="root", words=["a", "b", "a"], children=[child], count=8)

    assert (child.level.value, odd.Level.LOW.value, root.level.name) == (-3, 10, "HIGH")
    lines = dumps(root).decode().splitlines()
    assert lines[1].endswith('xmlns:odd="http://example.org/odd" class="root" count="8">')
    assert lines[2:] == [
        "  <words>a</words>",
        "  <words>b</words>",
        "  <words>a</words>",
        '  <children class="leaf" level="HIGH"/>',
        "</odd:Node>",
    ]
    feature = odd.Node.eClass.findEStructuralFeature("class")
    assert annotations(feature) == [
        ("http://example.org/note", {"key": "a 'word'", "other": '"\\'})
    ]


def test_hostile_documentation_stays_text(tmp_path):
    odd = load_generated(tmp_path / "documented_classes", odd_package())["odd"]

    stub = ast.parse((tmp_path / "documented_classes" / "odd.pyi").read_text(encoding="utf-8"))

    described = [entry for entry in stub.body if getattr(entry, "name", "") == "Node"]
    assert [ast.get_docstring(entry, clean=False) for entry in described] == [HOSTILE]
    assert odd.Node.__doc__ == HOSTILE


@pytest.mark.parametrize(
    "packages",
    [
        (package("p", metaclass("lambda")),),
        (package("p", metaclass("Element")),),
        (package("p", metaclass("A", EAttribute("ecore", EString))),),
    ],
)
def test_names_that_classes_use_themselves_are_refused_and_pyecore_stays(packages, refused):
    before = ENamedElement.__getattribute__

    with refused(ModelError):
        class_files(packages)

    assert ENamedElement.__getattribute__ is before


def test_second_run_changes_nothing(tmp_path):
    files = class_files(load_metamodels().packages)
    write_classes(tmp_path, files)
    before = {path: path.stat().st_mtime_ns for path in (tmp_path, *tmp_path.iterdir())}

    written = write_classes(tmp_path, files)

    assert written == ()
    assert {path: path.stat().st_mtime_ns for path in (tmp_path, *tmp_path.iterdir())} == before


def test_file_that_was_not_generated_is_kept(tmp_path):
    (tmp_path / "mission.py").write_text("precious = True\n")

    result = CliRunner().invoke(main, [str(tmp_path)])

    assert result.exit_code == 4
    assert "was not generated" in result.stderr
    assert contents(tmp_path) == {"mission.py": "precious = True\n"}


def test_check_names_stale_files_and_writes_nothing(tmp_path):
    write_classes(tmp_path, class_files(load_metamodels().packages))
    (tmp_path / "faults.pyi").unlink()

    fresh = CliRunner().invoke(main, [str(STATIC), "--check"])
    stale = CliRunner().invoke(main, [str(tmp_path), "--check"])

    assert (fresh.exit_code, stale.exit_code) == (0, 4)
    assert "faults.pyi" in stale.stderr
    assert not (tmp_path / "faults.pyi").exists()


def test_classes_explain_themselves():
    assert inspect.getdoc(mission.Robot).startswith("A robot of the team.")
    assert isinstance(mission.Robot(), elements.Element)
