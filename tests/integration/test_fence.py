"""Regions that loop for ever, or raise anything, in other processes and in machine code."""

import re
import subprocess
import sys
from contextlib import closing

import pytest

from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.engine.pools import WorkerPool
from mrsfi_runtime.errors import WorkerLost
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.engine_settings import COMPILED, EngineSettings
from tests.support.edited import edited
from tests.tiers import night, slow

MOVED = (TimedFault("f9", 5, 50, (0.0, 0.0, 0.0)),)
"""A fault that moves an obstacle on the map, which regions here look at."""

FOREVER = "    while ci.map.is_wrong:\n        pass\n    return False\n"


@pytest.fixture
def limited(monkeypatch):
    monkeypatch.setenv("MRSFI_TIME_LIMIT", "1")


@slow
@pytest.mark.usefixtures("limited")
def test_a_worker_that_gets_no_further_ends_the_evaluation(tmp_path):
    code = load_code(edited(tmp_path, "g1.check", FOREVER))

    with (
        WorkerPool(code, 1, 2, EngineSettings()) as pool,
        pytest.raises(WorkerLost, match=r":\d+: .* at tick 5: "),
    ):
        list(pool.evaluate_many([MOVED, ()]))


FLY = """
import sys
from pathlib import Path
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.record.engine_settings import COMPILED, EngineSettings
from mrsfi_runtime.errors import WorkerLost
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.faults import TimedFault

late = (TimedFault("f9", 700, 750, (0.0, 0.0, 0.0)),)
engine = open_engine(EngineSettings(COMPILED), load_code(Path(sys.argv[1])), 1, 2)
for fly in (lambda: list(engine.evaluate_many([(), late])), lambda: engine.record(late)):
    try:
        fly()
    except WorkerLost as error:
        print(error)
"""
"""Ends with two threads in machine code that nothing stops but the end of their process."""


@night
@pytest.mark.usefixtures("limited")
def test_machine_code_that_gets_no_further_is_given_up(tmp_path):
    there = FOREVER.replace("is_wrong", "is_wrong and ci.obstacles[4].y == 0.0")
    folder = edited(tmp_path, "g1.check", there)  # where no fault of the pool puts it

    done = subprocess.run(
        [sys.executable, "-c", FLY, str(folder)], capture_output=True, text=True, check=True
    )

    several, one = done.stdout.splitlines()
    for said in (several, one):
        assert re.search(r": compiled, .* at tick (699|700): .* tells the line", said)


@slow
@pytest.mark.usefixtures("limited")
def test_a_region_that_gets_no_further_is_named_before_machine_code_is_relied_on(tmp_path):
    code = load_code(edited(tmp_path, "g1.check", FOREVER))

    with (
        closing(open_engine(EngineSettings(COMPILED), code, 1)) as engine,
        pytest.raises(WorkerLost, match=r":\d+: the mission stopped at tick 0: TimeLimitReached"),
    ):
        engine.evaluate(())
