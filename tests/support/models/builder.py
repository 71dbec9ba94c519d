"""Missions and fault pools of the static classes: what draws or writes models starts from this."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from generated.metamodel import faults as f
from generated.metamodel import mission as m
from m2t.models.write import dumps
from tests.support.models.copies import FAULTS, MISSION


def point(x: float = 0.0, y: float = 0.0) -> m.Coordinates:
    """Return a point."""
    return m.Coordinates(x=x, y=y)


def area(name: str, radius: float, center: m.Coordinates | None = None) -> m.Area:
    """Return a disc, around the origin unless told otherwise."""
    return m.Area(ID=name, radius=radius, center=center or point())


def sensor(name: str, kind: str, cost: float = 1.0, rate: int = 1) -> m.Sensor:
    """Return a sensor of a type, what a sample costs, and how many samples it takes each tick."""
    literal = getattr(m.SensorType, kind)
    return m.Sensor(ID=name, name="", type=literal, energyPerSample=cost, samplesPerSecond=rate)


def robot(
    name: str,
    at: m.Coordinates,
    speed: float,
    energy: float,
    drive: float = 0.0,
    sensors: Iterable[m.Sensor] = (),
    **more: Any,
) -> m.Robot:
    """Return a robot with a battery, and what a unit of distance costs."""
    motor = m.MotionSource(ID=f"{name}_drive", name="", energyPerDistanceUnit=drive)
    return m.Robot(
        ID=name,
        name="",
        speed=speed,
        position=at,
        sensors=[*sensors],
        batteries=[m.Battery(ID=f"{name}_battery", name="", totalEnergy=energy)],
        motionSources=[motor],
        **more,
    )


def message(name: str, sender: Any, receiver: Any, **body: str) -> m.Message:
    """Return a message; ``body`` has the types of its fields."""
    entries = [m.MessageData(name=field, type=kind) for field, kind in body.items()]
    return m.Message(ID=name, sender=sender, receiver=receiver, body=entries)


def goal(name: str, task: Any, members: Iterable[m.Robot], **more: Any) -> m.Goal:
    """Return a goal."""
    return m.Goal(ID=name, name="", task=task, members=[*members], **more)


def fault(name: str, kind: str, target: Any, **values: float) -> f.Fault:
    """Return a fault of a type that touches an element of the mission."""
    affected = {f"affected{type(target).__name__}": target}
    return f.Fault(
        ID=name, name="", **{f"{kind[0].lower()}{kind[1:]}": getattr(f, kind)(**affected, **values)}
    )


def pool(faults: Iterable[f.Fault], **more: Any) -> f.FaultSpecification:
    """Return a pool."""
    return f.FaultSpecification(ID="pool", faults=[*faults], **more)


def write(folder: Path, mission: m.Mission, faults: f.FaultSpecification | None = None) -> Path:
    """Write the models of a mission, and return their folder."""
    folder.mkdir(parents=True)
    (folder / MISSION).write_bytes(dumps(mission))
    if faults is not None:
        (folder / FAULTS).write_bytes(dumps(faults, hrefs={mission: MISSION}))
    return folder
