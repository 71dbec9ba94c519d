"""Generation never loses hand-written code and never lets a model write code."""

import subprocess
import sys
from xml.sax.saxutils import quoteattr

import pytest

from m2t.generate import generate, stale
from mrsfi_runtime.errors import GenerationError, ModelError, ProtectedRegionError
from mrsfi_runtime.generated_code import load_code
from tests.support.models.copies import edit
from tests.support.models.generation import FILES, ROOT, contents, run_module

CODE = "    # written by hand\n    return ci.mission.tick > 3\n"
COLLECTIVE = "collective_intelligence.py"


def write_code(target, goal="g4"):
    default = f"    return goal_tasks.gather_samples.violated(ci, {goal.upper()})\n"
    edit(target / COLLECTIVE, default, CODE)


def body(target, region):
    text = (target / COLLECTIVE).read_text()
    begin = f"# protected region {region} on begin\n"
    end = f"    # protected region {region} end\n"
    return text[text.index(begin) + len(begin) : text.index(end)]


def goal_text(text: str, goal: str) -> str:
    start = text.index(f'  <goals ID="{goal}"')
    return text[start : text.index("</goals>\n", start) + len("</goals>\n")]


def test_code_survives_renaming_a_robot(models, target):
    write_code(target)
    edit(models / "mission.xmi", 'ID="r2" name="JEN"', 'ID="r2" name="Jenny the second"')

    result = generate(models, target)

    assert result.written == ("mission_loader.py", COLLECTIVE)
    assert body(target, "g4.check") == CODE
    assert "R2 = 1  # 'Jenny the second'\n" in (target / COLLECTIVE).read_text()


def test_code_survives_adding_a_goal_before_it(models, target):
    write_code(target)
    path = models / "mission.xmi"
    text = path.read_text()
    new = goal_text(text, "g2").replace('"g2"', '"g0"').replace('"a2"', '"a20"')
    for message in ("m4", "m5", "m6"):
        new = new.replace(f'"{message}"', f'"{message}0"')
    path.write_text(text.replace('  <goals ID="g1"', new + '  <goals ID="g1"'))

    generate(models, target)

    assert body(target, "g4.check") == CODE
    assert "G4 = 4\n" in (target / COLLECTIVE).read_text()
    assert [goal.id for goal in load_code(target).mission.goals][:2] == ["g0", "g1"]


def test_code_survives_reordering_goals(models, target):
    write_code(target)
    path = models / "mission.xmi"
    text = path.read_text()
    moved = goal_text(text, "g4")
    path.write_text(text.replace(moved, "").replace('  <goals ID="g1"', moved + '  <goals ID="g1"'))

    generate(models, target)

    code = load_code(target)
    assert body(target, "g4.check") == CODE
    assert body(target, "g1.check") == "    return goal_tasks.avoid_collision.violated(ci, G1)\n"
    assert [goal.id for goal in code.mission.goals] == ["g4", "g1", "g2", "g3", "g5", "g6"]
    text = (target / COLLECTIVE).read_text()
    assert text.index("check_g4(view)") < text.index("check_g1(view)")


def test_deleting_a_goal_with_code_stops_generation(models, target):
    write_code(target)
    path = models / "mission.xmi"
    text = path.read_text()
    path.write_text(text.replace(goal_text(text, "g4"), ""))
    edit_out_faults_of(models, "m10")
    before = contents(target)

    with pytest.raises(GenerationError) as caught:
        generate(models, target, force=True)

    assert caught.value.exit_code == 4
    assert f"{target / COLLECTIVE}:" in str(caught.value)
    assert "'g4.check' holds hand-written code, but element 'g4' is gone" in str(caught.value)
    assert contents(target) == before


def edit_out_faults_of(models, message):
    """Let the faults that refer to a message refer to another."""
    path = models / "faults.xmi"
    path.write_text(path.read_text().replace(f"mission.xmi#{message}", "mission.xmi#m11"))


def test_deleting_a_goal_without_code_removes_its_functions(models, target):
    path = models / "mission.xmi"
    text = path.read_text()
    path.write_text(text.replace(goal_text(text, "g4"), ""))
    edit_out_faults_of(models, "m10")

    generate(models, target)

    assert "g4" not in (target / COLLECTIVE).read_text()


def test_helpers_and_imports_survive_and_a_formatter_edits_nothing_outside_regions(models, target):
    path = target / COLLECTIVE
    begin = "# protected region {} on begin\n"
    edit(path, begin.format("imports"), begin.format("imports") + "import math\n")
    helper = "def half(x: float) -> float:\n    return math.fabs( x )/2\n"
    edit(path, begin.format("helpers"), begin.format("helpers") + helper)
    edit(path, "goal_tasks.gather_samples.violated(ci, G4)", "(half( ci.mission.tick )>1)")

    run_module("ruff", "format", "--config", ROOT / "pyproject.toml", target)

    assert body(target, "g4.check") == "    return half(ci.mission.tick) > 1\n"
    assert generate(models, target).written == ()
    load_code(target)


def test_edit_outside_regions_is_refused_unless_forced(models, target):
    write_code(target)
    edit(target / "simulation.py", "move(self.world, tick)", "move(self.world, tick)  # twice")

    with pytest.raises(ProtectedRegionError, match=r"simulation\.py:\d+: .*edited outside"):
        generate(models, target)
    with pytest.raises(ProtectedRegionError):
        stale(models, target)
    result = generate(models, target, force=True)

    assert result.written == ("simulation.py",)
    assert body(target, "g4.check") == CODE


def test_broken_marker_is_refused_with_file_and_line(models, target):
    write_code(target)
    edit(target / COLLECTIVE, "    # protected region g4.check end\n", "")
    before = contents(target)

    with pytest.raises(ProtectedRegionError, match=rf"{COLLECTIVE}:\d+: .*put the missing end"):
        generate(models, target, force=True)

    assert contents(target) == before


HOSTILE = [
    'x"); import os; os.system("touch owned")  #',
    "x'); import os; os.system('touch owned')  #",
    'x\n    import os; os.system("touch owned")\n#',
    '"""; import os; os.system("touch owned"); """',
    "{{ 7*7 }}{% raw %}{% for %}{# #}",
    "\n# protected region g1.check on begin\nraise SystemExit\n# protected region g1.check end\n",
    "# protected region helpers end",
    "\\",
    "\\N{DIGIT ONE}\\x41",
    "\u202egnitar\u2028x\u00e9\U0001f916",
    "noqa",
    "a # type: ignore # noqa",
]


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_names_are_only_ever_names(models, target, tmp_path, name):
    hostile = models.parent / "hostile"
    models.rename(hostile)
    for old in ('name="LEN"', 'name="1000"', 'name="GPS sensor of LEN"', 'name="Offshore server"'):
        edit(hostile / "mission.xmi", old, f"name={quoteattr(name)}".replace("\u2028", "&#x2028;"))
    edit(hostile / "faults.xmi", 'ID="f1" name="f1"', f'ID="f1" name={quoteattr(name)}')
    for file in ("mission.xmi", "faults.xmi"):
        text = (hostile / file).read_text()
        (hostile / file).write_bytes(text.encode("ascii", "xmlcharrefreplace"))
    folder = tmp_path / "hostile"

    generate(hostile, folder)

    code = load_code(folder)
    found = (
        code.mission.name,
        code.mission.robots[0].name,
        code.mission.robots[0].sensors[0].name,
        code.mission.servers[0].name,
        code.pool["f1"].name,
    )
    assert found == (name,) * 5
    assert not list(tmp_path.rglob("owned"))
    assert stale(hostile, folder) == ()
    assert body(folder, "g1.check") == body(target, "g1.check")
    run_module("ruff", "format", "--check", "--config", ROOT / "pyproject.toml", folder)


def test_hostile_code_leaves_no_trace_when_executed(models, tmp_path):
    name = 'x"); import os; os.system("touch owned")  #\n\'\'\'"""'
    edit(models / "mission.xmi", 'name="LEN"', f"name={quoteattr(name)}")
    folder = tmp_path / "out"
    generate(models, folder)

    for file in FILES:
        module = f"out.{file.removesuffix('.py')}"
        subprocess.run([sys.executable, "-B", "-m", module], cwd=tmp_path, check=True)

    assert sorted(path.name for path in folder.iterdir()) == sorted((*FILES, "manifest.json"))
    assert not (tmp_path / "owned").exists()


def test_huge_name_is_refused_clearly_or_stays_out_of_comments(models, tmp_path):
    edit(models / "mission.xmi", 'name="LEN"', f'name="{"x" * 10_000_000}"')
    folder = tmp_path / "out"

    try:
        generate(models, folder)
    except ModelError as error:
        message = str(error)
    else:
        message = "".join((folder / file).read_text() for file in FILES[1:])

    assert len(message) < 100_000
