"""Message definitions: the text format, the table, checks and defaults."""

import math
from pathlib import Path

import pytest
from rosbags.typesys import Stores, get_typestore

from mrsfi_bridge.errors import ProtocolError, SettingsError
from mrsfi_bridge.settings import STANDARD, TypeTable, _standard_message
from tests.support.bridge import TYPES


def define(folder: Path, name: str, text: str, kind: str = "msg") -> Path:
    package, _, type_name = name.partition("/")
    path = folder / package / kind / f"{type_name}.{kind}"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def test_every_definition_that_comes_with_the_server_is_sound():
    n_files = sum(1 for path in STANDARD.rglob("*.*"))

    assert TypeTable([STANDARD]).check() == n_files > 25


def test_every_message_of_ros_1_has_its_defaults():
    names = get_typestore(Stores.ROS1_NOETIC).fielddefs

    defaults = {name: TYPES.message(name).default() for name in names if "builtin" not in name}

    assert len(defaults) > 150
    assert defaults["std_msgs/msg/Empty"] == {}
    assert defaults["sensor_msgs/msg/Joy"]["axes"] == []
    assert defaults["geometry_msgs/msg/TwistWithCovariance"]["covariance"] == [0.0] * 36


def test_messages_that_come_with_the_server_are_those_of_ros_2():
    read, known = TypeTable(ros=2), get_typestore(Stores.ROS2_JAZZY).fielddefs
    names = [f"{path.parts[-3]}/{path.stem}" for path in STANDARD.glob("*/msg/*.msg")]
    shared = [name for name in names if name.replace("/", "/msg/") in known]

    assert sorted(shared) == [
        *("action_msgs/GoalInfo", "tf2_msgs/TF2Error", "tf2_msgs/TFMessage"),
        "unique_identifier_msgs/UUID",
    ]
    for name in shared:
        assert read.message(name).definition == _standard_message(name, 2)


@pytest.mark.parametrize("ros", [1, 2])
def test_actions_of_the_tutorials_are_known(ros):
    types = TypeTable(ros=ros)

    found = {
        name: types.action(name)
        for name in ("example_interfaces/Fibonacci", "actionlib/TestAction")
    }

    assert [
        [part.default() for part in (each.request, each.response, each.feedback)]
        for each in found.values()
    ] == [
        [{"order": 0}, {"sequence": []}, {"sequence": []}],
        [{"goal": 0}, {"result": 0}, {"feedback": 0}],
    ]
    error = types.action("tf2_msgs/action/LookupTransform").response.default()["error"]
    assert error == {"error": 0, "error_string": ""}


@pytest.mark.parametrize("spelling", ["geometry_msgs/Point", "geometry_msgs/msg/Point"])
def test_both_spellings_name_one_type(spelling):
    assert TYPES.message(spelling) is TYPES.message("geometry_msgs/Point")


def test_missing_fields_get_defaults_in_the_order_of_the_definition():
    message = TYPES.message("geometry_msgs/Pose").convert({"position": {"y": 2}})

    assert list(message.items()) == [
        ("position", {"x": 0.0, "y": 2.0, "z": 0.0}),
        ("orientation", {"x": 0.0, "y": 0.0, "z": 0.0, "w": 0.0}),
    ]


def test_fixed_arrays_default_to_their_length_and_byte_arrays_to_base64(tmp_path):
    define(tmp_path, "a/T", "float64[3] v\nuint8[2] b\nuint8[] c\nint8[] d\n")

    message = TypeTable([tmp_path]).message("a/T").convert({})

    assert message == {"v": [0.0, 0.0, 0.0], "b": "AAA=", "c": "", "d": []}


def test_bytes_are_accepted_as_list_and_as_base64(tmp_path):
    define(tmp_path, "a/T", "uint8[] b\n")
    structure = TypeTable([tmp_path]).message("a/T")

    assert structure.convert({"b": [1, 2, 255]}) == {"b": "AQL/"}
    assert structure.convert({"b": "AQL/"}) == {"b": "AQL/"}


def test_null_is_no_number():
    assert math.isnan(TYPES.message("std_msgs/Float64").convert({"data": None})["data"])


@pytest.mark.parametrize(
    ("type_name", "message"),
    [
        ("std_msgs/Float64", {"data": "1"}),
        ("std_msgs/Float64", {"data": True}),
        ("std_msgs/Float64", {"data": 10**400}),
        ("std_msgs/Float64", {"date": 1}),
        ("std_msgs/Empty", {"data": 1}),
        ("std_msgs/Int8", {"data": 128}),
        ("std_msgs/UInt8", {"data": -1}),
        ("std_msgs/Int32", {"data": 1.0}),
        ("std_msgs/Int64", {"data": 2**63}),
        ("std_msgs/Bool", {"data": 1}),
        ("std_msgs/String", {"data": None}),
        ("std_msgs/String", {"data": "\ud800"}),
        ("std_msgs/Time", {"data": {"secs": -1}}),
        ("std_msgs/Time", {"data": {"sec": 1}}),
        ("geometry_msgs/Pose", {"position": {"x": "a"}}),
        ("geometry_msgs/Pose", {"position": [1, 2]}),
        ("sensor_msgs/JointState", {"position": [1, "a"]}),
        ("sensor_msgs/JointState", {"position": 1}),
        ("nav_msgs/Odometry", {"pose": {"covariance": [1]}}),
        ("sensor_msgs/Image", {"data": "?"}),
        ("sensor_msgs/Image", {"data": [256]}),
    ],
)
def test_what_does_not_fit_is_refused_with_place_and_expectation(type_name, message, refused):
    with refused(ProtocolError):
        TYPES.message(type_name).convert(message)


def test_a_long_value_is_not_repeated_in_full():
    with pytest.raises(ProtocolError) as refusal:
        TYPES.message("std_msgs/Float64").convert({"data": "x" * 10_000})

    assert len(str(refusal.value)) < 200


@pytest.mark.parametrize("name", ["nowhere/Type", "std_msgs/Nothing", "../../x/y", "Float64", ""])
def test_an_unknown_type_is_refused(name, refused):
    with refused(ProtocolError):
        TYPES.message(name)


def test_definitions_of_the_user_come_first_and_may_name_standard_types(tmp_path):
    define(
        tmp_path, "my/Fix", "# a comment\nHeader header\ngeometry_msgs/Point at  # where\nPart[] p"
    )
    define(tmp_path, "my/Part", "string NAME=a # b\nint32 N = 7\nduration d\n")
    define(tmp_path, "std_msgs/Float64", "float64 data\nfloat64 more\n")
    define(tmp_path, "my/Ask", "Part part\n---\nbool ok\n", "srv")
    table = TypeTable([tmp_path])

    message = table.message("my/Fix").convert({"header": {"stamp": {}}, "p": [{}]})

    assert table.check() == 4
    assert message["p"] == [{"d": {"secs": 0, "nsecs": 0}}]
    assert table.message("my/Part").definition.constants == (("NAME", "a # b"), ("N", "7"))
    assert table.message("std_msgs/Float64").default() == {"data": 0.0, "more": 0.0}
    assert table.service("my/srv/Ask").response.default() == {"ok": False}


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("float64\n", "msg"),
        ("bool a\n\nbool a\n", "msg"),
        ("bool[<=3] a\n", "msg"),
        ("Elsewhere a\n", "msg"),
        ("a/T t\n", "msg"),
        ("bool a\n", "srv"),
        ("---\n---\n", "srv"),
        ("---\nbool\n", "srv"),
    ],
)
def test_a_wrong_definition_is_refused_with_file_and_line(tmp_path, text, kind, refused):
    define(tmp_path, "a/T", text, kind)

    with refused(SettingsError):
        TypeTable([tmp_path]).check()


def test_a_folder_without_definitions_is_refused(tmp_path, refused):
    with refused(SettingsError):
        TypeTable([tmp_path]).check()


def test_a_definition_of_ros_2_may_have_bounds_and_defaults(tmp_path, refused):
    text = (
        "int32 LIMIT=3\nstring<=3 name ab\nfloat64[<=2] speeds [1.5]\n"
        "bool is_on true\nbool is_off false\n"
        'string text "a b"\ntime at\nuint8 n 7  # seven\n'
    )
    define(tmp_path, "a/T", text)
    types = TypeTable([tmp_path], ros=2)
    structure = types.message("a/msg/T")

    assert types.check() == 1
    assert structure.convert({"is_on": False}) == {
        "name": "ab",
        "speeds": [1.5],
        "is_on": False,
        "is_off": False,
        "text": "a b",
        "at": {"sec": 0, "nanosec": 0},
        "n": 7,
    }
    structure.convert({"name": "abc", "speeds": [1.0, 2.0]})
    for wrong in ({"name": "abcd"}, {"speeds": [1.0, 2.0, 3.0]}):
        with refused(ProtocolError):
            structure.convert(wrong)
    with refused(SettingsError):
        TypeTable([tmp_path]).check()


def test_a_default_that_does_not_fit_is_refused(tmp_path, refused):
    define(tmp_path, "a/T", "uint8 n 256\n")

    with refused(SettingsError):
        TypeTable([tmp_path], ros=2).check()


@pytest.mark.parametrize(("n_borders", "is_sound"), [(1, False), (2, True), (3, False)])
def test_an_action_has_three_parts(tmp_path, n_borders, is_sound, refused):
    define(tmp_path, "a/T", "int32 n\n" + n_borders * "---\n", "action")
    types = TypeTable([tmp_path], ros=2)

    if is_sound:
        assert types.check() == 1
        assert types.action("a/action/T").request.convert({}) == {"n": 0}
    else:
        with refused(SettingsError):
            types.check()


def test_every_message_of_ros_2_has_its_defaults():
    names = get_typestore(Stores.ROS2_JAZZY).fielddefs
    types = TypeTable(ros=2)

    defaults = {name: types.message(name).default() for name in names}

    assert len(defaults) > 150
    assert defaults["std_msgs/msg/Header"] == {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
