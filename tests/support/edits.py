"""Kinds of edits of what a region reaches, each to be seen where it was compiled before.

``EDITS`` has by kind: files of a team, of which ``edit_team`` has a function ``verdict(x)``; the
text that is edited, in whichever of them it stands; and what it becomes.
"""

import importlib
import sys
from collections.abc import Mapping
from pathlib import Path

KERNEL = "from mrsfi_runtime.api import kernel\n"
TWO = """
@kernel
def careful(x):
    return x - 1.0
@kernel
def bold(x):
    return x + 1.0
"""
OTHER = KERNEL + TWO
COLORS = "import enum\nclass Low(enum.IntEnum):\n    A = 1\nclass High(enum.IntEnum):\n    A = 2\n"


_COMPUTED = """def __getattr__(name):
    if name != 'LIMIT':
        raise AttributeError(name)
    return 1.0
"""


def _edit(
    body: str, names: str, old: str, new: str, other: str = "", arguments: str = "x"
) -> tuple[Mapping[str, str], str, str]:
    """Return the files of a function, and an edit of them."""
    return _files(body, names, other, arguments), old, new


def _files(body: str, names: str, other: str = "", arguments: str = "x") -> Mapping[str, str]:
    """Return a function in one file, and what its names stand for in others."""
    verdict = f"{KERNEL}from edit_names import *\n@kernel\ndef verdict({arguments}):\n"
    files = {"edit_team": f"{verdict}    return {body}\n", "edit_names": f"{KERNEL}{names}\n"}
    return files | ({"edit_other": other} if other else {})


def _extended(how: str, arguments: str = "x", mark: str = "") -> str:
    """Return a function, and another one that numba compiles in the place of what is said."""
    return (
        "from numba import types\n"
        "from numba.extending import overload, overload_attribute, overload_method\n"
        f"{mark}\ndef near(x):\n    return x\noverloaded = 1.0\n{how}\ndef compiled({arguments}):\n"
        f"    return lambda {arguments}: overloaded\n"
    )


def _numbers(last: float) -> str:
    return f"import numpy as np\nTABLE = np.arange(5000) * 0.1\nTABLE[2500] = {last}\n"


EDITS: Mapping[str, tuple[Mapping[str, str], str, str]] = {
    "alias of an import": _edit(
        "policy(x)",
        "from edit_other import careful as policy",
        "careful as policy",
        "bold as policy",
        OTHER,
    ),
    "default of an argument": _edit(
        "pick(x, 2.0)", "PICK = min", "PICK = min", "PICK = max", arguments="x, pick=PICK"
    ),
    "default of a keyword": _edit(
        "by(x)", "@kernel\ndef by(x, *, step=1.0):\n    return x + step\n", "step=1.0", "step=2.0"
    ),
    "a library's function behind a name": _edit(
        "whole(x)", "from math import floor as whole", "floor", "ceil"
    ),
    "a builtin behind a name": _edit("pick(x, 2.0)", "pick = min", "pick = min", "pick = max"),
    "alias of a constant": _edit(
        "x + LIMIT",
        "from edit_other import LOW as LIMIT",
        "LOW as",
        "HIGH as",
        "LOW, HIGH = 1.0, 2.0\n",
    ),
    "alias of a class": _edit("kind(x)", "kind = int", "= int", "= float"),
    "fields of a class": _edit(
        "Point(x, 1.0).a",
        "from typing import NamedTuple\nclass Point(NamedTuple):\n    a: float\n    b: float\n",
        "    a: float\n    b: float\n",
        "    b: float\n    a: float\n",
    ),
    "alias of an enum": _edit(
        "x if Color.A > 1 else -x",
        "from edit_other import Low as Color",
        "Low as",
        "High as",
        COLORS,
    ),
    "value of an enum": _edit(
        "x if Low.A > 1 else -x", "from edit_other import Low", "A = 1", "A = 3", COLORS
    ),
    "swapped closures": _edit(
        "first(x) - 2.0 * second(x)",
        "from edit_other import made\nfirst, second = made(3.0), made(5.0)",
        "first, second =",
        "second, first =",
        f"{KERNEL}def made(step):\n    @kernel\n    def by(x):\n"
        "        return x * step\n    return by\n",
    ),
    "a tuple of functions": _edit(
        "ALL[0](x)",
        "from edit_other import careful, bold\nALL = (careful, bold)",
        "(careful, bold)",
        "(bold, careful)",
        OTHER,
    ),
    "a tuple of long arrays": _edit(
        "x + ALL[0][2500]",
        "from edit_other import TABLE\nALL = (TABLE,)",
        "7.0",
        "8.0",
        _numbers(7.0),
    ),
    "nearly equal digits": _edit(
        "x * 0.0 + TABLE[2500]",
        "from edit_other import TABLE",
        "= 0.1\n",
        "= 0.10000000000000002\n",
        _numbers(0.1),
    ),
    "a nested tuple": _edit("x + ALL[0][1]", "ALL = ((1, 2.5), 3)", "2.5", "4.5"),
    "a helper of a helper in another file": _edit(
        "inner(inner(x))",
        "from edit_other import inner",
        "x * 2.0",
        "x * 3.0",
        f"{KERNEL}@kernel\ndef inner(x):\n    return x * 2.0\n",
    ),
    "a marked lambda": _edit("by(x)", "by = kernel(lambda x: x + 1.0)", "x + 1.0", "x + 2.0"),
    "what a module's name stands for": _edit(
        "edit_other.policy(x)",
        "import edit_other",
        "policy = careful",
        "policy = bold",
        f"{OTHER}policy = careful\n",
    ),
    "what a star imports": _edit(
        "x + LIMIT", "from edit_other import *", "1.0", "2.0", "LIMIT = 1.0\n"
    ),
    "a constant that an import computes": _edit(
        "x + LIMIT",
        "from edit_other import LIMIT",
        "range(9)",
        "range(8)",
        "LIMIT = sum(k * 0.5 for k in range(9))\n",
    ),
    "a wrapped helper": _edit(
        "by(x)",
        "def twice(inner):\n    @kernel\n    def outer(x):\n"
        "        return inner(inner(x))\n    return outer\n"
        "@twice\n@kernel\ndef by(x):\n    return x + 1.0\n",
        "x + 1.0",
        "x + 2.0",
    ),
    "a global in a comprehension": _edit(
        "max([x * STEP for _ in range(2)])", "STEP = 1.5", "1.5", "2.5"
    ),
    "a text": _edit(
        "x if MODE == 'near' else -x", "MODE = 'near'", "MODE = 'near'", "MODE = 'away'"
    ),
    "a number of numpy": _edit(
        "x + LIMIT",
        "import numpy as np\nLIMIT = np.float64(1.0)",
        "np.float64(1.0)",
        "np.float64(1.1)",
    ),
    "an attribute of a function": _edit(
        "x + by.step",
        "@kernel\ndef by(x):\n    return x\nby.step = 1.0\n",
        "step = 1.0",
        "step = 2.0",
    ),
    "a conditional import": _edit(
        "policy(x)",
        "IS_BOLD = False\nif IS_BOLD:\n    from edit_other import bold as policy\n"
        "else:\n    from edit_other import careful as policy",
        "IS_BOLD = False",
        "IS_BOLD = True",
        OTHER,
    ),
}

REFUSED: Mapping[str, Mapping[str, str]] = {
    "a partial function": _files(
        "by(x)",
        (
            "from functools import partial\nfrom edit_other import careful, bold\n"
            "by = partial(careful)"
        ),
        OTHER,
    ),
    "an object": _files("LIMIT.value + x", "class Limit:\n    value = 1.0\nLIMIT = Limit()"),
    "an attribute that a module computes": _files(
        "x + edit_other.LIMIT", "import edit_other", _COMPUTED
    ),
    "an attribute that the class of a module computes": _files(
        "x + edit_other.LIMIT",
        "import edit_other",
        (
            "import sys, types\nclass Limits(types.ModuleType):\n"
            "    LIMIT = property(lambda self: 1.0)\nsys.modules[__name__].__class__ = Limits\n"
        ),
    ),
    "an attribute that a module of a module computes": _files(
        "x + names.edit_other.LIMIT",
        "import sys, edit_other\nnames = sys.modules[__name__]\n",
        _COMPUTED,
    ),
    "an overload of a function": _files("near(x)", _extended("@overload(near)")),
    "an overload of a function behind another name": _files(
        "by(x)", _extended("@overload(near)") + "by = near\n"
    ),
    "an overload of a marked function": _files(
        "near(x)", _extended("@overload(near)", mark="@kernel")
    ),
    "an overload of a library's function": _files(
        "floor(x)", "from math import floor\n" + _extended("@overload(floor)")
    ),
    "an overload of a function of numpy": _files(
        "numpy.hypot(x, 1.0)", "import numpy\n" + _extended("@overload(numpy.hypot)", "x, y")
    ),
    "a function that numba is to compile": _files(
        "near(x)",
        (
            "from numba.extending import register_jitable\nLIMIT = 1.0\n"
            "@register_jitable\ndef near(x):\n    return x + LIMIT\n"
        ),
    ),
    "an intrinsic": _files(
        "near(x)",
        (
            "from numba import types\nfrom numba.extending import intrinsic\n@intrinsic\n"
            "def near(context, x):\n    def made(context, builder, signature, values):\n"
            "        return context.get_constant(types.float64, 1.0)\n"
            "    return types.float64(x), made\n"
        ),
    ),
    "an overload of a method": _files(
        "x.conjugate()", _extended("@overload_method(types.Float, 'conjugate')")
    ),
    "an overload of an attribute": _files(
        "x.real", _extended("@overload_attribute(types.Float, 'real')")
    ),
    "an overload of an operator": _files(
        "x % 2.0", "import operator\n" + _extended("@overload(operator.mod)", "x, y")
    ),
}
"""Kinds of which no text tells the value: they are never edited."""

NUMBA_REFUSES = ("default of a keyword", "a tuple of functions", "an attribute of a function")


MODULES = ("edit_team", "edit_names", "edit_other")


def write_team(folder: Path, kind: str, *, is_edited: bool, number: str = "") -> str:
    """Write the files of a kind of edit, before it or after; the next import finds those.

    Returns the name of the module of ``verdict``; all have a number, if any.
    """
    files, old, new = EDITS[kind] if kind in EDITS else (REFUSED[kind], "\0", "")
    assert kind in REFUSED or sum(text.count(old) for text in files.values()) == 1
    for name, text in files.items():
        written = text.replace(old, new) if is_edited else text
        for module in MODULES:
            written = written.replace(module, f"{module}{number}")
            sys.modules.pop(f"{module}{number}", None)
        (folder / f"{name}{number}.py").write_text(written, encoding="utf-8")
    importlib.invalidate_caches()
    return f"edit_team{number}"
