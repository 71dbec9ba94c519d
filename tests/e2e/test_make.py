import os
import shutil
import stat
import subprocess
import tomllib
from pathlib import Path

import pytest

from tests.support.cli import ROOT, require_program

TARGETS = (
    "help",
    "install",
    "generate",
    "validate",
    "simulate",
    "evolve",
    "report",
    "quick",
    "test",
    "test-all",
    "test-night",
    "interop",
    "release",
    "check",
    "clean",
)


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """Folder with a Makefile and nothing installed."""
    for name in ("Makefile", "pyproject.toml", "constraints.txt"):
        shutil.copy(ROOT / name, tmp_path)
    return tmp_path


def make(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    inherited = {"MAKEFLAGS", "MAKELEVEL", "MFLAGS", "MISSION", "CASE", "SEED", "OUT", "PYTHON"}
    environment = {key: value for key, value in os.environ.items() if key not in inherited}
    return subprocess.run(
        check=False,
        args=[require_program("make"), *arguments],
        cwd=cwd,
        env=environment,
        capture_output=True,
        encoding="utf-8",
    )


def test_plain_make_prints_every_target_with_a_line(clone):
    done = make(cwd=clone)

    assert done.returncode == 0
    for target in TARGETS:
        assert any(
            line.split()[:2] == ["make", target] and len(line.split()) > 3
            for line in done.stdout.splitlines()
        )


def test_variables_reach_the_command_and_empty_ones_leave_the_defaults(clone):
    given = make("-n", "evolve", "CASE=b", "SEED=7", "WORKERS=2", "OUT=runs/x", cwd=clone).stdout
    bus = make("-n", "evolve", "ENGINE=rosbridge", "URL=ws://h:1", "RESUME=r", cwd=clone).stdout
    empty = make("-n", "evolve", "MISSION=", "CASE=", "SEED=", "ENGINE=", cwd=clone).stdout

    assert " ".join(given.split("\n")[-2].split()) == (
        ".venv/bin/mrsfi evolve 'uuv_sampling' --case 'b' --seed '7' --out 'runs/x' --workers '2'"
    )
    assert " ".join(bus.split("\n")[-2].split()) == (
        ".venv/bin/mrsfi evolve --resume 'r' --engine 'rosbridge' --url 'ws://h:1'"
    )
    assert empty.split("\n")[-2].strip() == ".venv/bin/mrsfi evolve 'uuv_sampling' --case 'a'"


@pytest.mark.parametrize("text", ["`touch x`", "$(touch x)", "$(shell touch x)", "'; touch x; '"])
def test_what_variables_hold_is_data_to_make_and_to_the_shell(text, clone):
    names = ("MISSION", "CASE", "SEED", "ENGINE", "URL", "OUT", "WORKERS", "PYTHON")
    given = [f"{name}={text.replace('$', '$$') if name == 'OUT' else text}" for name in names]
    bin_ = clone / ".venv" / "bin"
    bin_.mkdir(parents=True)
    for stamp in (".created", ".installed"):
        (clone / ".venv" / stamp).touch()
    for name, script in (("mrsfi", "printf '<%s>' \"$@\""), ("python", "exit 0")):
        (bin_ / name).write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
        (bin_ / name).chmod(0o755)

    done = make("-s", "help", "generate", "evolve", "report", *given, cwd=clone)
    shutil.rmtree(clone / ".venv")
    make("-s", "install", *given, cwd=clone)

    assert done.returncode == 0, done.stderr
    assert f"Variables: MISSION={text} CASE={text} " in done.stdout
    assert f"<generate><{text}>" in done.stdout
    assert f"<evolve><{text}><--case><{text}><--seed><{text}><--out><" in done.stdout
    assert not (clone / "x").exists()


@pytest.mark.parametrize("text", ["`touch x`", "$(shell touch x)", "'; touch x; '"])
def test_the_same_holds_in_a_project_of_ones_own(text, tmp_path, monkeypatch):
    shutil.copy(ROOT / "src" / "mrsfi" / "template" / "Makefile", tmp_path)
    (tmp_path / "mrsfi").write_text("#!/bin/sh\nprintf '<%s>' \"$@\"\n", encoding="utf-8")
    (tmp_path / "mrsfi").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)

    done = make("-s", "evolve", "regressions", f"MISSION={text}", f"CASE={text}", cwd=tmp_path)

    assert f"<evolve><{text}><--case><{text}>" in done.stdout
    assert f"<check><{text}><--junit>" in done.stdout
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize(("target", "has_tools"), [("evolve", False), ("test", True)])
def test_a_target_installs_what_it_needs_with_pins(target, has_tools, clone):
    text = make("-n", target, cwd=clone).stdout

    assert "--constraint constraints.txt" in text
    assert text.index("pip install") < text.index("mrsfi generate")
    assert ('".[dev,fast]"' in text) == has_tools


def test_an_installation_says_what_each_step_does_before_it_does_it(clone):
    text = make("-n", "install", cwd=clone).stdout

    steps = [
        *("Making the virtual environment", "-m venv", "Installing mrsfi and its packages"),
        *("pip install", "Compiling the simulation kernel", "-m mrsfi_runtime.engine.compiled"),
    ]
    places = [text.index(step) for step in steps]
    assert places == sorted(places)
    assert [text.count(f": {time}.") for time in ("some seconds", "about a minute")] == [1, 1]


def test_what_is_installed_is_not_installed_again(clone):
    (clone / ".venv").mkdir()
    for stamp in (".created", ".installed", ".installed-dev"):
        (clone / ".venv" / stamp).touch()

    assert "pip install" not in make("-n", "evolve", "test", "check", cwd=clone).stdout


def test_an_old_python_is_refused_with_a_message(clone):
    old = clone / "python-old"
    old.write_text("#!/bin/sh\nexit 1\n", encoding="utf-8")
    old.chmod(old.stat().st_mode | stat.S_IXUSR)

    done = make("install", "PYTHON=./python-old", cwd=clone)

    assert done.returncode != 0
    assert "needs Python 3.11 or newer" in done.stderr
    assert not (clone / ".venv").exists()


def test_clean_keeps_campaigns(clone):
    (clone / "runs" / "one").mkdir(parents=True)
    (clone / ".venv").mkdir()

    make("clean", cwd=clone)

    assert (clone / "runs" / "one").is_dir()
    assert not (clone / ".venv").exists()


def test_every_pin_is_exact_and_every_dependency_is_pinned():
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pins = [line for line in lines if line and not line.startswith("#")]
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    wanted = [
        *project["project"]["dependencies"],
        *project["project"]["optional-dependencies"]["dev"],
        *project["build-system"]["requires"],
    ]

    pinned = {pin.split("==")[0].lower() for pin in pins}
    assert all(pin.count("==") == 1 for pin in pins)
    assert {name.split(">")[0].split("=")[0].split("<")[0].lower() for name in wanted} <= pinned
