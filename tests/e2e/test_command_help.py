import shutil
import subprocess
import sys

import pytest

from m2t.load import load_mission_folder
from tests.support.cli import MISSION, mrsfi, stop_specification
from tests.support.models.published import published
from tests.tiers import slow

COMMANDS = (
    "new",
    "validate",
    "generate",
    "simulate",
    "evolve",
    "weaknesses",
    "show",
    "explain",
    "replay",
    "report",
    "keep",
    "check",
    "compare",
    "bridge",
    "import",
    "rename",
    "diff",
)

HEAVY = {
    *("cbor2", "deap", "distributed", "importlib.metadata", "jinja2", "lxml", "m2t", "matplotlib"),
    *("moocore", "numba", "numpy", "pyecore", "pyflakes", "rich", "roslibpy", "scipy"),
    "websockets",
}
"""What takes its time to import, and is not what every command needs."""

MODELS = {"lxml", "m2t", "pyecore"}
FRESH = {*MODELS, "jinja2"}
"""Generated code is fresh if it is what would be generated now."""

FLIGHT = {*FRESH, "pyflakes"}
SEARCH = {"deap", "importlib.metadata", "moocore", "numpy"}
BUS = {"cbor2", "importlib.metadata", "roslibpy", "websockets"}

TINY = ("--population", "4", "--generations", "0")
REFERENCE = ("--engine", "reference", "--workers", "1")
LONG = [
    (("simulate", MISSION, "--engine", "rosbridge"), {*FLIGHT, *BUS, "rich"}),
    (("evolve", MISSION, *TINY, *REFERENCE, "--no-explain"), {*FLIGHT, *SEARCH, "rich"}),
    (
        ("explain", MISSION, "--faults", f"models/{MISSION}/stop.xmi", *REFERENCE),
        {*FLIGHT, "numpy", "rich"},
    ),
    (("report", "FLOWN"), {*FRESH, "numpy", "rich"}),
]
IMPORTED = [
    (("--help",), set()),
    *(((command, "--help"), set()) for command in COMMANDS),
    (("--version",), {"importlib.metadata"}),
    (("validate", MISSION), FLIGHT),
    (("generate", MISSION, "--check"), FRESH),
    (("diff", MISSION, MISSION), MODELS),
    (("rename", MISSION, "r1=leader", "--diff"), FRESH),
    (("import", "published.xmi"), MODELS),
    (("simulate", MISSION), {*FLIGHT, "rich"}),
    (("replay", "FLOWN"), {*FRESH, "numpy", "rich"}),
    *(pytest.param(*case, marks=slow) for case in LONG),
]
"""Which of the heavy ones a command imports."""

_IMPORTS = """
import sys
from mrsfi_runtime.cli.main import main
code = main(sys.argv[2:])
print(*sorted(set(sys.argv[1].split()) & set(sys.modules)), file=sys.stderr)
sys.exit(code)
"""


def _named(value: object) -> str | None:
    return " ".join(value) if isinstance(value, tuple) else ""


def test_help_names_every_command_and_every_exit_code(tmp_path):
    text = mrsfi("--help", cwd=tmp_path).stdout

    assert all(f"\n  {command} " in text for command in COMMANDS)
    assert all(f" {code}  " in text for code in (*range(10), 130))


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_every_command_has_examples(command, tmp_path):
    text = mrsfi(command, "--help", cwd=tmp_path).stdout

    assert f"Usage: mrsfi {command} " in text
    assert f"Examples:\n    mrsfi {command}" in text


@pytest.mark.parametrize(("arguments", "expected"), IMPORTED, ids=_named)
def test_a_command_imports_what_it_uses(arguments, expected, flown, place):
    if "FLOWN" in arguments:
        shutil.copytree(flown, place / "FLOWN")
    models = load_mission_folder(place / "models" / MISSION)
    stop_specification(place / "models" / MISSION / "stop.xmi", [(100, 900)])
    (place / "published.xmi").write_text(published(models), encoding="ascii")

    done = subprocess.run(
        [sys.executable, "-c", _IMPORTS, " ".join(HEAVY), *arguments],
        cwd=place,
        capture_output=True,
        check=False,
        encoding="utf-8",
    )

    assert done.returncode == 0, done.stderr
    assert {*done.stderr.splitlines()[-1].split()} == expected


def test_version_is_printed(tmp_path):
    assert mrsfi("--version", cwd=tmp_path).stdout.startswith("mrsfi, version ")


@pytest.mark.parametrize(
    "arguments",
    [
        ("fly",),
        ("validate",),
        ("validate", "nowhere"),
        ("generate", "uuv_sampling", "--check", "--diff"),
        ("simulate", "uuv_sampling", "--each-fault", "100:900"),
        ("simulate", "uuv_sampling", "--no-faults", "--faults", "missing.xmi"),
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


def test_a_misspelt_command_is_told_what_may_have_been_meant(tmp_path):
    assert "Did you mean 'simulate'?" in mrsfi("simulat", "x", cwd=tmp_path, expected=2).stderr
    assert "Did you mean" not in mrsfi("fly", "x", cwd=tmp_path, expected=2).stderr


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
