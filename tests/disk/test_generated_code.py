"""The door to generated code: what it imports, and the fence around what a team wrote."""

import os
import shutil
import sys
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from types import ModuleType

import pytest

from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.engine.region_sources import imported_files
from mrsfi_runtime.errors import EvaluationError, GenerationError, UsageError, WorkerLost
from mrsfi_runtime.fence import importing
from mrsfi_runtime.generated_code import load_code, load_module
from mrsfi_runtime.model.mission import FailedFlight
from mrsfi_runtime.record.database import CampaignFolder
from tests.support.edited import COLLECTIVE, edited, indented, write_body
from tests.support.tree import ROOT

REGIONS = "collective_intelligence.py"
REACHED: dict[str, tuple[str, dict[str, str], set[str]]] = {
    "name": ("from team import A\n", {"team.py": "A = 1\n"}, {"team.py"}),
    "helper": (
        "import team\nA = team.A\n",
        {"team.py": "from deep import A\n", "deep.py": "A = 1\n", "other.py": ""},
        {"team.py", "deep.py"},
    ),
    "package": (
        "from pack.sub.leaf import A\n",
        {
            "pack/__init__.py": "",
            "pack/near.py": "A = 1\n",
            "pack/sub/__init__.py": "",
            "pack/sub/leaf.py": "from ..near import A\nfrom . import leaf\n",
        },
        {"pack/__init__.py", "pack/near.py", "pack/sub/__init__.py", "pack/sub/leaf.py"},
    ),
    "folder": (
        "import bare.leaf\nA = bare.leaf.A\n",
        {"bare/leaf.py": "A = 1\n"},
        {"bare/leaf.py"},
    ),
    "star": ("from team import *\n", {"team.py": "A = 1\n"}, {"team.py"}),
    "condition": (
        "try:\n    from fast import A\nexcept ImportError:\n    from team import A\n",
        {"team.py": "A = 1\n"},
        {"team.py"},
    ),
    "cycle": (
        "from one import A\n",
        {"one.py": "import two\nA = 1\n", "two.py": "import one\n"},
        {"one.py", "two.py"},
    ),
    "table": (
        "from team import A\n",
        {
            "team.py": "from pathlib import Path\n"
            "A = int(Path(__file__).with_name('a.txt').read_text())\n",
            "a.txt": "1",
        },
        {"team.py", "a.txt"},
    ),
    "library": ("import json, numpy, mrsfi_runtime.api\nA = 1\n", {"json.py": ""}, set()),
}  # fmt: skip
FOREVER = "while True:\n    pass"


def test_an_edit_of_the_same_size_in_the_same_second_is_seen(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    path = tmp_path / "team.py"
    found = []

    for text in ("SPEED = 4\n", "SPEED = 6\n"):
        path.write_text(text, encoding="utf-8")
        os.utime(path, (1_000_000_000, 1_000_000_000))
        found.append(load_module("edited_in_a_hurry", path).SPEED)
    del sys.modules["edited_in_a_hurry"]

    assert found == [4, 6]


def test_code_loaded_by_a_relative_path_knows_its_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("team.py").write_text("def speed():\n    return 4\n", encoding="utf-8")

    module = load_module("known_by_its_file", Path("team.py"))
    del sys.modules["known_by_its_file"]

    assert module.speed.__code__.co_filename == str(tmp_path / "team.py")


def test_code_of_another_version_is_told_apart_from_a_mistake(tmp_path, refused):
    path = tmp_path / "old.py"
    path.write_text("from mrsfi_runtime.api import reactions\n", encoding="utf-8")

    with refused(EvaluationError):
        load_module("of_another_version", path)


@pytest.mark.parametrize(
    "text",
    ['{"schema": 1}', '{"semantics": 99}', "[]", None],
)
def test_code_that_was_not_generated_for_todays_rules_is_not_loaded(tmp_path, text, refused):
    folder = shutil.copytree(ROOT / "generated" / "tight_margins", tmp_path / "code")
    (folder / "manifest.json").unlink()
    if text is not None:
        (folder / "manifest.json").write_text(text, encoding="utf-8")

    with refused(GenerationError):
        load_code(folder)


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder on Python's path, whose modules are forgotten afterwards."""
    before = {*sys.modules}
    monkeypatch.syspath_prepend(tmp_path / "project")
    yield tmp_path / "project"
    for name in {*sys.modules} - before:
        del sys.modules[name]


def write(folder: Path, files: Mapping[str, str]) -> Path:
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    return folder


def begun(folder: Path, project: Path, code: str, files: Mapping[str, str]) -> Path:
    """Return generated code with copies of what it imports from a project."""
    write(project, files)
    generated = write(folder / "source", {REGIONS: code})
    campaign = CampaignFolder(folder / "campaign")
    campaign.path.mkdir()
    campaign.fill(generated, generated, imported_files(generated))
    return campaign.generated


def loaded(generated: Path) -> ModuleType:
    return load_module(f"loaded_from_{generated.parent.parent.name}", generated / REGIONS)


@pytest.mark.parametrize("kind", REACHED)
def test_what_code_reaches_is_copied_and_imported_from_the_copies(kind, project, tmp_path):
    code, files, expected = REACHED[kind]
    generated = begun(tmp_path, project, code, files)

    write(project, dict.fromkeys(files, "A = 2\n"))
    copies = {file.relative_to(generated / "imported") for file in generated.rglob("*/*.*")}

    assert {path.as_posix() for path in copies} == expected
    assert loaded(generated).A == 1
    assert not {"team", "deep", "pack", "bare", "one", "two"} & set(sys.modules)


LATE = """
def late():
    import team, pack.leaf
    from pack import leaf
    return team.A + leaf.A
"""


def test_two_campaigns_and_the_project_each_have_their_own_modules(project, tmp_path):
    functions = []
    for number in (1, 2):
        texts = {"team.py": f"A = {number}\n", "pack/__init__.py": ""}
        late = "def later():\n    from .leaf import A\n    return A\n"
        texts |= {"pack/leaf.py": f"A = {number}0\n", "pack/later.py": late}
        code = f"from pack.later import later\n{LATE}"
        functions.append(loaded(begun(tmp_path / str(number), project, code, texts)))
    write(project, {"team.py": "A = 3\n", "pack/leaf.py": "A = 30\n"})

    import team

    assert [each.late() for each in (*functions, *functions)] == [11, 22, 11, 22]
    assert [each.later() for each in functions] == [10, 20]
    assert (team.A, sys.modules["team"]) == (3, team)


def test_what_no_import_statement_names_is_refused(project, tmp_path, refused):
    code = "import importlib\nA = importlib.import_module('te' 'am').A\n"
    generated = begun(tmp_path, project, code, {"team.py": "A = 1\n"})

    with refused(EvaluationError):
        loaded(generated)


def test_code_without_copies_imports_as_ever(project, tmp_path):
    write(project, {"team.py": "A = 1\n"})

    with importing(tmp_path):
        import team

    assert sys.modules["team"] is team


def fly(folder: Path, body: str = "return False", helpers: str = ""):
    """Fly the paper's mission with another body of a check, and other helpers."""
    code = edited(folder, "g1.check", indented(body))
    write_body(code / COLLECTIVE, "helpers", helpers)
    return ReferenceEngine(load_code(code), 1).evaluate(())


@pytest.fixture
def team(tmp_path, monkeypatch):
    """A module ``team`` that regions can import, forgotten again afterwards."""
    monkeypatch.syspath_prepend(tmp_path)
    yield tmp_path / "team.py"
    sys.modules.pop("team", None)


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ("raise SystemExit(0)", "SystemExit: 0"),
        ("import sys\nsys.exit()", "SystemExit: "),
        ("import os\nos._exit(0)", "SystemExit: 0"),
        ("raise GeneratorExit", "GeneratorExit: "),
        ("raise StopIteration", "StopIteration: "),
        ("class Odd(BaseException): pass\nraise Odd('x')", "Odd: x"),
        ("class Odd(Exception):\n    __str__ = exit\nraise Odd", "Odd: "),
        ("return fly(ci)", "NameError: name 'fly' is not defined"),
    ],
)
def test_whatever_a_region_raises_is_its_error(tmp_path, body, told):
    with pytest.raises(EvaluationError, match=rf"{COLLECTIVE}:\d+: .* at tick 0: ") as failed:
        fly(tmp_path, body)

    assert told in str(failed.value)


@pytest.mark.parametrize("end", ["return False", "raise ValueError"])
def test_the_working_folder_is_put_back_after_it(tmp_path, monkeypatch, end):
    place, away = tmp_path / "place", tmp_path / "away"
    away.mkdir()
    place.mkdir()
    monkeypatch.chdir(place)

    with suppress(EvaluationError):
        fly(
            tmp_path,
            f"import os\nos.chdir({str(away)!r})\n{end}",
            f"import os\nos.chdir({str(away)!r})",
        )

    assert Path.cwd() == place


@pytest.mark.parametrize("text", ["import sys\nsys.exit(0)\n", "raise GeneratorExit\n"])
def test_a_helper_that_ends_the_process_is_an_error_of_the_line_that_imports_it(
    tmp_path, team, text
):
    team.write_text(text, encoding="utf-8")

    with pytest.raises(EvaluationError, match=rf"{COLLECTIVE}:\d+: cannot be imported: \w+Exit"):
        fly(tmp_path, helpers="import team\n")


def test_under_faults_it_is_a_failed_evaluation_and_ctrl_c_is_none(tmp_path):
    code = load_code(edited(tmp_path, "g1.check", "    raise SystemExit(0)\n"))

    assert isinstance(ReferenceEngine(code, 1).attempt(()), FailedFlight)
    with pytest.raises(KeyboardInterrupt):
        fly(tmp_path / "other", "raise KeyboardInterrupt")


def test_a_belief_that_is_no_number_at_the_end_is_an_error_of_the_mission(tmp_path):
    body = "if ci.mission.tick == 999:\n    ci.servers = ci.robots[0].x = ''\nreturn False"

    with pytest.raises(EvaluationError, match=r"at tick 999: "):
        fly(tmp_path, body)


@pytest.mark.parametrize(
    ("body", "helpers"),
    [
        (FOREVER, ""),
        (f"try:\n    {FOREVER[:11]} pass\nexcept Exception:\n    return False", ""),
        ("return False", f"{FOREVER}\n"),
    ],
    ids=["region", "region that catches errors", "import"],
)
def test_code_that_gets_no_further_is_stopped_by_its_line(tmp_path, monkeypatch, body, helpers):
    monkeypatch.setenv("MRSFI_TIME_LIMIT", "0.5")

    with pytest.raises(WorkerLost, match=rf"{COLLECTIVE}:\d+: .*no progress for 0.5 s"):
        fly(tmp_path, body, helpers)


def test_what_time_has_stopped_is_no_result(tmp_path, monkeypatch):
    monkeypatch.setenv("MRSFI_TIME_LIMIT", "0.25")
    code = load_code(edited(tmp_path, "g1.check", indented(FOREVER)))

    with pytest.raises(WorkerLost):
        ReferenceEngine(code, 1).attempt(())


@pytest.mark.parametrize("seconds", ["1", "0"])
def test_what_gets_further_is_not_stopped(tmp_path, monkeypatch, seconds):
    monkeypatch.setenv("MRSFI_TIME_LIMIT", seconds)
    body = "import time\ntime.sleep(0.2 * (ci.mission.tick < 4))\nreturn False"

    assert fly(tmp_path, body).believed[0] == 0


def test_a_time_limit_that_is_none_is_told(tmp_path, monkeypatch):
    monkeypatch.setenv("MRSFI_TIME_LIMIT", "long")

    with pytest.raises(UsageError, match=r"MRSFI_TIME_LIMIT: found 'long'; expected seconds"):
        fly(tmp_path)


@pytest.mark.parametrize("kept", [0, 16, 40])
def test_damaged_bytecode_is_made_anew(tmp_path, monkeypatch, kept):
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    path = tmp_path / "damaged_team.py"
    path.write_text("SPEED = 4\n", encoding="utf-8")
    load_module("damaged_team", path)
    (cached,) = tmp_path.glob("__pycache__/*.pyc")
    cached.write_bytes(cached.read_bytes()[:kept])

    module = load_module("damaged_team", path)
    del sys.modules["damaged_team"]

    assert module.SPEED == 4
