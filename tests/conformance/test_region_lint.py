"""What the lint of regions says was measured: it differs or is alike; and what does not compile."""

import sys
from operator import attrgetter

import pytest
from numpy._core._multiarray_umath import __cpu_features__ as cpu_features

from mrsfi_runtime.engine.compiled.regions import CompilationError
from tests.conformance.regions import compile_alone, outcomes
from tests.support import lint_cases
from tests.support.edited import COLLECTIVE, REGION, write_region
from tests.support.lint_cases import written
from tests.tiers import seeds

DIFFERENT = lint_cases.DIFFERENT + lint_cases.CALLS
HELPERS = """
N, LIMITS, LISTED = 1, {'x': 2}, [2]


def unmarked(x):
    return x


@kernel
def recursive(n):
    if n < 2:
        return 1
    return n * recursive(n - 1)


@kernel
def listing(n, seen=[]):
    seen.append(n)
    return len(seen)
"""

EXCEPTION = "it tells exceptions apart; write `except Exception:`, or test before instead"
PYTHON = "'{}' of Python is not known to the compiler; write a loop, or leave it out"
LIBRARY = "'{}' is not known to the compiler; write the formula, or leave it out"
TEXT = "it makes a text; leave texts to the analysis"

REFUSED = [
    ("return sum(r.x for r in ci.robots) > 0.0", "it has a generator expression; write a loop"),
    ("return any([r.x > 0.0 for r in ci.robots])", PYTHON.format("any")),
    ("return len({k % 3 for k in range(9)})", "it has a set comprehension; write a loop"),
    (
        "if (t := ci.mission.tick) > 500:\n    return t\nreturn 0",
        "it has `:=`; assign on a line of its own",
    ),
    (
        "with open('x') as file:\n    return 1",
        "it has a `with`; leave it out: a region reads and commands `ci` alone",
    ),
    ("import math\nreturn math.pi", "it has an import; import in the region 'imports'"),
    ("global N\nN = 2\nreturn N", "it has a `global`; keep what lasts in the fields of `ci`"),
    (
        "class A:\n    pass\nreturn 1",
        "it has a class; write functions, or constants in the region 'helpers'",
    ),
    ("q = [1, 2]\ndel q[0]  # here\nreturn q[0]", "it has a `del`; leave the name alone"),
    ("try:\n    t = 1\nexcept IndexError:  # here\n    t = 2\nreturn t", EXCEPTION),
    ("try:\n    t = 1\nexcept Exception as e:  # here\n    t = 2\nreturn t", EXCEPTION),
    ("a, *b = (1, 2, 3)\nreturn b[0]", "it unpacks with a star; unpack by index"),
    ("return len(open('x').read())", PYTHON.format("open")),
    ("return time.time()", LIBRARY.format("time.time")),
    ("return math.fsum([ci.robots[0].x])", LIBRARY.format("math.fsum")),
    ("return min([1, 2, 3], key=lambda k: -k)", "'min' takes numbers alone; write a loop"),
    ("q = [r for r in ci.robots]\nreturn q[0].x", "it lists records; list their indices"),
    ("return ci.hazards.index(3)", "a list has no 'index' when compiled; write a loop"),
    (
        "t = 1\nreturn LIMITS['x'] > t  # here",
        "'LIMITS' is a global dict; write a number, or a tuple of numbers",
    ),
    ("t = 1\nreturn LISTED[0] > t  # here", "'LISTED' is a global list; write a tuple of numbers"),
    ("t = 1\nreturn unmarked(t)  # here", "'unmarked' is not marked @kernel; mark it"),
    ('return len(f"{ci.robots[0].x:.2f}")', TEXT),
    ('return len("%d" % ci.mission.tick)', TEXT),
    ('return len("{}".format(3))', TEXT),
    (
        "return recursive(3)",
        "'recursive' does not compile with what it is called with; a function cannot call itself",
    ),
    ("return listing(3)", "of an empty list no type is known; keep what lasts in `ci`"),
]
"""Bodies that the compiler refuses, and what it says; of the line ``# here``, or the first."""

WIDE = {
    *("numpy.arccos", "numpy.arcsin", "numpy.arctan", "numpy.arctan2", "numpy.tan"),
    *("numpy.arcsinh", "numpy.arctanh", "numpy.cosh", "numpy.sinh", "numpy.cbrt", "numpy.power"),
    *("numpy.exp", "numpy.exp2", "numpy.expm1", "numpy.log10", "numpy.log1p"),
}
"""Functions that numpy works out otherwise on processors with AVX-512, and as numba elsewhere."""


def _is_different(folder):
    return any(python != compiled for python, compiled in outcomes(folder))


@pytest.mark.parametrize("case", seeds(DIFFERENT, 1, 21), ids=attrgetter("name"))
def test_what_is_warned_of_compiles_and_differs(tmp_path, case):
    written(tmp_path, case)

    is_alike_here = case.name in WIDE and not cpu_features.get("AVX512_SKX")
    assert _is_different(tmp_path) != is_alike_here


@pytest.mark.parametrize(("body", "said"), REFUSED)
def test_what_does_not_compile_is_said_with_its_line_and_what_to_write(tmp_path, body, said):
    first = write_region(tmp_path, body, lint_cases.IMPORTS + HELPERS)
    line = first + next((n for n, text in enumerate(body.split("\n")) if "# here" in text), 0)

    with pytest.raises(CompilationError) as refused:
        compile_alone(tmp_path)

    where = f"{tmp_path / COLLECTIVE}:{line}: region {REGION}"
    assert str(refused.value) == f"{where} cannot be compiled: {said}"


@pytest.mark.parametrize("case", seeds(lint_cases.ALIKE, 0, 8), ids=attrgetter("name"))
def test_what_is_not_warned_of_is_alike(tmp_path, case):
    written(tmp_path, case)

    assert not _is_different(tmp_path)


def test_sums_of_floats_differ_from_python_3_12_on(tmp_path):
    written(tmp_path, lint_cases.SUMS)

    assert _is_different(tmp_path) == (sys.version_info >= (3, 12))
