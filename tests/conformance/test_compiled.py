"""The compiled engine finds what the reference engine finds, bit for bit, kernel edited or not."""

import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from itertools import islice
from pathlib import Path

import pytest
from numba.core.errors import TypingError

import mrsfi_runtime
from mrsfi_runtime.engine.compiled.compiler import compiled_kernel
from mrsfi_runtime.engine.compiled.layout import ALIKE
from mrsfi_runtime.engine.compiled.machine_code import kept_code, kernel_key
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.engine.opening import open_engine, tried
from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.kernel.flight import Verdicts, initial_state, no_verdicts
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.engine_settings import EngineSettings
from tests.conformance.regions import compiled
from tests.support.cli import edit
from tests.support.edited import COLLECTIVE, indented, write_body
from tests.support.edited import edited as edited_code
from tests.support.edits import EDITS, NUMBA_REFUSES, write_team
from tests.support.missing import skip
from tests.support.models.shapes import small_mission
from tests.support.trace import traced
from tests.support.tree import ROOT
from tests.support.triggers import with_triggers
from tests.support.world import code_of, paper_code, specifications
from tests.tiers import night, seeds, slow

SEED = 3
N_SPECIFICATIONS = 1000
COMPILED = EngineSettings("compiled")
FLY_EDITED = """
import json, sys
from pathlib import Path
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.record.engine_settings import EngineSettings
from mrsfi_runtime.generated_code import load_code

code = load_code(Path(sys.argv[1]))
found = []
for name in ("reference", "compiled"):
    with open_engine(EngineSettings(name), code, 3) as engine:
        found.append(engine.evaluate(()).digest)
print(json.dumps(found))
"""


@pytest.mark.parametrize("name", ["depot", "fleet_30", "uuv_sampling"])
def test_lists_whose_bounds_are_checked_by_one_length_are_alike(name):
    mission = load_code(ROOT / "generated" / name).mission
    records = {State: initial_state(mission, 1), Verdicts: no_verdicts(len(mission.goals))}

    for kind, alike in ALIKE.items():
        sizes = {each: len(getattr(records[kind], each)) for each in (*alike, *alike.values())}
        assert {each: sizes[each] for each in alike} == {a: sizes[b] for a, b in alike.items()}


@pytest.mark.parametrize("declare", [lambda code: code, with_triggers], ids=["plain", "triggers"])
@pytest.mark.parametrize("n", seeds([60, 1000], 1, 0))
def test_random_specifications_on_the_papers_mission_give_the_same_outcomes(n, declare):
    code = declare(paper_code(120))
    reference = ReferenceEngine(code, SEED)
    drawn = specifications(code, n)

    with open_engine(COMPILED, code, SEED, 2) as engine:
        outcomes = list(engine.evaluate_many(drawn))

    assert outcomes == [reference.evaluate(specification) for specification in drawn]


@pytest.mark.parametrize(("fault", "told"), [("f11", "r3"), ("f9", None)])
def test_what_is_believed_to_be_just_ahead_of_a_robot_is_avoided_at_once(fault, told):
    """What is far away is looked at less often when compiled, unless a belief is false."""
    code = paper_code(120)
    reference = ReferenceEngine(code, SEED)
    (moments,) = reference.record(()).moments()
    told = code.mission.robot_index.get(told)  # whose position the fault falsifies
    ahead = []
    for tick in range(5, 100, 5):
        for other in {*range(len(code.mission.robots))} - {told}:
            robot, command = (
                moments["world"][name][tick, other] for name in ("robots", "commands")
            )
            x, y = (robot[axis] + 20.0 * command[f"heading_{axis}"] for axis in "xy")
            ahead.append((TimedFault(fault, tick, tick + 2, (float(x), float(y), 1.0)),))

    with open_engine(COMPILED, code, SEED, 2) as engine:
        outcomes = list(engine.evaluate_many(ahead))

    assert outcomes == [reference.evaluate(specification) for specification in ahead]
    turned = {outcome.digest for outcome in outcomes}
    assert len(turned) == len(ahead)


def test_a_robot_that_reports_its_position_again_is_checked_at_once():
    """It goes on, and comes near others, while its GPS sensor is off."""
    code = code_of("atlas_search", 250)
    off = [(TimedFault("f24", first, first + 110, ()),) for first in range(60, 130, 7)]
    reference = ReferenceEngine(code, 1)

    with open_engine(COMPILED, code, 1) as engine:
        assert [*engine.evaluate_many(off)] == [reference.evaluate(each) for each in off]


def test_a_robot_near_the_edge_of_the_mission_area_turns_back_at_the_same_tick():
    """The edge is far from the robots of the paper's mission; here it is where they roam."""
    given, turned = paper_code(250), set()
    known = given.mission.robots
    robots = tuple(replace(each, max_speed=each.speed, turn_rate=20.0) for each in known)
    for radius in (330.0, 400.0, 470.0, 540.0):
        area = replace(given.mission.area, radius=radius)
        code = replace(given, mission=replace(given.mission, area=area, robots=robots))
        drawn = ((), *specifications(code, 3))
        reference = ReferenceEngine(code, SEED)
        with open_engine(COMPILED, code, SEED) as engine:
            outcomes = [*engine.evaluate_many(drawn)]
        assert outcomes == [reference.evaluate(each) for each in drawn]
        turned.add(outcomes[0].digest)
    assert len(turned) > 2


@pytest.mark.parametrize("name", ["depot", "fleet_30", "undersea", "uuv_sampling"])
def test_where_no_index_is_checked_none_is_wrong(name):
    code = load_code(ROOT / "generated" / name)
    drawn = specifications(code, 40)

    with open_engine(COMPILED, code, SEED) as engine:
        unguarded = list(engine.evaluate_many(drawn))  # from a state that is kept for later flights
        engine._fly_many.is_guarded = True
        engine._fly_many._compile()
        engine._reference = None  # which would repeat a flight with a wrong index
        guarded = list(engine.evaluate_many(drawn))

    assert guarded == unguarded


FLY = """
import sys
from pathlib import Path
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.record.engine_settings import EngineSettings
from mrsfi_runtime.generated_code import load_code
with open_engine(EngineSettings("compiled"), load_code(Path(sys.argv[1])), 1) as engine:
    engine.evaluate(())
    print(int(engine._fly_many.is_new))
"""


def test_the_kernel_needs_no_symbol_from_outside(tmp_path):
    if shutil.which("nm") is None:
        skip("nm is not installed")
    code, _ = kept_code(kernel_key(), compiled_kernel)
    (tmp_path / "kernel.o").write_bytes(code.binary)

    listed = subprocess.run(
        ["nm", "--undefined-only", tmp_path / "kernel.o"], capture_output=True, check=True
    )

    assert code.is_near
    assert listed.stdout == b""


@night
def test_of_two_processes_one_compiles_a_mission_and_the_other_waits(tmp_path, monkeypatch):
    monkeypatch.setenv("MRSFI_CACHE", str(tmp_path))
    command = [sys.executable, "-c", FLY, str(ROOT / "generated" / "tight_energy")]
    pipe = subprocess.PIPE
    processes = [subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True) for _ in range(2)]

    printed, told = zip(*(each.communicate(timeout=240) for each in processes), strict=True)

    assert sorted(printed) == ["0\n", "1\n"]
    assert re.search(
        r"compiling the kernel, once .*\ncompiled the kernel in \d+\.\d s\n", max(told)
    )
    assert min(told) == ""


REGION = "g0.check"


def edited(folder, body, imports=""):
    """Return code of a small mission with one goal, the check of which has another body."""
    path = small_mission(folder).directory / COLLECTIVE
    write_body(path, REGION, indented(body))
    marker = "# protected region imports on begin\n"
    edit(path, marker, marker + imports)
    return load_code(path.parent)


@night
def test_a_region_may_use_lists_sorting_and_nested_loops(tmp_path):
    body = (
        "xs = sorted([robot.x for robot in ci.robots])\n"
        "total = 0.0\n"
        "for k in range(len(xs)):\n"
        "    total += xs[k] / (k + 1)\n"
        "return total > 10.0 or min(xs) < -100.0"
    )
    code = edited(tmp_path, body)

    with open_engine(COMPILED, code, SEED) as engine:
        assert traced(engine, ()) == traced(ReferenceEngine(code, SEED), ())


@pytest.mark.parametrize(
    ("region", "body"),
    [
        ("g1.check", "return not goal_tasks.stay_within_mission_area.violated(ci, G1)"),
        ("g4.check", "return goal_tasks.gather_samples.violated(ci, G5) == (ci.mission.tick > 9)"),
        ("g3.react", "goal_tasks.avoid_collision.react(ci, G1)\ngoal_tasks.stay.react(ci, G2)"),
        ("g5.progress", "for g in (G4, G5):\n    goal_tasks.gather_samples.progress(ci, g)"),
        ("g2.check", "return ci.robots[-1].x > ci.robots[0].x"),
        ("g2.check", "return goal_tasks.avoid_collision.violated(ci, G1 - len(ci.goals))"),
    ],
)
def test_a_region_may_call_what_any_task_says_for_any_goal(tmp_path, region, body):
    code = load_code(edited_code(tmp_path, region, indented(body)))
    drawn = [(), *specifications(code, 2)]

    with open_engine(COMPILED, code, SEED) as engine:
        assert list(engine.evaluate_many(drawn)) == list(
            ReferenceEngine(code, SEED).evaluate_many(drawn)
        )


@slow
@pytest.mark.parametrize(
    ("body", "error"),
    [
        (
            "return 1 // (ci.sensors[0].active - 1 + ci.sensors[0].count * 0) > 5",
            "ZeroDivisionError: .*division",
        ),
        ("return ci.robots[len(ci.robots) + 7].x > 0.0", "IndexError"),
    ],
    ids=["division by zero", "beyond a list"],
)
def test_a_region_that_fails_does_so_as_in_python_with_its_line(tmp_path, body, error):
    code = edited(tmp_path, body)
    reference = ReferenceEngine(code, SEED)
    drawn = [(), *specifications(code, 6)]

    with open_engine(COMPILED, code, SEED) as engine:
        found = list(engine.evaluate_many(drawn))
        for fly in (engine.evaluate, engine.record):
            with pytest.raises(EvaluationError, match=rf"telligence.py:\d+: .*{error}"):
                fly(())

    expected = list(reference.evaluate_many(drawn))
    assert [type(one) for one in found] == [type(one) for one in expected]
    assert re.search(error, found[0].traceback)


@slow
@pytest.mark.parametrize("is_cached", [False, True])
def test_a_region_may_raise_an_error_of_its_own_with_values(tmp_path, is_cached):
    tick = "int(ci.mission.tick) + 41"
    body = f"if ci.mission.tick == 1:\n    raise ValueError('seen', {tick})\nreturn False"
    code = edited(tmp_path, body)
    if is_cached:
        command = [sys.executable, "-c", FLY, str(code.directory)]
        assert b"seen" in subprocess.run(command, capture_output=True, check=False).stderr

    with open_engine(COMPILED, code, SEED) as engine:
        [found] = engine.evaluate_many([()])

    assert "stopped at tick 1: ValueError: ('seen', 42)" in found.traceback


def test_what_does_not_compile_is_told_and_flies_on_the_reference_engine(tmp_path):
    body = "limit = 1.0\nreturn any([robot.x > limit for robot in ci.robots])"
    code = edited(tmp_path, body)
    path = code.directory / COLLECTIVE
    line = path.read_text().splitlines().index(f"    {body.splitlines()[1]}") + 1
    told = []

    with pytest.raises(EvaluationError) as error:
        open_engine(COMPILED, code, SEED)
    auto = tried(EngineSettings("auto"), code, SEED, told.append)

    where = f"{path}:{line}: region {REGION} cannot be compiled: "
    assert str(error.value).startswith(f"{where}the compiler does not support Python's 'any'")
    assert auto == EngineSettings("reference")
    assert str(error.value) in told[0]
    with open_engine(EngineSettings("auto"), code, SEED) as engine:
        assert isinstance(engine, ReferenceEngine)


@pytest.mark.parametrize(
    ("body", "compiled", "flown"),
    [
        ("ci.robots[0].mood = 1.0\nreturn True", "have no 'mood'", "AttributeError"),
        ("return nowhere(ci)", "'nowhere' is not defined", "NameError"),
    ],
)
def test_a_region_that_runs_on_no_engine_is_refused_by_auto_too(tmp_path, body, compiled, flown):
    code = edited(tmp_path, body)

    with pytest.raises(EvaluationError, match=compiled):
        open_engine(COMPILED, code, SEED)
    with pytest.raises(EvaluationError, match=f"stopped at tick 0: {flown}"):
        tried(EngineSettings("auto"), code, SEED, print)


FLOWN = [kind for kind in EDITS if kind not in NUMBA_REFUSES]


@night
def test_after_an_edit_of_all_that_a_region_reaches_both_engines_agree(tmp_path, monkeypatch):
    """All are made at once, for it compiles long; that each is seen, ``test_reach`` says."""
    monkeypatch.setenv("MRSFI_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.syspath_prepend(str(tmp_path))
    numbers = range(len(FLOWN))
    mean = " + ".join(f"verdict_{n}(x)" for n in numbers)
    digests = []
    for is_edited in (False, True):
        modules = [
            write_team(tmp_path, kind, is_edited=is_edited, number=f"_{n}")
            for n, kind in enumerate(FLOWN)
        ]
        names = [f"from {modules[n]} import verdict as verdict_{n}\n" for n in numbers]
        mixed = f"int(abs({mean}) * 1.0e6) % (3 + ci.mission.tick)"
        body = f"x = ci.robots[0].x * 1.0e-3\nreturn {mixed} < 2"
        code = edited(tmp_path / f"mission_{is_edited}", body, "".join(names))
        command = [sys.executable, "-c", FLY, str(code.directory)]
        told = subprocess.run(command, capture_output=True, check=True, text=True).stdout
        assert told == "1\n"
        with open_engine(COMPILED, code, SEED) as engine:
            digests.append(engine.evaluate(()).digest)
        assert digests[-1] == ReferenceEngine(code, SEED).evaluate(()).digest

    assert digests[0] != digests[1]


@pytest.mark.parametrize(
    "body",
    [
        "return len(ci.robots.x) > 0",
        "return ci.robots.size > 0",
        "return ci.robots[0]['x'] > 0.0",
        "return ci.robots[0].x.item() > 0.0",
        "return TABLE[0].a > 0.0",
        "return len(ci.goals[0].memory + 1.0) > 0",
        "return len(-ci.goals[0].memory) > 0",
    ],
)
def test_what_python_refuses_is_not_compiled(tmp_path, body):
    imports = "import numpy as np\nTABLE = np.ones(3, [('a', 'f8')])\n"
    code = edited(tmp_path, body, imports)
    check = sys.modules[code.functions.check.__module__].check_g0
    state = initial_state(code.mission, SEED)

    with pytest.raises((AttributeError, TypeError)):
        check(state)
    with pytest.raises(TypingError, match="has another meaning in Python"):
        compiled(check).compile("(int64,)")


def test_threads_and_chunks_change_nothing():
    code = paper_code(60)
    drawn = specifications(code, 150)

    results = []
    for n_threads in (1, 2, 3):
        with open_engine(COMPILED, code, SEED, n_threads) as engine:
            results.append(list(engine.evaluate_many(drawn)))
            results.append(list(islice(engine.evaluate_many(drawn), 150)))

    assert all(result == results[0] for result in results)


def campaign(code, drawn):
    """Try a mission out and evaluate on three mission seeds, as commands do."""
    with open_engine(tried(EngineSettings("auto"), code, SEED, print), code, SEED) as engine:
        return [list(engine.evaluate_many(drawn, seed)) for seed in (1, 2, SEED)]


ONE_KEY = """
from mrsfi_runtime.engine.compiled import engine
key_of = engine.key_of
engine.key_of = lambda *given: key_of(*given[:-1])
"""


@slow
def test_compiled_code_of_another_region_is_found_out_by_every_process_and_compiled_anew(
    tmp_path, monkeypatch
):
    monkeypatch.setenv("MRSFI_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    (tmp_path / "one_limit.py").write_text("LIMIT = 1.0e9\n", encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    code = edited(tmp_path, "return ci.mission.tick > one_limit.LIMIT", "import one_limit\n")
    n_compiled = []

    for limit in (1.0e9, -1.0e9, -1.0e9):
        (tmp_path / "one_limit.py").write_text(f"LIMIT = {limit}\n", encoding="utf-8")
        command = [sys.executable, "-c", ONE_KEY + FLY, str(code.directory)]
        flown = subprocess.run(command, check=True, capture_output=True, text=True)
        n_compiled.append(flown.stdout)

    assert n_compiled == ["1\n", "1\n", "0\n"]


def test_what_was_found_to_differ_is_found_again_and_again(tmp_path):
    code = edited(tmp_path, "return (ci.mission.tick + 2) * 9000000000000000000 > 0")

    for _ in range(2):
        with pytest.raises(EvaluationError, match="on the reference engine, but"):
            campaign(code, specifications(code, 2))
    with (
        open_engine(COMPILED, code, SEED) as engine,
        pytest.raises(EvaluationError, match="on the reference engine, but"),
    ):
        list(engine.evaluate_many([()]))


def test_a_region_that_fails_only_where_it_is_not_compiled_stops_the_search(tmp_path):
    code = edited(tmp_path, "return math.sqrt(-1.0 - ci.mission.tick) > 0.0", "import math\n")

    with (
        open_engine(COMPILED, code, SEED) as engine,
        pytest.raises(EvaluationError, match=r"collective_intelligence.py:\d+: .*math domain"),
    ):
        list(engine.evaluate_many([()]))
    with pytest.raises(EvaluationError, match="math domain"):
        tried(EngineSettings("auto"), code, SEED, print)


@pytest.mark.parametrize(
    "written",
    seeds(["ci.directions[0].x = 2.0", "ci.chances[0] = 7", "ci.mapped[0].gap = -9.0"], 1),
)
def test_a_region_that_writes_to_a_table_fails_with_its_line_on_both_engines(tmp_path, written):
    code = edited(tmp_path, f"{written}\nreturn False")

    reference = ReferenceEngine(code, SEED)

    with open_engine(COMPILED, code, SEED) as engine:
        found = list(engine.evaluate_many([(), ()]))

    text = (code.directory / "collective_intelligence.py").read_text(encoding="utf-8")
    line = text.splitlines().index(f"    {written}") + 1
    for failure in (*found, *reference.evaluate_many([()])):
        assert f"collective_intelligence.py:{line}: " in failure.traceback


def test_code_that_was_loaded_again_since_still_compiles():
    first = paper_code(60)
    paper_code(60)

    with open_engine(COMPILED, first, SEED) as engine:
        assert traced(engine, ()) == traced(ReferenceEngine(first, SEED), ())


def flown(runtime: Path, mission: Path, cache: Path) -> list[str]:
    """Return the digests of both engines, with the runtime that lies in a folder."""
    done = subprocess.run(
        [sys.executable, "-c", FLY_EDITED, str(mission)],
        check=True,
        capture_output=True,
        encoding="utf-8",
        env={**os.environ, "PYTHONPATH": str(runtime), "MRSFI_CACHE": str(cache)},
        cwd=runtime,
    )
    found: list[str] = json.loads(done.stdout)
    return found


@night
def test_an_edited_kernel_compiles_anew(tmp_path):
    mission = small_mission(tmp_path / "mission").directory
    package = tmp_path / "src" / "mrsfi_runtime"
    shutil.copytree(Path(str(mrsfi_runtime.__file__)).parent, package)
    motion = package / "kernel" / "commands.py"
    text = motion.read_text(encoding="utf-8")
    way = "robot.x += command.heading_x * speed"
    assert text.count(way) == 1
    found = []

    for edited in (text, text.replace(way, f"{way} * 0.5"), text):
        motion.write_text(edited, encoding="utf-8")
        found.append(flown(package.parent, mission, tmp_path / "cache"))

    assert all(reference == compiled for reference, compiled in found)
    assert found[0] == found[2] != found[1]
