"""Consoles of README and docs/ run as they stand, one after the other, in a copy of the tree."""

import os
import re
import shutil
import subprocess

import pytest

from tests.support.pages import Terminal, blocks, run_page
from tests.support.tree import ROOT
from tests.tiers import slow

RUN = (
    "README.md",
    "docs/projects.md",
    "docs/bags.md",
    "docs/gallery.md",
    "docs/causes.md",
    "docs/regressions.md",
    "docs/compare.md",
    "examples/warehouse/README.md",
)
"""Pages in the order in which they are run: what README finds, others look at."""

BY_RELEASE = "docs/tutorial.md"
KEPT = ("HOME", "LANG", "MRSFI_CACHE")
LEFT_OUT = re.compile(r"<!-- not run: ([^>]+) -->\n\n```console\n")


def _pages() -> dict[str, str]:
    names = [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("examples/*/README.md")]
    return {path.relative_to(ROOT).as_posix(): path.read_text("utf-8") for path in names}


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """A copy of the tree under git, as who clones it has it after make install."""
    copy = tmp_path_factory.mktemp("pages") / "mrsfi"
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


@slow
def test_every_console_prints_what_stands_there(tree):
    environment = {name: os.environ[name] for name in KEPT if name in os.environ}
    environment["PATH"] = f"{tree / '.venv' / 'bin'}:/usr/local/bin:/usr/bin:/bin"
    pages = _pages()
    for page in RUN:
        terminal = Terminal(tree, environment)
        ran = [command for command, _ in run_page(pages[page], terminal)]
        assert ran, page


def test_every_console_is_run_or_says_where_it_is():
    for page, text in _pages().items():
        if page not in (*RUN, BY_RELEASE):
            assert not [block.line for block in blocks(text) if block.kind == "console"], page
        for why in LEFT_OUT.findall(text):
            (place,) = re.findall(r"tests/[\w/]+\.py|^\.ci/run", why)[:1]
            assert (ROOT / place).is_file(), page


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


def test_an_edit_that_does_not_fit_fails(tmp_path):
    folder = tmp_path / "here"
    folder.mkdir()
    (folder / "a.txt").write_text("one\n", encoding="utf-8")
    terminal = Terminal(folder, {"PATH": os.environ["PATH"]})
    change = ("--- a/a.txt", "+++ b/a.txt", "@@ -1 +1 @@", "-one", "+two")

    terminal.edit(change)
    assert (folder / "a.txt").read_text(encoding="utf-8") == "two\n"
    with pytest.raises(AssertionError):
        terminal.edit(change)
