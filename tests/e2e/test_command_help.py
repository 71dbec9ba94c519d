import subprocess
import sys

import pytest

from tests.support.cli import mrsfi

COMMANDS = (
    "validate",
    "generate",
    "simulate",
    "evolve",
    "explain",
    "replay",
    "report",
    "compare",
    "bridge",
    "import",
    "diff",
)

_LIGHT_START = """
import sys
from mrsfi_runtime.cli.main import main
main(["--help"])
heavy = {"m2t", "pyecore", "matplotlib", "deap", "numpy", "rich"} & set(sys.modules)
sys.exit(f"imported {heavy}" if heavy else 0)
"""


def test_help_names_every_command_and_every_exit_code(tmp_path):
    text = mrsfi("--help", cwd=tmp_path).stdout

    assert all(f"\n  {command} " in text for command in COMMANDS)
    assert all(f" {code}  " in text for code in (*range(10), 130))


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_every_command_has_examples(command, tmp_path):
    text = mrsfi(command, "--help", cwd=tmp_path).stdout

    assert f"Usage: mrsfi {command} " in text
    assert f"Examples:\n    mrsfi {command}" in text


def test_help_imports_no_heavy_library():
    done = subprocess.run(
        [sys.executable, "-c", _LIGHT_START], capture_output=True, check=False, encoding="utf-8"
    )

    assert done.returncode == 0, done.stderr


def test_version_is_printed(tmp_path):
    assert mrsfi("--version", cwd=tmp_path).stdout.startswith("mrsfi, version ")


@pytest.mark.parametrize(
    "arguments",
    [
        ("fly",),
        ("validate",),
        ("validate", "nowhere"),
        ("generate", "uuv_sampling", "--check", "--diff"),
        ("simulate", "uuv_sampling", "--each-fault", "900:100"),
        ("simulate", "uuv_sampling", "--no-faults", "--each-fault", "1:2"),
        ("simulate", "uuv_sampling", "--markdown", "x.md"),
        ("simulate", "uuv_sampling", "--faults", "missing.xmi"),
        ("simulate", "uuv_sampling", "--log", "no/such/folder/x.log"),
        ("simulate", "uuv_sampling", "--seed", "-1"),
        ("evolve", "uuv_sampling", "--case", "z"),
        ("evolve", "uuv_sampling", "--algorithm", "magic"),
        ("evolve", "uuv_sampling", "--population", "0"),
        ("evolve", "uuv_sampling", "--engine", "warp"),
        ("evolve", "uuv_sampling", "--workers", "0"),
        ("evolve", "uuv_sampling", "--ratio", "g3:g1"),
        ("evolve", "uuv_sampling", "--ratio", "g3:g99=2:1"),
        ("replay", "runs/x", "--best", "--all"),
        ("report",),
    ],
)
def test_wrong_usage_ends_with_2_and_a_message(arguments, place):
    done = mrsfi(*arguments, cwd=place, expected=2)

    assert done.stdout == ""
    assert len(done.stderr.strip()) > 20
    assert not (place / "runs").exists()


def test_traceback_is_shown_on_request_only(place):
    done = subprocess.run(
        [sys.executable, "-m", "mrsfi_runtime.cli.main", "--traceback", "validate", "nowhere"],
        cwd=place,
        capture_output=True,
        check=False,
        encoding="utf-8",
    )

    assert done.returncode == 2
    assert "Traceback" in done.stderr
    assert "UsageError" in done.stderr
