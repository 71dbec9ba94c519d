"""Services: of clients, with calls, refusals and time-outs, and those of rosapi."""

import json

import pytest

from mrsfi_bridge.settings import Limits
from tests.support.bridge import FLOAT, POINT, Peer, new_hub

ADD = "rospy_tutorials/AddTwoInts"


def provider_of(hub, name="/add", type_name=ADD):
    peer = Peer(hub, "warning")
    peer.tell(op="advertise_service", service=name, type=type_name)
    return peer


def called(hub, name="/add", args=None, **more):
    peer = Peer(hub)
    peer.tell(op="call_service", service=name, args=args or {}, id=7, **more)
    return peer


def answer_of(caller):
    (answer,) = caller.take()
    assert answer["op"] == "service_response"
    assert answer["id"] == 7
    return answer["result"], answer["values"]


def respond(provider, **more):
    (call,) = provider.take()
    provider.tell(op="service_response", service=call["service"], id=call["id"], **more)
    return call


@pytest.mark.parametrize("args", [{"a": 2, "b": 40}, [2, 40]])
def test_a_call_reaches_its_provider_and_the_answer_its_caller(hub, args):
    provider = provider_of(hub)
    caller = called(hub, args=args)

    call = respond(provider, values={"sum": 42}, result=True)

    assert (call["op"], call["service"], call["args"]) == (
        "call_service",
        "/add",
        {"a": 2, "b": 40},
    )
    assert answer_of(caller) == (True, {"sum": 42})


def test_an_id_may_follow_the_name_of_a_service(hub):
    provider, caller = provider_of(hub), Peer(hub)
    caller.tell(op="call_service", service="/add#5", args=[2, 40])

    respond(provider, values={"sum": 42}, result=True)

    (answer,) = caller.take()
    assert (answer["service"], answer["id"], answer["values"]) == ("/add#5", "5", {"sum": 42})


def test_names_without_leading_slash_are_the_same_service_and_keep_their_spelling(hub):
    provider = provider_of(hub, "add")
    caller = called(hub, "/add")

    call = respond(provider, values={"sum": 1}, result=True)

    assert call["service"] == "add"
    assert caller.take()[0]["service"] == "/add"


def test_several_calls_are_answered_in_any_order(hub):
    provider = provider_of(hub)
    callers = [called(hub, args={"a": number}) for number in range(3)]
    calls = provider.take()

    for call in reversed(calls):
        values = {"sum": call["args"]["a"] * 10}
        provider.tell(
            op="service_response", service="/add", id=call["id"], values=values, result=True
        )

    assert [answer_of(caller)[1]["sum"] for caller in callers] == [0, 10, 20]


def test_values_count_for_more_than_result_as_with_the_genuine_server(hub):
    provider = provider_of(hub)
    caller = called(hub)

    respond(provider, values={"sum": 42}, result=False)

    assert answer_of(caller) == (True, {"sum": 42})


@pytest.mark.parametrize(
    "response",
    [
        {"result": False, "values": "out of paper"},
        {"result": False},
        {"result": True, "values": {"sum": "a"}},
    ],
)
def test_a_caller_is_told_that_and_why_a_provider_failed(hub, response, approved):
    provider = provider_of(hub)
    caller = called(hub)

    respond(provider, **response)

    is_ok, values = answer_of(caller)
    assert is_ok is False
    approved(values)


@pytest.mark.parametrize(
    ("name", "args"),
    [("/nothing", {}), ("/add", {"a": "x"}), ("/add", [1, 2, 3])],
)
def test_a_call_that_makes_no_sense_is_answered_at_once(hub, name, args, approved):
    provider = provider_of(hub)

    is_ok, values = answer_of(called(hub, name, args))

    assert is_ok is False
    approved(values)
    assert provider.take() == []


def test_a_provider_that_does_not_answer_is_not_waited_for(hub, clock, approved):
    provider = provider_of(hub)
    caller = called(hub)

    clock.advance(hub.limits.service_s - 0.1)
    before = caller.take()
    clock.advance(0.2)

    assert before == []
    approved(answer_of(caller))
    respond(provider, values={"sum": 1}, result=True)
    assert caller.take() == []
    approved(provider.take()[0]["msg"])


def test_a_caller_may_choose_the_time_it_waits(hub, clock, approved):
    provider_of(hub)
    patient, hasty = called(hub, timeout=100), called(hub, timeout=0.5)

    clock.advance(1)
    early = answer_of(hasty)
    clock.advance(98)

    approved(early)
    assert patient.take() == []


@pytest.mark.parametrize("way", ["leaves", "gives up"])
def test_a_provider_that_ends_answers_its_callers(hub, way, approved):
    provider = provider_of(hub)
    caller = called(hub)

    if way == "leaves":
        provider.session.leave()
    else:
        provider.tell(op="unadvertise_service", service="/add")

    is_ok, values = answer_of(caller)
    assert is_ok is False
    approved(values)
    approved(answer_of(called(hub)))


def test_a_new_provider_takes_the_place_of_the_old_one_and_its_callers_are_answered(hub, approved):
    old = provider_of(hub)
    caller = called(hub)

    new = provider_of(hub)

    assert answer_of(caller)[0] is False
    approved(new.take()[0]["msg"])
    old.take()
    second = called(hub)
    respond(new, values={"sum": 3}, result=True)
    assert answer_of(second) == (True, {"sum": 3})


def test_nobody_answers_for_another_or_twice(hub, approved):
    provider, stranger = provider_of(hub), provider_of(hub, "/other")
    caller = called(hub)
    call_id = provider.take()[0]["id"]

    stranger.tell(op="service_response", service="/add", id=call_id, values={"sum": 1}, result=True)
    nothing = caller.take()
    for total in (2, 3):
        provider.tell(
            op="service_response", service="/add", id=call_id, values={"sum": total}, result=True
        )

    assert nothing == []
    assert answer_of(caller) == (True, {"sum": 2})
    approved(stranger.take()[0]["msg"])
    approved(provider.take()[0]["msg"])


def test_the_answer_to_a_client_that_left_is_dropped(hub):
    provider = provider_of(hub)
    caller = called(hub)

    caller.session.leave()
    respond(provider, values={"sum": 1}, result=True)

    assert caller.take() == []


def test_services_and_calls_under_way_are_limited():
    hub, _ = new_hub(Limits(services=len(new_hub()[0].services.services) + 1, calls=2))
    provider = provider_of(hub)
    provider.tell(op="advertise_service", service="/more", type=ADD)
    caller = Peer(hub)
    for number in range(3):
        caller.tell(op="call_service", service="/add", id=number)

    assert "the limit" in provider.take()[0]["msg"]
    assert [(answer["id"], answer["result"]) for answer in caller.take()] == [(2, False)]


def test_answers_come_in_the_encoding_that_the_call_asks_for(hub):
    provider = provider_of(hub)
    caller = called(hub, compression="png", fragment_size=100_000)

    respond(provider, values={"sum": 1}, result=True)

    assert [operation["op"] for operation in caller.take()] == ["png"]


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
