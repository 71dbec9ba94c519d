"""The in-process bus, and errors of the embedded server as those of the runtime."""

import pytest

from mrsfi_bridge import errors as bridge
from mrsfi_bridge.structures import FieldError
from mrsfi_runtime.errors import ProtocolError
from mrsfi_runtime.transport.rosbridge import as_ours
from mrsfi_runtime.transport.topics import LocalBus, Reply, Service, Topic

SPEED = Topic("/r1/speed", "std_msgs/Float64")
RESET = Service("/mission/reset", "std_srvs/Trigger")


def test_every_subscriber_receives_every_message_in_order():
    bus, first, second = LocalBus(), [], []
    bus.subscribe(SPEED, first.append)
    publish = bus.advertise(SPEED)
    bus.subscribe(SPEED, second.append)

    publish({"data": 1.0})
    publish({"data": 2.0})

    assert first == second == [{"data": 1.0}, {"data": 2.0}]


def test_a_topic_keeps_its_type(refused):
    bus = LocalBus()
    bus.advertise(SPEED)

    with refused(ProtocolError):
        bus.subscribe(Topic("/r1/speed", "std_msgs/Int64"), print)


def test_the_newest_provider_of_a_service_answers():
    bus, replies = LocalBus(), []
    for message in ("old", "new"):
        bus.provide(RESET, lambda _request, said=message: {"message": said})

    bus.call(RESET, {}, replies.append)

    assert replies == [Reply({"message": "new"})]


def test_a_closed_bus_provides_nothing():
    bus, replies = LocalBus(), []
    bus.provide(RESET, lambda _request: {})

    bus.close()
    bus.call(RESET, {}, replies.append)

    assert replies == [Reply({}, "nobody provides service '/mission/reset'")]


@pytest.mark.parametrize("theirs", [bridge.BridgeError, *bridge.BridgeError.__subclasses__()])
def test_message_and_exit_code_stay(theirs):
    ours = as_ours(theirs("why"))

    assert (str(ours), ours.exit_code) == ("why", theirs.exit_code)


def test_a_field_that_does_not_fit_is_an_error_of_the_protocol():
    assert type(as_ours(FieldError("why"))) is ProtocolError
