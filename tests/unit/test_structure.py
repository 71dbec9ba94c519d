"""How modules lie in folders and import each other, and how tests are spread."""

import ast
import os
import socket
import subprocess
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from graphlib import CycleError, TopologicalSorter
from multiprocessing import get_context

import pytest

from tests.support.tree import ROOT
from tests.tiers import night, seeds, slow

PLUG_INS = {"src/mrsfi", "src/mrsfi_runtime/kernel/goal_tasks"}
"""Folders that may have more, as CONTRIBUTING.md lists them."""
MOST_MODULES = 10
FILES = {
    ".".join(path.relative_to(root).with_suffix("").parts).removesuffix(".__init__"): path
    for root in (ROOT, ROOT / "src")
    for package in ("m2t", "mrsfi", "mrsfi_bridge", "mrsfi_runtime")
    for path in (root / package).rglob("*.py")
}
"""All modules of src and m2t by the names that imports give them."""


def run_nodes(node: ast.AST) -> Iterator[ast.AST]:
    """Yield a node and all below it, but what only a type checker reads."""
    yield node
    is_of_types = isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
    for child in node.orelse if is_of_types else ast.iter_child_nodes(node):
        yield from run_nodes(child)


def imported(text: str) -> Iterator[str]:
    """Yield the modules of the tree that a text imports, inside functions too."""
    for node in run_nodes(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in FILES)
        elif isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            yield from (name if name in FILES else str(node.module) for name in names)


def test_no_module_imports_itself_by_way_of_others():
    imports = {name: {*imported(path.read_text())} & FILES.keys() for name, path in FILES.items()}

    cycle = []
    try:
        TopologicalSorter(imports).prepare()
    except CycleError as error:
        cycle = error.args[1]

    assert cycle == []


def test_folders_have_at_most_ten_modules_unless_they_hold_plug_ins():
    folders = Counter(
        path.parent.relative_to(ROOT).as_posix()
        for path in FILES.values()
        if path.name != "__init__.py"
    )
    full = {folder for folder, n_modules in folders.items() if n_modules > MOST_MODULES}

    assert full <= PLUG_INS


def test_imports_inside_functions_count_and_those_of_types_do_not():
    text = "if TYPE_CHECKING:\n import mrsfi.engines\ndef late():\n from mrsfi import engines\n"

    assert [*imported(text)] == ["mrsfi.engines"]


def test_first_seeds_are_plain_the_next_slow_and_all_others_of_the_night():
    assert seeds("abcd", 1, 2) == [
        "a",
        pytest.param("b", marks=slow),
        pytest.param("c", marks=slow),
        pytest.param("d", marks=night),
    ]


@pytest.mark.parametrize(
    "forbidden",
    [
        lambda: subprocess.run(["true"], check=True),
        lambda: get_context("spawn").Process(target=print).start(),
        lambda: os.fork() or os._exit(0),
        socket.socket,
    ],
)
def test_a_process_and_a_socket_fail_a_test_here_also_where_errors_are_caught(forbidden):
    with pytest.raises(pytest.fail.Exception, match="a test of tests/unit "), suppress(Exception):
        forbidden()
