"""The page on editing models keeps its word: its scripts run, and change what they say."""

import difflib
import os
import re
import subprocess
import sys

from m2t.generate import generate
from m2t.models.load import load_mission_folder
from tests.support.models.generation import ROOT, contents

PAGE = (ROOT / "docs" / "editing-models.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)


def run(script, folder):
    """Run a script in a folder that has models of its own."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, "-c", script], cwd=folder, env=environment, check=True)


def changed_lines(before, after):
    """Return removed and added lines by file, without those of the manifest's hashes."""
    return {
        name: [
            line
            for line in difflib.unified_diff(
                before[name].splitlines(), after[name].splitlines(), n=0, lineterm=""
            )
            if not line.startswith(("---", "+++", "@@"))
        ]
        for name in before
        if before[name] != after[name] and name != "manifest.json"
    }


def test_script_is_ten_lines_and_changes_one_line_of_model_and_code(tmp_path, models, target):
    before, code = contents(models), contents(target)

    run(BLOCKS[0], tmp_path)
    generate(models, target)

    assert len([line for line in BLOCKS[0].splitlines() if line]) == 10
    assert changed_lines(before, contents(models)) == {
        "mission.xmi": [
            '-  <robots ID="r2" name="JEN" speed="4.0">',
            '+  <robots ID="r2" name="JEN" speed="6.0">',
        ]
    }
    assert changed_lines(code, contents(target)) == {
        "mission_loader.py": ["-                speed=4.0,", "+                speed=6.0,"]
    }


def test_new_elements_stand_in_the_models(tmp_path, models):
    before = contents(models)

    run("".join(BLOCKS[:2]), tmp_path)

    changes = changed_lines(before, contents(models))
    assert changes["mission.xmi"][2:] == [
        '+    <batteries ID="b7" name="Spare battery of JEN" totalEnergy="500.0"/>'
    ]
    assert changes["faults.xmi"] == [
        '+  <faults ID="f31" name="f31">',
        "+    <stopRobot>",
        '+      <affectedRobot href="mission.xmi#r2"/>',
        "+    </stopRobot>",
        "+  </faults>",
    ]
    assert len(load_mission_folder(models).faults.faults) == 31


def test_scripts_of_the_page_satisfy_the_type_checker(tmp_path):
    script = tmp_path / "script.py"
    script.write_text("".join(BLOCKS), encoding="utf-8")

    checked = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", f"--cache-dir={tmp_path}", script],
        cwd=ROOT,
        check=False,
        capture_output=True,
        text=True,
    )

    assert checked.returncode == 0, checked.stdout + checked.stderr
