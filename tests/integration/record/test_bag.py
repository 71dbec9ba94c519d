"""Bags of flights, read back by rosbags."""

import csv
import json
from dataclasses import replace
from io import BytesIO, StringIO
from itertools import compress, count
from pathlib import Path

import pytest
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.kernel.flight import initial_state, no_verdicts
from mrsfi_runtime.model.faults import robots_of, touched
from mrsfi_runtime.record.observers import Bag, Events, SimulationLog, TraceTable, named_faults
from tests.support import world
from tests.support.bags import bagged, read_bag
from tests.tiers import slow

SEED = 3
SECOND = 10**9
LAYOUT = Path(__file__).parents[3] / "examples" / "bag_layout.json"


@pytest.fixture(scope="module")
def engine():
    with ReferenceEngine(world.paper_code(), SEED) as opened:
        yield opened


@pytest.fixture(scope="module")
def specification(engine):
    return world.specification(engine.code, 1)


@pytest.fixture(scope="module")
def bag(engine, specification, tmp_path_factory):
    path = tmp_path_factory.mktemp("bag") / "flight.mcap"
    path.write_bytes(bagged(engine, specification))
    return path


@pytest.fixture(scope="module")
def told(bag):
    return read_bag(bag)


@pytest.fixture(scope="module")
def rows(engine, specification):
    """The trace of the same flight: a row a tick, texts by column."""
    stream = StringIO()
    engine.evaluate(specification, observer=TraceTable(engine.code.mission, stream))
    return list(csv.DictReader(stream.getvalue().splitlines()))


@slow
def test_every_number_equals_the_trace_at_its_time(engine, told, rows):
    mission = engine.code.mission
    expected = {}
    for robot in mission.robots:
        for side, prefix in (("true", ""), ("believed", "/belief")):
            for name in ("speed", "energy"):
                expected[f"{prefix}/{robot.id}/{name}"] = f"{robot.id}.{name}.{side}"
            for sensor in robot.sensors:
                for topic, name in (("samples", "count"), ("active", "active")):
                    key = f"{prefix}/{robot.id}/{sensor.id}/{topic}"
                    expected[key] = f"{sensor.id}.{name}.{side}"
    for goal in mission.goal_ids:
        for topic, column in (
            ("believed", "violated.believed"),
            ("true", "violated.true"),
            ("missed", "missed.true"),
        ):
            expected[f"/goals/{goal}/{topic}"] = f"{goal}.{column}"

    for topic, column in expected.items():
        found = [(time, float(message.data)) for time, message in told[topic]]
        values = [float(row[column]) for row in rows]
        is_of_changes = topic.endswith(("/active", "/believed", "/true", "/missed"))
        assert found == [
            (tick * SECOND, value)
            for tick, value in enumerate(values)
            if not is_of_changes or tick == 0 or value != values[tick - 1]
        ], topic
    assert any(row["r1.speed.true"] != row["r1.speed.believed"] for row in rows)


def test_every_place_equals_the_trace_at_its_time(engine, told, rows):
    for k, robot in enumerate(engine.code.mission.robots):
        (gps,) = (sensor for sensor in robot.sensors if sensor.type == "GPS_POSITION")
        for side, prefix, frame in (("true", "", ""), ("believed", "/belief", "believed/")):
            names = [f"{robot.id}.{axis}.{side}" for axis in "xy"]
            places = [tuple(float(row[name]) for name in names) for row in rows]
            is_told = [side == "believed" or row[f"{gps.id}.active.true"] == "1" for row in rows]
            said = told[f"{prefix}/{robot.id}/position"]
            assert [(point.x, point.y) for _, point in said] == [*compress(places, is_told)]
            assert [time // SECOND for time, _ in said] == [*compress(count(), is_told)]
            moved = [message.transforms[2 * k + (side == "believed")] for _, message in told["/tf"]]
            assert {each.child_frame_id for each in moved} == {f"{frame}{robot.id}"}
            translations = [each.transform.translation for each in moved]
            assert [(each.x, each.y) for each in translations] == places
            assert [each.header.stamp.sec for each in moved] == [*range(len(rows))]


def test_what_is_true_is_on_the_topics_of_truth_and_clock(engine, told, rows):
    for robot in engine.code.mission.robots:
        names = [f"{robot.id}.{name}" for name in ("x", "y", "speed", "energy")]
        names += [f"{sensor.id}.{name}" for sensor in robot.sensors for name in ("count", "active")]
        values = [message.data.tolist() for _, message in told[f"/truth/{robot.id}"]]
        assert [[*each[:2], *each[3:]] for each in values] == [
            [float(row[f"{name}.true"]) for name in names] for row in rows
        ]
    ticks = [(time, message.clock.sec) for time, message in told["/clock"]]
    assert ticks == [(tick * SECOND, tick) for tick in range(len(rows))]


def test_commands_are_told_when_they_change(engine, specification, told):
    commanded = []
    engine.evaluate(
        specification,
        observer=lambda state, *_: commanded.append(
            [(each.heading_x, each.heading_y, each.speed) for each in state.commands]
        ),
    )
    for k, robot in enumerate(engine.code.mission.robots):
        for name, values in (
            ("heading", [each[k][:2] for each in commanded]),
            ("speed", [each[k][2] for each in commanded]),
        ):
            expected = [
                (tick * SECOND, value)
                for tick, value in enumerate(values)
                if tick == 0 or value != values[tick - 1]
            ]
            found = [
                (time, (said.x, said.y) if name == "heading" else said.data)
                for time, said in told[f"/{robot.id}/command/{name}"]
            ]
            assert found == expected
            assert len(found) > 1


def test_nothing_else_is_told_and_nothing_is_left_out(engine, told):
    mission = engine.code.mission
    n_sensors = len(mission.sensors)
    of_robots, of_sensors = len(mission.robots) * (4 + 3 + 2), n_sensors * (2 + 2 + 1)
    others = {"/clock", "/rosout", "/tf", "/mission_map", "/markers"}

    assert len(told) == of_robots + of_sensors + 3 * len(mission.goals) + len(others)
    assert others < {*told}


def test_events_are_those_of_the_log(engine, specification, told):
    mission, stream, tallies = engine.code.mission, StringIO(), []
    faults = named_faults(mission, engine.code.pool, specification)
    log = SimulationLog(mission, stream, Events(mission, faults, tallies))
    engine.evaluate(specification, observer=log, tallies=tallies)
    expected, tick = [], 0
    for line in stream.getvalue().splitlines():
        if line.startswith("tick "):
            tick = int(line.removeprefix("tick "))
        elif line.startswith("  event "):
            expected.append((tick * SECOND, line.removeprefix("  event ")))

    assert [(time, message.msg) for time, message in told["/rosout"]] == expected
    levels = {message.name: message.level for _, message in told["/rosout"]}
    assert levels == {"command": 10, "fault": 30, "collision": 40, "verdict": 40}


@pytest.mark.parametrize("tick", [0, 500, 999])
def test_markers_are_where_the_robots_are(engine, specification, told, rows, tick):
    mission, pool = engine.code.mission, engine.code.pool
    time, message = told["/markers"][tick]
    first, *drawn = message.markers
    of = {}
    for marker in drawn:
        of.setdefault(marker.ns, []).append(marker)
    struck = {
        robot
        for fault in named_faults(mission, pool, specification)
        if fault.window and fault.window[0] <= tick <= fault.window[1]
        for robot in robots_of(mission, touched(mission, fault.fault))
    }

    assert (time, first.action) == (tick * SECOND, 3)  # all of before are deleted
    assert len({(marker.ns, marker.id) for marker in drawn}) == len(drawn)
    assert {marker.header.frame_id for marker in drawn} == {"map"}
    places = [
        [
            tuple(float(rows[tick][f"{robot.id}.{axis}.{side}"]) for axis in "xy")
            for robot in mission.robots
        ]
        for side in ("true", "believed")
    ]
    for namespace, spots in zip(("robots", "believed robots"), places, strict=True):
        (spheres,) = of[namespace]
        assert [(spot.x, spot.y) for spot in spheres.points] == spots
        assert (spheres.type, spheres.scale.x, spheres.scale.y) == (7, 2.0, 2.0)
    assert {k for k, colour in enumerate(of["robots"][0].colors) if colour.r > 0.5} == struck
    ends = [spot for pair in zip(*places, strict=True) if pair[0] != pair[1] for spot in pair]
    assert [(spot.x, spot.y) for m in of.get("errors", []) for spot in m.points] == ends


def test_robots_are_struck_and_believed_elsewhere_at_some_ticks(told):
    robots = [said.markers[1] for _, said in told["/markers"]]

    assert {robot.ns for robot in robots} == {"robots"}
    assert any(colour.r > 0.5 for robot in robots for colour in robot.colors)
    assert any("errors" in [m.ns for m in said.markers] for _, said in told["/markers"])


def test_a_misplaced_obstacle_is_drawn_where_it_is_believed_to_be(engine, tmp_path):
    mission = engine.code.mission
    truth, belief, stream = initial_state(mission, SEED), initial_state(mission, SEED), BytesIO()
    belief.obstacles[1].x += 5.0
    bag = Bag(mission, stream, (), Events(mission, (), ()))
    bag(truth, belief, no_verdicts(len(mission.goals)))
    bag.finish()
    (tmp_path / "b.mcap").write_bytes(stream.getvalue())
    ((_, message),) = read_bag(tmp_path / "b.mcap")["/markers"]
    disc, name = (m for m in message.markers if m.ns.startswith("believed obstacles"))

    assert disc.pose.position.x == truth.obstacles[1].x + 5.0
    assert name.text == mission.obstacles[1].id


def test_the_map_is_told_once(engine, told):
    mission = engine.code.mission
    ((time, message),) = told["/mission_map"]
    discs = [
        (m.ns, m.pose.position.x, m.pose.position.y, m.scale.x / 2)
        for m in message.markers
        if m.type == 3
    ]
    area = mission.area

    names = {m.header.frame_id: m.text for m in message.markers if m.frame_locked}
    assert time == 0
    assert names == {robot.id: robot.id for robot in mission.robots}
    assert discs == [
        ("mission area", area.center.x, area.center.y, area.radius),
        *(
            ("goals", each.area.center.x, each.area.center.y, each.area.radius)
            for each in mission.goal_discs
        ),
        *(
            ("obstacles", each.area.center.x, each.area.center.y, each.area.radius)
            for each in mission.obstacles
        ),
    ]
    assert all(m.lifetime.sec == m.lifetime.nanosec == 0 for m in message.markers)


def test_definitions_are_those_of_ros_2(bag):
    published = get_typestore(Stores.ROS2_HUMBLE)
    with AnyReader([bag]) as reader:
        for connection in reader.connections:
            found = get_types_from_msg(connection.msgdef.data, connection.msgtype)
            assert found == {name: published.fielddefs[name] for name in found}
            assert connection.ext.serialization_format == "cdr"


@slow
def test_the_same_flight_gives_the_same_bytes(engine, specification, bag):
    assert bagged(engine, specification) == bag.read_bytes()


def test_ids_become_names_that_ros_allows(tmp_path):
    mission = world.mission()
    first, *others = mission.robots
    renamed = replace(mission, robots=(replace(first, id="Scout-1.a b"), *others))
    truth, stream = initial_state(mission, SEED), BytesIO()
    bag = Bag(renamed, stream, (), Events(renamed, (), ()))
    bag(truth, truth, no_verdicts(len(mission.goals)))
    bag.finish()
    (tmp_path / "b.mcap").write_bytes(stream.getvalue())
    told = read_bag(tmp_path / "b.mcap")

    assert "/scout_1_a_b/position" in told
    ((_, message),) = told["/mission_map"]
    assert {marker.text: marker.header.frame_id for marker in message.markers}["Scout-1.a b"] == (
        "scout_1_a_b"
    )


def test_the_layout_shows_topics_that_are_there(told):
    text = LAYOUT.read_text(encoding="utf-8")
    panels = json.loads(text)["configById"]
    topics = {topic for panel in panels.values() for topic in panel.get("topics", {})}
    paths = [path["value"] for panel in panels.values() for path in panel.get("paths", ())]
    plotted = {path.rpartition(".")[0] for path in paths}

    assert topics == {"/mission_map", "/markers"}
    assert plotted
    assert topics | plotted < {*told}
