"""Specifications that search found are written as models that load and validate again."""

from dataclasses import replace
from pathlib import Path

import pytest

from m2t.generate import rendered_file
from m2t.models.load import (
    inspect_folder,
    inspect_specification,
    load_mission_folder,
    load_specification,
    write_specification,
)
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.errors import SpecificationError
from mrsfi_runtime.generated_code import pool_from_text
from mrsfi_runtime.model.fault_types import Parameter, Range
from mrsfi_runtime.model.faults import Event, TimedFault, Trigger
from mrsfi_runtime.model.mission import Area, Coordinates
from tests.support.models.copies import FAULTS, copy_models, edit
from tests.support.triggers import in_xmi, with_triggers
from tests.support.world import paper_code

POOL = paper_code().pool
TIMED = (
    TimedFault("f9", 0, 10, (1.5, -3.0, *POOL["f9"].values[2:])),
    TimedFault("f14", 5, 999, (12.0,)),
    TimedFault("f9", 20, 20, POOL["f9"].values),
    TimedFault("f25", 3, 4, POOL["f25"].values),
)

WRITTEN = Path(__file__).with_name("written.xmi")


def _target(tmp_path: Path) -> Path:
    path = tmp_path / "critical" / "01.xmi"
    path.parent.mkdir()
    return path


def test_written_specification_reads_as_expected_loads_and_validates_again(tmp_path):
    path = _target(tmp_path)
    write_specification(copy_models(tmp_path), POOL, TIMED, path, identifier="critical_1")

    models = load_specification(path)

    assert path.read_bytes() == WRITTEN.read_bytes()
    assert inspect_specification(path).diagnostics == ()
    assert models.mission.name == "1000"
    assert [(fault.name, fault.start, fault.finish) for fault in models.faults.faults] == [
        ("f9", 0, 10),
        ("f14", 5, 999),
        ("f9", 20, 20),
        ("f25", 3, 4),
    ]


def test_bounds_of_the_pool_are_copied(tmp_path):
    folder, path = copy_models(tmp_path), _target(tmp_path)
    edit(folder / FAULTS, 'DELAY="200.0"', 'DELAY="200.0" DELAY_MAX="300.0"')

    write_specification(folder, POOL, (TimedFault("f8", 0, 1, (7.0,)),), path, identifier="s")

    assert '<delayMessage DELAY="7.0" DELAY_MAX="300.0">' in path.read_text(encoding="ascii")


def test_the_likelihood_of_the_pool_reaches_code_and_what_is_written(tmp_path):
    folder, path = copy_models(tmp_path), _target(tmp_path)
    edit(folder / FAULTS, 'ID="f8"', 'ID="f8" likelihood="1e-4"')

    timed = tuple(TimedFault(fault, 0, 1, POOL[fault].values) for fault in ("f8", "f9"))
    write_specification(folder, POOL, timed, path, identifier="s")

    pool = pool_from_text(rendered_file("fault_loader.py", load_mission_folder(folder)))
    written = pool_from_text(rendered_file("fault_loader.py", load_specification(path)))
    assert (pool["f8"].likelihood, pool["f9"].likelihood) == (1e-4, None)
    assert [fault.likelihood for fault in written] == [1e-4, None]


def test_what_waits_is_written_with_its_triggers_and_flies_as_in_the_pool(tmp_path):
    """An effect is that of all timed copies; what nothing waits for is left out."""
    folder = copy_models(tmp_path)
    code = with_triggers(paper_code())
    struck = Trigger("struck", Event.EFFECT, ("f9", "f5"), None, 2)
    triggers = (struck, *code.pool.triggers)
    pool = replace(code.pool, triggers=triggers)
    edit(folder / FAULTS, "</faults:F", f"{in_xmi(triggers)}</faults:F")
    waits = [trigger.id for trigger in triggers]
    faults = ("f9", "f9", "f14", "f30", "f2", "f8", "f28", "f29", "f21", "f26", "f1", "f5", "f20")
    timed = tuple(
        TimedFault(fault, 80 * n, 80 * n + 79, pool[fault].values, trigger)
        for n, (fault, trigger) in enumerate(zip(faults, ["", *waits], strict=False))
    )
    path = _target(tmp_path)

    write_specification(folder, pool, timed, path, identifier="s")

    assert inspect_folder(folder).diagnostics == ()
    assert pool_from_text(rendered_file("fault_loader.py", load_mission_folder(folder))) == pool
    models = load_specification(path)
    written = pool_from_text(rendered_file("fault_loader.py", models))
    assert [each.trigger for each in written.faults] == [each.trigger for each in timed]
    used = {each.trigger for each in timed}
    assert [each.id for each in written.triggers] == [each for each in waits if each in used]
    assert len(used) < len(triggers) + 1
    assert written.triggers_by_id["struck"].of == ("f9.1", "f9.2", "f5.1")
    engine = ReferenceEngine(code, 1)
    as_written = engine.evaluate(written.written_specification(), pool=written)
    assert as_written == engine.evaluate(timed, pool=pool)
    assert sum(applied > 0 for applied in as_written.applied) > 4


def test_an_area_of_the_mission_is_entered_as_one_of_the_trigger(tmp_path):
    folder, path = copy_models(tmp_path), _target(tmp_path)
    robot = '<triggers ID="t" event="ENTERED"><robot href="mission.xmi#r1"/>'
    at = f'{robot}<at href="mission.xmi#a8"/></triggers></faults:F'
    edit(folder / FAULTS, "</faults:F", at)

    timed = (TimedFault("f9", 0, 9, POOL["f9"].values, "t"),)
    write_specification(folder, POOL, timed, path, identifier="s")

    assert inspect_folder(folder).diagnostics == ()
    area = Area("a8", Coordinates(500.0, 500.0, 1.0), 40.0)
    for models in (load_mission_folder(folder), load_specification(path)):
        pool = pool_from_text(rendered_file("fault_loader.py", models))
        assert pool.triggers == (Trigger("t", Event.ENTERED, ("r1",), area),)
    assert '<at href="../models/uuv/mission.xmi#a8"/>' in path.read_text(encoding="ascii")


def test_empty_specification_loads_with_the_mission_beside_it(folder):

    write_specification(folder, POOL, (), folder / "empty.xmi", identifier="none")

    models = load_specification(folder / "empty.xmi")
    assert (models.faults.ID, list(models.faults.faults)) == ("none", [])


def test_folder_names_with_spaces_are_referred_to(tmp_path):
    folder = copy_models(tmp_path / "my missions # 1")
    path = _target(tmp_path)

    write_specification(folder, POOL, TIMED, path, identifier="s")

    assert "../my%20missions%20%23%201/models/uuv/mission.xmi#o5" in path.read_text()
    assert inspect_specification(path).diagnostics == ()


@pytest.mark.parametrize(
    "row",
    [
        TimedFault("f99", 0, 1),
        TimedFault("f9", 0, 1, (1.0,)),
        TimedFault("f9", 2, 1, POOL["f9"].values),
        TimedFault("f9", 1, 2, POOL["f9"].values, "low"),
    ],
)
def test_impossible_rows_are_errors_and_write_nothing(tmp_path, row, refused):
    path = _target(tmp_path)
    other = replace(POOL["f9"].kind, parameters=(Parameter("NEW_W", Range.X),))
    renamed = replace(POOL, faults=(replace(POOL["f9"], kind=other),))
    pool = renamed if len(row.values) == 1 else POOL

    with refused(SpecificationError):
        write_specification(copy_models(tmp_path), pool, (row,), path, identifier="s")

    assert not path.exists()
