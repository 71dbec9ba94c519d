"""Who edits the kernel sees it in the compiled engine at once, though compiled code is kept."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import mrsfi_runtime
from tests.support.models.shapes import small_mission
from tests.tiers import night

FLY = """
import json, sys
from pathlib import Path
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.record.engine_settings import EngineSettings
from mrsfi_runtime.generated_code import load_code

code = load_code(Path(sys.argv[1]))
found = []
for name in ("reference", "compiled"):
    with open_engine(EngineSettings(name), code, 3) as engine:
        found.append(engine.evaluate(()).digest)
print(json.dumps(found))
"""


def flown(runtime: Path, mission: Path, cache: Path) -> list[str]:
    """Return the digests of both engines, with the runtime that lies in a folder."""
    done = subprocess.run(
        [sys.executable, "-c", FLY, str(mission)],
        check=True,
        capture_output=True,
        encoding="utf-8",
        env={**os.environ, "PYTHONPATH": str(runtime), "MRSFI_CACHE": str(cache)},
        cwd=runtime,
    )
    found: list[str] = json.loads(done.stdout)
    return found


@night
def test_an_edited_kernel_compiles_anew(tmp_path):
    mission = small_mission(tmp_path / "mission").directory
    package = tmp_path / "src" / "mrsfi_runtime"
    shutil.copytree(Path(str(mrsfi_runtime.__file__)).parent, package)
    motion = package / "kernel" / "motion.py"
    text = motion.read_text(encoding="utf-8")
    way = "robot.x += command.heading_x * speed"
    assert text.count(way) == 1
    found = []

    for edited in (text, text.replace(way, f"{way} * 0.5"), text):
        motion.write_text(edited, encoding="utf-8")
        found.append(flown(package.parent, mission, tmp_path / "cache"))

    assert all(reference == compiled for reference, compiled in found)
    assert found[0] == found[2] != found[1]
