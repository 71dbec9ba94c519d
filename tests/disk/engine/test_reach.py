"""What compiled code reaches from a module."""

import sys
from pathlib import Path

import numpy as np
import pytest

from mrsfi_runtime.engine.compiled.reach import constants, kernel_functions, sources
from mrsfi_runtime.mission import load_module

KERNEL = "from mrsfi_runtime.api import kernel\n"
FILES = {
    "reach_limits": "LIMIT = 3.5\nUNREAD = 4\nOBJECT = object()\n",
    "reach_pack/__init__": "",
    "reach_pack/inner": f"{KERNEL}import reach_limits\n"
    "@kernel\ndef inner():\n    return reach_limits.LIMIT\n",
    "reach_pack/outer": f"{KERNEL}import reach_pack.inner\n"
    "@kernel\ndef outer():\n    return reach_pack.inner.inner()\n",
    "reach_first": f"{KERNEL}from reach_limits import OBJECT\nimport reach_pack.outer\n"
    "@kernel\ndef first():\n    OBJECT\n    return reach_pack.outer.outer()\n"
    "def plain():\n    return 0\n",
    "reach_made": f"{KERNEL}import enum\nimport reach_limits\n"
    "class Size(enum.Enum):\n    BIG = 6\n"
    "def made(around, called):\n    @kernel\n    def inner(given=(1, around)):\n"
    "        return [around + called() + reach_limits.LIMIT for _ in range(Size.BIG.value)]\n"
    "    return inner\n"
    "@kernel\ndef five():\n    return 5\n"
    "made = made(2.5, five)\n",
}


@pytest.fixture
def first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    for name, text in FILES.items():
        path = tmp_path / f"{name}.py"
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    yield load_module("reach_first", tmp_path / "reach_first.py")
    for name in [name for name in sys.modules if name.startswith("reach_")]:
        del sys.modules[name]


def test_functions_are_reached_through_modules_and_packages(first):
    found = {function.__name__ for function in kernel_functions(first)}

    assert found == {"first", "outer", "inner"}


def test_files_are_those_of_the_functions(first, tmp_path):
    names = ("reach_first", "reach_pack/inner", "reach_pack/outer")

    assert sources(first) == sorted(tmp_path / f"{name}.py" for name in names)


def test_constants_are_those_that_are_read_and_that_numba_freezes(first):
    assert constants(first) == ["reach_pack.inner.reach_limits.LIMIT 3.5"]


def test_what_a_function_was_made_with_and_what_its_comprehensions_read_is_reached(first, tmp_path):
    module = load_module("reach_made", tmp_path / "reach_made.py")

    assert {function.__name__ for function in kernel_functions(module)} == {"inner", "five"}
    assert constants(module) == [
        "reach_made.Size [<Size.BIG: 6>]",
        "reach_made.around 2.5",
        "reach_made.inner, default 0 (1, 2.5)",
        "reach_made.reach_limits.LIMIT 3.5",
    ]


def test_long_arrays_are_told_apart(first):
    first.TABLE = np.zeros(10_000)
    first.first.__globals__["OBJECT"] = first.TABLE
    before = constants(first)
    first.TABLE[5_000] = 1.0

    assert constants(first) != before
