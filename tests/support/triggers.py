"""Triggers drawn for a mission and its pool, of every event, in the runtime's words and in XMI."""

from collections.abc import Iterable
from dataclasses import replace
from random import Random

from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.model.faults import Event, FaultPool, Specification, Trigger
from mrsfi_runtime.model.mission import Area, Coordinates, Mission

REACHABLE = ("GatherSamples", "Visit", "Track")
N_EACH = 3  # of an event, at most


def drawn_triggers(rng: Random, mission: Mission, pool: FaultPool) -> tuple[Trigger, ...]:
    """Draw some triggers of every event that the mission and the pool have something for."""
    reachable = [goal for goal in mission.goals if goal.task.name in REACHABLE]
    robots = [*mission.robots]
    faults = [fault.id for fault in pool]
    found: list[tuple[Event, tuple[str, ...], Area | None]] = []
    for event, goals in ((Event.VIOLATED, [*mission.goals]), (Event.REACHED, reachable)):
        some = rng.sample(goals, min(N_EACH, len(goals)))
        found += [(event, (goal.id,), None) for goal in some]
    for n, robot in enumerate(rng.sample(robots, min(N_EACH, len(robots)))):
        near = rng.choice([robot.position, rng.choice(robots).position, mission.area.center])
        center = Coordinates(near.x + rng.uniform(-9.0, 9.0), near.y, 0.0)
        area = Area(f"entered{n}", center, rng.uniform(1.0, mission.area.radius))
        found.append((Event.ENTERED, (robot.id,), area))
    for _ in range(min(N_EACH, len(faults))):
        found.append((Event.EFFECT, tuple(rng.sample(faults, min(5, len(faults)))), None))
    return tuple(
        Trigger(f"t{n}", event, of, area, rng.choice((0, 0, 1, 5)), rng.choice((None, 1, 20)))
        for n, (event, of, area) in enumerate(found)
    )


def with_triggers(code: MissionCode, seed: int = 1) -> MissionCode:
    """Return the code of a mission whose pool declares triggers, the same for the same seed."""
    triggers = drawn_triggers(Random(seed), code.mission, code.pool)
    return replace(code, pool=replace(code.pool, triggers=triggers))


def waiting(rng: Random, specification: Specification, pool: FaultPool) -> Specification:
    """Return a specification of which about half of all faults wait for a trigger of the pool."""
    names = [trigger.id for trigger in pool.triggers]
    if not names:
        return specification
    return tuple(
        timed._replace(trigger=rng.choice(names) if rng.random() < 0.5 else "")
        for timed in specification
    )


def in_xmi(triggers: Iterable[Trigger]) -> str:
    """Return triggers as the elements of a fault pool beside its mission."""
    return "".join(map(_element, triggers))


def _element(trigger: Trigger) -> str:
    lasts = "" if trigger.duration is None else f' duration="{trigger.duration}"'
    head = (
        f'<triggers ID="{trigger.id}" event="{trigger.event.name}" delay="{trigger.delay}"{lasts}'
    )
    if trigger.event is Event.EFFECT:
        return f'{head} faults="{" ".join(trigger.of)}"/>\n'
    tag = "goal" if trigger.area is None else "robot"
    area = ""
    if trigger.area is not None:
        at = trigger.area.center
        area = (
            f'<area ID="{trigger.area.id}" radius="{trigger.area.radius!r}">'
            f'<center x="{at.x!r}" y="{at.y!r}"/></area>'
        )
    return f'{head}><{tag} href="mission.xmi#{trigger.of[0]}"/>{area}</triggers>\n'
