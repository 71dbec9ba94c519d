"""Laws of every flight, over random fault specifications."""

from dataclasses import fields, is_dataclass, replace
from functools import cache

from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.errors import SpecificationError
from mrsfi_runtime.model.fault_types import Field, Range
from mrsfi_runtime.model.faults import Event, Gate, TimedFault, Trigger, touched
from mrsfi_runtime.model.mission import Area, Coordinates
from tests.support.trace import TraceDigest, fields_of
from tests.support.world import code_of, cornered, paper_code, specification
from tests.tiers import law, slow

DURATION = 60
CODE = paper_code(DURATION)
POOL = tuple(CODE.pool)
EVERYWHERE = Area("e", Coordinates(), 1e9)


@st.composite
def specifications(draw, first=0):
    """Draw up to eight timed faults of the paper's pool, no two conflicting ones overlapping."""
    chosen = []
    for fault in draw(st.lists(st.sampled_from(POOL), max_size=8)):
        start = draw(st.integers(first, first + DURATION))
        timed = TimedFault(fault.id, start, start + draw(st.integers(0, DURATION)), fault.values)
        try:
            Gate(CODE.mission, CODE.pool).admitted((*chosen, timed))
        except SpecificationError:
            continue
        chosen.append(timed)
    return tuple(chosen)


def trace(specification, seed):
    digest = TraceDigest()
    ReferenceEngine(CODE, seed).evaluate(specification, observer=digest)
    return digest.hexdigest()


@cache
def free_trace(seed):
    return trace((), seed)


@law(40)
@given(specifications(first=DURATION), st.integers(0, 3))
def test_faults_after_the_end_are_no_faults_tick_by_tick(specification, seed):
    assert trace(specification, seed) == free_trace(seed)


@slow
@law(40)
@given(specifications(), st.integers(0, 2**40))
def test_the_same_seed_flies_the_same_and_one_engine_forgets_its_last_flight(specification, seed):
    engine = ReferenceEngine(CODE, seed)
    first = engine.evaluate(specification)

    engine.evaluate(())

    assert engine.evaluate(specification) == first
    assert ReferenceEngine(CODE, seed).evaluate(specification) == first


@law(40)
@given(specifications(), st.integers(0, 3), st.randoms(use_true_random=False))
def test_what_nothing_sets_off_flies_as_if_the_faults_were_not_there(specification, seed, rng):
    """Of triggers one is never entered, one is the effect of no fault, one comes too late."""
    late = Trigger("late", Event.ENTERED, ("r1",), EVERYWHERE, DURATION)
    nowhere = Trigger("nowhere", Event.ENTERED, ("r1",), Area("n", Coordinates(1e9), 1.0))
    never = (late, nowhere, Trigger("nothing", Event.EFFECT, ()))
    waiting = tuple(each._replace(trigger=rng.choice(never).id) for each in specification)

    digest = TraceDigest()
    pool = replace(CODE.pool, triggers=never)
    outcome = ReferenceEngine(CODE, seed).evaluate(waiting, pool=pool, observer=digest)

    assert digest.hexdigest() == free_trace(seed)
    assert not any(outcome.applied)


@law(40)
@given(specifications(), st.integers(0, 2**40))
def test_what_happens_at_tick_0_sets_off_from_tick_1_on(specification, seed):
    pool = replace(CODE.pool, triggers=(Trigger("begun", Event.ENTERED, ("r1",), EVERYWHERE),))
    waiting = tuple(each._replace(trigger="begun") for each in specification)
    later = [(each, each._replace(start=max(each.start, 1))) for each in specification]
    engine = ReferenceEngine(CODE, seed)

    found = engine.evaluate(waiting, pool=pool)

    expected = engine.evaluate([new for old, new in later if new.finish >= 1])
    kept = [new.finish >= 1 for _, new in later]
    assert found.true == expected.true
    assert found.believed == expected.believed
    for counted in ("applied", "changed"):
        counts = zip(getattr(found, counted), kept, strict=True)
        assert [count for count, is_kept in counts if is_kept] == [*getattr(expected, counted)]
    if all(kept):
        assert found == expected


@law(60)
@given(specifications(), st.integers(0, 2**40))
def test_what_no_active_fault_touches_is_believed_as_it_is(specification, seed):
    windows = [
        (timed.start, timed.finish, touched(CODE.mission, CODE.pool[timed.fault]))
        for timed in specification
    ]

    def watch(world, belief, verdicts):
        tick = world.mission.tick
        active = {
            target
            for start, finish, targets in windows
            if start <= tick <= finish
            for target in targets
        }
        is_off = [not world.sensors[robot.gps].active for robot in world.robots]
        true = fields_of(world)
        for (field, index), value in fields_of(belief).items():
            is_unheard = field is Field.POSITION and is_off[index]
            is_touched = field is not Field.ACTIVATION and (field, index) in active
            assert value == true[field, index] or is_unheard or is_touched
        for sensor in world.sensors:
            assert (sensor.rate, sensor.cost) == (sensor.nominal_rate, sensor.nominal_cost)
        for obstacle in world.obstacles:
            assert (obstacle.x, obstacle.y) == (obstacle.model_x, obstacle.model_y)

    ReferenceEngine(CODE, seed).evaluate(specification, observer=watch)


@law(40)
@given(specifications(), st.integers(0, 2**40))
def test_violations_are_counted_once_per_goal_and_tick(specification, seed):
    ticks = []

    def watch(world, belief, verdicts):
        judged = (verdicts.is_true, verdicts.is_believed, verdicts.missed)
        ticks.append(tuple(map(tuple, judged)))

    outcome = ReferenceEngine(CODE, seed).evaluate(specification, observer=watch)

    assert len(ticks) == DURATION
    for goal in range(len(CODE.mission.goals)):
        pairs = [(true[goal], believed[goal]) for true, believed, _ in ticks]
        assert outcome.true[goal] == sum(true for true, _ in pairs)
        assert outcome.believed[goal] == sum(believed for _, believed in pairs)
        assert outcome.phantom[goal] == sum(believed and not true for true, believed in pairs)
        assert outcome.masked[goal] == sum(true and not believed for true, believed in pairs)
        broken = [true[goal] or missed[goal] > 0 for true, _, missed in ticks]
        seen = [believed for _, believed in pairs][broken.index(True) :] if any(broken) else []
        n_late = seen.index(1) if any(seen) else len(seen)
        assert outcome.detection[goal] == (len(seen), n_late)


def test_a_digest_holds_what_each_fault_did_in_the_order_of_the_specification():
    first = TimedFault(POOL[0].id, 5, 20, POOL[0].values)
    idle = TimedFault(POOL[1].id, DURATION - 1, DURATION - 1, POOL[1].values)
    orders = ((first,), (first, idle), (idle, first))

    flights = [ReferenceEngine(CODE, 1).evaluate(order) for order in orders]

    assert len({flight.true + flight.believed for flight in flights}) == 1
    assert len({flight.digest for flight in flights}) == 3


LENGTHS = {"x", "y", "z", "speed", "max_speed", "radius", "clearance"}


def scaled(value, by, name=""):
    """Return a part of a mission with all its lengths multiplied."""
    if is_dataclass(value):
        given = {each.name: getattr(value, each.name) for each in fields(value)}
        return replace(value, **{name: scaled(each, by, name) for name, each in given.items()})
    if isinstance(value, tuple):
        return tuple(scaled(each, by) for each in value)
    if name == "energy_per_distance_unit":
        return value / by
    return value * by if name in LENGTHS and value is not None else value


def crowded():
    """Return the mission with robots so large, and kept so far apart, that they evade."""
    sizes = zip(CODE.mission.robots, (60.0, 100.0, 0.25), strict=True)
    robots = tuple(replace(robot, radius=radius) for robot, radius in sizes)
    mission = cornered(CODE.mission)
    first, *others = mission.goals
    goals = (replace(first, task=replace(first.task, clearance=45.0)), *others)
    return replace(mission, robots=robots, goals=goals)


def is_without_length(timed):
    kind = CODE.pool[timed.fault].kind
    return not {each.range for each in kind.parameters} & {Range.X, Range.Y, Range.SPEED}


@law(40)
@given(specifications(), st.integers(0, 3), st.integers(-4, 8))
def test_a_mission_whose_lengths_are_all_multiplied_flies_alike(specification, seed, power):
    """By a power of two, so that nothing is rounded."""
    faults, by = tuple(filter(is_without_length, specification)), 2.0**power
    small, large = crowded(), scaled(crowded(), by)

    one, other = (
        ReferenceEngine(replace(CODE, mission=mission), seed).evaluate(faults)
        for mission in (small, large)
    )

    assert (other.true, other.believed, other.missed) == (one.true, one.believed, one.missed)
    assert other.margins[0] == (one.margins[0][0] * by, one.margins[0][1])
    assert other.samples == one.samples


@law(20)
@given(st.integers(0, 2**16), st.integers(0, 3), st.integers(2, 40))
def test_a_route_of_one_area_flies_as_the_patrol_of_that_area(drawn, seed, period):
    code = code_of("tight_energy", DURATION)

    def flown(task):
        goals = tuple(
            replace(goal, task=task(goal.task)) if goal.id == "rounds" else goal
            for goal in code.mission.goals
        )
        engine = ReferenceEngine(replace(code, mission=replace(code.mission, goals=goals)), seed)
        return engine.evaluate(specification(code, drawn))

    one = flown(lambda task: replace(task, period=period))
    other = flown(lambda task: type(task)(period=period, route=(task.area,)))

    assert one == other


def strict():
    """Return the mission with robots that are often too near to each other, or outside."""
    mission = crowded()
    first, *others = mission.goals
    goals = (replace(first, task=replace(first.task, clearance=250.0)), *others)
    return replace(mission, goals=goals, area=replace(mission.area, radius=340.0))


def lasting(is_broken, grace):
    """Return whether a rule was broken at a tick and at each tick of the grace before."""
    return [all(is_broken[t - grace : t + 1]) and t >= grace for t in range(len(is_broken))]


@law(40)
@given(
    specifications(),
    st.integers(0, 3),
    st.lists(st.sampled_from((0, 1, 2, 4, 10, DURATION - 1)), min_size=6, max_size=6),
)
def test_a_violation_counts_if_its_rule_was_broken_during_the_grace_too(faults, seed, graces):
    """In truth and belief each by itself, so that a longer grace counts no more."""
    mission = strict()
    goals = zip(mission.goals, graces, strict=True)
    graced = replace(mission, goals=tuple(replace(goal, grace=n) for goal, n in goals))

    plain, found = (
        ReferenceEngine(replace(CODE, mission=each), seed).record(faults)
        for each in (mission, graced)
    )

    for name in ("is_true", "is_believed"):
        rules = zip(plain[name].T.tolist(), graces, strict=True)
        assert found[name].T.tolist() == [lasting(*each) for each in rules]
    is_true, is_believed = found["is_true"] > 0, found["is_believed"] > 0
    counts = {"true": is_true, "believed": is_believed}
    counts |= {"phantom": is_believed & ~is_true, "masked": is_true & ~is_believed}
    for name, at_tick in counts.items():
        assert found[name][-1].tolist() == at_tick.sum(axis=0).tolist()
    assert found["missed"][-1][:2].tolist() == (is_true.cumsum(axis=0) > 0).sum(axis=0)[:2].tolist()
    assert found["missed"][-1][2:].tolist() == plain["missed"][-1][2:].tolist()
    assert (found["margin"][-1][:2] < 0).tolist() == is_true.any(axis=0)[:2].tolist()
