"""All messages of a tick as one."""

import json
from functools import partial

import pytest

from mrsfi_runtime.cosimulation.bus_topics import (
    GO,
    GO_BUNDLE,
    SETUP,
    TICK,
    TICK_BUNDLE,
    BundlingTransport,
)
from mrsfi_runtime.errors import ProtocolError
from mrsfi_runtime.transport.topics import LocalBus, Topic

SPEED = Topic("/r1/speed", "std_msgs/Float64")
COMMAND = Topic("/r1/command/speed", "std_msgs/Float64")
ON_THE_BUS = (SPEED, TICK, TICK_BUNDLE, COMMAND, GO, GO_BUNDLE, SETUP)


@pytest.fixture
def bus():
    return LocalBus()


@pytest.fixture
def passed(bus):
    """All that passes on the bus, in order."""
    messages = []
    for topic in ON_THE_BUS:
        bus.subscribe(topic, lambda payload, topic=topic: messages.append((topic, payload["data"])))
    return messages


def test_what_belongs_to_a_tick_travels_as_one_message(bus, passed):
    ci = BundlingTransport.of_ci(bus)
    command, go = ci.advertise(COMMAND), ci.advertise(GO)

    command({"data": 1.5})
    go({"data": [1, 0, 1]})

    (sent,) = passed
    assert sent[0] == GO_BUNDLE
    assert json.loads(sent[1]) == [[COMMAND.name, {"data": 1.5}], [GO.name, {"data": [1, 0, 1]}]]


def test_the_other_side_hears_each_message_in_order(bus):
    ci, simulation = BundlingTransport.of_ci(bus), BundlingTransport.of_simulation(bus)
    command, go = ci.advertise(COMMAND), ci.advertise(GO)
    heard = []
    for topic in (GO, COMMAND):
        simulation.subscribe(topic, partial(lambda name, said: heard.append((name, said)), topic))

    command({"data": 0.1 + 0.2})
    go({"data": [1, 0, 1]})

    assert heard == [(COMMAND, {"data": 0.1 + 0.2}), (GO, {"data": [1, 0, 1]})]


@pytest.mark.parametrize("is_bundling", [True, False])
def test_a_simulation_answers_in_kind(bus, passed, is_bundling):
    ci = BundlingTransport.of_ci(bus) if is_bundling else bus
    simulation = BundlingTransport.of_simulation(bus)
    speed, tick, go = simulation.advertise(SPEED), simulation.advertise(TICK), ci.advertise(GO)
    simulation.subscribe(GO, lambda _: (speed({"data": 2.0}), tick({"data": [1, 0, 1]})))

    go({"data": [1, 0, 0]})

    topics = [topic for topic, _ in passed]
    expected = [GO_BUNDLE, TICK_BUNDLE] if is_bundling else [SPEED, TICK, GO]  # depth first
    assert sorted(topics) == sorted(expected)


def test_a_simulation_that_answered_bundles_goes_back_to_messages(bus, passed):
    ci, simulation = BundlingTransport.of_ci(bus), BundlingTransport.of_simulation(bus)
    tick = simulation.advertise(TICK)
    simulation.subscribe(GO, tick)

    ci.advertise(GO)({"data": [1, 0, 0]})
    bus.advertise(GO)({"data": [2, 0, 0]})

    assert sorted({topic for topic, _ in passed}) == sorted({GO_BUNDLE, TICK_BUNDLE, GO, TICK})


def test_what_waits_of_a_run_that_ended_is_dropped_when_the_next_begins(bus, passed):
    ci = BundlingTransport.of_ci(bus)
    setup, command, go = ci.advertise(SETUP), ci.advertise(COMMAND), ci.advertise(GO)

    command({"data": 1.5})
    setup({"data": [2, 7]})
    go({"data": [2, 0, 0]})

    assert passed == [(SETUP, [2, 7]), (GO_BUNDLE, '[["/mission/go",{"data":[2,0,0]}]]')]


def test_what_nobody_subscribed_to_is_left_aside(bus):
    ci, heard = BundlingTransport.of_ci(bus), []
    ci.subscribe(TICK, heard.append)

    bus.advertise(TICK_BUNDLE)({"data": '[["/other", {}], ["/mission/tick", {"data": [1]}]]'})

    assert heard == [{"data": [1]}]


@pytest.mark.parametrize("text", [None, 3, "", "[", "{}x", '["a"]', '[["a"]]', '[["a", 1]]'])
def test_a_bundle_of_another_form_is_refused(bus, text):
    BundlingTransport.of_ci(bus)

    with pytest.raises(ProtocolError, match=r"/mission/tick/bundle carried .*; expected a JSON"):
        bus.advertise(TICK_BUNDLE)({"data": text})
