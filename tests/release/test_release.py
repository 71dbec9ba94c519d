"""Wheel and sdist: what they hold, and the tutorial from the wheel in an empty folder."""

import os
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile
from email import message_from_bytes
from pathlib import Path

import pytest

from tests.support.edited import COLLECTIVE, write_body
from tests.support.missing import skip
from tests.support.pages import Terminal, run_page
from tests.support.tree import ROOT
from tests.tiers import seeds

VERSIONS = ("3.11", "3.12", "3.13")
TUTORIAL = (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")
KEPT = ("HOME", "LANG", "PIP_CERT", "PIP_INDEX_URL", "SSL_CERT_FILE", "REQUESTS_CA_BUNDLE")
AUTHOR = {
    f"GIT_{role}_{what}": value
    for role in ("AUTHOR", "COMMITTER")
    for what, value in (("NAME", "Team"), ("EMAIL", "team@example.org"))
}
NEARER = """    left, right = ci.robots[LEFT], ci.robots[RIGHT]
    return geometry.distance(left.x, left.y, right.x, right.y) < 1.3 * APART_METRES
"""


@pytest.fixture(scope="session")
def built():
    """The folder with wheel and sdist, which make release builds."""
    folder = ROOT / "dist"
    if not folder.is_dir():
        skip("needs what make release builds")
    return folder


def _only(folder: Path, pattern: str) -> Path:
    (found,) = folder.glob(pattern)
    return found


def _python(version: str) -> Path:
    """Return the interpreter of a version: this one, on the path, its neighbour, or pyenv's."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    neighbours = Path(sys.base_prefix).parent
    candidates = [sys.executable, shutil.which(f"python{version}")]
    for folder in (neighbours, pyenv):
        candidates += folder.glob(f"{version}.*/bin/python{version}")
    told = "import sys, ensurepip; print(sys.base_prefix, '%d.%d' % sys.version_info[:2])"
    found = {}
    for candidate in filter(None, candidates):
        done = subprocess.run([candidate, "-c", told], capture_output=True, text=True, check=False)
        prefix, _, its_version = done.stdout.strip().rpartition(" ")
        found[its_version] = Path(prefix) / "bin" / f"python{its_version}"
    if version not in found:
        skip(f"needs Python {version}")
    return found[version]


def test_the_wheel_says_what_it_is_and_brings_all_that_the_tool_reads(built):
    with zipfile.ZipFile(_only(built, "*.whl")) as wheel:
        names = set(wheel.namelist())
        info = f"{_only(built, '*.whl').name.rpartition('-py3')[0]}.dist-info"
        metadata = message_from_bytes(wheel.read(f"{info}/METADATA"))

    assert metadata["Name"] == "mrsfi"
    assert metadata["Requires-Python"] == ">=3.11"
    assert metadata["License-Expression"] == "Apache-2.0 AND BSD-3-Clause AND MIT"
    assert len(metadata.get_all("License-File")) == 3
    assert {f"{info}/licenses/{name}" for name in metadata.get_all("License-File")} <= names
    assert {name.partition("/")[0] for name in names} == {
        "m2t",
        "mrsfi",
        "mrsfi_bridge",
        "mrsfi_runtime",
        info,
    }
    ours = [
        path
        for room in ("m2t", "src/mrsfi", "src/mrsfi_bridge", "src/mrsfi_runtime")
        for path in (ROOT / room).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    ]
    assert {str(path.relative_to(ROOT)).removeprefix("src/") for path in ours} <= names
    assert {f"m2t/metamodels/{path.name}" for path in (ROOT / "metamodels").glob("*.*")} <= names


def test_scripts_are_checked_against_the_types_of_the_api(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import mrsfi\n\nuuv = mrsfi.load('uuv_sampling')\nreveal_type(uuv.fly().true_positions)\n"
        "reveal_type(uuv.evolve('a').weaknesses[0].faults)\nuuv.fly(1)\n",
        encoding="utf-8",
    )

    told = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "script.py"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    ).stdout.splitlines()

    assert "numpy.ndarray" in told[0]
    assert told[1].endswith('Revealed type is "tuple[str, ...]"')
    assert 'Argument 1 to "fly" of "Mission" has incompatible type "int"' in told[2]
    assert told[3] == "Found 1 error in 1 file (checked 1 source file)"


def test_the_version_is_that_of_the_changelog(built):
    (version,) = {path.name.split("-")[1].removesuffix(".tar.gz") for path in built.iterdir()}
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")

    assert f"\n## [{version}]" in changelog


def test_the_sdist_holds_the_tree(built):
    with tarfile.open(_only(built, "*.tar.gz")) as sdist:
        names = {name.partition("/")[2] for name in sdist.getnames()}

    listed = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    tracked = [name for name in listed.stdout.splitlines() if not name.startswith(".")]
    assert {*tracked} <= names


@pytest.mark.parametrize("version", seeds(VERSIONS, 0, 1))
def test_the_tutorial_runs_from_the_wheel_in_an_empty_folder(version, built, tmp_path):
    place = tmp_path / "empty"
    place.mkdir()
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "python3").symlink_to(_python(version))
    shutil.copy(_only(built, "*.whl"), place)
    terminal = Terminal(
        place,
        {
            **{name: os.environ[name] for name in KEPT if name in os.environ},
            **AUTHOR,
            "PATH": f"{tmp_path / 'bin'}:/usr/bin:/bin",
            "PIP_CONSTRAINT": str(ROOT / "constraints.txt"),
        },
    )

    ran = [command for command, _ in run_page(TUTORIAL, terminal)]

    assert ran[-1] == "make regressions"
    assert terminal.run("python --version").output[0].startswith(f"Python {version}.")
    code = place / "demo" / "generated" / "demo" / COLLECTIVE
    before = code.read_bytes()
    write_body(code, "apart.check", NEARER)
    came_back = terminal.run("mrsfi check --junit found.xml; echo $?")
    assert came_back.output[-1] == "10"
    assert "apart" in (place / "demo" / "found.xml").read_text(encoding="utf-8")
    code.write_bytes(before)
    assert terminal.run("mrsfi check > checked.txt; echo $?").output == ("0",)
    _require_build_servers_that_pass(place / "demo", terminal)
    _require_a_kernel_that_was_built_before(terminal)


def _require_build_servers_that_pass(project, terminal):
    """Do what the files for build servers say, on a fresh clone in a clean environment."""
    terminal.run("git add . && git commit --quiet --message End && git clone --quiet . ../cloned")
    terminal.run("env -u VIRTUAL_ENV python3 -m venv ../server")
    files = (".gitlab-ci.yml", ".github/workflows/mrsfi.yml")
    texts = [(project / name).read_text(encoding="utf-8") for name in files]
    steps = [re.findall(r"^ *- (?:run: )?((?:pip|make) .*)$", text, re.MULTILINE) for text in texts]
    assert steps[0] == steps[1]
    assert len(steps[0]) == 3

    for step in steps[0]:
        done = terminal.run(f"(cd ../cloned && PATH=$PWD/../server/bin:/usr/bin:/bin && {step})")
        assert done.code == 0, (step, done)
    judged = (project.parent / "cloned" / "regressions.xml").read_text(encoding="utf-8")
    assert 'tests="4" failures="0"' in judged


def _require_a_kernel_that_was_built_before(terminal):
    assert terminal.run("pip show numba").code != 0
    terminal.run("cd .. && mrsfi new plain && cd plain && mrsfi generate")
    compiled, reference = (
        terminal.run(f"mrsfi simulate plain --engine {name} --json")
        for name in ("compiled", "reference")
    )
    assert compiled.output == reference.output
    assert compiled.errors == ()

    room = terminal.run("echo ../.venv/lib/python*/site-packages/mrsfi_runtime").output[0]
    for file in ("kernel/commands.py", "engine/compiled/prebuilt/kernel.so"):
        terminal.run(f"echo >> {room}/{file}")
        refused = terminal.run("mrsfi simulate plain --engine compiled")
        terminal.run(f"truncate --size -1 {room}/{file}")
        assert "pip install 'mrsfi[fast]'" in "".join(refused.errors)
        assert refused.code == 2
    assert terminal.run("mrsfi simulate plain --engine compiled --json").output == reference.output
