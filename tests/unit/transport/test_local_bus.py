"""The in-process bus."""

from mrsfi_runtime.errors import ProtocolError
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
