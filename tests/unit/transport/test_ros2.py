"""Messages of ROS 2 as DDS carries them, against the serializer of rosbags."""

import pytest
from rosbags.typesys import Stores, get_typestore

from mrsfi_bridge.settings import TypeTable
from mrsfi_runtime.errors import MrsfiError, UsageError
from mrsfi_runtime.transport.ros2 import Types

STORE = get_typestore(Stores.ROS2_JAZZY)
NAMES = sorted(STORE.fielddefs)
ODOMETRY = {
    "header": {"stamp": {"sec": 7, "nanosec": 8}, "frame_id": "mäp"},
    "pose": {"pose": {"position": {"x": 1.5, "y": -2.5}}, "covariance": [0.25] * 36},
}
IMAGE = {"format": "png", "data": [1, 2, 255]}
ARRAY = {"layout": {"dim": [{"label": "a", "size": 2, "stride": 2}]}, "data": [-1, 2**40]}


@pytest.fixture(scope="module")
def types():
    return Types(TypeTable(ros=2))


def there_and_back(kind, name, payload):
    """Return a payload after rosbags has read and written it."""
    sent = kind.instance(payload).serialize()
    read = STORE.deserialize_cdr(sent, name)
    assert bytes(STORE.serialize_cdr(read, name)) == sent
    return kind.unpack(kind.made.deserialize(sent))


@pytest.mark.parametrize("name", NAMES)
def test_every_message_of_ros_2_is_read_by_another_serializer(types, name):
    short = name.replace("/msg/", "/")
    message = TypeTable(ros=2).message(short).default()

    assert there_and_back(types.message(short), name, message) == message


def test_a_text_of_wide_characters_is_told(tmp_path):
    (tmp_path / "wide" / "msg").mkdir(parents=True)
    (tmp_path / "wide" / "msg" / "Text.msg").write_text("wstring data\n", encoding="ascii")

    with pytest.raises(UsageError, match="wide/Text: field 'data': wstring is not supported over"):
        Types(TypeTable([tmp_path], ros=2)).message("wide/Text")


@pytest.mark.parametrize(
    ("name", "payload"),
    [
        ("nav_msgs/msg/Odometry", ODOMETRY),
        ("sensor_msgs/msg/CompressedImage", IMAGE),
        ("std_msgs/msg/Int64MultiArray", ARRAY),
    ],
)
def test_what_a_message_has_is_read_as_it_was_written(types, name, payload):
    short = name.replace("/msg/", "/")
    expected = TypeTable(ros=2).message(short).convert(payload)

    assert there_and_back(types.message(short), name, payload) == expected


def test_types_have_the_names_of_the_middleware(types):
    request, response = types.service("std_srvs/Trigger")

    assert types.message("nav_msgs/Odometry").name == "nav_msgs::msg::dds_::Odometry_"
    assert (request.name, response.name) == (
        "std_srvs::srv::dds_::Trigger_Request_",
        "std_srvs::srv::dds_::Trigger_Response_",
    )
    answer = response.instance({"success": True, "message": "run 1"}, guid=2**63, seq=3)
    assert response.made.deserialize(answer.serialize()) == answer


@pytest.mark.parametrize("name", ["nav_msgs/Odometrie", "x"])
def test_an_unknown_type_is_told(types, name):
    with pytest.raises(MrsfiError, match=name):
        types.message(name)


def test_a_value_that_does_not_fit_is_told(types):
    with pytest.raises(MrsfiError, match="field 'data': found 'x', expected a number"):
        types.message("std_msgs/Float64").instance({"data": "x"})
