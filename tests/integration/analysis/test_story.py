"""Flights told as figures and tables: in time, and in space."""

import re
from dataclasses import replace
from io import StringIO
from itertools import combinations

import numpy as np
import pytest
from matplotlib.patches import Polygon

from mrsfi_runtime.analysis.plots import flight_map, flight_timeline, mission_map
from mrsfi_runtime.analysis.story import (
    Collision,
    Flown,
    collisions,
    flight_content,
    mission_content,
    places_table,
    story_of,
    timeline_table,
)
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.kernel.goal_tasks.track import Track
from mrsfi_runtime.model.faults import Event, TimedFault, Trigger, numbered
from mrsfi_runtime.model.mission import Area, Coordinates, polygon
from mrsfi_runtime.record.observers import Events, SimulationLog, named_faults
from tests.support.drawing import require_inside, save, texts
from tests.support.search import paper_mission
from tests.support.world import cornered, paper_code, specification
from tests.tiers import slow

SEED = 2


@pytest.fixture(scope="module")
def flown():
    """Code, faults and recording of a flight under twelve faults."""
    code = paper_code(400)
    chosen = specification(code, 3, 12)
    names = numbered(timed.fault for timed in chosen)
    faults = named_faults(code.mission, code.pool, chosen, names)
    return code, faults, ReferenceEngine(code, SEED).record(chosen)


@pytest.fixture(scope="module")
def story(flown):
    code, faults, recording = flown
    return story_of("What happened", code.mission, faults, recording)


def test_the_timeline_has_the_windows_of_faults_and_verdicts(flown, story):
    code, faults, recording = flown
    header, *rows = timeline_table(story).lines

    assert header == ("kind", "name", "what", "first", "last")
    assert [(row[1], row[3:]) for row in rows if row[0] == "fault"] == [
        (fault.name, fault.window) for fault in faults if fault.window
    ]
    for k, goal in enumerate(code.mission.goal_ids):
        for what, flags in (
            ("violated in belief", recording["is_believed"]),
            ("truly violated", recording["is_true"]),
            ("failed", recording["missed"]),
        ):
            windows = [row[3:] for row in rows if row[1:3] == (goal, what)]
            ticks = [tick for first, last in windows for tick in range(first, last + 1)]
            assert ticks == np.flatnonzero(flags[:, k]).tolist()
            assert len(windows) < 2 or what != "failed"
    assert {row[2] for row in rows} > {"violated in belief", "truly violated"}


def test_places_are_those_of_the_flight(flown, story):
    code, _, recording = flown
    header, *rows = places_table(story).lines
    robots = code.mission.robots

    assert header == ("tick", "robot", "x", "y", "believed_x", "believed_y")
    assert [row[:2] for row in rows] == [(k, robot.id) for k in range(400) for robot in robots]
    for place, (side, axis) in enumerate((s, a) for s in ("world", "belief") for a in "xy"):
        found = np.array([row[2 + place] for row in rows]).reshape(400, len(robots))
        assert (found == recording[side]["robots"][axis]).all()


def test_discs_collide_and_are_drawn_by_their_radii():
    mission = paper_mission()
    sizes = zip(mission.robots, (3.0, 0.5, 1.0), strict=True)
    robots = tuple(replace(robot, radius=radius) for robot, radius in sizes)
    mission = replace(mission, robots=robots, obstacles=mission.obstacles[:1])
    rock = mission.obstacles[0].area
    true = np.full((5, 3, 2), -900.0)
    true[:, 1:, 0] = -903.6, 900.0
    true[0, 1, 0] = -903.4  # apart by 3.4, then by 3.6
    true[1, 2] = rock.center.x + rock.radius + 0.9, rock.center.y
    true[2, 0] = rock.center.x, rock.center.y + rock.radius + 2.9

    found = [(each.names, each.window) for each in collisions(mission, true)]
    circles = {(each.center, each.radius) for each in mission_map(mission).axes[0].patches}

    # the way away from a collision begins with it
    assert found == [("r1 and o1", (2, 3)), ("r2 and r1", (0, 1)), ("r3 and o1", (1, 2))]
    assert [each["radius"] for each in mission_content(mission)["robots"]] == [3.0, 0.5, 1.0]
    assert circles >= {((each.position.x, each.position.y), each.radius) for each in robots}


def test_a_long_flight_lists_each_so_many_th_tick(story):
    mission = replace(story.mission, duration=20_000)
    long = [np.zeros((20_000, 3, 2)) for _ in range(2)]
    longer = replace(story, mission=mission, true=long[0], believed=long[1])
    rows = [*places_table(longer).rows]

    assert [row[0] for row in rows[::3]] == [*range(0, 20_000, 3)]


def test_the_map_draws_true_paths_and_what_is_believed_instead(story, tmp_path):
    figure = flight_map(story)
    lines = [line.get_xydata() for line in figure.axes[0].lines]
    clouds = [np.asarray(each.get_offsets()) for each in figure.axes[0].collections]
    wrong = (story.true != story.believed).any(axis=-1)
    _, svg = save(figure, tmp_path / "map")

    for k, robot in enumerate(story.mission.robots):
        assert any(np.array_equal(line, story.true[:, k]) for line in lines)
        assert any(np.array_equal(each, story.believed[wrong[:, k], k]) for each in clouds)
        assert f"{robot.id}, true" in texts(svg)
    assert {"What happened", "believed, if wrong", "start", "end"} < {*texts(svg)}
    require_inside(figure)
    assert wrong.any()


def test_the_map_counts_what_is_believed_outside_of_it(story, tmp_path):
    far = story.true.copy()
    far[10:15, 1] = 1e6
    _, svg = save(flight_map(replace(story, believed=far)), tmp_path / "far")
    _, same = save(flight_map(replace(story, believed=story.true)), tmp_path / "same")

    assert "believed outside the figure: 5 robot-ticks" in texts(svg)
    assert not [text for text in texts(same) if "outside" in text]


def test_the_timeline_names_faults_and_goals(story, tmp_path):
    figure = flight_timeline(story)
    _, svg = save(figure, tmp_path / "timeline")

    assert {f"{fault.name} {fault.fault.type}" for fault in story.faults if fault.window} < {
        *texts(svg)
    }
    assert {*story.mission.goal_ids, "violated in belief", "violated in truth"} < {*texts(svg)}
    require_inside(figure)


def test_a_fault_that_waited_is_drawn_lightly_where_it_may_act_and_fully_where_it_did(tmp_path):
    code = paper_code(100)
    area = Area("e", Coordinates(), 1e9)
    triggers = (
        Trigger("begun", Event.ENTERED, ("r1",), area, 9, 20),
        Trigger("never", Event.ENTERED, ("r1",), area, 200),
    )
    pool = replace(code.pool, triggers=triggers)
    chosen = (
        TimedFault("f26", 5, 90, (), "begun"),
        TimedFault("f30", 5, 90, (), "never"),
        TimedFault("f1", 5, 90),
    )
    faults = named_faults(code.mission, pool, chosen)
    recording = ReferenceEngine(replace(code, pool=pool), SEED).record(chosen)

    story = story_of("", code.mission, faults, recording)
    figure = flight_timeline(story)
    _, svg = save(figure, tmp_path / "timeline")
    content = flight_content(code.mission, Flown("", faults, recording, {}), 1)["faults"]

    assert [fault.window for fault in story.faults] == [(10, 29), None, (5, 90)]
    assert [row[1:] for row in timeline_table(story).rows if row[0] == "fault"] == [
        ("f26", "StopRobot on r1 motion", 10, 29),
        ("f1", "ActivateSensor on s2 activation", 5, 90),
    ]
    drawn = [(bar.get_x(), bar.get_width(), bar.get_alpha()) for bar in figure.axes[0].patches]
    assert drawn == [(5, 86, 0.15), (10, 20, 0.75), (5, 86, 0.15), (5, 86, 0.75)]
    assert "may be triggered" in texts(svg)
    assert [each["window"] for each in content] == [(10, 29), None, (5, 90)]
    assert [each.get("waits") for each in content] == [(5, 90), (5, 90), None]


def crowded(n):
    """Return the paper's mission with goals at one place, and a trajectory through it."""
    mission = paper_mission()
    sampling = mission.goals[3]
    path = (Coordinates(-250, 250), Coordinates(0, 0), Coordinates(300, 100))
    track = replace(sampling, id="g8", name="Round", task=Track(path, 5.0))
    others = [replace(sampling, id=f"g{10 + k}", name="GatherSamples") for k in range(n)]
    return replace(mission, goals=(*mission.goals, *others, track))


def test_polygons_are_drawn_with_their_corners():
    mission = paper_mission()
    corners = ((-300.0, 200.0), (-200.0, 200.0), (-250.0, 220.0), (-250.0, 300.0))
    area = polygon("shore", tuple(Coordinates(*each) for each in corners))
    sampling = replace(mission.goals[3], area=area)
    rock = replace(mission.obstacles[0], area=polygon("pier", area.corners, Coordinates(-250, 210)))
    mission = replace(mission, goals=(sampling,), obstacles=(rock,))

    figure, content = mission_map(mission), mission_content(mission)

    drawn = [each for each in figure.axes[0].patches if isinstance(each, Polygon)]
    assert [each.get_xy().tolist() for each in drawn] == [[*map(list, (*corners, corners[0]))]] * 3
    (disc,), (obstacle,) = content["discs"], content["obstacles"]
    assert [(disc["x"] + x, disc["y"] + y) for x, y in disc["corners"]] == [*corners]
    assert obstacle["corners"] == ((-50, -10), (50, -10), (0, 10), (0, 90))
    assert "corners" not in mission_content(paper_mission())["obstacles"][0]


def test_labels_on_one_another_are_parted():
    figure = mission_map(crowded(3))
    axes = figure.axes[0]
    boxes = [text.get_window_extent() for text in axes.texts]

    assert len(boxes) == 3 + 3 + 1 + 8 + 3
    assert not [1 for one, other in combinations(boxes, 2) if one.overlaps(other)]


def test_a_map_of_very_many_robots_has_no_labels_and_a_few_of_them_in_its_key(tmp_path):
    mission = paper_mission()
    robots = tuple(replace(mission.robots[0], id=f"q{k}", name=f"robot {k}") for k in range(200))

    figure = mission_map(replace(mission, robots=robots))
    _, svg = save(figure, tmp_path / "map")

    assert [*figure.axes[0].texts] == []
    assert len(figure.axes[0].collections[0].get_offsets()) == 200
    named = {each for each in texts(svg) if each.startswith("start")}
    assert named == {f"start of robot {k} (q{k})" for k in range(12)} | {
        "starts of 200 robots in all"
    }


def test_trajectories_are_drawn(tmp_path):
    figure = mission_map(crowded(0))
    _, svg = save(figure, tmp_path / "map")

    paths = [line.get_xydata().tolist() for line in figure.axes[0].lines]
    assert [[-250, 250], [0, 0], [300, 100]] in paths
    assert {"g8 Round", "trajectory or route of a goal"} < {*texts(svg)}


@slow
@pytest.mark.parametrize("shaped", [replace, cornered])
def test_collisions_are_those_of_the_log(shaped):
    code, met = paper_code(), 0
    code = replace(code, mission=shaped(code.mission))
    engine = ReferenceEngine(code, 3)
    for drawn in (1, 2):
        chosen, stream = specification(code, drawn), StringIO()
        log = SimulationLog(code.mission, stream, Events(code.mission, (), ()))
        engine.evaluate(chosen, observer=log)
        told, tick = [], 0
        for line in stream.getvalue().splitlines():
            tick = int(line[5:]) if line.startswith("tick ") else tick
            if found := re.match(r"  event collision of (\S+) and (\S+): (\w+)", line):
                told.append(({found[1], found[2]}, found[3] == "no", tick))
        story = story_of("", code.mission, (), engine.record(chosen, 3))

        ended = [each for each in story.collisions if each.window[1] + 1 < code.mission.duration]
        begun = [each for each in story.collisions if each.window[0] > 0]
        assert sorted(tick for _, was, tick in told if was) == sorted(e.window[0] for e in begun)
        assert sorted(tick for _, was, tick in told if not was) == sorted(
            each.window[1] + 1 for each in ended
        )
        assert all(({*e.names.split(" and ")}, True, e.window[0]) in told for e in begun)
        met += len(begun)
    assert met > 0


def test_a_collision_is_marked_where_it_begins(story, tmp_path):
    met = replace(story, collisions=[Collision("r1 and o3", 0, (7, 9))])
    figure = flight_map(met)
    _, svg = save(figure, tmp_path / "met")
    *_, crosses = figure.axes[0].collections

    assert crosses.get_offsets().tolist() == [story.true[7, 0].tolist()]
    assert "collision" in texts(svg)
    assert [*timeline_table(met).rows][-1] == ("collision", "r1 and o3", "truly", 7, 9)
