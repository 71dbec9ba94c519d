"""Actions: every goal gets one result, whoever leaves, and nothing is silent."""

import pytest

from mrsfi_bridge.settings import TypeTable
from tests.support.bridge import Peer, new_hub

NAME, KIND = "/fibonacci", "example_interfaces/action/Fibonacci"


@pytest.fixture(params=[1, 2])
def hub(request):
    return new_hub(types=TypeTable(ros=request.param))[0]


@pytest.fixture
def provider(hub):
    peer = Peer(hub, "warning")
    peer.tell(op="advertise_action", action=NAME, type=KIND)
    return peer


@pytest.fixture
def caller(hub):
    return Peer(hub, "warning")


def send(caller, goal_id="g", feedback=True, **goal):
    caller.tell(
        op="send_action_goal",
        id=goal_id,
        action=NAME,
        action_type=KIND,
        args=goal,
        feedback=feedback,
    )


def asked(provider):
    """Return the identifier of the goal that a provider is asked for."""
    (goal,) = provider.take()
    assert (goal["op"], goal["action"], goal["args"]) == ("send_action_goal", NAME, {"order": 3})
    return goal["id"]


def result(caller):
    (told,) = caller.take()
    assert (told["op"], told["action"], told["id"]) == ("action_result", NAME, "g")
    return told["result"], told["status"], told["values"]


def test_a_goal_has_feedback_and_a_result(provider, caller):
    send(caller, order=3)
    goal = asked(provider)
    provider.tell(op="action_feedback", action=NAME, id=goal, values={"sequence": [0, 1]})

    (feedback,) = caller.take()
    assert feedback == {
        "op": "action_feedback",
        "id": "g",
        "action": NAME,
        "values": {"sequence": [0, 1]},
    }
    provider.tell(
        op="action_result", action=NAME, id=goal, values={"sequence": [0, 1, 1]}, status=4
    )
    assert result(caller) == (True, 4, {"sequence": [0, 1, 1]})
    provider.tell(op="action_result", action=NAME, id=goal, values={})
    assert "no call" in provider.take()[0]["msg"]


def test_a_result_that_does_not_fit_is_told_as_a_failure(provider, caller):
    send(caller, order=3)
    goal = asked(provider)
    provider.tell(op="action_result", action=NAME, id=goal, values={"sequence": ["x"]}, status=4)

    is_ok, status, values = result(caller)
    assert (is_ok, status) == (False, 6)
    assert "found 'x', expected int32" in values


def test_feedback_comes_to_who_asked_for_it(provider, caller):
    send(caller, feedback=False, order=3)
    provider.tell(op="action_feedback", action=NAME, id=asked(provider), values={"sequence": [0]})

    assert caller.take() == []


def test_a_goal_is_cancelled_by_its_caller_only(hub, provider, caller, approved):
    send(caller, order=3)
    goal = asked(provider)
    stranger = Peer(hub, "warning")
    stranger.tell(op="cancel_action_goal", action=NAME, id="g")
    approved(stranger.take()[0]["msg"])
    assert provider.take() == []

    caller.tell(op="cancel_action_goal", action=NAME, id="g")

    assert provider.take() == [{"op": "cancel_action_goal", "id": goal, "action": NAME}]
    provider.tell(op="action_result", action=NAME, id=goal, values={}, status=5)
    assert result(caller) == (True, 5, {"sequence": []})


def test_a_call_of_cancel_goal_cancels_all_goals_of_the_action(hub, provider, caller):
    send(caller, "first", order=3)
    send(Peer(hub), "second", order=3)
    goals = [goal["id"] for goal in provider.take()]

    answer = Peer(hub).call(f"{NAME}/_action/cancel_goal")

    assert (answer["return_code"], len(answer["goals_canceling"])) == (0, 2)
    cancelled = [{"op": "cancel_action_goal", "id": goal, "action": NAME} for goal in goals]
    assert provider.take() == cancelled
    assert provider.call("/rosapi/services_for_type", type="action_msgs/CancelGoal") == {
        "services": [f"{NAME}/_action/cancel_goal"]
    }
    assert f"{NAME}/_action/cancel_goal" not in provider.call("/rosapi/services")["services"]


def test_a_call_of_cancel_goal_with_the_id_of_a_goal_is_rejected(hub, provider, caller):
    send(caller, order=3)
    asked(provider)

    one = {"goal_id": {"uuid": [1] * 16}}
    answer = caller.call(f"{NAME}/_action/cancel_goal", goal_info=one)

    assert answer == {"return_code": 1, "goals_canceling": []}
    assert provider.take() == []


def test_a_provider_may_fail(provider, caller):
    send(caller, order=3)
    provider.tell(
        op="action_result", action=NAME, id=asked(provider), values="no", result=False, status=6
    )

    assert result(caller) == (True, 6, {"sequence": []})


def test_rosapi_names_actions(provider, caller):
    assert caller.call("/rosapi/action_servers") == {"action_servers": [NAME]}


def test_nobody_who_provides_is_told(hub, caller, approved):
    send(caller, order=3)

    approved(result(caller))


@pytest.mark.parametrize("op", ["leave", "unadvertise"])
def test_a_provider_that_goes_is_told(provider, caller, op):
    send(caller, order=3)
    if op == "leave":
        provider.session.leave()
    else:
        provider.tell(op="unadvertise_action", action=NAME)

    is_ok, status, reason = result(caller)
    assert (is_ok, status) == (False, 6)
    assert "its provider" in reason


def test_what_does_not_fit_the_type_is_told_to_both(provider, caller, approved):
    send(caller, orders=3)
    approved(result(caller)[2])
    assert provider.take() == []

    send(caller, order=3)
    goal = asked(provider)
    provider.tell(op="action_feedback", action=NAME, id=goal, values={"sequence": 1})
    assert "expected a list" in provider.take()[0]["msg"]
    provider.tell(op="action_result", action=NAME, id=goal, values={"sequence": 1})
    assert "expected a list" in result(caller)[2]
    assert "expected a list" in provider.take()[0]["msg"]


@pytest.mark.parametrize("kind", ["std_msgs/action/No", "no type", "example_interfaces/action/F"])
def test_a_goal_of_another_type_is_refused(provider, caller, kind):
    caller.tell(op="send_action_goal", id="g", action=NAME, action_type=kind, args={"order": 3})

    assert provider.take() == []
    (told,) = [each for each in caller.take() if each["op"] == "action_result"]
    assert (told["result"], told["status"]) == (False, 6)


def test_an_unknown_type_of_action_is_refused_with_the_file_to_add(hub):
    peer = Peer(hub, "warning")
    peer.tell(op="advertise_action", action="/x", type="a_package/action/Walk")

    assert "add a_package/action/Walk.action" in peer.take()[0]["msg"]
