"""What a team adds to the metamodel: it reaches the regions as constants, or is an error."""

import pytest

from m2t.generate import generate
from mrsfi_runtime.errors import ModelError
from tests.support.models.copies import edit
from tests.support.models.generation import GENERATED, run_module
from tests.support.models.loiter import write_loiter
from tests.support.own_metamodels import a_class, an_enumeration, attribute, many, part, reference
from tests.support.tree import ROOT


@pytest.fixture
def models(tmp_path, own_metamodels):
    return write_loiter(tmp_path, own_metamodels)


def constants(models):
    """Return the constants of the generated code, but those of the task's own features."""
    target = models.parent.parent / "generated" / models.name
    generate(models, target)
    names: dict[str, object] = {}
    exec((target / "collective_intelligence.py").read_text(encoding="utf-8"), names)
    known = {"NEAR", "INSIDE", "A", "A_GPS", "A_DEPTH"}
    return {
        name: value
        for name, value in names.items()
        if name.isupper() and name not in known and not name.startswith("NEAR_")
    }


def mission(models):
    return models / "mission.xmi"


def test_features_of_every_class_of_ours(models, own_metamodels):
    own_metamodels.extend("Mission", attribute("current", "EDouble"))
    own_metamodels.extend("Robot", attribute("payload", "EDouble"))
    own_metamodels.extend("Sensor", attribute("depthRating", "EInt"))
    own_metamodels.extend("Battery", attribute("maker"))
    own_metamodels.extend("Server", attribute("isBackup", "EBoolean"))
    own_metamodels.extend("Goal", attribute("weight", "EDouble"))
    own_metamodels.extend("Area", attribute("colour"))
    own_metamodels.extend("Coordinates", attribute("accuracy", "EDouble"))
    own_metamodels.extend("Message", attribute("rate", "EInt"))
    own_metamodels.extend("MessageData", attribute("unit"))
    edit(mission(models), '<robots ID="a"', '<robots ID="a" payload="3.0"')
    edit(mission(models), '<body name="SPEED"', '<body unit="kn" name="SPEED"')
    edit(mission(models), '<home x="30.0"', '<home accuracy="0.5" x="30.0"')

    found = constants(models)

    assert found == {
        "MISSION_CURRENT": 0.0,
        "WHOLE_COLOUR": "",
        "WHOLE_CORNERS_ACCURACY": (),
        "A_PAYLOAD": 3.0,
        "A_GPS_DEPTH_RATING": 0,
        "A_DEPTH_DEPTH_RATING": 0,
        "A_BATTERY_MAKER": "",
        "BASE_IS_BACKUP": False,
        "INSIDE_WEIGHT": 0.0,
        "FROM_A_RATE": 0,
        "FROM_A_BODY_UNIT": ("", "", "kn"),
    }
    text = models.parent.parent / "generated" / models.name / "collective_intelligence.py"
    assert "NEAR_HOME_ACCURACY = 0.5\n" in text.read_text(encoding="utf-8")
    assert "NEAR_STOPS_ACCURACY = (0.0, 0.0)\n" in text.read_text(encoding="utf-8")


def test_parts_of_a_teams_own(models, own_metamodels):
    own_metamodels.add(
        a_class("Layer", "", attribute("depth", "EDouble") + attribute("salt", "EInt", many())),
        a_class(
            "Zone",
            "#//Identified",
            part("disc", "Area") + part("layers", "Layer", many()) + reference("next", "Zone"),
        ),
    )
    own_metamodels.extend("Mission", part("zones", "Zone", many()))
    own_metamodels.extend("Robot", part("hull", "Layer"), reference("lair", "Zone"))
    edit(
        mission(models),
        "</mission:Mission>",
        '<zones ID="z1" next="z2"><disc ID="d1" radius="2.0"/><layers depth="1.0"><salt>3</salt>'
        '</layers><layers depth="4.0"/></zones><zones ID="z2"><disc ID="d2" radius="5.0"/></zones>'
        "</mission:Mission>",
    )
    edit(
        mission(models),
        '<robots ID="a" name="a" speed="3.0">',
        '<robots ID="a" name="a" speed="3.0" lair="z2">',
    )

    assert constants(models) == {
        "A_LAIR": 1,
        "MISSION_ZONES_ID": ("z1", "z2"),
        "MISSION_ZONES_DISC": ((0.0, 0.0, 0.0, 2.0), (0.0, 0.0, 0.0, 5.0)),
        "MISSION_ZONES_LAYERS_DEPTH": ((1.0, 4.0), ()),
        "MISSION_ZONES_LAYERS_SALT": (((3,), ()), ()),
        "MISSION_ZONES_NEXT": (1, -1),
    }


def test_a_subclass_of_a_task_flies_as_that_task_with_constants(models, own_metamodels):
    own_metamodels.add(
        a_class("Strict", "#//StayWithinMissionArea", attribute("margin", "EDouble"))
    )
    edit(mission(models), '"mission:StayWithinMissionArea"', '"mission:Strict" margin="7.5"')

    assert constants(models) == {"INSIDE_MARGIN": 7.5}

    target = models.parent.parent / "generated" / models.name
    assert "task=StayWithinMissionArea()" in (target / "mission_loader.py").read_text()


def test_generated_code_with_many_constants_is_formatted(models, own_metamodels):
    own_metamodels.extend("Robot", attribute("marks", "EDouble", many()))
    marks = "".join(f"<marks>{n}.5</marks>" for n in range(40))
    edit(mission(models), '<sensors ID="a_gps"', f'{marks}<sensors ID="a_gps"')

    assert len(constants(models)["A_MARKS"]) == 40

    target = models.parent.parent / "generated" / models.name
    run_module("ruff", "format", "--check", "--config", ROOT / "pyproject.toml", target)


def test_an_enumeration_becomes_the_name_of_its_literal(models, own_metamodels):
    own_metamodels.add(an_enumeration("Colour", "RED", "BLUE"))
    own_metamodels.extend("Robot", attribute("colours", "#//Colour", many()))
    edit(
        mission(models),
        '<sensors ID="a_gps"',
        '<colours>BLUE</colours><colours>RED</colours><sensors ID="a_gps"',
    )

    assert constants(models) == {"A_COLOURS": ("BLUE", "RED")}


REFUSED = {
    "one name": (lambda own: own.extend("Robot", attribute("gps")), ("", "")),
    "no index": (
        lambda own: own.extend("Robot", reference("spare", "Battery")),
        ('<robots ID="a"', '<robots ID="a" spare="a_battery"'),
    ),
    "different classes": (
        lambda own: own.add(a_class("Note", "#//Mark")),
        ('<marks depth="2.0"/>', '<marks xsi:type="mission:Note"/>'),
    ),
    "one of many": (
        lambda own: own.extend("Mark", part("place", "Coordinates")),
        ('<marks depth="2.0"/>', '<marks depth="2.0"><place/></marks>'),
    ),
    "two classes": (
        lambda own: own.add(a_class("Both", "#//Loiter #//Patrol #//SufficientEnergy")),
        ("", ""),
    ),
}


@pytest.mark.parametrize("why", REFUSED)
def test_what_code_cannot_know_is_refused(models, own_metamodels, why, refused):
    add, (found, replaced) = REFUSED[why]
    add(own_metamodels)
    edit(mission(models), found, replaced)

    with refused(ModelError):
        constants(models)


def test_without_additions_there_are_indices_only():
    names: dict[str, object] = {}
    exec((GENERATED / "collective_intelligence.py").read_text(encoding="utf-8"), names)

    assert {type(value) for name, value in names.items() if name.isupper()} == {int}
