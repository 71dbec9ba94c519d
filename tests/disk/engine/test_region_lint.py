"""What the lint of regions says."""

from pathlib import Path

import pytest

from mrsfi_runtime.engine.region_lint import COMPILES_ALIKE, lint_regions, require_sound_regions
from mrsfi_runtime.errors import EvaluationError
from tests.support import lint_cases
from tests.support.edited import REGION
from tests.support.lint_cases import named, written
from tests.support.tree import ROOT

FILE = "collective_intelligence.py"
TEXT = """from mrsfi_runtime.api import State, kernel

# protected region imports on begin
{imports}
# protected region imports end

# protected region helpers on begin
{helpers}
# protected region helpers end


@kernel
def check_g1(ci: State) -> bool:
    # protected region g1.check on begin
    {body}
    # protected region g1.check end
"""
HELPED = "@kernel\ndef squared(x):\n    return x ** 2"
HELPER = "    return math.hypot(3.0, 4.0)"
FAR_AWAY = "math.hypot(1.0, 2.0) > 2.0"
NOWHERE = "        return nowhere(ci)"


def _write(folder: Path, body: str = "return True", imports: str = "", helpers: str = "") -> Path:
    text = TEXT.format(imports=imports, helpers=helpers, body=body)
    (folder / FILE).write_text(text, encoding="utf-8")
    return folder


def _line(path: Path, text: str) -> int:
    return path.read_text(encoding="utf-8").splitlines().index(text) + 1


def _messages(folder: Path, body: str, helpers: str = "") -> list[str]:
    _write(folder, body, "import math", helpers)
    return [found.message for found in lint_regions(folder)]


def test_where_nothing_was_generated_there_is_nothing_to_warn_of(tmp_path):
    assert lint_regions(tmp_path) == ()


@pytest.mark.parametrize(
    ("body", "imports", "line", "constraint"),
    [
        (f"return {FAR_AWAY}", "import math", f"    return {FAR_AWAY}", COMPILES_ALIKE),
        ("return (", "", "    return (", "RegionRuns"),
        (f"if ci.mission.tick < 0:\n{NOWHERE}\n    return True", "", NOWHERE, "RegionRuns"),
    ],
    ids=["differs", "no Python", "a name that is defined nowhere, although no flight reaches it"],
)
def test_what_is_found_has_file_line_region_cause_and_remedy(
    tmp_path, body, imports, line, constraint, approved
):
    _write(tmp_path, body, imports)

    (found,) = lint_regions(tmp_path)

    assert (found.path, found.element) == (tmp_path / FILE, "region 'g1.check'")
    assert found.line == _line(found.path, line)
    is_error = constraint == "RegionRuns"
    assert (found.constraint, found.severity == "error") == (constraint, is_error)
    approved(found.message)


def test_a_marked_function_of_the_helpers_is_looked_at(tmp_path):
    _write(tmp_path, imports="import math", helpers=f"@kernel\ndef far():\n{HELPER}")

    (found,) = lint_regions(tmp_path)

    assert found.element == "region 'helpers'"
    assert found.line == _line(found.path, HELPER)


def test_other_names_of_a_module_are_seen_through(tmp_path):
    for imports, call in (
        ("import math as m", "m.hypot(1.0, 2.0)"),
        ("from math import hypot", "hypot(1.0, 2.0)"),
        ("from math import hypot as far", "far(1.0, 2.0)"),
    ):
        _write(tmp_path, f"return {call} > 2.0", imports)

        assert [": found `" in found.message for found in lint_regions(tmp_path)] == [True]


def test_files_of_the_team_are_looked_at_as_deep_as_they_import(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    _write(tmp_path, "return near() > 2.0", "from team.near import near")
    team = tmp_path / "team"
    team.mkdir()
    head = "import math\nfrom mrsfi_runtime.api import kernel\n"
    (team / "__init__.py").write_text("")
    (team / "near.py").write_text(
        f"{head}from team.far import far\n\n@kernel\ndef near():\n    return far()\n"
    )
    (team / "far.py").write_text(f"{head}\n@kernel\ndef far():\n{HELPER}\n")

    (found,) = lint_regions(tmp_path)

    assert (found.path, found.line) == (team / "far.py", _line(team / "far.py", HELPER))
    assert found.element == "function 'far'"


def test_files_are_found_by_whatever_import_names_them(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    team = tmp_path / "team"
    team.mkdir()
    (team / "__init__.py").write_text("")
    text = f"import math\nfrom mrsfi_runtime.api import kernel\n\n@kernel\ndef near():\n{HELPER}\n"
    (team / "near.py").write_text(text)
    for imports in ("import team.near", "import team.near as near", "from team import near"):
        _write(tmp_path, imports=imports)

        assert [one.path for one in lint_regions(tmp_path)] == [team / "near.py"]


def test_files_that_import_each_other_are_looked_at_once(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    _write(tmp_path, "return a() > 2.0", "from team_a import a")
    head = "import math\nfrom mrsfi_runtime.api import kernel\n"
    for one, other in ("ab", "ba"):
        (tmp_path / f"team_{one}.py").write_text(
            f"{head}from team_{other} import {other}\n\n@kernel\ndef {one}():\n{HELPER}\n"
        )

    found = lint_regions(tmp_path)

    assert [one.path.name for one in found] == ["team_a.py", "team_b.py"]


def test_imports_are_found_without_running_them(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    _write(tmp_path, imports="from team import near\nfrom nowhere.at_all import far")
    (tmp_path / "team.py").write_text("raise SystemExit(1)\n")

    assert lint_regions(tmp_path) == ()


@pytest.mark.parametrize(
    ("body", "helpers"),
    [
        ("str = abs\n    return str(ci.robots[0].x) > 2.0", ""),
        ("n = ci.mission.tick\n    return n ** 2 + 2 ** 10 + ci.goals[0].count ** 3 > 1", ""),
        ("t = 0\n    for k in range(3):\n        t += k ** 2\n    return t > 1", ""),
        (
            "return squared(3) > 2",
            "@kernel\ndef squared(n: int) -> int:\n    return n ** 2",
        ),
        ("return True", f"FAR = math.hypot(3.0, 4.0) ** 2\n\n\ndef far():\n{HELPER}"),
    ],
    ids=[
        "a local name is not the builtin",
        "powers of whole numbers",
        "what a loop counts is a whole number",
        "an annotated argument has its kind",
        "code that no engine compiles",
    ],
)
def test_what_is_alike_on_every_engine_is_none_of_its_business(tmp_path, body, helpers):
    assert _messages(tmp_path, body, helpers) == []


def test_what_a_marked_helper_does_is_looked_at(tmp_path, approved):
    (message,) = _messages(tmp_path, "return squared(3) > 2", HELPED)

    approved(message)


def _errors(folder: Path, body: str, imports: str = "", helpers: str = "") -> list[str]:
    _write(folder, body, imports, helpers)
    return [found.message for found in lint_regions(folder) if found.severity == "error"]


def test_a_name_of_a_file_of_the_team_is_named_there(tmp_path, monkeypatch, approved):
    monkeypatch.syspath_prepend(tmp_path)
    _write(tmp_path, "return near()", "from team import near")
    (tmp_path / "team.py").write_text("def near():\n    return far()\n")

    (found,) = lint_regions(tmp_path)

    assert (found.path, found.line, found.element) == (tmp_path / "team.py", 2, "function 'near'")
    approved(found.message)


def test_names_that_python_or_the_file_define_are_none_of_these_errors(tmp_path):
    helpers = "LIMIT = 3\n\n\ndef far(n: int = LIMIT) -> int:\n    return [k for k in range(n)][-1]"

    assert _errors(tmp_path, "return far() > LIMIT or __name__ == ''", helpers=helpers) == []


GOALS = "from mrsfi_runtime.api import goal_tasks as goals"


FAR = "def far(state: State) -> bool:\n    return state.robots[0].far > 1.0"


@pytest.mark.parametrize(
    ("body", "more"),
    [
        ("return '%d %d' % (1,)", {}),
        ("return '{} {}'.format(1)", {}),
        ("return True\n    raise NotImplemented", {}),
        ("break", {}),
        ("return True\nreturn False", {}),
        ("return ci.robots[0].heading > 0.0", {}),
        ("robots = ci.robots\n    return robots[1].sped > 0", {}),
        ("for s in ci.sensors:\n        s.on = 1\n    return True", {}),
        ("return [r for r in ci.robots if r.on] == []", {}),
        ("q = [r.x for r in ci.robots]\n    return q == [r.on for r in ci.robots]", {}),
        ("return ci.robot[0].x > 0.0", {}),
        ("return ci.mission.time > 0", {}),
        ("return ci.goals[0].zzz > 0", {}),
        ("return far(ci)", {"helpers": FAR}),
        ("return goals.visit.violatd(ci, 0)", {"imports": GOALS}),
    ],
)
def test_what_no_engine_can_run_is_an_error(tmp_path, body, more, approved):
    (message,) = _errors(tmp_path, body, **more)

    approved(message)


def test_what_cannot_be_told_is_no_error(tmp_path):
    bodies = (
        "ci = anything()\n    return ci.whatever",
        "r = ci.robots[0]\n    r = anything()\n    return r.whatever",
        "r = ci.robots[0]\n    return [r.whatever for r in anything()]",
        "r = ci.robots[0]\n    return (lambda r: r.whatever)(anything())",
        "r, s = ci.robots[0], 1\n    return r.whatever",
        "with anything() as commands:\n        return commands.whatever",
        "return team.mission.whatever",
    )
    helpers = "import team\nfrom mrsfi_runtime.api import commands\n\n\ndef anything(): ..."

    assert [_errors(tmp_path, body, helpers=helpers) for body in bodies] == [[]] * len(bodies)


def test_unsound_regions_are_refused_with_every_error(tmp_path):
    _write(tmp_path, "return nowhere(ci) or never or math.hypot(1.0, 2.0) > 2.0", "import math")

    with pytest.raises(EvaluationError) as refused:
        require_sound_regions(tmp_path)

    place = f"{tmp_path / FILE}:15: region 'g1.check': found `"
    names = [line.removeprefix(place).partition("`")[0] for line in str(refused.value).split("\n")]
    assert names == ["never", "nowhere"]


def test_regions_with_warnings_alone_are_sound(tmp_path):
    require_sound_regions(_write(tmp_path, "return math.hypot(1.0, 2.0) > 2.0", "import math"))


@pytest.mark.parametrize("case", **named([*lint_cases.DIFFERENT, lint_cases.SUMS]))
def test_what_differs_is_warned_of(tmp_path, case):
    line = written(tmp_path, case)

    found = lint_regions(tmp_path)

    assert [(one.line, one.element, one.constraint) for one in found[:1]] == [
        (line, f"region '{REGION}'", COMPILES_ALIKE)
    ]
    assert {one.line for one in found} <= {line, line + 1}


@pytest.mark.parametrize("case", **named(lint_cases.CALLS))
def test_every_name_that_differs_is_known(tmp_path, case):
    line = written(tmp_path, case)

    found = lint_regions(tmp_path)

    assert [(one.line, one.constraint) for one in found] == [(line, COMPILES_ALIKE)]


@pytest.mark.parametrize("case", **named(lint_cases.ALIKE))
def test_what_is_alike_is_not_warned_of(tmp_path, case):
    written(tmp_path, case)

    assert lint_regions(tmp_path) == ()


def test_generated_code_has_nothing_to_warn_of():
    missions = [path.parent for path in ROOT.glob("generated/*/collective_intelligence.py")]

    assert len(missions) >= 3
    assert [lint_regions(mission) for mission in missions] == [()] * len(missions)
