"""What README, CONTRIBUTING and docs/ name exists, and a region that a page shows flies."""

import ast
import re
from collections.abc import Iterator
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path

import click

import mrsfi
from mrsfi_runtime.cli.main import cli
from mrsfi_runtime.engine.region_lint import lint_regions
from tests.support.edited import COLLECTIVE
from tests.support.tree import ROOT

PAGES = {
    page.relative_to(ROOT).as_posix(): page.read_text(encoding="utf-8")
    for pattern in ("*.md", "docs/**/*.md", "examples/*/README.md", "benchmarks/results/*.md")
    for page in ROOT.glob(pattern)
    if page.name != "CHANGELOG.md"  # names what is gone as well
}
PACKAGES = {
    "mrsfi": ROOT / "src" / "mrsfi",
    "mrsfi_runtime": ROOT / "src" / "mrsfi_runtime",
    "mrsfi_bridge": ROOT / "src" / "mrsfi_bridge",
    **{name: ROOT / name for name in ("benchmarks", "generated", "m2t", "tests")},
}
ROOMS = (".ci", "docs", "examples", "metamodels", "models", "src", *PACKAGES)
SUFFIXES = (".py", ".ecore", ".evl", ".eol", ".j2", ".md", ".toml", ".xmi")
MADE = {
    "dist",
    "site",
    "runs",
    "vendor",
    "figures",
    "tables",
    "report.md",
    "my_simulator.py",
    ".ecore",
}
"""What commands make, or what stands for a reader's own."""

ELSEWHERE = ("/", "~", "runs/", "critical/", "models/demo/", "generated/demo/", ".github/")
"""How paths begin that lie elsewhere: of campaigns, and of the project that the tutorial begins."""


@cache
def _tree() -> tuple[str, ...]:
    found = [path for room in ROOMS for path in (ROOT / room).rglob("*")]
    kept = [path for path in (*ROOT.iterdir(), *found) if path.name != "__pycache__"]
    return tuple(f"/{path.relative_to(ROOT).as_posix()}" for path in kept)


def _paths(page: str) -> Iterator[str]:
    """Give what looks like a path of the tree, a placeholder as a star."""
    prose = re.sub(r"^```.*?^```", "", PAGES[page], flags=re.MULTILINE | re.DOTALL)
    yield from re.findall(r"python ((?:\w+/)+\w+\.py)", PAGES[page])
    for span in re.findall(r"`([^`\n]+)`", prose):
        name = re.sub(r"<\w+>|…", "*", span).removesuffix("/")
        if re.search(r"[^\w./*-]", name) or name.startswith(ELSEWHERE):
            continue
        is_folder = span.endswith("/") or ("/" in name and name.split("/")[0] in ROOMS)
        if (is_folder or name.endswith(SUFFIXES)) and name not in MADE:
            yield name


def _is_defined(dotted: str) -> bool:
    """Return whether a dotted name is a package, a module, or defined in one."""
    first, *rest = dotted.split(".")
    if first == "mrsfi" and rest[0] in mrsfi.__all__:
        return True
    place = PACKAGES[first]
    for index, name in enumerate(rest, 1):
        place /= name
        if (module := place.with_suffix(".py")).exists():
            return not rest[index:] or rest[index] in _names(module)
        if not place.is_dir():
            return False
    return True


def _names(module: Path) -> set[str]:
    names: set[str] = set()
    for node in ast.parse(module.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            names.add(node.name)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            names |= {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}
    return names


def _headings(page: Path) -> set[str]:
    lines = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), flags=re.MULTILINE)
    return {re.sub(r"[^\w -]", "", line.lower()).replace(" ", "-") for line in lines}


def _unknown_words(line: str) -> list[str]:
    """Return the subcommand or those options of a command line that ``mrsfi`` does not have."""
    name, *words = line.replace("…", " ").split()
    if not re.fullmatch("[a-z]+", name):
        return []
    command = cli.get_command(click.Context(cli), name)
    if command is None:
        return [name]
    known = {
        option
        for parameter in command.params
        for option in (*parameter.opts, *parameter.secondary_opts)
    }
    return [f"{name} {word}" for word in words if word.startswith("--") and word not in known]


def _block_after(heading: str, sign: str, page: str = "README.md") -> str:
    """Return the first block of text after a heading of a page that holds a text."""
    text = PAGES[page].split(f"## {heading}\n", 1)[1]
    blocks = re.findall(r"```\w+\n(.*?)```", text, flags=re.DOTALL)
    return next(block for block in blocks if sign in block)


def test_every_path_named_exists():
    missing = [
        f"{page}: {name}"
        for page in PAGES
        for name in _paths(page)
        if not any(fnmatchcase(path, f"*/{name}") for path in _tree())
    ]

    assert missing == []


def test_every_module_named_exists():
    pattern = rf"(?<![\w./-])(?:{'|'.join(PACKAGES)})(?!\.csv|\.toml)(?:\.[A-Za-z_]\w*)+(?!/)"

    missing = [
        f"{page}: {name}"
        for page, text in PAGES.items()
        for name in re.findall(pattern, text)
        if not _is_defined(name)
    ]

    assert missing == []


def test_every_link_leads_somewhere():
    broken = []
    for page, text in PAGES.items():
        for link in re.findall(r"\]\((?!\w+://)([^)\s]+)\)", text):
            path, _, heading = link.partition("#")
            target = (ROOT / page).parent / path if path else ROOT / page
            if not target.exists() or (heading and heading not in _headings(target)):
                broken.append(f"{page}: {link}")

    assert broken == []


def test_every_command_and_option_exists():
    pattern = r"(?:^\$ |^|`|\| )mrsfi ([^`\n|#]+)"

    unknown = [
        f"{page}: {words}"
        for page, text in PAGES.items()
        for line in re.findall(pattern, text.replace("\\\n", " "), flags=re.MULTILINE)
        for words in _unknown_words(line)
    ]

    assert unknown == []


def test_every_target_of_make_exists():
    ours = _targets(ROOT / "Makefile")
    of_a_project = ours | _targets(ROOT / "src" / "mrsfi" / "template" / "Makefile")

    for page, text in PAGES.items():
        named = set(re.findall(r"(?:^\$ |`)make ([a-z-]+)", text, flags=re.MULTILINE))

        assert named <= (of_a_project if page == "docs/tutorial.md" else ours), page


def _targets(makefile: Path) -> set[str]:
    return {*re.findall(r"^([a-z-]+):", makefile.read_text("utf-8"), flags=re.MULTILINE)}


def test_the_tree_of_contributing_is_the_tree():
    named: list[str] = []
    for line in _block_after("Tree", "metamodels/", "CONTRIBUTING.md").splitlines():
        room, entries = re.fullmatch(r"(  (?=\w))?((?:[\w/]+/(?: |$))*).*", line).groups()  # type: ignore[union-attr]
        named += [("src/mrsfi_runtime/" if room else "") + entry for entry in entries.split()]

    rooms = [
        f"{path.relative_to(ROOT).as_posix()}/"
        for parent in (ROOT, ROOT / "src", ROOT / "src" / "mrsfi_runtime")
        for path in parent.iterdir()
        if path.name not in ("src", "runs", "build", "dist", "site", "__pycache__")
        and "." not in path.name
        if any(path.rglob("*.*"))
    ]

    assert sorted(named) == sorted(rooms)


def test_a_region_that_a_page_shows_is_one_that_flies():
    region = _block_after("Write a goal's logic", "@kernel", "docs/extending.md")

    code = (ROOT / "generated" / "tight_margins" / COLLECTIVE).read_text(encoding="utf-8")
    assert region in code
    assert lint_regions(ROOT / "generated" / "tight_margins") == ()
