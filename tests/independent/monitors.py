"""The monitors of docs/monitors.md, recounted from a recorded flight in plain Python."""

import math
from collections import defaultdict

from tests.independent.simulation import FIRST_HEADING, Weather

RESERVE = 0.2
COUNTED = {"position frozen", "age of reports", "switch against command"}
COUNTED |= {"sample count frozen", "sample count rate"}


def beginning(mission, seed):
    """Return what the CI knows before the first tick: the model, and first commands."""
    weather = Weather(seed)
    robots, commands = [], []
    for k, robot in enumerate(mission.robots):
        at = {axis: getattr(robot.position, axis) for axis in "xyz"}
        robots.append(at | {"speed": robot.speed, "energy": robot.total_energy})
        x, y = weather.direction(0, k, FIRST_HEADING)
        commands.append({"heading_x": x, "heading_y": y, "speed": robot.speed})
    sensors = [{"count": 0} for _ in mission.sensors]
    switches = [{"active": 1} for _ in mission.sensors]
    return {"robots": robots, "commands": commands, "sensors": sensors, "switches": switches}


def measures(mission, flight, seed):
    """Return the measures of a flight at each tick, by monitor and element."""
    belief, found = flight["belief"], defaultdict(list)
    n_in_a_row = defaultdict(int)

    def note(name, element, value):
        found[name, element.id].append(value)

    def lasts(name, element, is_so):
        n_in_a_row[name, element.id] = n_in_a_row[name, element.id] + 1 if is_so else 0
        note(name, element, n_in_a_row[name, element.id])

    for tick in range(len(flight)):
        was = belief[tick - 1].copy() if tick else beginning(mission, seed)
        now = belief[tick].copy()
        for k, robot in enumerate(mission.robots):
            before, after, order = was["robots"][k], now["robots"][k], was["commands"][k]
            speed = min(max(order["speed"], 0.0), after["max_speed"])
            speed = speed if before["energy"] > 0.0 else 0.0
            dx, dy = after["x"] - before["x"], after["y"] - before["y"]
            way = math.sqrt(dx * dx + dy * dy)
            is_same = all(
                before[name] == after[name] for name in ("x", "y", "z", "speed", "energy")
            )
            lasts("position frozen", robot, way == 0.0 and speed > 0.0)
            lasts("age of reports", robot, is_same and speed > 0.0)
            center = mission.area.center
            off = math.dist((after["x"], after["y"]), (center.x, center.y)) - mission.area.radius
            note("position range", robot, max(off, 0.0))
            note("position rate", robot, way)
            ordered = speed * order["heading_x"], speed * order["heading_y"]
            note("motion against command", robot, math.dist((dx, dy), ordered))
            note("speed against command", robot, abs(after["speed"] - speed))
            note("speed against positions", robot, abs(after["speed"] - way))
            spent = after["speed"] * after["energy_per_distance"]
            for place, sensor in enumerate(mission.sensors):
                if sensor in robot.sensors and now["sensors"][place]["active"]:
                    spent += sensor.samples_per_second * sensor.energy_per_sample
            left = (
                max(before["energy"] - spent, 0.0) if before["energy"] > 0.0 else before["energy"]
            )
            note("energy balance", robot, abs(after["energy"] - left))
        for k, sensor in enumerate(mission.sensors):
            before, after = was["sensors"][k], now["sensors"][k]
            (owner,) = (r for r, robot in enumerate(mission.robots) if sensor in robot.sensors)
            is_other = after["active"] != was["switches"][k]["active"]
            lasts("switch against command", sensor, is_other and was["robots"][owner]["energy"] > 0)
            n_new = after["count"] - before["count"]
            lasts("sample count frozen", sensor, n_new == 0 and after["active"] == 1)
            note("sample count rate", sensor, abs(n_new))
            off = (
                after["rate"] - sensor.samples_per_second,
                after["cost"] - sensor.energy_per_sample,
            )
            note("data sheet", sensor, math.hypot(*off))
        for k, obstacle in enumerate(mission.obstacles):
            place, center = now["obstacles"][k], obstacle.area.center
            note("map", obstacle, math.dist((place["x"], place["y"]), (center.x, center.y)))
    return found


def thresholds(every):
    """Return the thresholds for the measures of flights without faults."""
    found = {}
    for name, element in every[0]:
        highest = max(max(some[name, element]) for some in every)
        if name in COUNTED:
            found[name, element] = highest + max(1, math.floor(RESERVE * highest))
        else:
            found[name, element] = highest + max(1e-6, RESERVE * highest)
    return found


def first_alarms(measured, limits, since=0):
    """Return the first tick from a tick on at which each measure exceeds its threshold."""
    ticks = {
        key: next((k for k, value in enumerate(some) if k >= since and value > limits[key]), None)
        for key, some in measured.items()
    }
    return {key: tick for key, tick in ticks.items() if tick is not None}


def detection(flight, goal, alarms):
    """Return when it is detected that a goal is broken, by the verdicts of each tick and alarms.

    ``alarms`` are ticks. The count of true violations, or of ticks at which the goal can no longer
    be met, is above 0 from the tick on at which the goal is broken.
    """
    true, failed = flight["true"][:, goal].tolist(), flight["missed"][:, goal].tolist()
    broken = next(k for k, counts in enumerate(zip(true, failed, strict=True)) if any(counts))
    last = next((k for k, count in enumerate(failed) if count), math.inf)
    believed = flight["is_believed"][:, goal].tolist()
    detected = [k for k, is_so in enumerate(believed) if is_so and k >= broken] + alarms
    if not detected:
        return "never"
    if min(detected) <= broken:
        return "in time"
    return "before the goal fails" if min(detected) < last else "later"
