"""What clients can ask about topics, services, types, nodes and parameters."""

import json

import pytest

from mrsfi_bridge.settings import Limits
from tests.support.bridge import FLOAT, POINT, Peer, new_hub


def setting(name, value):
    return {"name": name, "value": json.dumps(value)}


@pytest.fixture
def peer(hub):
    busy = Peer(hub)
    busy.tell(op="advertise", topic="/a", type=FLOAT)
    busy.tell(op="subscribe", topic="/b", type=POINT)
    busy.tell(op="advertise_service", service="/reset", type="std_srvs/Trigger")
    return Peer(hub)


def test_topics_and_their_types(peer):
    topics = peer.call("/rosapi/topics")

    assert dict(zip(topics["topics"], topics["types"], strict=True)) == {
        "/rosout": "rosgraph_msgs/Log",
        "/rosout_agg": "rosgraph_msgs/Log",
        "/client_count": "std_msgs/Int32",
        "/connected_clients": "rosbridge_msgs/ConnectedClients",
        "/a": FLOAT,
        "/b": POINT,
    }
    assert peer.call("/rosapi/topic_type", topic="/a") == {"type": FLOAT}
    assert peer.call("rosapi/topic_type", topic="a") == {"type": FLOAT}
    assert peer.call("/rosapi/topic_type", topic="/c") == {"type": ""}
    assert peer.call("/rosapi/topics_for_type", type="geometry_msgs/msg/Point") == {
        "topics": ["/b"]
    }
    assert peer.call("/rosapi/topics_for_type", type="???") == {"topics": []}


def test_types_of_topics_as_text(peer):
    answer = peer.call("/rosapi/topics_and_raw_types")

    text = answer["typedefs_full_text"][answer["topics"].index("/rosout")]
    assert "byte level\n" in text
    assert "MSG: std_msgs/Header\nuint32 seq\n" in text


def test_services_and_their_types(peer):
    assert "/reset" in peer.call("/rosapi/services")["services"]
    assert peer.call("/rosapi/service_type", service="/reset") == {"type": "std_srvs/Trigger"}
    assert peer.call("/rosapi/service_type", service="/x") == {"type": ""}
    assert peer.call("/rosapi/services_for_type", type="std_srvs/Trigger") == {
        "services": ["/reset"]
    }


def test_every_service_of_rosapi_has_the_type_that_it_says(peer, hub):
    for name in peer.call("/rosapi/services")["services"]:
        type_name = peer.call("/rosapi/service_type", service=name)["type"]
        assert hub.types.service(type_name).name == type_name


def test_details_of_a_message_include_the_types_that_it_holds(peer):
    definitions = peer.call("/rosapi/message_details", type="actionlib_msgs/GoalStatus")["typedefs"]

    by_name = {definition["type"]: definition for definition in definitions}
    status = by_name["actionlib_msgs/GoalStatus"]
    assert status["fieldnames"] == ["goal_id", "status", "text"]
    assert status["fieldtypes"] == ["actionlib_msgs/GoalID", "uint8", "string"]
    assert status["fieldarraylen"] == [-1, -1, -1]
    assert status["examples"] == ["{}", "0", ""]
    assert dict(zip(status["constnames"], status["constvalues"], strict=True))["SUCCEEDED"] == "3"
    assert by_name["time"]["fieldnames"] == ["secs", "nsecs"]
    arguments = {"type": "geometry_msgs/PoseWithCovariance"}
    assert peer.call("/rosapi/message_details", **arguments)["typedefs"][0]["fieldarraylen"] == [
        -1,
        36,
    ]


@pytest.mark.parametrize(
    ("service", "arguments"),
    [
        ("message_details", {"type": "x/Y"}),
        ("set_param", setting("/big", "x" * 2000)),
        ("set_param", setting("/many", dict.fromkeys("abcd", 1))),
        ("set_param", setting("/", 1)),
        ("set_param", setting("/a", {"b/c": 1})),
        ("set_param", {"name": "/p", "value": '{"a":' * 40 + "1" + "}" * 40}),
    ],
)
def test_what_is_unknown_or_too_much_is_refused(service, arguments, approved):
    peer = Peer(new_hub(Limits(parameters=3, parameter_bytes=1000))[0])

    peer.tell(op="call_service", service=f"/rosapi/{service}", args=arguments)

    (answer,) = peer.take()
    assert answer["result"] is False
    approved(answer["values"])


def test_details_of_services(peer):
    request = peer.call("/rosapi/service_request_details", type="rospy_tutorials/AddTwoInts")
    response = peer.call("/rosapi/service_response_details", type="rospy_tutorials/AddTwoInts")

    assert request["typedefs"][0]["fieldnames"] == ["a", "b"]
    assert response["typedefs"][0]["fieldtypes"] == ["int64"]


def test_nodes(peer):
    assert peer.call("/rosapi/nodes") == {"nodes": ["/rosapi", "/rosbridge_websocket"]}
    assert peer.call("/rosapi/node_details", node="/rosbridge_websocket") == {
        "subscribing": ["/b"],
        "publishing": ["/a"],
        "services": ["/reset"],
    }
    assert peer.call("/rosapi/publishers", topic="/a") == {"publishers": ["/rosbridge_websocket"]}
    assert peer.call("/rosapi/subscribers", topic="/a") == {"subscribers": []}


def test_time_is_that_of_day(peer):
    assert peer.call("/rosapi/get_time")["time"]["secs"] > 1_600_000_000


def test_action_servers_are_recognised_by_their_topics(hub):
    peer = Peer(hub)
    for part in ("goal", "cancel", "status", "feedback", "result"):
        peer.tell(op="advertise", topic=f"/arm/{part}", type="std_msgs/Empty")
    peer.tell(op="advertise", topic="/leg/goal", type="std_msgs/Empty")

    assert peer.call("/rosapi/action_servers") == {"action_servers": ["/arm"]}


def get(peer, name, default=""):
    return json.loads(peer.call("/rosapi/get_param", name=name, default=default)["value"])


def put(peer, name, value):
    peer.call("/rosapi/set_param", **setting(name, value))


@pytest.mark.parametrize(
    "value", [1, 0.5, "text", True, None, [1, [2]], {}, {"a": {"b": 1}, "c": 2}]
)
def test_a_parameter_keeps_its_value(peer, value):
    put(peer, "p", value)

    assert get(peer, "/p") == value


def test_a_missing_parameter_is_null_or_the_default(peer):
    assert get(peer, "/p") is None
    assert get(peer, "/p", "[1]") == [1]
    assert get(peer, "/p", "plain words") == "plain words"
    assert peer.call("/rosapi/has_param", name="/p") == {"exists": False}


def test_parameters_form_a_tree(peer):
    put(peer, "/r/arm", {"speed": 1, "reach": {"max": 2}})
    put(peer, "/r/name", "x")

    assert get(peer, "/r") == {"arm": {"speed": 1, "reach": {"max": 2}}, "name": "x"}
    assert get(peer, "/r/arm/reach/max") == 2
    assert peer.call("/rosapi/get_param_names") == {
        "names": ["/r/arm/speed", "/r/arm/reach/max", "/r/name"]
    }
    assert peer.call("/rosapi/has_param", name="r/arm") == {"exists": True}


def test_setting_replaces_what_was_below_and_above(peer):
    put(peer, "/a", {"b": 1, "c": 2})
    put(peer, "/a", {"d": 3})
    put(peer, "/a/d/e", 4)

    assert get(peer, "/a") == {"d": {"e": 4}}


def test_deleting_ends_a_parameter_and_all_below_it(peer):
    put(peer, "/a", {"b": 1})
    put(peer, "/ab", 2)

    peer.call("/rosapi/delete_param", name="/a")
    peer.call("/rosapi/delete_param", name="/never")

    assert peer.call("/rosapi/get_param_names") == {"names": ["/ab"]}
