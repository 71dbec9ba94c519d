"""The transport of native ROS 2: DDS by ``cyclonedds``, without a server and without ROS.

A ``Ros2Transport`` is a participant of a DDS domain. It names topics, services and types as the
middleware of ROS 2 does: messages of ``/r1/odom`` travel on ``rt/r1/odom``, requests and replies
of a service on ``rq/…Request`` and ``rr/…Reply``. ``Types`` makes the structures of messages from
the definitions of the bridge.

All callbacks run in one thread. DDS keeps the order of the messages of one writer only, so an
executor may take a tick's messages in any order, but it takes all that have arrived. The *barrier*
asks the parameter service, which every node of rclpy and rclcpp has, twice: when a node of a single
thread answers the second call, it has taken all messages before, and published its commands.

Topics are interoperable across vendors of DDS, services are not. Those here are Cyclone's, as
rmw_cyclonedds_cpp has them.

References
----------
https://design.ros2.org/articles/topic_and_service_names.html; rmw_cyclonedds, ``rmw_node.cpp``.
"""

import base64
import os
import secrets
import socket
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, suppress
from functools import partial
from itertools import count
from pathlib import Path
from random import sample
from sched import scheduler
from threading import Thread, get_ident
from typing import Any, NamedTuple, TypeAlias

from cyclonedds.builtin import (
    BuiltinDataReader,
    BuiltinTopicDcpsParticipant,
    BuiltinTopicDcpsPublication,
    BuiltinTopicDcpsSubscription,
    DcpsEndpoint,
    DcpsParticipant,
)
from cyclonedds.core import (
    DDSException,
    Entity,
    GuardCondition,
    InstanceState,
    Policy,
    Qos,
    ReadCondition,
    SampleState,
    ViewState,
    WaitSet,
)
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct, make_idl_struct
from cyclonedds.idl import types as idl
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic as DdsTopic

from mrsfi_bridge.settings import TypeTable
from mrsfi_bridge.structures import BYTE_ARRAYS, FORMATS, SCALAR, VARIABLE, Field, Structure
from mrsfi_runtime.errors import ProtocolError, TransportClosed, TransportError, UsageError
from mrsfi_runtime.transport.rosbridge import ListenedTransport, errors_as_ours
from mrsfi_runtime.transport.topics import (
    BEST_EFFORT,
    PUBLISHERS,
    RELIABLE,
    STRONG,
    SUBSCRIBERS,
    TOPICS,
    TRANSIENT_LOCAL,
    VOLATILE,
    Payload,
    Provider,
    Publisher,
    Reply,
    Service,
    Topic,
    TopicQos,
)

_BOUNDED_TEXT: Any = idl.bounded_str
_SEQUENCE: Any = idl.sequence
_ARRAY: Any = idl.array
"""Indexed by the type of their elements, and how many there are."""

_PRIMITIVES: Mapping[str, Any] = {
    **{name: getattr(idl, name, None) for name in FORMATS},
    "bool": bool,
    "byte": idl.uint8,
    "char": idl.uint8,
    "string": str,
}
_EMPTY = "structure_needs_at_least_one_member"  # the field of a structure without any, as in ROS 2


class Kind:
    """A type of messages; those of a service begin with a ``header``."""

    def __init__(
        self, name: str, structure: Structure, made: type[IdlStruct], nested: Mapping[str, "Kind"]
    ) -> None:
        self.name = name
        self.made = made
        self._structure = structure
        fields = structure.definition.fields
        self._packs = {each.name: _packs(each, nested.get(each.type)) for each in fields}
        self._unpacks = {each.name: _unpacks(each, nested.get(each.type)) for each in fields}
        self._lacking = {} if fields else {_EMPTY: 0}

    @errors_as_ours()
    def instance(self, payload: Payload, **header: int) -> Any:
        """Return a message with default values where the payload has none."""
        return self.pack(self._structure.convert(payload), **header)

    def pack(self, payload: Payload, **header: int) -> Any:
        """Return the message of a payload in normal form."""
        values = {name: pack(payload[name]) for name, pack in self._packs.items()}
        return self.made(**header, **values, **self._lacking)

    def unpack(self, message: Any) -> Payload:
        """Return the payload of a message."""
        return {name: unpack(getattr(message, name)) for name, unpack in self._unpacks.items()}


class Types:
    """The types of DDS, made of those of ROS 2 when they are first asked for.

    One that is unknown, or that DDS cannot carry here, is a ``MrsfiError``.
    """

    def __init__(self, table: TypeTable) -> None:
        self._table = table
        self._kinds: dict[str, Kind] = {}

    @errors_as_ours()
    def message(self, name: str) -> Kind:
        """Return the type of the messages of a topic."""
        return self._kind(self._table.message(name))

    @errors_as_ours()
    def service(self, name: str) -> tuple[Kind, Kind]:
        """Return the types of the requests and the responses of a service."""
        found = self._table.service(name)
        header = {"guid": idl.uint64, "seq": idl.int64}  # of rmw_cyclonedds
        request = self._made(f"{found.name}_Request", "srv", found.request, header)
        return request, self._made(f"{found.name}_Response", "srv", found.response, header)

    def _kind(self, structure: Structure) -> Kind:
        if structure.name not in self._kinds:
            self._kinds[structure.name] = self._made(structure.name, "msg", structure, {})
        return self._kinds[structure.name]

    def _made(
        self, name: str, folder: str, structure: Structure, header: Mapping[str, Any]
    ) -> Kind:
        package, _, short = name.partition("/")
        nested = {each: self._kind(inner) for each, inner in structure.nested.items()}
        fields = dict(header)
        for each in structure.definition.fields:
            fields[each.name] = _type_of(each, name, nested.get(each.type))
        if not structure.definition.fields:
            fields[_EMPTY] = idl.uint8
        full = f"{package}::{folder}::dds_::{short}_"
        return Kind(full, structure, make_idl_struct(f"{short}_", full, fields), nested)


def _type_of(field: Field, owner: str, nested: Kind | None) -> Any:
    element = nested.made if nested is not None else _PRIMITIVES.get(field.type)
    if element is None:
        raise UsageError(f"{owner}: field '{field.name}': {field.type} is not supported over DDS")
    if field.length == SCALAR:
        return _BOUNDED_TEXT[field.bound] if field.bound and element is str else element
    if field.length == VARIABLE:
        return _SEQUENCE[element, field.bound] if field.bound else _SEQUENCE[element]
    return _ARRAY[element, field.length]


def _packs(field: Field, nested: Kind | None) -> Callable[[Any], Any]:
    if field.length != SCALAR and field.type in BYTE_ARRAYS:
        return base64.b64decode
    if nested is None:
        return _same
    return nested.pack if field.length == SCALAR else lambda some: [*map(nested.pack, some)]


def _unpacks(field: Field, nested: Kind | None) -> Callable[[Any], Any]:
    if field.length != SCALAR and field.type in BYTE_ARRAYS:
        return lambda some: base64.b64encode(bytes(some)).decode("ascii")
    if nested is None:
        return _same if field.length == SCALAR else list
    return nested.unpack if field.length == SCALAR else lambda some: [*map(nested.unpack, some)]


def _same(value: Any) -> Any:
    return value


DOMAINS = range(1, 100)
"""Domains of ROS 2 that leave the ports of clients alone, without the default one."""

_PORTS, _PORTS_OF_ONE, _LOCK = 7400, 250, 248
"""The first port of DDS, how many a domain has, and which of them no participant uses."""

_ON_THIS_MACHINE = (
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name='lo' multicast='false'/>"
    "</Interfaces><AllowMulticast>false</AllowMulticast></General><Discovery><Peers>"
    "<Peer Address='127.0.0.1'/></Peers><ParticipantIndex>auto</ParticipantIndex>"
    "<MaxAutoParticipantIndex>100</MaxAutoParticipantIndex></Discovery></Domain></CycloneDDS>"
)
"""Cyclone's configuration of a domain that other machines do not see."""

_ENDS_AT_ONCE = (
    "<CycloneDDS><Domain><Internal><WriterLingerDuration>0s</WriterLingerDuration></Internal>"
    "</Domain></CycloneDDS>"
)
"""Its configuration of writers: by default each waits a second for a node that has ended."""


def _delete(entity: Entity) -> None:
    """End an entity of DDS, and all of it, before the garbage collector does."""
    entity.__del__()


class DdsDomain(NamedTuple):
    """A domain, and the environment in which a node joins it."""

    number: int
    variables: tuple[str, ...]


def domain_of(number: int | None, opened: ExitStack) -> DdsDomain:
    """Return a domain, or a free one that no other mrsfi of this machine uses until the end."""
    variables = ["RMW_IMPLEMENTATION=rmw_cyclonedds_cpp"]
    if number is not None:
        configured = filter(None, (os.environ.get("CYCLONEDDS_URI"), _ENDS_AT_ONCE))
        with suppress(DDSException):  # this process has joined it, or cannot: told when it joins
            opened.callback(_delete, Domain(number, ",".join(configured)))
        return DdsDomain(number, (f"ROS_DOMAIN_ID={number}", *variables))
    for each in sample(DOMAINS, len(DOMAINS)):  # one that was used just now may still be known
        lock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            lock.bind(("127.0.0.1", _PORTS + each * _PORTS_OF_ONE + _LOCK))
        except OSError:
            lock.close()
            continue
        opened.callback(lock.close)
        opened.callback(_delete, Domain(each, f"{_ON_THIS_MACHINE},{_ENDS_AT_ONCE}"))
        variables += [f"ROS_DOMAIN_ID={each}", f"CYCLONEDDS_URI={_ON_THIS_MACHINE}"]
        return DdsDomain(each, tuple(variables))
    raise TransportError("the DDS domains 1 to 99 are all in use; expected a free one, or --domain")


_Property = Policy.Property
_ANY = ViewState.Any | InstanceState.Any | SampleState.NotRead
_ALIVE = ViewState.Any | InstanceState.Alive | SampleState.Any
_CYCLONE = bytes((1, 16))  # the vendor, in the first two bytes of a participant's key
_PARAMETERS = "rcl_interfaces/GetParameters"
_DEFINITIONS = Path(__file__).parent / "types"  # what a server of either ROS does not bring
_MANY = 1000  # samples to take at a time


def _ends(
    participant: DomainParticipant, service: Service, request: Kind, response: Kind
) -> tuple[DdsTopic[Any], DdsTopic[Any]]:
    """Return the topics of the requests and the replies of a service."""
    asks = DdsTopic(participant, f"rq{service.name}Request", request.made)
    return asks, DdsTopic(participant, f"rr{service.name}Reply", response.made)


_AGAIN = 0.2  # seconds after which a request is sent again
Later: TypeAlias = Callable[[float, Callable[[], None]], None]
"""Calls a function after some seconds."""


class _Call:
    """A client of a service: the requests without a reply yet, and what to do with it."""

    def __init__(
        self, participant: DomainParticipant, service: Service, types: Types, later: Later
    ) -> None:
        self._later = later
        self._request, self._response = types.service(service.type)
        asks, replies = _ends(participant, service, self._request, self._response)
        self.writer = DataWriter(participant, asks, qos=_SERVICE_QOS)
        self.reader = DataReader(participant, replies, qos=_SERVICE_QOS)
        self._guid, self._numbers = secrets.randbits(63), count(1)
        self._open: dict[int, Callable[[Reply], None]] = {}
        self.is_met = False

    def begin(self, request: Payload, on_reply: Callable[[Reply], None]) -> None:
        """Send a request."""
        number = next(self._numbers)
        self._open[number] = on_reply
        self._send(self._request.instance(request, guid=self._guid, seq=number))

    def _send(self, message: Any) -> None:
        """Send a request until the first reply: who serves may not know this client yet."""
        if message.seq in self._open:
            self.writer.write(message)
            if not self.is_met:
                self._later(_AGAIN, partial(self._send, message))

    def receive(self, message: Any) -> None:
        """Take a reply, which may be that of another client."""
        if message.guid == self._guid and message.seq in self._open:
            self.is_met = True
            self._open.pop(message.seq)(Reply(self._response.unpack(message)))


def _qos(of: TopicQos) -> Qos:
    is_best_effort = of.reliability == BEST_EFFORT
    is_kept = of.durability == TRANSIENT_LOCAL
    return Qos(
        Policy.Reliability.BestEffort if is_best_effort else _RELIABLE,
        Policy.Durability.TransientLocal if is_kept else Policy.Durability.Volatile,
        Policy.History.KeepLast(of.depth),
    )


_RELIABLE = Policy.Reliability.Reliable(10**9)  # nanoseconds for which a full queue blocks
_SERVICE_QOS = Qos(_RELIABLE, Policy.Durability.Volatile, Policy.History.KeepAll)


Readers: TypeAlias = list[tuple[DataReader[Any], Callable[[Any], None]]]
"""Readers, and what receives each of their messages."""


class Ros2Transport(ListenedTransport):
    """A participant of a DDS domain; ``qos`` are those of topics that differ from the default."""

    ros = 2
    hint = "names or the domain may differ: compare `ros2 node info` with [node]"

    def __init__(self, domain: DdsDomain, types: TypeTable, qos: Mapping[str, TopicQos]) -> None:
        super().__init__()
        try:
            self._participant = DomainParticipant(domain.number)
        except DDSException as error:
            what = f"DDS domain {domain.number} cannot be joined: {error}"
            raise TransportError(what) from error
        self._types = Types(types)
        self._own_types = Types(TypeTable([_DEFINITIONS], ros=2))
        self._qos = qos
        self._heard: Readers = []
        self._served: Readers = []
        self._ours: dict[str, tuple[Topic, str]] = {}  # by their names in DDS, with their types
        self._asked: tuple[str, ...] = ()
        self._calls: dict[str, _Call] = {}
        self._later = scheduler()
        self._participants = BuiltinDataReader(self._participant, BuiltinTopicDcpsParticipant)
        self._endpoints = {
            PUBLISHERS: BuiltinDataReader(self._participant, BuiltinTopicDcpsPublication),
            SUBSCRIBERS: BuiltinDataReader(self._participant, BuiltinTopicDcpsSubscription),
        }
        self._wake = GuardCondition(self._participant)
        self._waits = WaitSet(self._participant)
        self._waits.attach(self._wake)
        self._conditions: list[ReadCondition] = []
        self._is_closing = False
        self._thread = Thread(target=self._serve, daemon=True)
        self._thread.start()

    def advertise(self, topic: Topic) -> Publisher:
        """Return the function that publishes on a topic."""
        kind = self._types.message(topic.type)
        writer = DataWriter(self._participant, self._named(topic, kind), qos=self._qos_of(topic))

        def publish(payload: Payload) -> None:
            self.require_open()
            writer.write(kind.instance(payload))

        return publish

    def subscribe(self, topic: Topic, callback: Callable[[Payload], None]) -> None:
        """Have a callback receive every message of a topic."""
        kind = self._types.message(topic.type)
        reader = DataReader(self._participant, self._named(topic, kind), qos=self._qos_of(topic))
        receive = self.reporting(callback)
        self._hear(self._heard, reader, lambda message: receive(kind.unpack(message)))

    def provide(self, service: Service, provider: Provider) -> None:
        """Answer the calls of a service."""
        request, response = self._types.service(service.type)
        asks, replies = _ends(self._participant, service, request, response)
        writer = DataWriter(self._participant, replies, qos=_SERVICE_QOS)
        answer = self.reporting(provider)

        def serve(message: Any) -> None:
            values = answer(request.unpack(message))
            writer.write(response.instance(values, guid=message.guid, seq=message.seq))

        self._hear(self._served, DataReader(self._participant, asks, qos=_SERVICE_QOS), serve)

    def call(self, service: Service, request: Payload, on_reply: Callable[[Reply], None]) -> None:
        """Call a service; of those of a server, who uses topics is known here."""
        self.require_open()
        reply = self.reporting(on_reply)
        if service in {TOPICS, *self._endpoints}:
            found = self._known(service, str(request.get("topic")))
            self.call_later(0.0, lambda: reply(Reply({service.name.rpartition("/")[2]: found})))
            return
        asks = {each.topic_name for each in self._others(SUBSCRIBERS)}
        if f"rq{service.name}Request" in asks:
            self._call(service).begin(request, reply)
        else:
            self.call_later(0.0, lambda: reply(Reply({}, f"nobody provides {service.name}")))

    def call_later(self, seconds: float, function: Callable[[], None]) -> None:
        """Call a function after a time, in the thread of the callbacks."""
        self._later.enter(seconds, 0, self._call_due, (function,))
        self._wake.set(True)

    def barrier(self, then: Callable[[], None]) -> None:
        """Call a function when every node has answered all messages so far.

        If there is no such node, it is a ``ProtocolError``.
        """
        names = self._asked = self._asked or self._nodes()
        waiting = len(names)

        def end() -> None:
            nonlocal waiting
            waiting -= 1
            if not waiting:
                self.settle()
                then()

        for name in names:
            self._ask_twice(self._call(Service(f"{name}/get_parameters", _PARAMETERS)), end)

    @staticmethod
    def _ask_twice(call: _Call, end: Callable[[], None]) -> None:
        call.begin({}, lambda _: call.begin({}, lambda _: end()))

    def settle(self) -> None:
        """Take all messages that have arrived; in the thread of the callbacks."""
        for reader, receive in self._heard:
            _take(reader, receive)

    def close(self) -> None:
        """Give up all topics and services."""
        if self.lost is None:
            self.lost = TransportClosed("the participant was closed")
            self.report(self.lost)
            self._is_closing = True
            self._wake.set(True)
            if get_ident() != self._thread.ident:
                self._thread.join()
                _delete(self._participant)

    def _serve(self) -> None:
        due: float | None = None  # seconds until the next function is
        while not self._is_closing:
            self._waits.wait(int(min(1.0 if due is None else due, 1.0) * 1e9))
            self._wake.take()
            with suppress(Exception):  # reported to the listener
                self.settle()
            for reader, receive in [*self._served]:
                with suppress(Exception):
                    _take(reader, receive)
            due = self._later.run(blocking=False)

    def _call_due(self, function: Callable[[], None]) -> None:
        with suppress(Exception):
            if not self._is_closing:
                self.reporting(function)()

    def _hear(
        self, readers: Readers, reader: DataReader[Any], receive: Callable[[Any], None]
    ) -> None:
        readers.append((reader, receive))
        self._conditions.append(ReadCondition(reader, _ANY))
        self._waits.attach(self._conditions[-1])
        self._wake.set(True)

    def _named(self, topic: Topic, kind: Kind) -> DdsTopic[Any]:
        self._ours[f"rt{topic.name}"] = topic, kind.name
        return DdsTopic(self._participant, f"rt{topic.name}", kind.made)

    def _qos_of(self, topic: Topic) -> Qos:
        return _qos(self._qos.get(topic.name, TopicQos()))

    def _call(self, service: Service) -> _Call:
        if service.name not in self._calls:
            call = self._calls[service.name] = _Call(
                self._participant,
                service,
                self._own_types if service.type == _PARAMETERS else self._types,
                self.call_later,
            )
            self._hear(self._served, call.reader, self.reporting(call.receive))
        return self._calls[service.name]

    def _others(self, what: Service) -> Iterator[DcpsEndpoint]:
        """Yield the publishers or subscribers of other participants whose processes run.

        DDS itself notices the end of a process that was killed after ten seconds only.
        """
        found = _known_to(self._participants)
        left_out = {self._participant.guid, *(each.key for each in found if not _is_running(each))}
        for each in _known_to(self._endpoints[what]):
            if each.participant_key not in left_out:
                yield each

    def _known(self, what: Service, topic: str) -> list[str]:
        """Return what a server would answer; a node that cannot be met is a ``ProtocolError``."""
        self._asked = ()
        for call in self._calls.values():
            call.is_met = False
        if what == TOPICS:
            return [
                each.topic_name.removeprefix("rt")
                for each in self._others(PUBLISHERS)
                if each.topic_name.startswith("rt/")
            ]
        there = [each for each in self._others(what) if each.topic_name == f"rt{topic}"]
        for each in there:
            self._require_fit(what, each)
        return [str(each.participant_key) for each in there]

    def _require_fit(self, what: Service, there: DcpsEndpoint) -> None:
        topic, kind = self._ours[there.topic_name]
        verb = "publishes" if what == PUBLISHERS else "subscribes to"
        place = f"the node {verb} {topic.name}"
        if there.type_name != kind:
            found, expected = (_spelled(each) for each in (there.type_name, kind))
            raise ProtocolError(f"{place} with type {found}; expected {expected}, as in [node]")
        ours, theirs = self._qos.get(topic.name, TopicQos()), _qos_of(there)
        offered, requested = (theirs, ours) if what == PUBLISHERS else (ours, theirs)
        for name, strong in STRONG.items():
            if getattr(requested, name) == strong != getattr(offered, name):
                found, expected = getattr(theirs, name), getattr(ours, name)
                raise ProtocolError(
                    f"{place} with {name} {found}, which does not meet {expected}; expected qos = "
                    f"{{ {name} = '{found}' }} for this topic in [node]"
                )

    def _nodes(self) -> tuple[str, ...]:
        """Return the names of the nodes that use a topic of this participant."""
        used = {
            each.participant_key
            for what in self._endpoints
            for each in self._others(what)
            if each.topic_name in self._ours
        }
        ending = "/get_parametersRequest"
        names = {
            each.topic_name.removeprefix("rq").removesuffix(ending)
            for each in self._others(SUBSCRIBERS)
            if each.topic_name.endswith(ending) and each.participant_key in used
        }
        foreign = next((each for each in used if each.bytes[:2] != _CYCLONE), None)
        if foreign is not None:
            raise ProtocolError(
                f"the node runs on another DDS than Cyclone (vendor {foreign.hex[:4]}), whose "
                "services cannot be called; start it with RMW_IMPLEMENTATION=rmw_cyclonedds_cpp, "
                "or set --node-pace to answer or a rate"
            )
        if not names:
            raise ProtocolError(
                "the node has no parameter service; expected one of rclpy or rclcpp, whose "
                "services were not switched off, or --node-pace answer or a rate"
            )
        return tuple(sorted(names))


def _known_to(reader: BuiltinDataReader) -> list[Any]:
    """Return the participants or endpoints that DDS knows."""
    return [*reader.read(_MANY, ReadCondition(reader, _ALIVE))]


def _is_running(participant: DcpsParticipant) -> bool:
    """Return whether a participant's process runs, as far as that can be known."""
    told = {each.key: each.value for each in participant.qos if isinstance(each, _Property)}
    if told.get("__Hostname") != socket.gethostname() or not told.get("__Pid", "").isdecimal():
        return True
    with suppress(PermissionError):
        try:
            os.kill(int(told["__Pid"]), 0)
        except ProcessLookupError:
            return False
    return True


def _take(reader: DataReader[Any], receive: Callable[[Any], None]) -> None:
    for message in reader.take(_MANY):
        if isinstance(message, IdlStruct):  # not the end of a writer
            receive(message)


def _qos_of(endpoint: DcpsEndpoint) -> TopicQos:
    """Return the quality of service of another participant's end of a topic."""
    reliability, durability = endpoint.qos[Policy.Reliability], endpoint.qos[Policy.Durability]
    return TopicQos(
        BEST_EFFORT if reliability == Policy.Reliability.BestEffort else RELIABLE,
        VOLATILE if durability == Policy.Durability.Volatile else TRANSIENT_LOCAL,
    )


def _spelled(kind: str) -> str:
    return kind.replace("::dds_", "").replace("::", "/").removesuffix("_")
