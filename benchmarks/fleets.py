"""Missions for as many robots as wanted, at the same density, with generated code."""

from collections.abc import Iterator
from math import ceil, sqrt
from pathlib import Path

from m2t.generate import generate
from mrsfi_runtime.generated_code import MissionCode, load_code

_SPACING = 60.0  # between neighbours at the start
_ROBOTS_PER_OBSTACLE = 4
_MOST_FAULTS = 30

_HEAD = (
    '<?xml version="1.0" encoding="ASCII"?>\n<{package}:{root} xmi:version="2.0" '
    'xmlns:xmi="http://www.omg.org/XMI" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" '
    'xmlns:{package}="http://mrsfi.org/{package}/1.0" {attributes}>\n'
)


def fleet(folder: Path, n_robots: int, duration: int) -> MissionCode:
    """Return the code of a fleet, with faults of its first robots.

    The share of robots with a fault falls as the fleet grows.
    """
    write_fleet(folder / "fleet", n_robots, duration, min(n_robots, _MOST_FAULTS))
    generate(folder / "fleet", folder / "generated")
    return load_code(folder / "generated")


def write_fleet(models: Path, n_robots: int, duration: int, n_faults: int) -> None:
    """Write models of a mission in which robots keep apart, inside, and within their energy.

    The pool delays the positions of robots by a tick, which changes little of what a robot does.
    """
    models.mkdir(parents=True)
    mission, faults = _mission(n_robots, duration), _faults(n_robots, n_faults)
    (models / "mission.xmi").write_text("".join(mission), encoding="ascii")
    (models / "faults.xmi").write_text("".join(faults), encoding="ascii")


def _mission(n_robots: int, duration: int) -> Iterator[str]:
    side = ceil(sqrt(n_robots))
    obstacles = range(n_robots // _ROBOTS_PER_OBSTACLE)
    attributes = f'name="fleet" duration="{duration}"'
    yield _HEAD.format(package="mission", root="Mission", attributes=attributes)
    yield f'  <missionArea ID="whole" radius="{_SPACING * (side + 1)}"/>\n'
    for n in range(n_robots):
        x, y = (_SPACING * (place - side / 2) for place in (n % side, n // side))
        yield (
            f'  <robots ID="r{n}" name="robot {n}" speed="2.0">\n'
            f'    <position x="{x}" y="{y}"/>\n'
            f'    <sensors ID="s{n}" name="GPS" type="GPS_POSITION" energyPerSample="0.1" '
            'samplesPerSecond="1"/>\n'
            f'    <batteries ID="b{n}" name="battery" totalEnergy="{9.0 * duration}"/>\n'
            f'    <motionSources ID="d{n}" name="motor" energyPerDistanceUnit="1.0"/>\n'
            "  </robots>\n"
        )
    yield '  <servers ID="base" name="base"/>\n'
    for k in obstacles:
        n = k * _ROBOTS_PER_OBSTACLE
        x, y = (_SPACING * (place - side / 2 + 0.5) for place in (n % side, n // side))
        yield (
            f'  <obstacles ID="o{k}"><area ID="a{k}" radius="5.0"><center x="{x}" y="{y}"/>'
            "</area></obstacles>\n"
        )
    robots = " ".join(f"r{n}" for n in range(n_robots))
    around = " ".join(f"o{k}" for k in obstacles)
    around = f' obstacles="{around}"' if around else ""
    tasks = ("StayWithinMissionArea", "SufficientEnergy")
    yield from _goal("g1", robots, f'AvoidCollision" robots="{robots}"{around}', n_robots)
    for number, task in enumerate(tasks, 2):
        yield from _goal(f"g{number}", robots, f'{task}"', 0)
    yield "</mission:Mission>\n"


def _goal(identifier: str, robots: str, task: str, n_messages: int) -> Iterator[str]:
    yield f'  <goals ID="{identifier}" name="{identifier}" members="{robots}">\n'
    yield f'    <task xsi:type="mission:{task}/>\n'
    for n in range(n_messages):
        yield (
            f'    <messages ID="m{n}" sender="r{n}" receiver="base">'
            '<body name="POSITION" type="Coordinates"/></messages>\n'
        )
    yield "  </goals>\n"


def _faults(n_robots: int, n_faults: int) -> Iterator[str]:
    yield _HEAD.format(package="faults", root="FaultSpecification", attributes='ID="pool"')
    for n in range(n_faults):
        yield (
            f'  <faults ID="f{n}" name="delay of {n}"><delayMessage DELAY="1.0">'
            f'<affectedMessage href="mission.xmi#m{n % n_robots}"/></delayMessage></faults>\n'
        )
    yield "</faults:FaultSpecification>\n"
