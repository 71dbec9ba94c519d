"""The table [node]: what makes no sense in it is said with its place, and what was expected."""

import re
import tomllib

import pytest

from mrsfi_bridge.settings import TypeTable
from mrsfi_runtime.cosimulation.node_mapping import NodeMapping
from mrsfi_runtime.cosimulation.node_speech import Speech
from mrsfi_runtime.errors import UsageError
from tests.support.tree import ROOT
from tests.support.world import paper_code

MISSION = paper_code().mission
TELLS = {"topic": "/{robot}/x", "type": "std_msgs/Float64", "fields": {"data": "x"}}
OBEYS = {"topic": "/{robot}/go", "type": "geometry_msgs/Vector3", "fields": {"x": "speed"}}


def tells(**other):
    """Return a table whose first rule of what is told is another."""
    return {"tells": [{**TELLS, **other}], "obeys": [OBEYS]}


def obeys(**other):
    """Return a table whose first rule of what is obeyed is another."""
    return {"tells": [TELLS], "obeys": [{**OBEYS, **other}]}


FIRST = "[node]: [[node.tells]] 1: "


@pytest.mark.parametrize(
    ("table", "said"),
    [
        (
            {"tels": []},
            (
                "[node]: found 'tels'; expected one of tells, obeys, answer, reset, names, types, "
                "frame_id, clock_hz; did you mean 'tells'?"
            ),
        ),
        ({"tells": [TELLS]}, "[node]: found no [[node.obeys]]; expected at least one topic"),
        (
            tells(topik="x"),
            FIRST + "found 'topik'; expected one of topic, type, fields, world, qos; "
            "did you mean 'topic'?",
        ),
        (tells(type="Float64"), FIRST + "'Float64' is not a type name; expected 'package/Type'"),
        (tells(topic=""), FIRST + "found topic = ''; expected a text"),
        (tells(fields={}), FIRST + "found fields = {}; expected { field = 'name' }"),
        (
            tells(fields={"a..b": "x"}),
            FIRST + "found field 'a..b'; expected a path such as data[0].x",
        ),
        (tells(fields={"data": 3}), FIRST + "data: found 3; expected a name or { of = … }"),
        (
            tells(fields={"data": {"of": "x", "scale": "2"}}),
            FIRST + "data: found scale = '2'; expected of, scale and offset (numbers), or value",
        ),
        (
            tells(fields={"data": {"of": "x", "scale": 0}}),
            FIRST + "data: found scale = 0; expected any other number",
        ),
        (
            tells(fields={"data": "r1.x"}),
            FIRST + "found 'r1.x'; expected a name without an element",
        ),
        (tells(topic="/x"), FIRST + "found 'x'; expected ELEMENT.NAME, such as r1.x"),
        (
            tells(topic="/{rob}/x"),
            FIRST + "found {rob} in its topic; expected one of robot, sensor, obstacle; "
            "did you mean 'robot'?",
        ),
        (
            tells(fields={"data": "sped"}),
            FIRST + "found 'sped'; expected one of x, y, z, speed, vx, "
            "vy, energy, heading_x, heading_y, yaw, qz, qw, sent, radius; did you mean 'speed'?",
        ),
        (
            obeys(fields={"x": "vx"}),
            "[node]: [[node.obeys]] 1: found 'vx' alone; expected vx and vy",
        ),
        (
            obeys(world="/w", fields={"x": "speed"}),
            (
                "[node]: [[node.obeys]] 1: found world = '/w'; expected a topic with {robot} "
                "and no fields: its messages are passed on unchanged"
            ),
        ),
        (
            {**tells(), "answer": "/done"},
            "[node]: answer: found '/done'; expected { topic = …, type = … }",
        ),
        (tells(qos=3), FIRST + "found qos = 3; expected { depth = 10 }"),
        (
            tells(qos={"history": 1}),
            FIRST + "qos: found 'history'; expected one of reliability, durability, depth",
        ),
        (
            tells(qos={"reliability": "best"}),
            FIRST + "reliability: found 'best'; expected one of reliable, best_effort",
        ),
        (tells(qos={"depth": 0}), FIRST + "depth: found 0; expected a number of messages"),
        ({**tells(), "clock_hz": 0}, "[node]: clock_hz: found 0; expected an integer, 1 to 1000"),
        ({**tells(), "frame_id": 1}, "[node]: found frame_id = 1; expected a text"),
        (
            {**tells(), "names": {"r1": 1}},
            "[node]: names: found {'r1': 1}; expected { r1 = 'husky1' }",
        ),
    ],
)
def test_a_table_that_makes_no_sense_is_refused(table, said):
    with pytest.raises(UsageError) as raised:
        NodeMapping.of(table)

    assert str(raised.value) == said


@pytest.mark.parametrize(
    ("table", "said"),
    [
        (
            tells(fields={"dat": "x"}),
            (
                "[node] /{robot}/x: std_msgs/Float64: found field 'dat'; "
                "expected one of data; did you mean 'data'?"
            ),
        ),
        (
            tells(fields={"data.x": "x"}),
            (
                "[node] /{robot}/x: std_msgs/Float64: found field 'data.x'; "
                "expected one of (there is none)"
            ),
        ),
        (
            tells(type="std_msgs/Nothing"),
            (
                "[node] /{robot}/x: unknown message type "
                "'std_msgs/Nothing'; add std_msgs/msg/Nothing.msg to a folder of --types"
            ),
        ),
        (
            tells(type="nav_msgs/Odometry", fields={"pose.pose": "x"}),
            (
                "[node] /{robot}/x: nav_msgs/Odometry: found 'pose.pose', a geometry_msgs/Pose; "
                "expected one of its fields: position, orientation"
            ),
        ),
        (
            tells(type="std_msgs/Float64MultiArray"),
            ("[node] /{robot}/x: std_msgs/Float64MultiArray: found 'data'; expected data[0]"),
        ),
        (
            tells(topic="/x", fields={"data": "r7.x"}),
            (
                "[node] /x: found 'r7.x'; expected one of r1, "
                "r2, r3, s1, s2, s3, s4, s5, s6, o1, o2, o3, o4, o5, o6, o7, o8"
            ),
        ),
        (
            tells(topic="/x", fields={"data": "s1.x"}),
            ("[node] /x: found 's1.x'; expected one of samples, active, rate, cost"),
        ),
        (
            {**tells(), "names": {"r9": "a"}},
            (
                "[node] names: found 'r9'; expected one of r1, r2, r3, "
                "s1, s2, s3, s4, s5, s6, o1, o2, o3, o4, o5, o6, o7, o8"
            ),
        ),
    ],
)
def test_a_table_that_does_not_fit_mission_or_types_is_refused(table, said):
    with pytest.raises(UsageError) as raised:
        Speech(NodeMapping.of(table), MISSION, TypeTable())

    assert str(raised.value) == said


def test_topics_bear_the_names_of_the_node():
    table = {**tells(topic="/{robot}/{sensor}/n", fields={"data": "samples"}),
             "names": {"r1": "husky", "s1": "lidar"}}  # fmt: skip

    names = [
        each.topic.name for each in Speech(NodeMapping.of(table), MISSION, TypeTable()).sayings
    ]

    assert names[:3] == ["/husky/lidar/n", "/husky/s2/n", "/r2/s3/n"]


def test_the_table_that_the_page_shows_is_sound():
    page = (ROOT / "docs" / "node.md").read_text(encoding="utf-8")
    (shown,) = re.findall(r"^```toml\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    table = tomllib.loads(shown)["node"]

    speech = Speech(NodeMapping.of({**table, "types": []}), MISSION, TypeTable())

    assert [each.topic.name for each in speech.sayings][::3] == ["/husky1/odom", "/husky1/battery"]
