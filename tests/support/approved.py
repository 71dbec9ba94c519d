"""Texts that a person approved, word for word: for each test file, one in ``tests/approved``.

A test hands over a text or a list of lines, ``approved(text)``, or what fails, ``with
refused(UsageError)``; its texts stand in that file under its name. ``pytest --approve FILE``
writes what they are now, and drops what no test asks for. A line number in a copy of a metamodel
is replaced by the name in that line, so that a new fault type changes no approved text.
"""

import re
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from difflib import unified_diff
from itertools import count, groupby
from pathlib import Path
from tempfile import gettempdir

import pytest

from tests.support.tree import ROOT

Approved = Callable[[object], None]
Refused = Callable[..., AbstractContextManager[pytest.ExceptionInfo[BaseException]]]
_NEW = pytest.StashKey[dict[str, dict[str, str]]]()
"""For each file of texts what its tests handed over in this run."""
_METAMODEL_LINE = re.compile(r"(/[^\s:]+\.ecore):(\d+)(?=:)")


def _named(place: re.Match[str]) -> str:
    """Return a place in a metamodel with the first name in its line for the line's number."""
    path, number = Path(place[1]), int(place[2])
    lines = path.read_text(encoding="utf-8").splitlines() if path.is_file() else []
    name = re.search('name="([^"]+)"', lines[number - 1]) if number <= len(lines) else None
    return f"{path}:LINE OF {name[1]}" if name else place[0]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--approve", action="store_true", help="write tests/approved anew")


def pytest_configure(config: pytest.Config) -> None:
    config.stash[_NEW] = {}


@pytest.fixture
def approved(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Approved:
    """Compare a text with the approved one; folders of the test and of the tree may vary."""
    roots = map(re.escape, (str(tmp_path_factory.getbasetemp()), gettempdir()))
    folder = re.compile(f"({'|'.join(roots)})/[\\w-]+")
    path = request.path.relative_to(ROOT / "tests").with_suffix(".txt")
    new = request.config.stash[_NEW].setdefault(str(path), {})
    old = _read(ROOT / "tests" / "approved" / path)
    test, bracket, values = request.node.name.partition("[")
    case = f" [{values}" if bracket else ""
    names = (f"{test}{case}{f' {k}' if k > 1 or not case else ''}" for k in count(1))

    def compare(text: object) -> None:
        name = next(names)
        lines = map(str, text) if isinstance(text, list) else [str(text)]
        named = _METAMODEL_LINE.sub(_named, "\n".join(lines))
        plain = folder.sub("TMP", named.replace(str(ROOT), "ROOT"))
        plain = re.sub(r"ROOT/(src|m2t|tests)/[^:]+:\d+", "ROOT/SOURCE", plain)
        new[name] = "\n".join(line.rstrip() for line in plain.strip("\n").splitlines())
        if old.get(name) != new[name] and not request.config.getoption("--approve"):
            pair = old.get(name, "").splitlines(), new[name].splitlines()
            diff = "\n".join(unified_diff(*pair, "approved", "found", lineterm=""))
            pytest.fail(f"{name}: see tests/approved/{path}\n{diff}", pytrace=False)

    return compare


@pytest.fixture
def refused(approved: Approved) -> Refused:
    """Expect an exception whose text is the approved one."""

    @contextmanager
    def expect(kind: type[BaseException]) -> Iterator[pytest.ExceptionInfo[BaseException]]:
        with pytest.raises(kind) as caught:
            yield caught
        approved(caught.value)

    return expect


def pytest_sessionfinish(session: pytest.Session) -> None:
    if hasattr(session.config, "workeroutput"):
        session.config.workeroutput["approved"] = session.config.stash[_NEW]


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: pytest.Item) -> None:
    """Take over what a worker's tests handed over; those of one file run in several."""
    for path, new in getattr(node, "workeroutput", {}).get("approved", {}).items():
        node.config.stash[_NEW].setdefault(path, {}).update(new)


def pytest_unconfigure(config: pytest.Config) -> None:
    if not config.getoption("--approve") or hasattr(config, "workeroutput"):
        return
    for path, new in config.stash[_NEW].items():
        file = ROOT / "tests" / "approved" / path
        tests = (ROOT / "tests" / path).with_suffix(".py").read_text(encoding="utf-8")
        asking = {*re.findall(r"^def (\w+)\([^)]*\b(?:approved|refused)\b", tests, flags=re.M)}
        asking -= {name.split()[0] for name in new}
        kept = {name: text for name, text in _read(file).items() if name.split()[0] in asking}
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(_written(kept | new), encoding="utf-8")


def _written(texts: dict[str, str]) -> str:
    """Return texts as in a file: a line for each test, and indented its cases and their texts."""
    order = sorted(texts, key=lambda name: re.sub(r"\d+", lambda n: n[0].zfill(9), name))
    lines = []
    for test, names in groupby(order, key=lambda name: name.split()[0]):
        lines.append(test)
        for name in names:
            case, text = name.removeprefix(f"{test} "), texts[name].replace("\n", "\n        ")
            lines += [line.rstrip() for line in f"    {case}: {text}".split("\n")]
    return "\n".join([*lines, ""])


def _read(file: Path) -> dict[str, str]:
    """Return the texts of a file by their names."""
    texts = {}
    written = file.read_text(encoding="utf-8") if file.exists() else ""
    for test, entries in re.findall(r"^(\w+)\n((?:(?: .*)?\n)*)", written, flags=re.M):
        for entry in re.split(r"^    (?=\S)", entries, flags=re.M)[1:]:
            case, text = re.findall(r"^(\d+|\[.*?\](?: \d+)?): ?(.*)", entry[:-1], flags=re.S)[0]
            texts[f"{test} {case}"] = re.sub("^        ", "", text, flags=re.M)
    return texts
