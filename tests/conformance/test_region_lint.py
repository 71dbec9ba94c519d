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

REFUSED = [
    "return sum(r.x for r in ci.robots) > 0.0",
    "return any([r.x > 0.0 for r in ci.robots])",
    "return len({k % 3 for k in range(9)})",
    "if (t := ci.mission.tick) > 500:\n    return t\nreturn 0",
    "with open('x') as file:\n    return 1",
    "import math\nreturn math.pi",
    "global N\nN = 2\nreturn N",
    "class A:\n    pass\nreturn 1",
    "q = [1, 2]\ndel q[0]  # here\nreturn q[0]",
    "try:\n    t = 1\nexcept IndexError:  # here\n    t = 2\nreturn t",
    "try:\n    t = 1\nexcept Exception as e:  # here\n    t = 2\nreturn t",
    "a, *b = (1, 2, 3)\nreturn b[0]",
    "return len(open('x').read())",
    "return time.time()",
    "return math.fsum([ci.robots[0].x])",
    "return min([1, 2, 3], key=lambda k: -k)",
    "q = [r for r in ci.robots]\nreturn q[0].x",
    "return ci.hazards.index(3)",
    "t = 1\nreturn LIMITS['x'] > t  # here",
    "t = 1\nreturn LISTED[0] > t  # here",
    "t = 1\nreturn unmarked(t)  # here",
    'return len(f"{ci.robots[0].x:.2f}")',
    'return len("%d" % ci.mission.tick)',
    'return len("{}".format(3))',
    "return recursive(3)",
    "return listing(3)",
]
"""Bodies that the compiler refuses; of the line ``# here``, or the first."""

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


@pytest.mark.parametrize("body", REFUSED)
def test_what_does_not_compile_is_said_with_its_line_and_what_to_write(tmp_path, body, refused):
    first = write_region(tmp_path, body, lint_cases.IMPORTS + HELPERS)
    line = first + next((n for n, text in enumerate(body.split("\n")) if "# here" in text), 0)

    with refused(CompilationError) as caught:
        compile_alone(tmp_path)

    assert str(caught.value).startswith(f"{tmp_path / COLLECTIVE}:{line}: region {REGION} ")


@pytest.mark.parametrize("case", seeds(lint_cases.ALIKE, 0, 8), ids=attrgetter("name"))
def test_what_is_not_warned_of_is_alike(tmp_path, case):
    written(tmp_path, case)

    assert not _is_different(tmp_path)


def test_sums_of_floats_differ_from_python_3_12_on(tmp_path):
    written(tmp_path, lint_cases.SUMS)

    assert _is_different(tmp_path) == (sys.version_info >= (3, 12))
