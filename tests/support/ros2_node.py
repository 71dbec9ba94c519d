"""A node of ROS 2 for tests, as rclpy would run it: on DDS alone, and in a single thread.

``python -m tests.support.ros2_node CODE DOMAIN SEED [WHAT]`` flies with the generated reactions of
a mission. ``WHAT`` is something that it does wrong. Its types and names are typed here by hand,
after the definitions of ROS 2, so that it shares no code with what it tests.
"""

import os
import sys
from dataclasses import dataclass
from pathlib import Path
from random import Random
from threading import Thread
from time import sleep

from cyclonedds.core import (
    InstanceState,
    Policy,
    Qos,
    ReadCondition,
    SampleState,
    ViewState,
    WaitSet,
)
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import float64, int32, int64, sequence, uint8, uint32, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from mrsfi_runtime.cosimulation.bus_topics import CLOCK
from tests.support.standin_node import StandIn


@dataclass
class Point(IdlStruct, typename="geometry_msgs::msg::dds_::Point_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Float64(IdlStruct, typename="std_msgs::msg::dds_::Float64_"):
    data: float64


@dataclass
class Float32(IdlStruct, typename="std_msgs::msg::dds_::Float32_"):
    data: float


@dataclass
class Int64(IdlStruct, typename="std_msgs::msg::dds_::Int64_"):
    data: int64


@dataclass
class Bool(IdlStruct, typename="std_msgs::msg::dds_::Bool_"):
    data: bool


@dataclass
class Dimension(IdlStruct, typename="std_msgs::msg::dds_::MultiArrayDimension_"):
    label: str
    size: uint32
    stride: uint32


@dataclass
class Layout(IdlStruct, typename="std_msgs::msg::dds_::MultiArrayLayout_"):
    dim: sequence[Dimension]
    data_offset: uint32


@dataclass
class Int64MultiArray(IdlStruct, typename="std_msgs::msg::dds_::Int64MultiArray_"):
    layout: Layout
    data: sequence[int64]


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Clock(IdlStruct, typename="rosgraph_msgs::msg::dds_::Clock_"):
    clock: Time


@dataclass
class Trigger(IdlStruct, typename="std_srvs::srv::dds_::Trigger_Request_"):
    guid: uint64
    seq: int64
    structure_needs_at_least_one_member: uint8


@dataclass
class Triggered(IdlStruct, typename="std_srvs::srv::dds_::Trigger_Response_"):
    guid: uint64
    seq: int64
    success: bool
    message: str


@dataclass
class GetParameters(IdlStruct, typename="rcl_interfaces::srv::dds_::GetParameters_Request_"):
    guid: uint64
    seq: int64
    names: sequence[str]


@dataclass
class ParameterValue(IdlStruct, typename="rcl_interfaces::msg::dds_::ParameterValue_"):
    type: uint8
    bool_value: bool
    integer_value: int64
    double_value: float64
    string_value: str
    byte_array_value: sequence[uint8]
    bool_array_value: sequence[bool]
    integer_array_value: sequence[int64]
    double_array_value: sequence[float64]
    string_array_value: sequence[str]


@dataclass
class GotParameters(IdlStruct, typename="rcl_interfaces::srv::dds_::GetParameters_Response_"):
    guid: uint64
    seq: int64
    values: sequence[ParameterValue]


TYPES = {
    "geometry_msgs/Point": Point,
    "geometry_msgs/Vector3": Vector3,
    "std_msgs/Float64": Float64,
    "std_msgs/Int64": Int64,
    "std_msgs/Bool": Bool,
    "std_msgs/Int64MultiArray": Int64MultiArray,
    "rosgraph_msgs/Clock": Clock,
}
QOS = Qos(Policy.Reliability.Reliable(10**9), Policy.History.KeepLast(10))
ANY = SampleState.NotRead | ViewState.Any | InstanceState.Any
OF_SERVICES = Qos(Policy.Reliability.Reliable(10**9), Policy.History.KeepAll)
STRICT = Qos(
    Policy.Reliability.Reliable(10**9),
    Policy.Durability.TransientLocal,
    Policy.History.KeepLast(10),
)


class Executor:
    """Takes one message of each subscription in turn, in a random order, and then one request."""

    ros = 2

    def __init__(self, domain: int, what: str) -> None:
        self.what = what
        self.participant = DomainParticipant(domain)
        self.waits = WaitSet(self.participant)
        self.conditions = []
        self.subscriptions, self.services = [], []
        self.random = Random(domain)

    def advertise(self, topic):
        kind = TYPES[topic.type]
        writer = self.writer(f"rt{topic.name}", kind, QOS)

        def publish(payload):
            if kind is Int64MultiArray:
                payload = {"layout": Layout([], 0), **payload}
            message = kind(**payload)
            if self.what == "commands late" and "/command/" in topic.name:
                Thread(target=lambda: (sleep(0.05), writer.write(message))).start()
            else:
                writer.write(message)

        return publish

    def subscribe(self, topic, callback):
        kind = TYPES[topic.type]
        if self.what == "has another type" and topic.name.endswith("/speed"):
            kind = Float32
        is_strict = self.what == "wants more" and topic.name.endswith("/speed")
        reader = self.reader(f"rt{topic.name}", kind, STRICT if is_strict else QOS)
        self.subscriptions.append((reader, lambda message: callback(vars(message))))

    def provide(self, service, provider):
        self.serve(service.name, Trigger, Triggered, lambda _: provider({}))

    def serve(self, name, asked, answered, provider):
        reader = self.reader(f"rq{name}Request", asked, OF_SERVICES)
        writer = self.writer(f"rr{name}Reply", answered, OF_SERVICES)

        def answer(request):
            values = provider(request)
            if values is not None:
                writer.write(answered(guid=request.guid, seq=request.seq, **values))

        self.services.append((reader, answer))

    def spin(self):
        """Run for ever."""
        self.serve_parameters()
        while True:
            self.random.shuffle(self.subscriptions)
            n_taken = sum(self.take_one(*each) for each in (*self.subscriptions, *self.services))
            if not n_taken:
                self.waits.wait(10**9)

    def serve_parameters(self):
        """Have the parameter service that every node has."""
        if self.what != "has no parameters":
            values = None if self.what == "is silent" else {"values": []}
            name = "/patrol/get_parameters"
            self.serve(name, GetParameters, GotParameters, lambda _: values)

    @staticmethod
    def take_one(reader, execute):
        taken = [each for each in reader.take(1) if isinstance(each, IdlStruct)]
        for message in taken:
            execute(message)
        return len(taken)

    def reader(self, name, kind, qos):
        reader = DataReader(self.participant, Topic(self.participant, name, kind), qos=qos)
        self.conditions.append(ReadCondition(reader, ANY))
        self.waits.attach(self.conditions[-1])
        return reader

    def writer(self, name, kind, qos):
        return DataWriter(self.participant, Topic(self.participant, name, kind), qos=qos)


def main() -> None:
    """Fly until it is ended."""
    directory, domain, seed, *what = sys.argv[1:]
    executor = Executor(int(domain), "".join(what))
    StandIn(Path(directory), executor, int(seed))
    if what == ["dies"]:
        executor.subscribe(CLOCK, lambda now: now["clock"].sec == 40 and os._exit(3))
    executor.spin()


if __name__ == "__main__":
    main()
