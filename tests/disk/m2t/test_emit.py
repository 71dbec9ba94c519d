"""Writing generated files: nothing is lost, whenever a crash comes."""

import json
from pathlib import Path

import pytest

from m2t.emit import MANIFEST, GenerationPlan, plan_files
from m2t.generate import generate
from mrsfi_runtime.errors import GenerationError, ProtectedRegionError
from mrsfi_runtime.files import changing
from tests.support.crashes import crash_after
from tests.support.tree import ROOT

REGION = """
# protected region {name} on begin
{body}
# protected region {name} end
"""


def rendered(version: int, *, names=("a.py", "b.py", "c.py")) -> dict[str, str]:
    """Return files whose skeletons and default bodies differ from version to version."""
    return {
        name: f"# {name} {version}\n" + REGION.format(name="g1", body=f"default = {version}")
        for name in names
    }


def emit(target: Path, files: dict[str, str], *, force: bool = False) -> GenerationPlan:
    with changing(target.parent) as change:
        plan = plan_files(target, files, {"mission.xmi": "hash"}, force=force)
        change.replace(plan.changes)
    return plan


def names(plan: GenerationPlan) -> tuple[tuple[str, ...], ...]:
    return plan.written, plan.unchanged, plan.removed


def contents(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in folder.iterdir() if path.suffix == ".py"}


@pytest.fixture
def target(tmp_path: Path) -> Path:
    return tmp_path / "generated" / "mission"


def test_files_and_manifest_are_written(target):
    result = emit(target, rendered(1))

    assert names(result) == (("a.py", "b.py", "c.py"), (), ())
    assert contents(target) == rendered(1)
    assert sorted(json.loads((target / MANIFEST).read_text())["files"]) == ["a.py", "b.py", "c.py"]
    assert [path.name for path in target.parent.iterdir()] == ["mission"]


def test_second_run_touches_nothing(target):
    emit(target, rendered(1))
    before = {path: path.stat().st_mtime_ns for path in (target, *target.iterdir())}

    result = emit(target, rendered(1))

    assert names(result) == ((), ("a.py", "b.py", "c.py"), ())
    assert {path: path.stat().st_mtime_ns for path in (target, *target.iterdir())} == before


def test_only_changed_files_are_replaced(target):
    emit(target, rendered(1))
    inode = (target / "a.py").stat().st_ino

    result = emit(target, rendered(1) | {"b.py": "# b.py 2\n"})

    assert names(result) == (("b.py",), ("a.py", "c.py"), ())
    assert (target / "a.py").stat().st_ino == inode


def test_file_that_is_no_longer_generated_is_removed(target):
    emit(target, rendered(1))
    (target / "mine.py").write_text("x = 1\n")

    result = emit(target, rendered(1, names=("a.py",)))

    assert names(result) == ((), ("a.py",), ("b.py", "c.py"))
    assert sorted(contents(target)) == ["a.py", "mine.py"]


@pytest.mark.parametrize("edit", [("default", "my"), ("# b.py", "# mine")])
def test_file_with_hand_written_code_is_never_removed(target, edit, refused):
    emit(target, rendered(1))
    path = target / "b.py"
    path.write_text(path.read_text().replace(*edit))

    with refused(ProtectedRegionError):
        emit(target, rendered(1, names=("a.py",)), force=True)

    assert sorted(contents(target)) == ["a.py", "b.py", "c.py"]


def test_nothing_is_written_when_one_file_is_refused(target, refused):
    emit(target, rendered(1))
    path = target / "c.py"
    path.write_text(path.read_text().replace("# c.py", "# mine"))
    before = contents(target)

    with refused(ProtectedRegionError):
        emit(target, rendered(2))

    assert contents(target) == before


def test_without_manifest_equal_files_are_taken_over(target):
    emit(target, rendered(1))
    (target / MANIFEST).unlink()

    assert names(emit(target, rendered(1))) == ((), ("a.py", "b.py", "c.py"), ())
    assert (target / MANIFEST).exists()


def test_carriage_returns_are_neither_edits_nor_changes(target):
    emit(target, rendered(1))
    path = target / "a.py"
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))

    assert emit(target, rendered(1)).written == ()
    assert emit(target, rendered(2)).written == ("a.py", "b.py", "c.py")
    assert contents(target) == rendered(2)
    assert b"\r" not in path.read_bytes()


def test_edited_region_with_carriage_returns_keeps_its_code(target):
    emit(target, rendered(1))
    path = target / "a.py"
    code = path.read_bytes().replace(b"default = 1", b"x = 1\n\n\ny = 2")
    path.write_bytes(code.replace(b"\n", b"\r\n"))

    emit(target, rendered(2))

    assert path.read_text() == rendered(2)["a.py"].replace("default = 2", "x = 1\n\n\ny = 2")


def test_file_that_is_no_text_is_refused(target, refused):
    emit(target, rendered(1))
    (target / "a.py").write_bytes(b"\xff\xfe")

    with refused(GenerationError):
        emit(target, rendered(1))


@pytest.mark.parametrize("first", [0, 5, 11, 13, 15])
@pytest.mark.parametrize("second", [7, 12, 14, 16])
def test_crashed_generations_are_not_mistaken_for_edits(target, first, second):
    emit(target, rendered(1))
    path = target / "b.py"
    path.write_text(path.read_text().replace("default = 1", "hand_written = 1"))
    for version, n_steps in ((2, first), (3, second)):
        with crash_after(n_steps):
            emit(target, rendered(version))

    emit(target, rendered(4))

    expected = rendered(4)
    expected["b.py"] = expected["b.py"].replace("default = 4", "hand_written = 1")
    assert contents(target) == expected
    assert plan_files(target, rendered(4), {"mission.xmi": "hash"}).stale == ()


def test_folder_that_cannot_be_made_is_an_error_of_generation(tmp_path, refused):
    (tmp_path / "there").write_text("a file where a folder is needed")

    with refused(GenerationError):
        generate(ROOT / "models" / "uuv_sampling", tmp_path / "there")
