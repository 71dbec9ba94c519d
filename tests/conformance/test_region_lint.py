"""What the lint of regions says was measured: it differs, does not compile, or is alike."""

import sys
from operator import attrgetter

import pytest
from numba.core.errors import NumbaError, UnsupportedBytecodeError
from numpy._core._multiarray_umath import __cpu_features__ as cpu_features

from mrsfi_runtime.engine.region_names import NAMES
from tests.conformance.regions import outcomes
from tests.support import lint_cases
from tests.support.lint_cases import named, written
from tests.tiers import in_turn, seeds

DIFFERENT = lint_cases.DIFFERENT + [
    case for case in lint_cases.CALLS if NAMES[case.name].does_compile
]
NOT_COMPILED = (
    lint_cases.NOT_COMPILED
    + lint_cases.HELPERS
    + [case for case in lint_cases.CALLS if not NAMES[case.name].does_compile]
)
ERRORS = (NumbaError, UnsupportedBytecodeError, NotImplementedError, AssertionError, ValueError)


WIDE = {
    *("numpy.arccos", "numpy.arcsin", "numpy.arctan", "numpy.arctan2", "numpy.tan"),
    *("numpy.arcsinh", "numpy.arctanh", "numpy.cosh", "numpy.sinh", "numpy.cbrt", "numpy.power"),
    *("numpy.exp", "numpy.exp2", "numpy.expm1", "numpy.log10", "numpy.log1p"),
}
"""Functions that numpy works out otherwise on processors with AVX-512, and as numba elsewhere."""


def _is_different(folder):
    return any(python != compiled for python, compiled in outcomes(folder))


@pytest.mark.parametrize("case", seeds(DIFFERENT, 1), ids=attrgetter("name"))
def test_what_is_warned_of_compiles_and_differs(tmp_path, case):
    written(tmp_path, case)

    is_alike_here = case.name in WIDE and not cpu_features.get("AVX512_SKX")
    assert _is_different(tmp_path) != is_alike_here


@pytest.mark.parametrize("case", **named(NOT_COMPILED))
def test_what_is_said_not_to_compile_does_not(tmp_path, case):
    written(tmp_path, case)

    with pytest.raises(ERRORS):
        list(outcomes(tmp_path, 1))


@pytest.mark.parametrize("case", in_turn(lint_cases.ALIKE), ids=attrgetter("name"))
def test_what_is_not_warned_of_is_alike(tmp_path, case):
    written(tmp_path, case)

    assert not _is_different(tmp_path)


def test_sums_of_floats_differ_from_python_3_12_on(tmp_path):
    written(tmp_path, lint_cases.SUMS)

    assert _is_different(tmp_path) == (sys.version_info >= (3, 12))
