"""Reasons why a fault changes no goal hold in the very flight that they are given for.

They are checked by other means: flights with and without the fault are recorded whole, and what a
reason says is looked for in the records.
"""

import re
from dataclasses import dataclass, field, replace

import pytest

from mrsfi_runtime.analysis.effects import audit
from mrsfi_runtime.analysis.other_values import other_values
from mrsfi_runtime.engine.reference import ReferenceEngine
from mrsfi_runtime.kernel.forecast import energy_reserve
from mrsfi_runtime.kernel.geometry import distance
from mrsfi_runtime.kernel.packing import state_bytes
from mrsfi_runtime.model.faults import FaultPool, TimedFault
from mrsfi_runtime.model.mission import ROBOT_RADIUS
from tests.support.world import code_of
from tests.tiers import seeds, slow

WINDOWS = {"uuv_sampling": (100, 900), "tight_margins": (60, 180), "tight_energy": (60, 340)}
COUNTS = ("believed", "true", "missed")


@dataclass
class Recording:
    """All of a flight, tick by tick."""

    world: list = field(default_factory=list)
    belief: list = field(default_factory=list)
    commands: list = field(default_factory=list)
    verdicts: list = field(default_factory=list)
    reserve: list = field(default_factory=list)
    gap: list = field(default_factory=list)

    def __call__(self, world, belief, verdicts):
        self.world.append(state_bytes(world))
        self.belief.append(state_bytes(belief))
        self.commands.append(
            (
                [(each.heading_x, each.heading_y, each.speed) for each in world.commands],
                [switch.active for switch in world.switches],
            )
        )
        self.verdicts.append(([*verdicts.is_true], [*verdicts.is_believed]))
        views = (world, belief)
        self.reserve.append([_reserve(view) for view in views])
        self.gap.append([_gap(view) for view in views])


def _reserve(view):
    return min(energy_reserve(view, index) for index in range(len(view.robots)))


def _gap(view):
    """Return the least gap between any two discs; in the paper's mission g1 is about all."""
    robots = [(robot.x, robot.y, ROBOT_RADIUS) for robot in view.robots]
    others = robots + [(each.x, each.y, each.radius) for each in view.obstacles]
    return min(
        distance(x, y, to_x, to_y) - radius - to_radius
        for place, (x, y, radius) in enumerate(robots)
        for to_x, to_y, to_radius in others[place + 1 :]
    )


def _rows(mission, seed, *faults):
    """Audit some faults of a mission, all of them if none is named."""
    code = code_of(mission)
    if faults:
        code = replace(code, pool=FaultPool("some", tuple(code.pool[each] for each in faults)))
    return code, audit(ReferenceEngine(code, seed), *WINDOWS[mission])


def _fly(code, seed, specification):
    recording = Recording()
    outcome = ReferenceEngine(code, seed).evaluate(specification, observer=recording)
    return outcome, recording


def _require_that_reasons_hold(mission, seed, *faults):
    """Fly every fault again, and return how many changed a goal."""
    code, rows = _rows(mission, seed, *faults)
    without, twin = _fly(code, seed, ())
    for row in rows:
        alone = (TimedFault(row.fault.id, *WINDOWS[mission], row.fault.values),)
        outcome, flight = _fly(code, seed, alone)
        is_silent = all(getattr(outcome, name) == getattr(without, name) for name in COUNTS)

        assert bool(row.reason) == is_silent, row.fault.id
        assert bool(row.n_seeds) != is_silent, row.fault.id
        if is_silent:
            _require_holds(row, flight, twin)
            if mission == "uuv_sampling" and "limit" in row.reason:
                _require_left(row.reason, flight, twin)
    return sum(not row.reason for row in rows)


def _require_holds(row, flight, twin):
    is_same = {
        name: getattr(flight, name) == getattr(twin, name)
        for name in ("world", "belief", "commands", "verdicts")
    }
    if "nothing differs at any tick" in row.reason or "does not carry" in row.reason:
        expected = {"world": True, "belief": True, "commands": True, "verdicts": True}
    elif "no command does" in row.reason:
        expected = {"world": True, "belief": False, "commands": True, "verdicts": True}
    elif "no verdict does" in row.reason:
        expected = {"world": False, "belief": is_same["belief"], "verdicts": True}
        expected["commands"] = is_same["commands"]
    else:
        pytest.fail(f"{row.fault.id}: {row.reason}")
    assert is_same == expected, f"{row.fault.id}: {row.reason}"


def _require_left(reason, flight, twin):
    """Look for the margins of the paper's g1 and g3 where they are other than in the twin."""
    for name, words in (("gap", r"g1 ([\d.,]+) distance"), ("reserve", r"g3 ([\d.,]+) energy")):
        pairs = zip(getattr(flight, name), getattr(twin, name), strict=True)
        left = [
            value
            for now, before in pairs
            for value, was in zip(now, before, strict=True)
            if value != was
        ]
        said = re.search(words, reason)
        assert bool(left) == bool(said), reason
        if said is not None:
            least = float(said[1].replace(",", ""))
            assert least <= min(left) <= 1.01 * least + 1.0, reason


@slow
@pytest.mark.parametrize("seed", seeds(range(1, 41), 2))
def test_the_reasons_of_a_blocked_position_and_a_wandering_obstacle_hold(seed):
    _require_that_reasons_hold("uuv_sampling", seed, "f2", "f19")


@pytest.mark.parametrize("seed", seeds([1, 2, 7], 0))
def test_every_reason_on_the_papers_mission_holds(seed):
    n_effective = _require_that_reasons_hold("uuv_sampling", seed)

    assert 10 <= n_effective < 30


@slow
@pytest.mark.parametrize("seed", seeds(range(1, 41), 3))
def test_every_reason_on_a_mission_with_tight_margins_holds(seed):
    _require_that_reasons_hold("tight_margins", seed)


@slow
def test_seeds_are_counted_and_the_silent_ones_have_the_reasons_that_hold_there():
    code = code_of("tight_margins")
    pool = FaultPool("some", (code.pool["f25"],))
    window, n_seeds = WINDOWS["tight_margins"], 12
    engine = ReferenceEngine(replace(code, pool=pool), 1)

    (row,) = audit(engine, *window, n_seeds)

    alone = [_rows("tight_margins", seed, "f25")[1][0] for seed in range(1, 1 + n_seeds)]
    reasons = [each.reason for each in alone if each.reason]
    goals = [goal for each in alone for goal in each.n_seeds]
    assert row.reason == alone[0].reason
    assert row.n_seeds == {goal: goals.count(goal) for goal in {*goals}}
    assert sum(n for _, n in row.reasons) == len(reasons)
    assert 0 < len(reasons) < n_seeds


@slow
def test_other_values_change_the_goals_that_they_are_said_to_change_and_nearer_ones_do_not():
    code = code_of("tight_energy")
    pool = FaultPool("some", (code.pool["f8"],))
    window = WINDOWS["tight_energy"]
    engine = ReferenceEngine(replace(code, pool=pool), 1)

    (row,) = audit(engine, *window, 2, tries_values=True)

    def changed(values, seed):
        without = engine.evaluate((), seed)
        found = engine.evaluate((TimedFault("f8", *window, values),), seed)
        return {
            goal
            for name in COUNTS
            for goal, a, b in zip(
                code.mission.goal_ids, getattr(found, name), getattr(without, name), strict=True
            )
            if a != b
        }

    (other,) = row.others
    values = tuple(other.values.values())
    found = [changed(values, seed) for seed in (1, 2)]
    assert found[0]
    assert other.n_seeds == {
        goal: sum(goal in goals for goals in found) for goal in set.union(*found)
    }
    tried = other_values(code.mission, row.fault)
    nearer = [row.fault.values, *tried[: tried.index(values)]]
    assert [changed(each, 1) for each in nearer] == [set()] * len(nearer)
