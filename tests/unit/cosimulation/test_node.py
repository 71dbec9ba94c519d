"""A team's node between what is heard and what is commanded."""

import math
import re
from contextlib import contextmanager
from dataclasses import replace
from queue import SimpleQueue
from threading import Thread
from unittest.mock import patch

import pytest

from mrsfi_bridge.settings import TypeTable
from mrsfi_runtime.cosimulation import node as node_of
from mrsfi_runtime.cosimulation.bus_lockstep import BusLockstep, SimulationHost
from mrsfi_runtime.cosimulation.bus_topics import BARRIER, Pace, Patience
from mrsfi_runtime.cosimulation.node import Node
from mrsfi_runtime.cosimulation.node_mapping import GENERATED, NodeMapping
from mrsfi_runtime.cosimulation.node_speech import Relay, Speech, held_commands, out_of_reach
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.errors import TransportError, TransportTimeout
from mrsfi_runtime.kernel.injections import plan
from mrsfi_runtime.model.faults import Event, FaultPool, TimedFault, Trigger
from mrsfi_runtime.model.mission import Message
from mrsfi_runtime.transport.rosbridge import ListenedTransport
from mrsfi_runtime.transport.topics import LocalBus, Reply, Service, Topic
from tests.support.fault_types import FAULT_TYPES
from tests.support.search import paper_mission, pool_of
from tests.support.two_sides import BusEngine
from tests.support.world import paper_code

PATIENCE = Patience(tick=1.0, handshake=2.0)
T = 30
CODE = paper_code(T)
ODOMETRY = {
    "topic": "/{robot}/odom",
    "type": "nav_msgs/Odometry",
    "fields": {"pose.pose.position.x": "x", "twist.twist.linear.x": "speed"},
}
POSITION = {
    "topic": "/{robot}/pose",
    "type": "geometry_msgs/PoseStamped",
    "fields": {"pose.position.x": "x", "header.frame_id": {"value": "map"}},
}
TWIST = {
    "topic": "/{robot}/cmd_vel",
    "type": "geometry_msgs/Twist",
    "fields": {"linear.x": "speed", "angular.z": "turn"},
}
DONE = {"topic": "/done", "type": "std_msgs/Empty"}
TABLE = {"tells": [ODOMETRY, POSITION], "obeys": [TWIST]}
MISSION = paper_mission()


class NodeBus(ListenedTransport):
    """Delivers at once, in a thread of its own; ``said`` is what was published on it."""

    ros = 1

    def __init__(self):
        super().__init__()
        self.bus, self.said, self.heard = LocalBus(), [], set()
        self._queue = SimpleQueue()
        Thread(target=self._work, daemon=True).start()

    def advertise(self, topic):
        publish = self.bus.advertise(topic)

        def tell(payload):
            self.said.append((topic.name, payload))
            publish(payload)

        return tell

    def subscribe(self, topic, callback):
        self.heard.add(topic.name)
        self.bus.subscribe(topic, self.reporting(callback))

    def provide(self, service, provider):
        self.bus.provide(service, provider)

    def call(self, service, request, on_reply):
        if service.name == "/rosapi/topics":
            on_reply(Reply({"topics": [*self.bus._types]}))
        elif service.name == "/rosapi/subscribers":
            on_reply(Reply({"subscribers": ["n"] * (request["topic"] in self.heard)}))
        else:
            self.bus.call(service, request, on_reply)

    def call_later(self, _seconds, function):
        self._queue.put(self.reporting(function))

    def close(self):
        self._queue.put(None)

    def _work(self):
        while (function := self._queue.get()) is not None:
            try:
                function()
            except Exception:  # noqa: BLE001 - the listener was told
                continue


@contextmanager
def engine_with(code, mapping, node, pace=BARRIER):
    """Yield an engine that flies with a node, and its bus.

    ``node`` gets a function that subscribes and one that advertises, and is reset by a service.
    """
    bus, world = NodeBus(), LocalBus()
    bus.provide(Service("/mission/reset", "std_srvs/Trigger"), lambda _: {"success": True})
    speech = Speech(mapping, code.mission, TypeTable())
    between = Node(bus, speech, Pace(pace, lambda then: bus.call_later(0.0, then)), PATIENCE)
    SimulationHost(world, code.simulation, code.mission, PATIENCE)
    lockstep = BusLockstep(world, code.mission, code.interface, code.truth, PATIENCE, between)
    between.pass_on(lockstep.advertise)
    bus.watch(lockstep.fail)
    node(
        lambda *topic, then: bus.subscribe(Topic(*topic), then), lambda *t: bus.advertise(Topic(*t))
    )
    try:
        with patch.object(node_of, "_STEADY", 0.0):  # it subscribed before
            yield BusEngine(code, 1, lockstep), bus, between
    finally:
        bus.close()


def mapping(**other):
    """Return the mapping of a table, some of it replaced."""
    return NodeMapping.of({**TABLE, **other})


def silent(hear, _):
    """Hear, and say nothing."""
    hear("/r1/pose", "geometry_msgs/PoseStamped", then=lambda _: None)


def saying(topic, kind, *messages, to="/r2/pose"):
    """Return a node that says the next of some messages whenever it hears a pose."""

    def node(hear, say):
        publish, left = say(topic, kind), [*messages]
        hear(to, "geometry_msgs/PoseStamped", then=lambda _: left and publish(left.pop(0)))

    return node


def flown(table, specification=(), node=silent, code=CODE, **more):
    """Return the outcome of a flight, and for each tick what the node was told, by topic."""
    with engine_with(code, table, node, **more) as (engine, bus, _):
        outcome = engine.evaluate(specification)
    ticks = [{}]
    for topic, message in bus.said:
        if topic == "/mission/tick":
            ticks.append({})
        elif topic != "/mission/setup":
            ticks[-1][topic] = message
    return outcome, ticks[:T]


def test_a_message_has_what_is_mapped_in_its_place():
    _, ticks = flown(mapping())

    (x,) = ticks[0]["/r1/odom"]["pose"]["pose"]["position"].values()
    assert ticks[0]["/r1/pose"] == {
        "pose": {"position": {"x": x}},
        "header": {"frame_id": "map", "stamp": {"secs": 0, "nsecs": 0}},
    }
    assert [{*tick} - {"/clock"} for tick in ticks] == [
        {f"/{robot}/{what}" for robot in ("r1", "r2", "r3") for what in ("odom", "pose")}
    ] * T


def test_the_last_turn_of_a_tick_counts_from_the_heading_before_the_tick():
    twists = [{"linear": {"x": 2.0}, "angular": {"z": turn}} for turn in (0.5, -0.3)]

    def node(last):
        def both(hear, say):
            publish = say("/r1/cmd_vel", "geometry_msgs/Twist")
            sent = twists[-last:]
            hear("/r2/pose", "geometry_msgs/PoseStamped", then=lambda _: [*map(publish, sent)])

        return both

    outcomes = [flown(mapping(), node=node(last))[0] for last in (1, 2)]

    assert outcomes[0] == outcomes[1]
    assert outcomes[0] != flown(mapping())[0]


def test_headers_have_the_time_of_the_tick_and_a_frame():
    _, ticks = flown(mapping(frame_id="odom"))

    for topic, frame in (("/r1/pose", "map"), ("/r1/odom", "odom")):
        assert [tick[topic]["header"] for tick in ticks] == [
            {"frame_id": frame, "stamp": {"secs": t, "nsecs": 0}} for t in range(T)
        ]


def test_the_clock_may_go_in_steps():
    with engine_with(CODE, mapping(clock_hz=4), silent) as (engine, bus, _):
        engine.evaluate(())

    said = [(topic, each) for topic, each in bus.said if topic in {"/clock", "/r1/odom"}]
    clocks = [each["clock"] for topic, each in said if topic == "/clock"]
    assert [each["secs"] + each["nsecs"] / 1e9 for each in clocks] == [
        quarter / 4 for quarter in range(4 * T - 3)
    ]
    assert [topic for topic, _ in said[2:7]] == ["/clock"] * 3 + ["/r1/odom", "/clock"]


def test_a_command_after_the_answer_is_late():
    commands = []

    def node(hear, say):
        publish = say("/r1/cmd_vel", "geometry_msgs/Twist")
        hear("/r1/pose", "geometry_msgs/PoseStamped", then=lambda _: commands.append(publish))

    with engine_with(CODE, mapping(), node) as (engine, _, between):
        between._pace.settle = lambda: len(commands) == 3 and commands[0]({"linear": {"x": 1.0}})
        with pytest.raises(TransportError, match="/r1/cmd_vel: a command came after the node had"):
            engine.evaluate(())
    assert not between.is_to_blame


def test_a_tick_counts_the_messages_of_the_mapping_without_the_clock_and_the_commands():
    twist = {"linear": {"x": 0.5}, "angular": {"z": 0.0}}
    node = saying("/r1/cmd_vel", "geometry_msgs/Twist", *[twist] * 10, to="/r1/pose")
    with engine_with(CODE, mapping(), node) as (engine, bus, _):
        engine.evaluate((TimedFault("f2", 4, 20, (5.0,)),))  # no position of r2 for 5 ticks

    counts = [message["data"][2:] for topic, message in bus.said if topic == "/mission/tick"]
    assert counts == [[6 - (4 <= tick <= 8), min(tick + 1, 10)] for tick in range(T)]


def test_scale_and_offset_are_of_what_the_node_is_told():
    field = {"data": {"of": "energy", "scale": 0.5, "offset": 3.0}}
    rule = {"topic": "/{robot}/volts", "type": "std_msgs/Float64", "fields": field}
    plain = {**rule, "topic": "/{robot}/energy", "fields": {"data": "energy"}}

    _, ticks = flown(mapping(tells=[rule, plain, POSITION]))

    assert [tick["/r2/volts"]["data"] for tick in ticks] == [
        3.0 + 0.5 * tick["/r2/energy"]["data"] for tick in ticks
    ]


def test_elements_of_one_message_are_named():
    fields = {"data[0]": "r1.x", "data[3]": "s4.samples"}
    rule = {"topic": "/all", "type": "std_msgs/Float64MultiArray", "fields": fields}

    _, ticks = flown(mapping(tells=[rule, POSITION]))

    told = ticks[5]["/all"]["data"]
    assert told == [ticks[5]["/r1/pose"]["pose"]["position"]["x"], 0.0, 0.0, told[3]]


def test_a_block_is_silence_and_other_topics_speak():
    _, ticks = flown(mapping(), (TimedFault("f2", 4, 20, (5.0,)),))  # position of r2

    assert [n for n, tick in enumerate(ticks) if "/r2/pose" not in tick] == [4, 5, 6, 7, 8]
    x = [tick["/r2/odom"]["pose"]["pose"]["position"]["x"] for tick in ticks]
    assert x[3] == x[4] == x[8] != x[9]


def test_a_delay_is_silence_until_what_is_late_arrives():
    rule = {"topic": "/{sensor}/n", "type": "std_msgs/Int64", "fields": {"data": "samples"}}
    _, ticks = flown(mapping(tells=[rule, POSITION]), (TimedFault("f8", 4, 12, (3.0,)),))
    _, true = flown(mapping(tells=[rule, POSITION]))

    told = [tick["/s4/n"]["data"] if "/s4/n" in tick else None for tick in ticks]
    counts = [tick["/s4/n"]["data"] for tick in true]
    heard, newest = [], None
    for each in told:
        newest = newest if each is None else each
        heard.append(newest)
    assert heard == [*counts[:4], *[counts[3]] * 3, *counts[4:10], *counts[13:]]


def test_a_falsified_position_is_told_and_judged():
    outcome, ticks = flown(mapping(), (TimedFault("f11", 3, 6, (9000.0, 0.0, 1.0)),))

    x = [tick["/r3/pose"]["pose"]["position"]["x"] for tick in ticks]
    assert [n for n, each in enumerate(x) if each == 9000.0] == [3, 4, 5, 6]
    area = CODE.mission.goal_ids.index("g2")
    assert (outcome.believed[area], outcome.true[area]) == (4, 0)


def test_a_forged_command_beats_what_the_node_says():
    twist = {"linear": {"x": 0.5}, "angular": {"z": 0.0}}
    node = saying("/r1/cmd_vel", "geometry_msgs/Twist", *[twist] * T, to="/r1/pose")
    _, ticks = flown(mapping(), (TimedFault("f26", 5, 9),), node)

    speeds = [tick["/r1/odom"]["twist"]["twist"]["linear"]["x"] for tick in ticks]
    assert speeds[1:] == [0.5] * 4 + [0.0] * 5 + [0.5] * 20


@pytest.mark.parametrize(
    ("fields", "given", "heading"),
    [
        ({"x": "heading_x", "y": "heading_y"}, (0.0, -5.0), (0.0, -1.0)),
        ({"x": "vx", "y": "vy"}, (-0.25, 0.0), (-1.0, 0.0)),
        ({"x": {"of": "yaw", "scale": 180.0 / math.pi}}, (90.0, 0.0), (0.0, 1.0)),
        ({"x": "to_x", "y": "to_y"}, (1e12, -250.0), (1.0, 0.0)),
    ],
)
def test_headings_are_commanded_in_several_ways(fields, given, heading):
    rule = {"topic": "/{robot}/go", "type": "geometry_msgs/Vector3", "fields": fields}
    told = {"topic": "/{robot}/v", "type": "geometry_msgs/Vector3",
            "fields": {"x": "heading_x", "y": "heading_y"}}  # fmt: skip
    node = saying("/r1/go", "geometry_msgs/Vector3", dict(zip("xy", given, strict=True)))

    _, ticks = flown(mapping(tells=[told, POSITION], obeys=[rule]), node=node)

    found = ticks[1]["/r1/v"]
    assert (found["x"], found["y"]) == pytest.approx(heading, abs=1e-6)


def test_a_unit_heading_is_not_touched():
    angle = 0.1
    while math.hypot(math.cos(angle), math.sin(angle)) == 1.0:
        angle += 0.1
    unit = {"x": math.cos(angle), "y": math.sin(angle), "z": 0.0}
    told = {"topic": "/{robot}/v", "type": "geometry_msgs/Vector3",
            "fields": {"x": "heading_x", "y": "heading_y"}}  # fmt: skip
    node = saying("/r1/command/heading", "geometry_msgs/Vector3", unit)

    _, ticks = flown(mapping(tells=[told, POSITION], obeys=GENERATED["obeys"]), node=node)

    assert (ticks[1]["/r1/v"]["x"], ticks[1]["/r1/v"]["y"]) == (unit["x"], unit["y"])


def test_a_silent_node_lets_robots_go_on():
    outcome, _ = flown(mapping())
    functions = CODE.functions._replace(react=lambda _: None)

    assert outcome == ReferenceEngine(replace(CODE, functions=functions), 1).evaluate(())


@pytest.mark.parametrize(
    ("kind", "message", "said"),
    [
        ("geometry_msgs/Twist", {"linear": {"x": math.nan}, "angular": {"z": 0.0}},
         "/r1/cmd_vel carried nan in linear.x; expected a finite number"),
        ("geometry_msgs/Twist", {"linear": {"x": "fast"}, "angular": {"z": 0.0}},
         "/r1/cmd_vel carried 'fast' in linear.x; expected a finite number"),
        ("geometry_msgs/Twist", {"linear": {"x": True}, "angular": {"z": 0.0}},
         "/r1/cmd_vel carried True in linear.x; expected a finite number"),
        ("geometry_msgs/Twist", {"linear": {"x": 1.0}},
         "/r1/cmd_vel carried {'linear': {'x': 1.0}}; expected a field angular.z"),
    ],
)  # fmt: skip
def test_a_command_that_makes_no_sense_ends_the_flight(kind, message, said):
    node = saying("/r1/cmd_vel", kind, message)
    with (
        engine_with(CODE, mapping(), node) as (engine, _, between),
        pytest.raises(TransportError) as raised,
    ):
        engine.evaluate(())

    assert str(raised.value) == f"run 1, tick 0: {said}"
    assert between.is_to_blame


@pytest.mark.parametrize(
    ("numbers", "said"),
    [
        (
            [1, 0],
            r"tick 0: /mission/answer carried \[1, 0\]; expected \[tick, commands\], here \[0,",
        ),
        ([0, "1"], r"tick 0: /mission/answer carried \[0, '1'\]; expected"),
        ([0, 2], r"tick 0: the node was silent for 1 s; expected 2 commands, as ann"),
    ],
)
def test_an_answer_has_to_be_of_the_tick_and_of_its_commands(numbers, said):
    node = saying("/mission/answer", "std_msgs/Int64MultiArray", {"data": numbers})
    with (
        engine_with(CODE, mapping(), node, pace="answer") as (engine, *_),
        pytest.raises(TransportError, match=said),
    ):
        engine.evaluate(())


REMEDIES = (
    "if it answers on another topic, name that topic as answer in [node] of mrsfi.toml; "
    "if it answers on none, set a rate with --node-pace RATE; "
)


@pytest.mark.parametrize(
    ("answer", "topic", "remedies"),
    [({}, "/mission/answer", REMEDIES), ({"answer": DONE}, "/done", "")],
)
def test_of_a_node_that_never_answers_it_is_told_how_it_may(answer, topic, remedies):
    said = f"expected a message on {topic}; {remedies}check that it still runs, or increase "
    unheard = ", ".join(sorted([topic, *(f"/{robot}/cmd_vel" for robot in ("r1", "r2", "r3"))]))
    said += f"--timeout; nothing arrived on {unheard}, the server may have refused the type of"
    with (
        engine_with(CODE, mapping(**answer), silent, pace="answer") as (engine, *_),
        pytest.raises(TransportTimeout, match=re.escape(said)),
    ):
        engine.evaluate(())


def test_any_message_may_answer():
    node = saying("/done", "std_msgs/Empty", *[{}] * T)
    table = mapping(answer=DONE)

    assert flown(table, node=node, pace="answer")[0] == flown(mapping())[0]


def test_commands_of_strangers_are_refused():
    node = saying("/r9/cmd_vel", "geometry_msgs/Twist", {"linear": {"x": 1.0}})
    with (
        engine_with(CODE, mapping(), node) as (engine, *_),
        pytest.raises(
            TransportError, match="commands robot 'r9' on /r9/cmd_vel; the mission has r1"
        ),
    ):
        engine.evaluate(())


def test_faults_of_what_no_topic_tells_are_out_of_reach():
    beyond = out_of_reach(CODE.mission, CODE.pool, Speech(mapping(), CODE.mission, TypeTable()))

    assert beyond["f4"] == "r3 energy"
    assert {"f8", "f9", "f5", "f6"} <= {*beyond}
    assert not {"f1", "f2", "f7", "f25", "f26"} & {*beyond}
    generated = Speech(NodeMapping.of(None), CODE.mission, TypeTable())
    assert len(out_of_reach(CODE.mission, CODE.pool, generated)) == 12


def commanding(goals):
    """Return goals of which the first has a message from the server to robot r1."""
    order = Message("m99", "sv1", "r1", ())
    return (replace(goals[0], messages=(*goals[0].messages, order)), *goals[1:])


@pytest.mark.parametrize(
    ("kind", "values", "passed_on"),
    [
        ("DelayMessage", (3.0,), [*range(5), 5, 6, 7, *range(11, T - 1)]),
        ("BlockMessage", (3.0,), [*range(5), *range(8, T - 1)]),
    ],
)
def test_what_is_no_heading_and_speed_is_passed_on_and_held_back(kind, values, passed_on):
    thrust = {"topic": "/{robot}/thrust", "type": "std_msgs/Int64", "world": "/{robot}/force"}
    template = next(fault for fault in CODE.pool if fault.type == kind)
    fault = replace(template, id="f99", target="m99", values=values)
    mission = replace(CODE.mission, goals=commanding(CODE.mission.goals))
    pool = FaultPool("p", (fault, *CODE.pool.faults))
    felt = []

    class Forced(CODE.simulation):
        def __init__(self, transport, mission):
            super().__init__(transport, mission)
            topic = Topic("/r1/force", "std_msgs/Int64")
            transport.subscribe(topic, lambda message: felt.append(message["data"]))

    code = replace(CODE, mission=mission, pool=pool, simulation=Forced)
    table = mapping(obeys=[TWIST, thrust])
    numbers = [{"data": n} for n in range(T)]
    node = saying("/r1/thrust", "std_msgs/Int64", *numbers, to="/r1/pose")
    speech = Speech(table, mission, TypeTable())

    assert "f99" not in out_of_reach(mission, code.pool, speech)
    assert "f26" in out_of_reach(mission, code.pool, speech)
    with engine_with(code, table, node) as (engine, _, between):
        specification = (TimedFault("f99", 5, 10, values),)
        between.held = [*held_commands(mission, code.pool, specification)]
        engine.evaluate(specification)
    assert felt == passed_on


def commanded(mission):
    """Return a mission whose first message is sent by the server, to r1."""
    goals = [*mission.goals]
    message = replace(goals[0].messages[0], sender="sv1", receiver="r1")
    goals[0] = replace(goals[0], messages=(message, *goals[0].messages[1:]))
    return replace(mission, goals=tuple(goals)), message.id


WINDOW = (2, 9)


@pytest.mark.parametrize(
    ("kind", "ticks", "trigger", "fired", "lost", "late"),
    [
        ("BlockMessage", 3.0, "", -1, [2, 3, 4], {}),
        ("BlockMessage", 3.0, "low", -1, [], {}),
        ("BlockMessage", 3.0, "low", 4, [6, 7, 8], {}),
        ("BlockMessage", 3.0, "low", 0, [2, 3, 4], {}),
        ("BlockMessage", 3.0, "low", 7, [9], {}),
        ("DelayMessage", 2.0, "", -1, [2, 3], {4: 2, 5: 3, 6: 4, 7: 5, 8: 6, 9: 7}),
        ("DelayMessage", 2.0, "low", 4, [6, 7], {8: 6, 9: 7}),
        ("DelayMessage", 0.0, "low", 4, [], {}),
    ],
)
def test_commands_are_held_back_from_when_a_fault_acts_to_when_it_ends(
    kind, ticks, trigger, fired, lost, late
):
    """Without a trigger at the ticks of the window; else from one later than the next tick on."""
    mission, message = commanded(MISSION)
    fault = replace(pool_of()["f2"], kind=FAULT_TYPES[kind], target=message, values=(ticks,))
    triggers = (Trigger("low", Event.VIOLATED, ("g3",), delay=1),)
    pool = replace(pool_of(), faults=(fault,), triggers=triggers)
    specification = (TimedFault("f2", *WINDOW, (ticks,), trigger),)
    laid_out, heard = plan(mission, pool, specification), []
    relay = Relay({"/arm": (0, heard.append)})
    relay.begin([*held_commands(mission, pool, specification)])

    for tick in range(12):
        if trigger and tick == fired:
            laid_out.triggers[0].fired = fired
        relay.take("/arm", tick)
        relay.pass_on(laid_out, tick)

    assert heard == [late.get(tick, tick) for tick in range(12) if tick not in lost]
    assert laid_out.tallies[0].applied == len([*lost, *late])
