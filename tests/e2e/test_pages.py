"""Blocks of README and docs/ run as they stand, page after page, in a copy of the tree."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.support.pages import Terminal, at_free_ports, blocks, run_page
from tests.support.tree import ROOT, UNDRAWN
from tests.tiers import night, seeds, slow

RUN = (
    "README.md",
    "docs/concepts.md",
    "docs/paper.md",
    "docs/editing-models.md",
    "docs/projects.md",
    "docs/bags.md",
    "docs/gallery.md",
    "docs/explain.md",
    "docs/compare.md",
    "docs/regressions.md",
    "docs/sharing.md",
    "docs/bridge.md",
    "examples/own_search/README.md",
    "docs/workers.md",
    "docs/bus.md",
    "examples/nodes/README.md",
    "docs/find-weaknesses.md",
    "docs/requirements.md",
    "docs/missions.md",
    "docs/monitors.md",
)
"""Pages in the order in which they are run: what README finds, others look at."""

ELSEWHERE = {
    "docs/api.md": "tests/e2e/test_api_page.py",
    "docs/editing-models.md": "tests/integration/test_editing_models.py",
    "docs/epsilon.md": "tests/interop/test_configurations.py",
    "docs/extending.md": "tests/integration/test_documentation.py",
    "docs/faults.md": "tests/recipes/performed.py",
    "docs/monitors.md": "tests/e2e/test_monitors.py",
    "docs/nightly.md": "tests/e2e/test_decide.py",
    "docs/node.md": "tests/unit/cosimulation/test_node_mapping.py",
    "docs/projects.md": "tests/e2e/test_project.py",
    "docs/ros2.md": "tests/integration/test_node_examples.py",
    "docs/tutorial.md": "tests/release/test_release.py",
    "examples/warehouse/README.md": "tests/e2e/test_warehouse.py",
    "examples/worlds/README.md": "tests/interop/test_second_simulator.py",
}
"""What runs, or holds to the code, blocks that are run neither in order nor shortened."""

HOURS = ("docs/find-weaknesses.md", "benchmarks/results/searches.md", "docs/compare.md")
SHORTER = {"compare": "--seeds 2 --evaluations 2 --engine reference", "evolve": "--evaluations 5"}
KEPT = ("HOME", "LANG", "MRSFI_CACHE")
LEFT_OUT = re.compile(r"<!-- not run: ([^>]+) -->\n\n?```\w+\n")


PAGES = {
    path.relative_to(ROOT).as_posix(): path.read_text("utf-8")
    for pattern in ("*.md", "docs/**/*.md", "examples/*/README.md", "benchmarks/results/*.md")
    for path in ROOT.glob(pattern)
}


@pytest.fixture
def tree(tmp_path):
    """A copy of the tree under git, as who clones it has it after make install."""
    copy = tmp_path / "mrsfi"
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    for name in listed.stdout.splitlines():
        (copy / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, copy / name)
    for command in ("init", "add .", "-c user.name=a -c user.email=a@example.org commit -m Begin"):
        subprocess.run(["git", *command.split()], cwd=copy, capture_output=True, check=True)
    (copy / ".venv").symlink_to(ROOT / ".venv")
    for name in ("pyproject.toml", "constraints.txt"):
        os.utime(copy / name, (0, 0))  # nothing is to be installed: it would be this copy
    return copy


@pytest.fixture
def environment(tree):
    kept = {name: os.environ[name] for name in KEPT if name in os.environ}
    return {**kept, "PATH": f"{tree / '.venv' / 'bin'}:/usr/local/bin:/usr/bin:/bin"}


@pytest.mark.parametrize(
    ("pages", "is_drawn"),
    [
        pytest.param(RUN[::3], False, marks=slow, id="every third"),
        pytest.param(RUN, True, marks=night, id="all"),
    ],
)
def test_every_console_prints_what_stands_there(pages, is_drawn, tree, environment):
    """Figures of README alone are drawn, which takes as long as the rest of it."""
    for page in pages:
        path = {} if is_drawn and page == RUN[0] else {"PYTHONPATH": str(UNDRAWN)}
        assert [*run_page(at_free_ports(PAGES[page]), Terminal(tree, environment | path))], page
    examples = Terminal(tree, environment).run("git status --short examples")
    assert not examples.output, "runs are left beside examples"


@pytest.mark.parametrize("page", seeds(HOURS, 0, 1))
def test_what_takes_hours_runs_in_minutes_as_it_stands_but_for_its_size(page, tree, environment):
    for block in (block for block in blocks(PAGES[page]) if block.kind == "sh"):
        text = "\n".join(block.lines).replace("\\\n", " ")
        text = re.sub(
            rf"^ *mrsfi ({'|'.join(SHORTER)}) .*$",
            lambda found: f"{found[0]} {SHORTER[found[1]]}",
            text,
            flags=re.M,
        )
        terminal = Terminal(tree, environment | {"PYTHONPATH": str(UNDRAWN)})
        done = terminal.run(f"set -e\n{text}\nset +e\necho done")
        assert done.output[-1:] == ("done",), (page, block.line, done.errors[-3:])


def test_every_block_is_run_or_held_to_what_is_there():
    for page, text in PAGES.items():
        kinds = {block.kind for block in blocks(text) if not block.file} - {"text"}
        kinds -= {"console", "diff"} if page in RUN else set()
        kinds -= {"sh"} if page in HOURS else set()
        if kinds:
            assert page in ELSEWHERE, (page, kinds)
        for why in LEFT_OUT.findall(text):
            (place,) = re.findall(r"tests/[\w/]+\.py|^\.ci/run", why)[:1]
            assert (ROOT / place).is_file(), page
    for page, test in ELSEWHERE.items():
        read = (ROOT / test).read_text(encoding="utf-8")
        assert Path(page).name in read, (page, test)


@pytest.mark.parametrize(
    ("page", "wrong"),
    [
        ("$ echo a\na\n", ""),
        ("$ echo a; echo b\n…\nb\n", ""),
        ("$ echo 'took 3 s'\ntook … s\n", ""),
        ("$ echo a; echo progress >&2\na\n", ""),
        ("$ echo a; echo wrong >&2\nwrong\na\n", ""),
        ("$ export x=1\n$ cd ..\n$ echo $x\n1\n", ""),
        ("$ echo a\nb\n", "expected:\nb\n\nfound:\na"),
        ("$ echo a; echo b\na\n", "found:\na\nb"),
        ("$ echo a\n", "found:\na"),
        ("$ true\na\n", "expected:\na"),
        ("$ echo wrong >&2; false\nwrong\n", ""),
        ("$ echo wrong >&2; false\n", "found:\nwrong"),
        ("$ echo wrong >&2; false\n…\n", "found:\nwrong"),
        ("$ echo a; sleep 60\na\n^C\n", ""),
        ("$ (echo a; sleep 60) &\na\n$ echo b\nb\n", ""),
        ("$ echo a; sleep 60\nb\n^C\n", "found:\na"),
        ("$ (echo a; sleep 60) &\nb\n", "found:\na"),
    ],
)
def test_a_console_fails_where_it_prints_something_else(page, wrong, tmp_path):
    folder = tmp_path / "here"
    folder.mkdir()
    terminal = Terminal(folder, {"PATH": os.environ["PATH"]})

    def run() -> list[str]:
        return [command for command, _ in run_page(f"```console\n{page}```\n", terminal)]

    if not wrong:
        assert run()
        return
    with pytest.raises(AssertionError) as failure:
        run()
    assert wrong in str(failure.value)
