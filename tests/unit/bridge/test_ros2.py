"""A server of ROS 2: types, times and middleware as rosbridge_suite 2.1.0 on Jazzy has them."""

import json

import cbor2
import pytest
from rosbags.typesys import Stores, get_typestore

from mrsfi_bridge.broker import DEPTH, LIFESPAN_S
from mrsfi_bridge.settings import TypeTable
from tests.support.bridge import Peer, new_hub

TYPES = TypeTable(ros=2)
INTEGER = "std_msgs/msg/Int64"


@pytest.fixture
def hub_and_clock():
    return new_hub(types=TYPES)


def joined(hub, op, *topics, kind=INTEGER, **more):
    peer = Peer(hub, "warning")
    for topic in topics:
        peer.tell(op=op, topic=topic, type=kind, **more)
    return peer


def publish(peer, values, topic="/t"):
    for value in values:
        peer.tell(op="publish", topic=topic, msg={"data": value})


def heard(peer):
    return [(said["topic"], said["msg"]["data"]) for said in peer.take() if said["op"] == "publish"]


@pytest.mark.parametrize("n", [DEPTH, DEPTH + 1, 100])
def test_of_a_burst_the_last_ten_arrive_in_order(hub, clock, n):
    listener, publisher = joined(hub, "subscribe", "/t"), joined(hub, "advertise", "/t")

    publish(publisher, range(n))
    clock.advance(0.0)

    assert heard(listener) == [("/t", value) for value in range(n)][-DEPTH:]


def test_topics_speak_in_the_order_in_which_they_were_subscribed_to(hub, clock):
    publisher = joined(hub, "advertise", "/a", "/b")
    publish(publisher, [-1], "/a")
    publish(publisher, [-1], "/b")
    clock.advance(2 * LIFESPAN_S)
    listener = joined(hub, "subscribe", "/b", "/a")

    for value in range(3):
        publish(publisher, [value], "/a")
        publish(publisher, [value], "/b")
    clock.advance(0.0)

    assert heard(listener) == [(topic, value) for value in range(3) for topic in ("/b", "/a")]


def test_who_comes_late_hears_the_last_second_once_also_of_who_has_left(hub, clock):
    publisher, first = joined(hub, "advertise", "/t"), joined(hub, "subscribe", "/t")
    publish(publisher, [1])
    clock.advance(0.6 * LIFESPAN_S)
    publish(publisher, [2])
    publisher.session.leave()
    clock.advance(0.6 * LIFESPAN_S)
    late = joined(hub, "subscribe", "/t")
    clock.advance(0.0)

    assert heard(late) == [("/t", 2)]
    assert heard(first) == [("/t", 1), ("/t", 2)]
    first.session.leave()
    late.session.leave()
    clock.advance(LIFESPAN_S)
    assert heard(joined(hub, "subscribe", "/t")) == []


def test_nothing_is_heard_that_is_older_than_a_second(hub, clock):
    publisher = joined(hub, "advertise", "/t")
    publish(publisher, [1])
    clock.advance(0.9 * LIFESPAN_S)
    publish(publisher, [2])
    clock.advance(1.05 * LIFESPAN_S)

    assert heard(joined(hub, "subscribe", "/t")) == []


def test_one_appointment_sees_to_the_age_of_all_messages(hub, clock):
    publisher = joined(hub, "advertise", "/t")

    for value in range(20):
        publish(publisher, [value])
        clock.advance(0.01)

    assert clock.n_due == 1


def test_a_topic_of_another_type_has_no_past(hub, clock):
    publisher = joined(hub, "advertise", "/t")
    publish(publisher, [1, 2])
    publisher.session.leave()
    other = joined(hub, "subscribe", "/t", kind="std_msgs/msg/String")
    clock.advance(0.0)

    assert heard(other) == []
    assert heard(joined(hub, "subscribe", "/t", kind="std_msgs/msg/String")) == []


def test_of_a_topic_that_nobody_uses_nothing_is_kept(hub, clock):
    publisher = joined(hub, "advertise", "/t")
    publish(publisher, [1])
    publisher.session.leave()
    clock.advance(3 * LIFESPAN_S)

    assert "/t" not in hub.broker._lanes


@pytest.mark.parametrize("n_listeners", [0, 1])
def test_a_loss_is_logged_once_where_somebody_listens(hub, caplog, n_listeners, approved):
    publisher = joined(hub, "advertise", "/t")
    for _ in range(n_listeners):
        joined(hub, "subscribe", "/t")
    publish(publisher, range(DEPTH + 5))

    told = [record.getMessage() for record in caplog.records]
    approved(told)


def test_what_is_latched_is_heard_later_and_once(hub, clock):
    publish(joined(hub, "advertise", "/t", latch=True), [1, 2])
    early = joined(hub, "subscribe", "/t")
    clock.advance(0.0)

    assert heard(early) == [("/t", 1), ("/t", 2)]
    assert heard(joined(hub, "subscribe", "/t")) == [("/t", 1), ("/t", 2)]
    clock.advance(2 * LIFESPAN_S)
    assert heard(joined(hub, "subscribe", "/t")) == [("/t", 2)]


@pytest.mark.parametrize(
    ("kind", "message", "problem"),
    [
        ("std_msgs/msg/Header", {"seq": 1}, "no field 'seq'"),
        *((INTEGER, {"data": value}, "expected int64") for value in (3.0, None, True, "3")),
        ("shape_msgs/msg/SolidPrimitive", {"dimensions": [1.0] * 4}, "expected at most 3"),
    ],
)
def test_a_wrong_value_drops_the_message_and_is_told_to_who_asked_for_it(
    hub, clock, kind, message, problem
):
    listener = joined(hub, "subscribe", "/t", kind=kind)
    publisher = joined(hub, "advertise", "/t", kind=kind)

    publisher.tell(op="publish", topic="/t", msg=message)
    clock.advance(0.0)

    assert listener.take() == []
    (status,) = publisher.take()
    assert (status["op"], problem in status["msg"]) == ("status", True)


@pytest.mark.parametrize(
    "stamp", [{"sec": 7, "nanosec": 8}, {"secs": 7, "nsecs": 8}], ids=["ROS 2", "ROS 1"]
)
def test_times_are_told_as_in_ros_2_and_taken_in_either_form(stamp):
    header = TYPES.message("std_msgs/Header")

    assert header.convert({"stamp": stamp}) == {"stamp": {"sec": 7, "nanosec": 8}, "frame_id": ""}
    assert header.convert({})["stamp"]["sec"] > 10**9
    assert TYPES.message("rosgraph_msgs/Clock").convert({})["clock"] == {"sec": 0, "nanosec": 0}


def test_no_header_is_numbered(hub, clock):
    listener = joined(hub, "subscribe", "/t", kind="geometry_msgs/msg/PoseStamped")
    publisher = joined(hub, "advertise", "/t", kind="geometry_msgs/msg/PoseStamped")
    publisher.tell(op="publish", topic="/t", msg={"header": {"frame_id": "map"}})
    clock.advance(0.0)

    assert listener.messages()[0]["header"].keys() == {"stamp", "frame_id"}


def test_what_is_left_out_has_the_default_of_its_definition():
    assert TYPES.message("geometry_msgs/Pose").convert({})["orientation"]["w"] == 1.0


def test_rosapi_names_types_in_three_parts(hub):
    peer = joined(hub, "advertise", "/t", kind="geometry_msgs/PoseStamped")
    three = "geometry_msgs/msg/PoseStamped"

    assert peer.call("/rosapi/topic_type", topic="/t") == {"type": three}
    assert peer.call("/rosapi/topics_for_type", type=three) == {"topics": ["/t"]}
    assert peer.call("/rosapi/topics_for_type", type="geometry_msgs/PoseStamped") == {"topics": []}
    assert peer.call("/rosapi/service_type", service="/rosapi/topics")["type"] == (
        "rosapi_msgs/srv/Topics"
    )
    told = peer.call("/rosapi/message_details", type=three)["typedefs"]
    assert [definition["type"] for definition in told][:3] == [
        three,
        "std_msgs/msg/Header",
        "builtin_interfaces/msg/Time",
    ]
    assert told[0]["fieldtypes"] == ["std_msgs/msg/Header", "geometry_msgs/msg/Pose"]
    assert peer.call("/rosapi/get_time")["time"].keys() == {"sec", "nanosec"}
    assert peer.call("/rosapi/get_ros_version") == {"version": 2, "distro": "jazzy"}


def test_parameters_belong_to_nodes_and_are_no_trees(hub):
    peer = Peer(hub)
    tree = '{"a": 1}'
    for name, value in (("arm:speed", "2.5"), ("/arm:limits.max", tree), ("/speed", "1")):
        peer.call("/rosapi/set_param", name=name, value=value)

    assert peer.call("/rosapi/get_param_names") == {"names": ["/arm:speed", "/arm:limits.max"]}
    assert peer.call("/rosapi/get_param", name="/arm:speed") == {"value": "2.5"}
    assert json.loads(peer.call("/rosapi/get_param", name="arm:limits.max")["value"]) == tree
    assert peer.call("/rosapi/has_param", name="arm:speed") == {"exists": True}
    peer.call("/rosapi/delete_param", name="arm:speed")
    assert peer.call("/rosapi/has_param", name="arm:speed") == {"exists": False}


@pytest.mark.parametrize(
    ("name", "default", "value"),
    [("arm:speed", "", '""'), ("arm:speed", "3", "3"), ("/speed", "3", ""), ("a:b:c", "3", "")],
)
def test_a_missing_parameter_is_empty_or_the_default_and_one_of_no_node_is_nothing(
    hub, name, default, value
):
    asked = {"name": name, "default_value": default}

    assert Peer(hub).call("/rosapi/get_param", **asked) == {"value": value}


@pytest.mark.parametrize(
    ("kind", "message", "read", "expected"),
    [
        (
            "sensor_msgs/msg/JointState",
            {"name": ["a", "bcd", ""], "position": [1.5, -2.0]},
            lambda joints: (joints.name, [*joints.position], [*joints.effort]),
            (["a", "bcd", ""], [1.5, -2.0], []),
        ),
        (
            "sensor_msgs/msg/Image",
            {"encoding": "é", "data": "aGVsbG8=", "step": 7},
            lambda image: (image.encoding, image.step, bytes(image.data)),
            ("é", 7, b"hello"),
        ),
        ("nav_msgs/msg/Odometry", {"child_frame_id": "x"}, lambda read: read.child_frame_id, "x"),
        ("std_msgs/msg/Empty", {}, lambda _: None, None),
    ],
)
def test_cbor_raw_carries_what_rosbags_reads_as_the_message(
    hub, clock, kind, message, read, expected
):
    listener = Peer(hub)
    listener.tell(op="subscribe", topic="/t", type=kind, compression="cbor-raw")
    joined(hub, "advertise", "/t", kind=kind).tell(op="publish", topic="/t", msg=message)
    clock.advance(0.0)

    content = cbor2.loads(listener.frames[0].data)["msg"]["bytes"]
    store = get_typestore(Stores.ROS2_JAZZY)
    found = store.deserialize_cdr(content, kind)
    assert read(found) == expected
    assert bytes(store.serialize_cdr(found, kind)) == content
