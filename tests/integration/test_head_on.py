"""Two robots that fly head-on at a speed at which a tick takes them past each other."""

from dataclasses import replace

from generated.metamodel import mission as m
from m2t.generate import generate
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.mission import Coordinates
from tests.support.models.builder import area, fault, goal, point, pool, robot, write

SPEED = 8.0
N_FLIGHTS = 80


def code(folder, *, evades):
    """Return the code of a mission whose robots change places, and evade first or last."""
    one, other = (robot(name, point(0.0, 0.0), SPEED, 1e6, 1.0) for name in "ab")
    visits = [
        goal(
            f"visit_{each.ID}",
            m.Visit(tolerance=1.0, deadline=99, coordinates=point(way, 0.0)),
            [each],
        )
        for way, each in ((200.0, one), (-200.0, other))
    ]
    clear = goal("clear", m.AvoidCollision(robots=[one, other]), [one, other])
    mission = m.Mission(
        name="head_on",
        duration=100,
        missionArea=area("whole", 400.0, point(0.0, 0.0)),
        robots=[one, other],
        servers=[m.Server(ID="base", name="")],
        goals=[clear, *visits] if evades else [*visits, clear],
    )
    write(folder / "models", mission, pool([fault("f", "StopRobot", one)]))
    generate(folder / "models", folder / "generated")
    return load_code(folder / "generated")


def flights(code):
    """Fly from 80 places, sideways by up to 2 of each other, and return what became of clear."""
    number = [each.id for each in code.mission.goals].index("clear")
    for n in range(N_FLIGHTS):
        places = Coordinates(-200.0), Coordinates(200.0 + 1.7 * (n % 8), 0.45 * (n // 8) - 2.0)
        robots = zip(code.mission.robots, places, strict=True)
        moved = tuple(replace(each, position=place) for each, place in robots)
        there = replace(code, mission=replace(code.mission, robots=moved))
        outcome = ReferenceEngine(there, n).evaluate(())
        yield outcome.true[number], outcome.margins[number]


def test_who_does_not_evade_collides_between_two_ticks(tmp_path):
    found = [(true, margin) for true, margin in flights(code(tmp_path, evades=False)) if true > 0]

    assert len(found) > N_FLIGHTS / 4
    assert all(margin[0] < 0.0 for _, margin in found)


def test_who_evades_first_never_collides(tmp_path):
    assert [true for true, _ in flights(code(tmp_path, evades=True)) if true > 0] == []
