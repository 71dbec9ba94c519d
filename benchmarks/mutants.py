"""Which defects the tests of a room find: seeded single mutations of its code.

Run ``python -m benchmarks.mutants record 30``. Each mutant is one changed place in a copy of the
tree: a comparison, an operator, a number, an ``and``, a ``not``, what is returned, or a statement
that is gone. The room's own tests of ``make test`` run on it, cheapest first, until one fails. With
the same seed, a commit is compared with another; after a move of code, ``--write`` there and
``--same`` here judge the same changes of the same lines. What was judged stands in ``--out``, one
line of JSON each; the same command again goes on where it was stopped. Tests that fail in the copy
without any mutation are left out, and named.
"""

import argparse
import ast
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import deepcopy
from dataclasses import asdict, dataclass
from pathlib import Path
from threading import Lock, local
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[1]
PATIENCE = 3.0
"""How much longer a mutant may take than none; a minute more, and it is killed by the clock."""

ROOMS = {
    "model": """
        unit/model disk/test_generated_code.py model/test_specification.py
        model/test_fault_meaning.py golden/test_flights.py conformance/test_fault_types.py
        unit/search/test_space.py unit/search/test_algorithms.py unit/record unit/analysis
    """,
    "engine": """
        unit/mrsfi/test_engines.py disk/engine disk/test_generated_code.py
        conformance/test_compiled.py conformance/test_region_lint.py conformance/test_engines.py
        integration/test_workers.py
    """,
    "cosimulation": """
        unit/cosimulation unit/transport
        integration/test_mutilated_simulators.py integration/test_rosbridge.py
    """,
    "record": """
        unit/record unit/mrsfi/test_engines.py disk/record integration/record
        e2e/test_replay_and_report.py
    """,
    "search": """
        unit/search disk/search conformance/test_algorithms.py conformance/test_own_search.py
    """,
    "causes": "unit/causes integration/causes e2e/test_explain.py",
    "kernel": "unit/kernel golden property",
    "transport": """
        unit/transport unit/cosimulation conformance/test_transports.py
        integration/test_rosbridge.py integration/test_injector.py
    """,
    "mrsfi_bridge": """
        unit/transport unit/bridge disk/bridge integration/test_bridge_embedded.py
        conformance/test_transports.py integration/test_bridge_command.py
        integration/test_bridge_server.py
    """,
    "study": """
        unit/study disk/study integration/study e2e/test_compare.py
    """,
    "analysis": """
        unit/analysis disk/analysis integration/analysis e2e/test_replay_and_report.py
        e2e/test_page.py e2e/test_show.py e2e/test_weaknesses.py
    """,
    **dict.fromkeys(
        ("m2t", "m2t/check", "m2t/write"), "unit/m2t disk/m2t model integration/test_generation.py"
    ),
    "mrsfi": """
        unit/mrsfi e2e/test_mission_folders.py e2e/test_project.py e2e/test_rename.py
        e2e/test_keep_and_check.py e2e/test_validate_and_generate.py e2e/test_api.py
        e2e/test_fix.py e2e/test_new.py
    """,
    "cli": """
        unit/cli e2e/test_command_help.py e2e/test_validate_and_generate.py e2e/test_simulate.py
        e2e/test_keep_and_check.py e2e/test_rename.py e2e/test_replay_and_report.py
        e2e/test_explain.py e2e/test_evolve.py
    """,
}
"""The tests that judge a room, below ``tests``, cheapest first."""

_COMPARISONS = {
    ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE,
    ast.GtE: ast.Gt, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
}  # fmt: skip
_OPERATORS = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult, ast.Mod: ast.Mult, ast.BitOr: ast.BitAnd, ast.BitAnd: ast.BitOr,
}  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """One changed place, and what takes the place of the text there."""

    file: str  # from the root of the tree
    line: int
    begin: int  # in bytes of the file
    end: int
    before: str
    after: str
    kind: str
    function: str = ""
    text: str = ""  # of the line

    @property
    def change(self) -> tuple[str, ...]:
        """What tells it from others, wherever its statement stands."""
        return self.kind, self.before, self.after, self.text

    def __str__(self) -> str:
        one, two = (" ".join(text.split())[:60] for text in (self.before, self.after))
        return f"{self.file}:{self.line} ({self.kind}): {one}  ->  {two}"

    def apply(self, root: Path) -> None:
        """Write the mutant into a copy of the tree."""
        content = (ROOT / self.file).read_bytes()
        text = content[: self.begin] + self.after.encode() + content[self.end :]
        (root / self.file).write_bytes(text)


def changes(node: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    """Yield what may become of a node, each with the kind of change."""
    if isinstance(node, ast.stmt):
        yield from _of_statement(node)
    elif isinstance(node, ast.Constant):
        yield from _of_constant(node.value)
    else:
        yield from _of_expression(deepcopy(node))


def _of_statement(node: ast.stmt) -> Iterator[tuple[str, ast.AST]]:
    match node:
        case ast.Return(value=ast.expr() as value) if ast.unparse(value) != "None":
            yield "return", ast.Return(ast.Constant(None))
        case ast.Assign() | ast.AugAssign() | ast.Expr(value=ast.Call()):
            yield "statement gone", ast.Pass()


def _of_constant(value: object) -> Iterator[tuple[str, ast.AST]]:
    if isinstance(value, bool):
        yield "truth", ast.Constant(not value)
    elif isinstance(value, int | float):
        yield "number", ast.Constant(value + 1)
        yield "number", ast.Constant(value - 1)


def _of_expression(changed: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    match changed:
        case ast.Compare(ops=[operator]) if type(operator) in _COMPARISONS:
            changed.ops = [_COMPARISONS[type(operator)]()]
            yield "comparison", changed
        case ast.BinOp() if type(changed.op) in _OPERATORS:
            changed.op = _OPERATORS[type(changed.op)]()
            yield "operator", changed
        case ast.BoolOp():
            changed.op = ast.Or() if isinstance(changed.op, ast.And) else ast.And()
            yield "and, or", changed
        case ast.UnaryOp(op=ast.Not()):
            yield "not", changed.operand


def _code(node: ast.AST) -> Iterator[ast.AST]:
    """Walk what runs inside of functions: no annotation, decorator or text of a message."""
    skipped = (ast.JoinedStr, ast.Raise, ast.arguments, ast.AnnAssign)
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST) and not isinstance(child, skipped):
                yield child
                yield from _code(child)


def mutants(file: Path) -> Iterator[Mutant]:
    """Yield all mutants of a file."""
    content = file.read_bytes()
    starts = [0]
    for line in content.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    tree = ast.parse(content)
    kinds = ast.FunctionDef | ast.AsyncFunctionDef
    functions = [node for node in ast.walk(tree) if isinstance(node, kinds)]
    nested = {inner for outer in functions for inner in ast.walk(outer) if inner is not outer}
    for function in functions:
        if function in nested:
            continue
        for node in _code(function):
            for kind, changed in changes(node):
                begin = starts[node.lineno - 1] + node.col_offset
                end = starts[node.end_lineno - 1] + node.end_col_offset
                text = ast.unparse(ast.fix_missing_locations(changed))
                after = text if isinstance(changed, ast.stmt) else f"({text})"
                before = content[begin:end].decode()
                name = str(file.relative_to(ROOT))
                text = content[starts[node.lineno - 1] : starts[node.lineno]].decode().strip()
                place = (name, node.lineno, begin, end, before, after, kind)
                yield Mutant(*place, function.name, text)


def drawn(seed: int, room: str) -> list[Mutant]:
    """Return all mutants of a room in an order drawn from a seed, the kinds in turn."""
    folder = next(
        ROOT / at / room for at in ("src/mrsfi_runtime", "src", ".") if (ROOT / at / room).is_dir()
    )
    found = [each for file in sorted(folder.rglob("*.py")) for each in mutants(file)]
    random.Random(seed).shuffle(found)
    turn: Counter[str] = Counter()
    places = {}
    for each in found:
        places[each] = turn[each.kind], each.kind
        turn[each.kind] += 1
    return sorted(found, key=places.__getitem__)


def again(listed: Path) -> Iterator[tuple[dict[str, Any], Mutant | None]]:
    """Yield mutants that ``--write`` listed, each with the same change of the same line today.

    A line that stands several times is looked for in a function of the same name.
    """
    files = [*(ROOT / "src").rglob("*.py"), *(ROOT / "m2t").rglob("*.py")]
    today: dict[tuple[str, ...], list[Mutant]] = {}
    for each in (mutant for file in sorted(files) for mutant in mutants(file)):
        today.setdefault(each.change, []).append(each)
    for line in listed.read_text("utf-8").splitlines():
        values = json.loads(line)
        found = today.get(Mutant(**values).change, [])
        same = [each for each in found if each.function == values["function"]] or found
        yield values, same[0] if same else None


class Copy:
    """A copy of the tree in which mutants are judged one after the other, by some tests.

    A mutant that takes more than ``limit`` seconds is killed by the clock.
    """

    def __init__(
        self,
        folder: Path,
        tests: list[str],
        left_out: Sequence[str] = (),
        limit: float | None = None,
    ) -> None:
        self.root = folder / "tree"
        self._cache = folder.parent / "compiled"
        self._options = [*tests, *(f"--deselect={test}" for test in left_out)]
        self._limit = limit
        listed = subprocess.run(
            ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
            cwd=ROOT, check=True, capture_output=True, text=True,
        ).stdout  # fmt: skip
        for name in filter(None, listed.split("\0")):
            if (ROOT / name).is_file():
                (self.root / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(ROOT / name, self.root / name)

    def killer(self, mutant: Mutant) -> str:
        """Return which test kills a mutant, or nothing."""
        mutant.apply(self.root)
        try:
            return next(iter(self.failed("--exitfirst")), "")
        finally:
            shutil.copy2(ROOT / mutant.file, self.root / mutant.file)

    def failed(self, *options: str) -> list[str]:
        """Return the tests that fail here."""
        command = [sys.executable, "-m", "pytest", "-q", "-rfE", "-n0"]
        command += ["-p", "no:cacheprovider", "--tb=no", *options, *self._options]
        paths = [str(self.root / "src"), str(self.root)]
        environment = os.environ | {
            "PYTHONPATH": os.pathsep.join(paths),
            "PYTHONDONTWRITEBYTECODE": "1",  # a mutant may have size and second of the last
            "MRSFI_CACHE": str(self._cache),
        }
        with subprocess.Popen(
            command, cwd=self.root, env=environment, text=True, start_new_session=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        ) as process:  # fmt: skip
            _RUNNING.add(process.pid)
            try:
                output, _ = process.communicate(timeout=self._limit)
            except subprocess.TimeoutExpired:
                return [f"took more than {self._limit:.0f} s"]
            finally:
                _RUNNING.discard(process.pid)
                _end(process.pid)
        if process.returncode == -signal.SIGKILL:
            message = "the tests were killed from outside: nothing is known of the mutant"
            raise RuntimeError(message)
        if process.returncode == pytest.ExitCode.NO_TESTS_COLLECTED:
            message = f"no test takes part: {' '.join(self._options)}"
            raise RuntimeError(message)
        lines = [line.split(" - ")[0] for line in output.splitlines()]
        named = [line.split(" ", 1)[1] for line in lines if line.startswith(("FAILED ", "ERROR "))]
        return named or ([] if process.returncode == 0 else [output[-300:]])


_RUNNING: set[int] = set()
"""Process groups of the tests that run now."""


def _end(group: int) -> None:
    """End what a run of the tests has left behind."""
    try:
        os.killpg(group, signal.SIGKILL)
    except ProcessLookupError:
        return


class Record:
    """What was judged, in a file of JSON lines that is only appended to."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._lock = Lock()
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
        self.lines = [json.loads(line) for line in path.read_text("utf-8").splitlines()]

    def add(self, **line: Any) -> dict[str, Any]:
        """Keep a line, and return it."""
        with self._lock, self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
            self.lines.append(line)
        return line

    def killer(self, mutant: Mutant) -> str | None:
        """Return what killed a mutant, or nothing; ``None`` if it was not judged yet."""
        found = (line["killer"] for line in self.lines if line.get("mutant") == asdict(mutant))
        return next(found, None)

    def unmutated(self) -> dict[str, Any] | None:
        """Return how the tests end without a mutation, if that is known."""
        return next((line for line in self.lines if "left_out" in line), None)


def judge(
    wanted: list[Mutant], tests: list[str], record: Record, n_jobs: int, folder: Path
) -> None:
    """Judge mutants, some at a time."""
    known = record.unmutated()
    if known is None:
        begun = time.monotonic()
        failed = Copy(folder / "plain", tests).failed()
        known = record.add(left_out=failed, seconds=time.monotonic() - begun)
    left_out, limit = known["left_out"], 60 + PATIENCE * known["seconds"]
    print(f"left out, because they fail unmutated: {left_out or 'none'}", flush=True)
    mine = local()

    def decide(mutant: Mutant) -> None:
        if record.killer(mutant) is None:
            if not hasattr(mine, "copy"):
                place = Path(tempfile.mkdtemp(dir=folder))
                mine.copy = Copy(place, tests, left_out, limit)
            killer = mine.copy.killer(mutant)
            record.add(mutant=asdict(mutant), killer=killer)
            print(f"{'killed' if killer else 'SURVIVED':8} {mutant}  {killer}", flush=True)

    with ThreadPoolExecutor(n_jobs) as pool:
        try:
            list(pool.map(decide, wanted))
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for group in tuple(_RUNNING):
                _end(group)
            raise


def main() -> None:
    """Judge mutants as the command line says."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("room", choices=ROOMS)
    parser.add_argument("n", type=int, help="how many mutants")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2, help="how many at a time")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--write", type=Path, help="list the mutants, and judge none")
    parser.add_argument("--same", type=Path, help="judge those of such a list")
    arguments = parser.parse_args()
    room = arguments.room
    named = [f"tests/{test}" for test in ROOMS[room].split()]
    tests = [test for test in named if (ROOT / test).exists()]  # also of an earlier commit
    if arguments.same:
        pairs = [*again(arguments.same)]
        for values, _ in (pair for pair in pairs if pair[1] is None):
            print(f"gone: {Mutant(**values)}")
        wanted = [mutant for _, mutant in pairs if mutant is not None]
    else:
        wanted = drawn(arguments.seed, room)[: arguments.n]
    if arguments.write:
        lines = "".join(json.dumps(asdict(mutant)) + "\n" for mutant in wanted)
        arguments.write.write_text(lines, encoding="utf-8")
        return
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # ends what runs, as Ctrl-C does
    name = f"mutants-{room.replace('/', '-')}.jsonl"
    record = Record(arguments.out or ROOT / "runs" / name)
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        judge(wanted, tests, record, arguments.jobs, Path(folder))
    alive = [mutant for mutant in wanted if not record.killer(mutant)]
    print(f"\n{len(wanted) - len(alive)} of {len(wanted)} mutants are killed")
    for mutant in alive:
        print(f"  lives: {mutant}")


if __name__ == "__main__":
    main()
