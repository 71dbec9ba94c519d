"""The compiled engine finds what the reference engine finds, bit for bit."""

import subprocess
import sys
from dataclasses import replace
from itertools import islice
from uuid import uuid4

import pytest

from mrsfi_runtime.engine.reference import ReferenceEngine
from mrsfi_runtime.engine.settings import EngineSettings
from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.mission import load_code
from tests.support.cli import edit
from tests.support.edited import COLLECTIVE, indented, write_body
from tests.support.models.shapes import small_mission
from tests.support.modules import old_modules  # noqa: F401 - a fixture
from tests.support.trace import traced
from tests.support.tree import ROOT
from tests.support.world import paper_code, specifications
from tests.tiers import seeds, slow

SEED = 3
N_SPECIFICATIONS = 1000
COMPILED = EngineSettings("compiled")


@pytest.mark.parametrize("n", [60, pytest.param(1000, marks=slow)])
def test_random_specifications_on_the_papers_mission_give_the_same_outcomes(n):
    code = paper_code(120)
    reference = ReferenceEngine(code, SEED)
    drawn = specifications(code, n)

    with COMPILED.open(code, SEED, 2) as engine:
        outcomes = list(engine.evaluate_many(drawn))

    assert outcomes == [reference.evaluate(specification) for specification in drawn]


FLY = """
import sys
from pathlib import Path
from mrsfi_runtime.engine.settings import EngineSettings
from mrsfi_runtime.mission import load_code
with EngineSettings("compiled").open(load_code(Path(sys.argv[1])), 1) as engine:
    engine.evaluate(())
(name,) = (name for name in sys.modules if name.startswith("mrsfi_compiled_"))
print(sum(sys.modules[name].fly_many.stats.cache_misses.values()))
"""


@slow
def test_of_two_processes_one_compiles_a_mission_and_the_other_waits(tmp_path, monkeypatch):
    monkeypatch.setenv("MRSFI_CACHE", str(tmp_path))
    command = [sys.executable, "-c", FLY, str(ROOT / "generated" / "tight_margins")]
    processes = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(2)]

    printed = [process.communicate(timeout=240)[0] for process in processes]

    assert sorted(printed) == ["0\n", "1\n"]


REGION = "g0.check"


def edited(folder, body, imports=""):
    """Return code of a small mission with one goal, the check of which has another body."""
    path = small_mission(folder).directory / COLLECTIVE
    write_body(path, REGION, indented(body))
    marker = "# protected region imports on begin\n"
    edit(path, marker, marker + imports)
    return load_code(path.parent)


@slow
def test_a_region_may_use_lists_sorting_and_nested_loops(tmp_path):
    body = (
        "xs = sorted([robot.x for robot in ci.robots])\n"
        "total = 0.0\n"
        "for k in range(len(xs)):\n"
        "    total += xs[k] / (k + 1)\n"
        "return total > 10.0 or min(xs) < -100.0"
    )
    code = edited(tmp_path, body)

    with COMPILED.open(code, SEED) as engine:
        assert traced(engine, ()) == traced(ReferenceEngine(code, SEED), ())


@slow
def test_a_region_that_divides_by_zero_fails_with_its_line_and_spares_the_others(tmp_path):
    body = "return 1 // (ci.sensors[0].active - 1 + ci.sensors[0].count * 0) > 5"
    code = edited(tmp_path, body)
    reference = ReferenceEngine(code, SEED)
    drawn = [(), *specifications(code, 6)]

    with COMPILED.open(code, SEED) as engine:
        found = list(engine.evaluate_many(drawn))
        for fly in (engine.evaluate, engine.record):
            with pytest.raises(EvaluationError, match=r"telligence.py:\d+: .*division"):
                fly(())

    expected = list(reference.evaluate_many(drawn))
    assert [type(one) for one in found] == [type(one) for one in expected]
    assert "ZeroDivisionError" in found[0].traceback


@slow
def test_a_region_that_reads_beyond_a_list_fails_as_in_python(tmp_path):
    code = edited(tmp_path, "return ci.robots[len(ci.robots) + 7].x > 0.0")

    with COMPILED.open(code, SEED) as engine, pytest.raises(EvaluationError, match="IndexError"):
        engine.evaluate(())


@slow
@pytest.mark.parametrize("is_cached", [False, True])
def test_a_region_may_raise_an_error_of_its_own_with_values(tmp_path, is_cached):
    tick = "int(ci.mission.tick) + 41"
    body = f"if ci.mission.tick == 1:\n    raise ValueError('seen', {tick})\nreturn False"
    code = edited(tmp_path, body)
    if is_cached:
        command = [sys.executable, "-c", FLY, str(code.directory)]
        assert b"seen" in subprocess.run(command, capture_output=True, check=False).stderr

    with COMPILED.open(code, SEED) as engine:
        [found] = engine.evaluate_many([()])

    assert "failed at tick 1: ValueError: ('seen', 42)" in found.traceback


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("return any(robot.x > 1.0 for robot in ci.robots)", "use of yield"),
        ("return unmarked(ci)", "'unmarked' is not marked @kernel"),
        ("return LIMITS['x'] > 1", "'LIMITS' is a global dict"),
        ("with open(__file__) as file:\n    return True", "with"),
        ("import math\nreturn math.pi > 3.0", "IMPORT_NAME"),
    ],
)
def test_a_region_that_cannot_be_compiled_is_named_with_its_line(tmp_path, body, expected):
    imports = "LIMITS = {'x': 2}\n\n\ndef unmarked(ci):\n    return True\n"
    code = edited(tmp_path, body, imports)
    line = 1 + (code.directory / "collective_intelligence.py").read_text().splitlines().index(
        f"    # protected region {REGION} on begin"
    )
    told = []

    with pytest.raises(EvaluationError) as error:
        COMPILED.open(code, SEED)
    auto = EngineSettings("auto").tried(code, SEED, told.append)

    path, place, *_ = str(error.value).split(":")
    assert path.endswith("collective_intelligence.py")
    assert line < int(place) <= line + body.count("\n") + 1
    assert f"region {REGION} cannot be compiled" in str(error.value)
    assert expected in str(error.value)
    assert auto == EngineSettings("reference")
    assert str(error.value) in told[0]


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
        COMPILED.open(code, SEED)
    with pytest.raises(EvaluationError, match=f"failed at tick 0: {flown}"):
        EngineSettings("auto").tried(code, SEED, print)


HEAD = "from mrsfi_runtime.api import kernel\n\n\n@kernel\n"
IMPORTED = {
    "an edited import": {"team_limits": f"{HEAD}def limit():\n    return {{}}\n"},
    "what an import imports, known by its constants": {
        "team_inner": f"import team_numbers\n{HEAD}def inner():\n    return team_numbers.LIMIT\n",
        "team_limits": f"import team_inner\n{HEAD}def limit():\n    return team_inner.inner()\n",
        "team_numbers": "LIMIT = {}\n",
    },
}


@slow
@pytest.mark.parametrize("modules", IMPORTED.values(), ids=IMPORTED)
def test_what_was_edited_compiles_anew(tmp_path, monkeypatch, modules):
    monkeypatch.syspath_prepend(str(tmp_path))
    counts = []
    for value in ("-1.0e9", "1.0e9"):
        for name, text in modules.items():
            (tmp_path / f"{name}.py").write_text(text.format(value), encoding="utf-8")
        body = "return ci.robots[0].x > team_limits.limit()"
        code = edited(tmp_path / value, body, "import team_limits\n")
        with COMPILED.open(code, SEED) as engine:
            counts.append(engine.evaluate(()).believed[0])
        for name in modules:
            del sys.modules[name]

    assert counts == [40, 0]


def test_threads_and_chunks_change_nothing():
    code = paper_code(60)
    drawn = specifications(code, 150)

    results = []
    for n_threads in (1, 2, 3):
        with COMPILED.open(code, SEED, n_threads) as engine:
            results.append(list(engine.evaluate_many(drawn)))
            results.append(list(islice(engine.evaluate_many(drawn), 150)))

    assert all(result == results[0] for result in results)


@pytest.fixture
def checked(monkeypatch):
    """Mission seeds of the flights on the reference engine."""
    seeds = []
    evaluate = ReferenceEngine.evaluate

    def counted(engine, specification, seed=None, **others):
        seeds.append(engine.seed if seed is None else seed)
        return evaluate(engine, specification, seed, **others)

    monkeypatch.setattr(ReferenceEngine, "evaluate", counted)
    return seeds


@pytest.fixture
def unchecked(tmp_path, old_modules):  # noqa: F811 - a fixture
    """Code of a mission that nothing is remembered of."""
    return renamed(edited(tmp_path, "return ci.robots[0].x > 31.0"))


def renamed(code):
    """Return code of a mission with a name that no other has."""
    return replace(code, mission=replace(code.mission, name=uuid4().hex))


def campaign(code, drawn):
    """Try a mission out and evaluate on three mission seeds, as commands do."""
    with EngineSettings("auto").tried(code, SEED, print).open(code, SEED) as engine:
        return [list(engine.evaluate_many(drawn, seed)) for seed in (1, 2, SEED)]


@slow
def test_what_is_compiled_is_tried_and_checked_once_for_all_seeds_and_campaigns(checked, unchecked):
    drawn = specifications(unchecked, 3)

    first = campaign(unchecked, drawn)

    assert checked == [SEED, 1, 1]
    assert campaign(unchecked, drawn) == first
    assert checked == [SEED, 1, 1]


def test_a_mission_that_is_known_to_fly_alone_is_checked(checked, unchecked):
    EngineSettings("auto").tried(unchecked, SEED, print)
    EngineSettings("auto").tried(unchecked, SEED, print)
    assert checked == [SEED]

    campaign(unchecked, specifications(unchecked, 2))
    assert checked == [SEED, 1, 1]


def test_a_mission_that_is_known_to_compile_alike_alone_is_tried(checked, unchecked):
    with COMPILED.open(unchecked, SEED) as engine:
        list(engine.evaluate_many(specifications(unchecked, 2)))
    assert checked == [SEED, SEED]

    campaign(unchecked, specifications(unchecked, 2))
    assert checked == [SEED, SEED, SEED]


@pytest.mark.parametrize("drawn", [[()], [(), ()]], ids=["one", "without faults"])
def test_a_check_of_little_is_not_remembered(checked, unchecked, drawn):
    campaign(unchecked, drawn)
    campaign(unchecked, drawn)

    checks = [1] * len(drawn)
    assert checked == [SEED, *checks, *checks]


def test_what_was_found_to_differ_is_found_again_and_again(tmp_path):
    code = renamed(edited(tmp_path, "return (ci.mission.tick + 2) * 9000000000000000000 > 0"))

    for _ in range(2):
        with pytest.raises(EvaluationError, match="the reference engine has"):
            campaign(code, specifications(code, 2))


def test_a_region_that_compiles_to_something_else_stops_the_search(tmp_path):
    code = edited(tmp_path, "return (ci.mission.tick + 2) * 9000000000000000000 > 0")

    with (
        COMPILED.open(code, SEED) as engine,
        pytest.raises(EvaluationError, match="the reference engine has"),
    ):
        list(engine.evaluate_many([()]))


def test_a_region_that_fails_only_where_it_is_not_compiled_stops_the_search(tmp_path):
    code = edited(tmp_path, "return math.sqrt(-1.0 - ci.mission.tick) > 0.0", "import math\n")

    with (
        COMPILED.open(code, SEED) as engine,
        pytest.raises(EvaluationError, match=r"collective_intelligence.py:\d+: .*math domain"),
    ):
        list(engine.evaluate_many([()]))
    with pytest.raises(EvaluationError, match="math domain"):
        EngineSettings("auto").tried(code, SEED, print)


@pytest.mark.parametrize(
    "written",
    seeds(["ci.directions[0].x = 2.0", "ci.chances[0] = 7", "ci.mapped[0].gap = -9.0"], 1),
)
def test_a_region_that_writes_to_a_table_fails_with_its_line_on_both_engines(tmp_path, written):
    code = edited(tmp_path, f"{written}\nreturn False")

    reference = ReferenceEngine(code, SEED)

    with COMPILED.open(code, SEED) as engine:
        found = list(engine.evaluate_many([(), ()]))

    text = (code.directory / "collective_intelligence.py").read_text(encoding="utf-8")
    line = text.splitlines().index(f"    {written}") + 1
    for failure in (*found, *reference.evaluate_many([()])):
        assert f"collective_intelligence.py:{line}: " in failure.traceback


def test_code_that_was_loaded_again_since_still_compiles():
    first = paper_code(60)
    paper_code(60)

    with COMPILED.open(first, SEED) as engine:
        assert traced(engine, ()) == traced(ReferenceEngine(first, SEED), ())
