"""Work grows as the models do: counted in calls, because seconds say more of the machine."""

import re
import sys
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

from m2t.generate import plan
from m2t.models.fixes import mend
from m2t.models.load import inspect_folder
from tests.support.models.copies import FAULTS, copy_models
from tests.support.models.shapes import shape, write_drawn


def _n_calls(work: Callable[[], Any]) -> int:
    """Return how many functions of Python are called."""
    count = 0

    def counted(frame: Any, event: str, argument: Any) -> None:
        nonlocal count
        count += event == "call"

    before = sys.getprofile()
    sys.setprofile(counted)
    try:
        work()
    finally:
        sys.setprofile(before)
    return count


def _with_faults(folder: Path, n_faults: int) -> Path:
    """Return a mission folder whose faults all finish before they start."""
    models = copy_models(folder)
    path = models / FAULTS
    text = path.read_text(encoding="utf-8")
    fault = re.search(r'  <faults ID="f2".*?</faults>\n', text, re.DOTALL)
    assert fault is not None
    one = fault[0].replace('name="f2"', 'name="f2" start="9" finish="8"')
    many = "".join(one.replace('ID="f2"', f'ID="more{n}"') for n in range(n_faults))
    path.write_text(text.replace(fault[0], fault[0] + many), encoding="utf-8")
    return models


def test_a_plan_of_generation_grows_as_the_fleet(tmp_path):
    calls = []
    for n_robots in (15, 15, 60):  # the first fills caches
        rng, of = Random(1), shape(n_robots, 3)
        folder = tmp_path / str(len(calls))
        models = write_drawn(folder, rng, of, 100)
        calls.append(_n_calls(lambda at=models: plan(at, at / "fresh")))

    assert calls[2] < 4.5 * calls[1]


def test_mending_grows_as_the_defects(tmp_path):
    calls = []
    for n_faults in (100, 100, 400):
        inspection = inspect_folder(_with_faults(tmp_path / str(len(calls)), n_faults))
        calls.append(_n_calls(lambda found=inspection: mend(found)))
        assert len(inspection.diagnostics) == n_faults

    assert calls[2] < 4.5 * calls[1]
