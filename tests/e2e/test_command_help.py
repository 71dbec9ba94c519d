import os
import shutil
import subprocess
import sys

import pytest

from m2t.models.load import load_mission_folder
from mrsfi_runtime.glossary import TERMS
from tests.support.cli import MISSION, edit, mrsfi, stop_specification
from tests.support.models.published import published
from tests.support.tree import ROOT
from tests.tiers import slow

COMMANDS = (
    "new",
    "validate",
    "generate",
    "simulate",
    "evolve",
    "weaknesses",
    "monitors",
    "show",
    "explain",
    "replay",
    "report",
    "keep",
    "decide",
    "check",
    "compare",
    "history",
    "bridge",
    "import",
    "requirements",
    "rename",
    "diff",
    "confirm",
    "pack",
    "help",
)

HEAVY = {
    *("cbor2", "deap", "distributed", "importlib.metadata", "jinja2", "lxml", "m2t", "matplotlib"),
    *("moocore", "numba", "numpy", "pyecore", "pyflakes", "rich", "rosbags", "roslibpy", "scipy"),
    *("sqlite3", "websockets"),
}
"""What takes its time to import, and is not what every command needs."""

MODELS = {"lxml", "m2t", "pyecore"}
FRESH = {*MODELS, "jinja2"}
"""Generated code is fresh if it is what would be generated now."""

FLIGHT = {*FRESH, "pyflakes"}
SEARCH = {"deap", "importlib.metadata", "moocore", "numpy", "sqlite3"}
BUS = {"cbor2", "importlib.metadata", "rosbags", "roslibpy", "websockets"}

TINY = ("--population", "4", "--generations", "0")
REFERENCE = ("--engine", "reference", "--workers", "1")
LONG = [
    (("simulate", MISSION, "--engine", "rosbridge"), {*FLIGHT, *BUS, "rich"}),
    (("evolve", MISSION, *TINY, *REFERENCE, "--no-explain"), {*FLIGHT, *SEARCH, "rich"}),
    (
        ("explain", MISSION, "--faults", f"models/{MISSION}/stop.xmi", *REFERENCE),
        {*FLIGHT, "numpy", "rich", "sqlite3"},
    ),
    (("report", "FLOWN"), {*FRESH, "matplotlib", "numpy", "rich", "sqlite3"}),
]
IMPORTED = [
    (("--help",), set()),
    *(((command, "--help"), {"rosbags"} if command == "bridge" else set()) for command in COMMANDS),
    *((("help", topic), set()) for topic in ("evolve", "bus", "words")),
    (("--version",), {"importlib.metadata"}),
    (("validate", MISSION), FLIGHT),
    (("generate", MISSION, "--check"), FRESH),
    (("diff", MISSION, MISSION), MODELS),
    (("rename", MISSION, "r1=leader", "--diff"), FRESH),
    (("import", "published.xmi"), MODELS),
    (("requirements", "required.reqif", MISSION), MODELS),
    (("simulate", MISSION), {*FLIGHT, "rich"}),
    (("replay", "FLOWN"), {"m2t", "numpy", "rich", "sqlite3"}),
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


FLYING = (
    "simulate",
    "evolve",
    "weaknesses",
    "monitors",
    "explain",
    "replay",
    "keep",
    "check",
    "compare",
    "history",
)


@pytest.mark.parametrize("command", FLYING)
def test_options_of_a_bus_are_named_in_each_command_and_described_in_a_topic(command, tmp_path):
    text = mrsfi(command, "--help", cwd=tmp_path).stdout.partition("\nOptions:")[2]
    text = " ".join(text.replace("-\n  ", "-").split())  # a name may be wrapped

    named, _, said = text.partition("Your own simulator or node: ")[2].partition(": see ")
    topic = mrsfi("help", "bus", cwd=tmp_path).stdout
    assert said.split()[:3] == ["`mrsfi", "help", "bus`"]
    assert len(named.split()) == 15
    for name in named.replace(",", "").split():
        assert f"\n  {name} " in topic
        assert text.count(f"{name} ") + text.count(f"{name},") + text.count(f"{name}:") == 1


def test_options_stand_in_groups(tmp_path):
    text = mrsfi("evolve", "--help", cwd=tmp_path).stdout

    heads = [line for line in text.splitlines() if line.endswith(":") and not line.startswith(" ")]
    assert heads == ["Options:", "Search:", "Engine:", "Your own simulator or node:", "Output:"]


def test_help_prints_what_a_command_prints_and_every_term_of_the_glossary(tmp_path, approved):
    words = mrsfi("help", "words", cwd=tmp_path).stdout

    assert all(f"{term.name}:\n" in words for term in TERMS)
    assert all(len(line) <= 80 for line in words.splitlines())
    assert (
        mrsfi("help", "evolve", cwd=tmp_path).stdout
        == mrsfi("evolve", "--help", cwd=tmp_path).stdout
    )
    approved(mrsfi("help", "evolv", cwd=tmp_path, expected=2).stderr)


def test_a_shell_completes_commands(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "mrsfi_runtime.cli.main"],
        cwd=tmp_path,
        env={"_MRSFI_COMPLETE": "bash_complete", "COMP_WORDS": "mrsfi weak", "COMP_CWORD": "1"},
        capture_output=True,
        check=False,
        encoding="utf-8",
    )

    assert done.stdout == "plain,weaknesses\n"


@pytest.mark.parametrize(("arguments", "expected"), IMPORTED, ids=_named)
def test_a_command_imports_what_it_uses(arguments, expected, flown, place, tmp_path, monkeypatch):
    monkeypatch.setenv("MRSFI_CACHE", str(tmp_path / "cache"))  # no code is known to be fresh
    if "FLOWN" in arguments:
        shutil.copytree(flown, place / "FLOWN")
    models = load_mission_folder(place / "models" / MISSION)
    stop_specification(place / "models" / MISSION / "stop.xmi", [(100, 900)])
    (place / "published.xmi").write_text(published(models), encoding="ascii")
    shutil.copy(ROOT / "models" / "undersea" / "requirements.reqif", place / "required.reqif")

    done = subprocess.run(
        [sys.executable, "-c", _IMPORTS, " ".join(HEAVY), *arguments],
        cwd=place,
        capture_output=True,
        check=False,
        encoding="utf-8",
    )

    assert done.returncode == 0, done.stderr
    assert {*done.stderr.splitlines()[-1].split()} == expected


def test_what_was_fresh_once_is_not_generated_again_until_a_file_changes(
    place, tmp_path, monkeypatch
):
    monkeypatch.setenv("MRSFI_CACHE", str(tmp_path / "cache"))
    for path in (place / "models" / MISSION).glob("*.xmi"):
        os.utime(path, (1_000_000_000, 1_000_000_000))  # a file of the last second may change again

    def simulated(expected=0):
        done = subprocess.run(
            [sys.executable, "-c", _IMPORTS, " ".join(HEAVY), "simulate", MISSION],
            cwd=place,
            capture_output=True,
            check=False,
            encoding="utf-8",
        )
        assert done.returncode == expected
        return done

    first, again = simulated(), simulated()

    assert again.stdout == first.stdout
    assert {*again.stderr.split()} == {"m2t", "rich"}
    region = "# protected region helpers on begin\n"
    edit(place / "generated" / MISSION / "collective_intelligence.py", region, f"{region}A = 1\n")
    assert {*simulated().stderr.split()} == {"m2t", "pyflakes", "rich"}
    edit(place / "models" / MISSION / "faults.xmi", 'name="', 'name="new ')
    assert "stale" in simulated(4).stderr
    mrsfi("generate", MISSION, cwd=place)
    assert simulated().stdout == first.stdout
    code = place / "generated" / MISSION / "mission_loader.py"
    code.write_text(f"{code.read_text('utf-8')}# mine\n", encoding="utf-8")
    assert "mission_loader.py" in simulated(4).stderr


def test_a_kept_weakness_is_flown_without_numpy_and_read_once(place, tmp_path, monkeypatch):
    monkeypatch.setenv("MRSFI_CACHE", str(tmp_path / "cache"))
    for path in (place / "models" / MISSION).rglob("*.xmi"):
        os.utime(path, (1_000_000_000, 1_000_000_000))  # a file of the last second may change again

    first, again = (
        subprocess.run(
            [sys.executable, "-c", _IMPORTS, " ".join(HEAVY), "check", MISSION],
            cwd=place,
            capture_output=True,
            check=True,
            encoding="utf-8",
        )
        for _ in range(2)
    )

    assert again.stdout == first.stdout
    assert {*first.stderr.split()} == {*FLIGHT, "rich"}
    assert {*again.stderr.split()} == {"m2t", "rich"}


def test_help_imports_neither_subcommands_nor_their_options_nor_the_glossary(tmp_path):
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "mrsfi_runtime.cli.main", "--help"],
        cwd=tmp_path,
        capture_output=True,
        check=True,
        encoding="utf-8",
    )

    imported = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}
    assert {name for name in imported if name.startswith("mrsfi_runtime.")} == {
        "mrsfi_runtime.cli",
        "mrsfi_runtime.cli.terminal",
        "mrsfi_runtime.errors",
        "mrsfi_runtime.project_file",
    }


def test_version_is_printed(tmp_path):
    assert mrsfi("--version", cwd=tmp_path).stdout.startswith("mrsfi, version ")


OVER_BUS = ("--engine", "rosbridge")
NOWHERE = (*OVER_BUS, "--url", "ws://127.0.0.1:1")
WRONG = [
    ("validate",),
    ("validate", "nowhere"),
    ("generate", MISSION, "--check", "--diff"),
    ("simulate", MISSION, "--each-fault", "100:900"),
    ("simulate", MISSION, "--no-faults", "--faults", "missing.xmi"),
    ("simulate", MISSION, "--faults", "missing.xmi"),
    ("simulate", MISSION, "--log", "no/such/folder/x.log"),
    ("simulate", MISSION, "--mcap", "nowhere/b.mcap"),
    ("simulate", MISSION, "--seed", "-1"),
    ("simulate", MISSION, "--url", "ws://127.0.0.1:1"),
    ("simulate", MISSION, *OVER_BUS, "--side", "simulation"),
    ("simulate", MISSION, *OVER_BUS, "--url", "nowhere"),
    ("simulate", MISSION, *NOWHERE, "--side", "simulation", "--no-faults"),
    ("evolve",),
    ("evolve", MISSION, *NOWHERE, "--workers", "2"),
    ("evolve", MISSION, "--case", "z"),
    ("evolve", MISSION, "--algorithm", "magic"),
    ("evolve", MISSION, "--population", "0"),
    ("evolve", MISSION, "--engine", "warp"),
    ("evolve", MISSION, "--workers", "0"),
    ("evolve", MISSION, "--ratio", "g3:g1"),
    ("evolve", MISSION, "--ratio", "g3:g99=2:1"),
    ("evolve", MISSION, "--minimise", "faults"),
    ("compare", MISSION, "--algorithms", "paper,magic"),
    ("compare", MISSION, "--algorithms", "paper,paper"),
    ("compare", MISSION, "--algorithms", "paper,"),
    ("compare", MISSION, "--sweep", "crossover=1.5"),
    ("compare", MISSION, "--sweep", "population=10:25:3"),
    ("compare", MISSION, "--sweep", "crossover"),
    ("compare", MISSION, "--sweep", "crossover=0.5", "--algorithms", "paper,random"),
    ("compare", MISSION, "--seeds", "0"),
    ("compare", MISSION, "--evaluations", "0"),
    ("compare", MISSION, "--case", "z"),
    ("replay", "runs/x", "--best", "--all"),
    ("report",),
]


@pytest.mark.parametrize("arguments", WRONG, ids=_named)
def test_wrong_usage_ends_with_2_and_a_message(arguments, place, approved):
    done = mrsfi(*arguments, cwd=place, expected=2)

    assert done.stdout == ""
    approved(done.stderr)
    assert not (place / "runs").exists()


@pytest.mark.parametrize("command", ["simulate", "evolve", "compare"])
def test_stale_generated_code_ends_with_4_and_makes_no_folder(command, place, approved):
    edit(place / "models" / MISSION / "mission.xmi", 'speed="5.0"', 'speed="6.0"')

    approved(mrsfi(command, MISSION, cwd=place, expected=4).stderr)
    assert not (place / "runs").exists()


def test_a_misspelt_command_is_told_what_may_have_been_meant(tmp_path, approved):
    approved(mrsfi("simulat", "x", cwd=tmp_path, expected=2).stderr)
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
