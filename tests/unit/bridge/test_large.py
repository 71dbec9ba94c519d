"""Large texts are carried out step by step, with the same result."""

import json
from unittest.mock import patch

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrsfi_bridge import texts
from mrsfi_bridge.session import LARGE
from mrsfi_bridge.texts import LARGE_DECODER, to_json, to_large_json
from tests.support.bridge import Peer, new_hub, parse_frames

ARRAY = "std_msgs/Float64MultiArray"
JOY = "sensor_msgs/Joy"
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner, max_size=20) | st.dictionaries(st.text(), inner, max_size=5),
)


@given(VALUES)
def test_a_value_is_written_and_read_in_parts_as_in_one_go(value):
    with patch.object(texts, "_PART", 3), patch.object(texts, "_PART_LETTERS", 5):
        content = to_large_json(value)
        found = LARGE_DECODER.decode(content.decode())

    assert json.loads(content) == json.loads(to_json(value)) == found


@pytest.mark.parametrize("text", ["[1,]", "[,1]", "[1,,2]", "[1 2]", "[1", "[1,2}", "[--1]"])
def test_what_is_no_list_of_numbers_is_refused_in_parts_too(text):
    with patch.object(texts, "_PART_LETTERS", 1), pytest.raises(ValueError, match=r"char \d"):
        LARGE_DECODER.decode(text)


def subscribed(hub, **wish):
    peer = Peer(hub)
    peer.tell(op="subscribe", topic="/a", type=ARRAY, **wish)
    return peer


@pytest.mark.parametrize("wish", [{}, {"compression": "png"}, {"compression": "cbor"}])
def test_a_large_message_is_what_a_small_one_would_be(wish):
    hub, _ = new_hub()
    publisher, peer = Peer(hub), subscribed(hub, **wish)
    publisher.tell(op="advertise", topic="/a", type=ARRAY)
    numbers = [0.5, -1.0, 1e300] * (LARGE // 10)

    publisher.tell(op="publish", topic="/a", msg={"data": numbers})
    with patch("mrsfi_bridge.session.LARGE", 1 << 30):
        publisher.tell(op="publish", topic="/a", msg={"data": numbers})

    large, small = peer.frames
    assert large.data == small.data
    assert len(large.data) > 1000


def test_a_large_message_is_numbered_kept_and_given_to_who_comes_later():
    hub, _ = new_hub()
    publisher, peer = Peer(hub), Peer(hub)
    publisher.tell(op="advertise", topic="/j", type=JOY, latch=True)
    for _ in range(2):
        publisher.tell(op="publish", topic="/j", msg={"axes": [0.5] * LARGE, "header": {"seq": 9}})

    peer.tell(op="subscribe", topic="/j")

    (operation,) = peer.take()
    assert operation["msg"]["header"]["seq"] == 2
    assert len(operation["msg"]["axes"]) == LARGE


@pytest.mark.parametrize(
    ("operation", "reason"),
    [
        ({"op": "publish", "topic": "/b", "msg": {"data": [0] * LARGE}}, "'/b' is not advertised"),
        ({"op": "publish", "topic": "/a", "msg": {"data": ["x"] * LARGE}}, "expected a number"),
        ({"op": "publish", "topic": "/a", "msg": [0] * LARGE}, "'msg' is"),
        ({"op": "dance", "steps": [0] * LARGE}, "unknown op 'dance'"),
    ],
)
def test_what_is_wrong_with_a_large_operation_is_told(operation, reason):
    hub, _ = new_hub()
    peer = Peer(hub, "error")
    peer.tell(op="advertise", topic="/a", type=ARRAY)

    peer.tell(**operation)

    (status,) = peer.take()
    assert reason in status["msg"]
    assert hub.counts.dropped == 1


def test_many_operations_of_one_text_leave_others_their_turns():
    hub, _ = new_hub()
    publisher, peer = Peer(hub), subscribed(hub)
    publisher.tell(op="advertise", topic="/a", type=ARRAY)
    message = json.dumps({"op": "publish", "topic": "/a", "msg": {"data": [1.0]}})
    n = LARGE // len(message) + 1

    steps = publisher.session.steps(message * n + '{"op":')
    values = steps.send(next(steps)())
    turns = [values, *steps]

    assert turns == [None] * n
    assert len(peer.take()) == n
    assert hub.counts.dropped == 1
    assert parse_frames(b"") == []


def called(type_name, **request):
    """Return a caller, and a provider that has its call."""
    hub, _ = new_hub()
    provider, caller = Peer(hub), Peer(hub)
    provider.tell(op="advertise_service", service="/s", type=type_name)
    caller.tell(op="call_service", service="/s#7", args=request)
    return caller, provider


def test_a_large_request_reaches_its_provider_as_a_small_one_does():
    caller, provider = called("rosapi/SetParam", name="n", value="é" * LARGE)

    (call,) = provider.take()
    provider.tell(op="service_response", service="/s", id=call["id"], values={}, result=True)

    assert call == {
        "op": "call_service",
        "id": call["id"],
        "service": "/s",
        "args": {"name": "n", "value": "é" * LARGE},
    }
    (answer,) = caller.take()
    assert answer["result"] is True


@pytest.mark.parametrize(
    ("values", "result", "expected"),
    [
        ({"success": True, "message": "x" * LARGE}, True, (True, "x" * LARGE)),
        ({"success": True, "message": "x" * LARGE}, False, (True, "x" * LARGE)),
        ("no" * LARGE, False, (False, "no" * LARGE)),
        ({"success": 5, "message": "x" * LARGE}, True, (False, "found 5, expected true or false")),
    ],
)
def test_a_large_answer_is_what_a_small_one_would_be(values, result, expected):
    caller, provider = called("std_srvs/Trigger")
    (call,) = provider.take()

    provider.tell(op="service_response", service="/s", id=call["id"], values=values, result=result)

    (answer,) = caller.take()
    is_ok, told = expected
    assert (answer["id"], answer["service"], answer["result"]) == ("7", "/s#7", is_ok)
    if is_ok:
        assert answer["values"] == {"success": True, "message": told}
    else:
        assert told in answer["values"]


def test_a_large_request_that_is_wrong_is_answered_with_the_reason():
    caller, provider = called("rosapi/SetParam", name=5, value="x" * LARGE)

    (answer,) = caller.take()
    assert answer["result"] is False
    assert "request of service /s: field 'name': found 5, expected text" in answer["values"]
    assert provider.take() == []


def test_a_large_call_of_nobodys_service_is_answered():
    hub, _ = new_hub()
    caller = Peer(hub)

    caller.tell(op="call_service", service="/none", args={"name": "x" * LARGE}, id="1")

    assert "Service /none does not exist" in caller.take()[0]["values"]
