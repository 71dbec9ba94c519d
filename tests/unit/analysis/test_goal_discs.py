from dataclasses import replace

from mrsfi_runtime.analysis.story import working_window
from mrsfi_runtime.api import Patrol, Stay, Visit
from mrsfi_runtime.model.mission import Coordinates, Goal
from tests.support.campaigns import area
from tests.support.search import paper_mission


def test_only_areas_that_a_task_reads_are_places():
    waters = paper_mission()
    unread = replace(waters.goals[0], area=area("a9", 600, -200, 4))
    waters = replace(waters, goals=(unread, *waters.goals[1:]))

    assert [(p.goal.id, p.x, p.y, p.radius) for p in waters.goal_discs] == [
        ("g4", -250, 250, 150),
        ("g5", 250, 250, 150),
        ("g6", 250, -250, 150),
    ]


def test_areas_and_points_of_other_tasks_are_places_too():
    goals = (
        Goal("g1", "Patrol", ("r1",), Patrol(area("a1", 1, 2, 3), 10)),
        Goal("g2", "Stay", ("r1",), Stay(area("a2", 4, 5, 6))),
        Goal("g3", "Visit", ("r1",), Visit(Coordinates(7, 8), 9, 10)),
    )

    places = replace(paper_mission(), goals=goals).goal_discs

    assert [(p.x, p.y, p.radius) for p in places] == [(1, 2, 3), (4, 5, 6), (7, 8, 9)]


def test_the_window_holds_every_start_obstacle_and_goal_area():
    x, y, half = working_window(paper_mission())

    assert x - half < -545 < 545 < x + half
    assert y - half < -530 < 550 < y + half
    assert half < 700


def test_a_mission_at_one_point_still_has_a_window():
    waters = replace(
        paper_mission(),
        obstacles=(),
        goals=paper_mission().goals[:1],
        robots=paper_mission().robots[:1],
    )

    assert working_window(waters) == (250, -250, 20.0)
