"""Barriers: what waits until all clients have answered what they were told."""

from mrsfi_bridge.server import ROUNDS, Barriers


class Loop:
    """Calls what it was given when it is asked to."""

    def __init__(self):
        self.waiting = []

    def call_soon(self, function, *arguments):
        self.waiting.append((function, arguments))

    def run(self):
        waiting, self.waiting = self.waiting, []
        for function, arguments in waiting:
            function(*arguments)


class Client:
    """Keeps the pings that it got."""

    def __init__(self):
        self.pings = []

    def ping(self, content):
        self.pings.append(content)


def test_all_clients_answer_every_round():
    barriers, done = Barriers(Loop(), lambda: True), []
    first, second = Client(), Client()
    barriers.begin(lambda: [first, second], lambda: done.append(True))

    for number in range(ROUNDS):
        assert len(first.pings) == len(second.pings) == number + 1
        barriers.pong(first, first.pings[-1])
        barriers.pong(first, first.pings[-1])
        assert not done
        barriers.pong(second, second.pings[-1])
    assert done == [True]


def test_none_is_waited_for_that_has_left_and_nobody_answers_where_nobody_is():
    barriers, done = Barriers(Loop(), lambda: True), []
    first, second = Client(), Client()
    clients = [first, second]
    barriers.begin(lambda: clients, lambda: done.append("one is left"), 1)
    clients = [first]
    barriers.gone(second)
    barriers.pong(first, first.pings[-1])
    barriers.begin(lambda: clients, lambda: done.append("none is left"), 1)
    clients = []
    barriers.gone(first)

    assert done == ["one is left"]


def test_a_pong_that_answers_no_barrier_changes_nothing():
    barriers, done = Barriers(Loop(), lambda: True), []
    client = Client()
    barriers.begin(lambda: [client], lambda: done.append(True), rounds=1)
    barriers.pong(client, b"")  # of a ping that was to see whether it lives

    assert not done
    barriers.pong(client, client.pings[-1])
    assert done


def test_pings_go_behind_what_waits_for_its_turn():
    loop, is_idle, client = Loop(), False, Client()
    barriers = Barriers(loop, lambda: is_idle)
    barriers.begin(lambda: [client], lambda: None)

    loop.run()
    assert not client.pings
    is_idle = True
    loop.run()
    assert len(client.pings) == 1
