"""Generation never loses hand-written code and never lets a model write code."""

from xml.sax.saxutils import quoteattr

import pytest

from m2t.generate import generate, plan
from mrsfi_runtime.generated_code import load_code
from tests.support.models.copies import edit
from tests.support.models.generation import ROOT, run_module

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
    quoted = quoteattr(name)
    rated = f'ID="g1" integrityLevel={quoted} rationale={quoted} requirements="G1"'
    edit(hostile / "mission.xmi", 'ID="g1"', rated)
    required = f'<requirements ID="G1" text={quoted}/>'
    edit(hostile / "mission.xmi", "<goals ", f"{required}<goals ")
    edit(hostile / "faults.xmi", 'ID="f1" name="f1"', f'ID="f1" name={quoted} reference={quoted}')
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
        code.pool["f1"].reference,
        code.mission.goals[0].integrity_level,
        code.mission.goals[0].rationale,
        code.mission.requirements[0].text,
    )
    assert found == (name,) * 9
    assert not list(tmp_path.rglob("owned"))
    assert plan(hostile, folder).stale == ()
    assert body(folder, "g1.check") == body(target, "g1.check")
    run_module("ruff", "format", "--check", "--config", ROOT / "pyproject.toml", folder)
