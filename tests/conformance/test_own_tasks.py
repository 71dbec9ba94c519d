"""A goal task of a team's own: generated, filled, and flown alike on every engine."""

import math
from dataclasses import replace

import numpy as np
import pytest

from m2t.generate import generate, plan
from mrsfi_runtime.causes.chain import Chain, Change, First, chain, chains
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.engine.recording import Recording, moment_type
from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.kernel.flight import initial_state
from mrsfi_runtime.model.faults import Fault, FaultPool, TimedFault
from mrsfi_runtime.record.engine_settings import EngineSettings
from tests.support.fault_types import FAULT_TYPES
from tests.support.models.loiter import BODIES, CONSTANTS, fill, write_loiter
from tests.support.trace import TraceDigest
from tests.tiers import slow

STRAY = Fault("stray", FAULT_TYPES["FixedRobotCoordinates"], "from_a", (500.0, 500.0, 0.0))
POOL = FaultPool("one", (STRAY,))
SPECIFICATION = (TimedFault("stray", 10, 30, STRAY.values),)


@pytest.fixture
def generated(tmp_path, own_metamodels):
    models = write_loiter(tmp_path, own_metamodels)
    target = tmp_path / "generated" / "own_task"
    generate(models, target)
    yield target
    assert plan(models, target).stale == ()


def flown(engine, seen=None):
    digest = TraceDigest()

    def observer(world, belief, verdicts):
        digest(world, belief, verdicts)
        if seen is not None:
            seen.append((list(world.goals[1].memory), list(belief.goals[1].memory)))

    outcome = engine.evaluate(SPECIFICATION, pool=POOL, observer=observer)
    return outcome, digest.hexdigest()


def test_features_reach_the_regions_as_constants(generated):
    names: dict[str, object] = {}
    text = (generated / "collective_intelligence.py").read_text(encoding="utf-8")

    exec(text, names)

    found = {name: value for name, value in names.items() if name.startswith("NEAR_")}
    assert found == CONSTANTS
    assert 'task=OwnTask(class_name="Loiter")' in (generated / "mission_loader.py").read_text()


def test_memory_is_kept_apart_in_belief_and_truth(generated):
    fill(generated)
    seen = []

    outcome, _ = flown(ReferenceEngine(load_code(generated), 1), seen)

    worlds, beliefs = zip(*seen, strict=True)
    assert (worlds[9][0], beliefs[9][0]) == (0.0, 0.0)
    assert (worlds[12][0], beliefs[12][0]) == (0.0, 3.0)
    assert beliefs[30][0] == 21.0
    assert outcome.believed[1] > outcome.true[1] > 0
    assert (worlds[-1][7], beliefs[-1][7]) == (0.0, 120 * 2.5)


def test_what_only_memory_tells_apart_changes_digests(generated):
    fill(generated)
    usual = flown(ReferenceEngine(load_code(generated), 1))
    fill(generated, {**BODIES, "near.react": BODIES["near.react"].replace("[7]", "[6]")})

    other = flown(ReferenceEngine(load_code(generated), 1))

    assert replace(other[0], digest=usual[0].digest) == usual[0]
    assert other[0].digest != usual[0].digest
    assert other[1] != usual[1]


@pytest.mark.parametrize("name", [pytest.param("compiled", marks=slow), "rosbridge"])
def test_it_flies_alike_on_every_engine(generated, name):
    fill(generated)
    code = load_code(generated)

    with open_engine(EngineSettings(name), code, 1) as engine:
        assert flown(engine) == flown(ReferenceEngine(code, 1))


@slow
@pytest.mark.parametrize("name", ["reference", "compiled"])
def test_what_differs_in_memory_stands_in_the_chain_of_a_fault(generated, name):
    fill(generated)
    code = replace(load_code(generated), pool=POOL)

    with open_engine(EngineSettings(name), code, 1) as engine:
        (found,) = chains(engine.record, code.mission, SPECIFICATION)

    assert found.belief.tick == 10
    near = {change.quantity: change for change in found.belief.changes if change.owner == "near"}
    assert [*near] == ["memory[0]", "memory[1]"]
    assert near["memory[0]"][2:] == ((1.0,), (0.0,))
    assert near["memory[1]"].found == (pytest.approx(math.dist((500.0, 500.0), (30.0, 0.0))),)


def test_memory_alone_is_a_difference(generated):
    fill(generated)
    mission = load_code(generated).mission
    layout = moment_type(initial_state(mission, 1))
    flight, twin = Recording(layout), Recording(layout)
    moments = np.zeros(5, layout)
    twin.append(moments.copy())
    moments["belief"]["goals"]["memory"][2, 1, 3] = 2.5
    flight.append(moments)

    remembered = Change("near", "memory[3]", (2.5,), (0.0,))
    assert chain(mission, flight, twin) == Chain(First(2, (remembered,)), None, None, ())


def test_regions_that_nobody_filled_do_not_fly(generated):
    fill(generated, {"near.check": "    # later\n"})

    with pytest.raises(EvaluationError) as caught:
        load_code(generated)

    path = generated / "collective_intelligence.py"
    lines = path.read_text(encoding="utf-8").splitlines()
    check, react = (
        lines.index(f"    # protected region near.{word} on begin") + 1
        for word in ("check", "react")
    )
    told = "{}:{}: region 'near.{}': is empty; expected the body of {}_near, which is to: {}"
    whether = "Return whether goal near (Loiter) is violated now."
    command = "Command the members of goal near (Loiter)."
    assert str(caught.value).splitlines() == [
        told.format(path, check, "check", "check", whether),
        told.format(path, react, "react", "react", command),
    ]


def test_progress_is_optional(generated):
    fill(generated, {"near.check": "    return False\n", "near.react": "    pass\n"})

    outcome, _ = flown(ReferenceEngine(load_code(generated), 1))

    assert outcome.believed[1] == 0
