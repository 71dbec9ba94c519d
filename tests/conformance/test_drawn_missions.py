"""Whole missions that hypothesis draws fly alike, interpreted and compiled, bit for bit."""

from collections import Counter
from dataclasses import astuple, dataclass, field, fields
from struct import iter_unpack

import pytest
from hypothesis import given, note, settings
from hypothesis import strategies as st

from m2t.generate import generate
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.kernel.flight import Verdicts
from mrsfi_runtime.kernel.state import COLUMNS, state_bytes
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.engine_settings import EngineSettings
from tests.support.fault_types import FAULT_TYPES
from tests.support.models.shapes import (
    TASKS,
    draw_specification,
    shape,
    write_drawn,
)
from tests.tiers import seeds

N_SPECIFICATIONS = 10
FEW = {
    "one robot": (shape(1, 1, seed=14), 60, 70),
    "three robots": (shape(3, 2, ("Visit", "GatherSamples"), seed=5), 60, 20),
}
MANY = {
    "eleven robots": (shape(11, 4, ("AvoidCollision", "Patrol", "Track"), seed=1), 40, 6),
    "fifty robots": (shape(50, 3, ("Stay",), seed=15), 20, 6),
}
"""Shape, the longest mission in ticks, and how many missions are drawn."""


class Watch:
    """Observer that keeps every field of belief and truth, and all verdicts, at every tick."""

    def __init__(self):
        self.moments = []

    def __call__(self, world, belief, verdicts):
        self._state = belief
        packed = state_bytes(world), state_bytes(belief)
        self.moments.append((*packed, *map(tuple, astuple(verdicts))))

    def first_difference(self, other):
        """Return where two flights part: tick, side, field and both values."""
        sides = ("true", "believed", *(each.name for each in fields(Verdicts)))
        names = [
            f"{name}[{index}].{column}"
            for name, columns in COLUMNS.items()
            for index in range(len(getattr(self._state, name)))
            for column in columns
        ]
        for tick, pair in enumerate(zip(self.moments, other.moments, strict=False)):
            for side, one, two in zip(sides, *pair, strict=True):
                if one != two and isinstance(one, bytes):
                    values = zip(names, iter_unpack("<d", one), iter_unpack("<d", two), strict=True)
                    return next((tick, side, *found) for found in values if found[1] != found[2])
                if one != two:
                    return tick, side, one, two
        return len(self.moments), len(other.moments)


def flown(engine, specification):
    watch = Watch()
    return engine.evaluate(specification, observer=watch), watch


@dataclass
class Coverage:
    """In how many flights each goal was violated and kept, and each fault type had an effect."""

    n_flights: int = 0
    violated: Counter[int] = field(default_factory=Counter)
    kept: Counter[int] = field(default_factory=Counter)
    changed: Counter[str] = field(default_factory=Counter)

    def add(self, code, specification, outcome):
        self.n_flights += 1
        for goal, n_ticks in enumerate(outcome.believed):
            self.violated[goal] += n_ticks > 0
            self.kept[goal] += n_ticks < code.mission.duration
        for timed, n_ticks in zip(specification, outcome.changed, strict=True):
            self.changed[code.pool[timed.fault].type] += n_ticks > 0


def fly_alike(folders, of, longest, n_missions):
    """Draw missions and specifications, fly them on both engines, and return what was covered.

    Drawn specifications are compared at every tick, each fault of the pool alone by its outcome.
    """
    coverage = Coverage()

    @settings(max_examples=n_missions, deadline=None, derandomize=True)
    @given(st.randoms(use_true_random=True), st.integers(0, 2**40))
    def flies_alike(rng, seed):
        folder = folders.mktemp("drawn")
        note(f"models and code: {folder}")
        models = write_drawn(folder / "models", rng, of, longest)
        generate(models, folder / "generated")
        code = load_code(folder / "generated")
        some = [draw_specification(rng, code) for _ in range(N_SPECIFICATIONS)]
        last = code.mission.duration - 1
        alone = [(TimedFault(fault.id, 0, last, fault.values),) for fault in code.pool]
        reference = ReferenceEngine(code, seed)

        with open_engine(EngineSettings("compiled"), code, seed) as engine:
            found = [flown(engine, specification) for specification in some]
            outcomes = list(engine.evaluate_many([*some, *alone]))

        for specification, (outcome, watch) in zip(some, found, strict=True):
            expected, seen = flown(reference, specification)
            if watch.moments != seen.moments:
                pytest.fail(f"{specification}: {watch.first_difference(seen)}")
            assert outcome == expected
            coverage.add(code, specification, expected)
        assert outcomes[: len(some)] == [outcome for outcome, _ in found]
        for specification, outcome in zip(alone, outcomes[len(some) :], strict=True):
            expected = reference.evaluate(specification)
            assert outcome == expected, specification
            coverage.add(code, specification, expected)

    flies_alike()
    assert coverage.n_flights >= n_missions * (N_SPECIFICATIONS + len(FAULT_TYPES))
    return coverage


@pytest.mark.parametrize("name", [*seeds(FEW, 0, 1), *seeds(MANY, 0, 1)])
def test_drawn_missions_fly_alike(tmp_path_factory, name):
    """Draws 102 missions, and 1,020 specifications, and flies each fault alone beside.

    With few robots every goal was violated at some ticks and not at others, and each of the
    thirty fault types changed something; with many, half the goals and most fault types matter.
    """
    drawn = {**FEW, **MANY}[name]
    least_goals, least_types = (1.0, 1.0) if name in FEW else (0.5, 0.8)

    coverage = fly_alike(tmp_path_factory, *drawn)

    n_goals = len(drawn[0].goals)
    assert sum(n > 0 for n in coverage.violated.values()) >= least_goals * n_goals
    assert sum(n > 0 for n in coverage.kept.values()) >= least_goals * n_goals
    assert sum(n > 0 for n in coverage.changed.values()) >= least_types * len(FAULT_TYPES)


def test_every_task_is_flown_by_few_and_by_many_robots():
    for shapes in (FEW, MANY):
        assert {goal.task for of, *_ in shapes.values() for goal in of.goals} == set(TASKS)
