"""Services among clients: calls, answers, refusals, time-outs."""

import pytest

from mrsfi_bridge.settings import Limits
from tests.support.bridge import Peer, new_hub

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
