"""What code imports is found without running it, copied, and imported from the copies."""

import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import ModuleType

import pytest

from mrsfi_runtime.engine.region_sources import imported_files
from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.fence import importing
from mrsfi_runtime.generated_code import load_module
from mrsfi_runtime.record.database import CampaignFolder

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
