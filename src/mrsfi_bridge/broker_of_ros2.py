"""Topics as the middleware of ROS 2 has them: ten messages under way, each topic in its turn."""

import logging
from asyncio import AbstractEventLoop
from collections import deque
from collections.abc import Hashable
from dataclasses import dataclass, field
from itertools import count

from mrsfi_bridge.broker import Broker, Subscriber, Topic
from mrsfi_bridge.frames import Outgoing
from mrsfi_bridge.settings import Limits, TypeTable

DEPTH = 10
"""Messages of a topic that are under way at most; of more, the oldest are lost."""

LIFESPAN_S = 1.0
"""How long what was said on a topic is kept for those who subscribe later."""

_LOGGER = logging.getLogger("mrsfi.bridge")


@dataclass(slots=True)
class _Lane:
    """What is under way on a topic, and what was not long ago; ``order`` is that of subscribing."""

    order: int
    waiting: deque[Outgoing] = field(default_factory=lambda: deque(maxlen=DEPTH))
    recent: deque[tuple[float, Outgoing]] = field(default_factory=lambda: deque(maxlen=DEPTH))
    n_lost: int = 0


class BrokerOfRos2(Broker):
    """Delivers messages in the next turn of the loop, in order within a topic only.

    A turn delivers one message of each topic, in the order in which topics were subscribed to. A
    late subscriber gets the last second of a topic, also of publishers that have left. So did
    rosbridge_suite 2.1.0 on ROS 2 Jazzy, where it was measured.
    """

    def __init__(self, types: TypeTable, limits: Limits, scheduler: AbstractEventLoop) -> None:
        super().__init__(types, limits)
        self._scheduler = scheduler
        self._lanes: dict[str, _Lane] = {}
        self._ready: dict[str, _Lane] = {}
        self._orders = count()
        self._is_expiring = False

    def subscribe(
        self, client: Hashable, name: str, type_name: str | None, subscriber: Subscriber
    ) -> None:
        """Do as ``Broker`` does; the first to subscribe gives a topic its place among others."""
        super().subscribe(client, name, type_name, subscriber)
        if len(self.topics[name].subscribers) == 1:
            self._lane(name).order = next(self._orders)

    @property
    def is_idle(self) -> bool:
        """Whether no topic waits for its turn."""
        return not self._ready

    def _pass_on(self, topic: Topic, outgoing: Outgoing) -> None:
        lane = self._lane(topic.name)
        if len(lane.waiting) == DEPTH and topic.subscribers:
            lane.n_lost += 1
            if lane.n_lost == 1:
                _LOGGER.warning("%s: lost a message, the oldest of %d", topic.name, DEPTH + 1)
        lane.waiting.append(outgoing)
        if not self._ready:
            self._scheduler.call_soon(self._turn)
        self._ready[topic.name] = lane

    def _kept(self, topic: Topic) -> list[Outgoing]:
        since = self._scheduler.time() - LIFESPAN_S
        lane = self._lane(topic.name)
        recent = [
            outgoing
            for moment, outgoing in lane.recent
            if moment >= since and outgoing.structure is topic.structure
        ]
        come = (*recent, *lane.waiting)
        return [*(each for each in super()._kept(topic) if each not in come), *recent]

    def _lane(self, name: str) -> _Lane:
        lane = self._lanes.get(name)
        if lane is None:
            lane = self._lanes[name] = _Lane(next(self._orders))
        return lane

    def _turn(self) -> None:
        """Deliver one message of each topic."""
        ready, self._ready = self._ready, {}
        now = self._scheduler.time()
        for name, lane in sorted(ready.items(), key=lambda item: item[1].order):
            outgoing = lane.waiting.popleft()
            lane.recent.append((now, outgoing))
            topic = self.topics.get(name)
            if topic is not None and topic.structure is outgoing.structure:
                super()._pass_on(topic, outgoing)
        for name, lane in ready.items():
            if lane.waiting:
                if not self._ready:
                    self._scheduler.call_soon(self._turn)
                self._ready[name] = lane
        if not self._is_expiring:
            self._is_expiring = True
            self._scheduler.call_later(LIFESPAN_S, self._expire)

    def _expire(self) -> None:
        """Forget what is over, and topics on which nothing is left."""
        since = self._scheduler.time() - LIFESPAN_S
        for name, lane in tuple(self._lanes.items()):
            while lane.recent and lane.recent[0][0] <= since:
                lane.recent.popleft()
            if name not in self.topics and not lane.recent and not lane.waiting:
                del self._lanes[name]
        self._is_expiring = any(lane.recent for lane in self._lanes.values())
        if self._is_expiring:
            self._scheduler.call_later(LIFESPAN_S, self._expire)
