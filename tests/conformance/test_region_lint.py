"""What the lint of regions says was measured: it differs or is alike; and what does not compile."""

import sys
from operator import attrgetter

import pytest
from numpy._core._multiarray_umath import __cpu_features__ as cpu_features

from mrsfi_runtime.engine.compiled.reach import CompilationError
from tests.conformance.regions import compile_alone, outcomes
from tests.support import lint_cases
from tests.support.edited import COLLECTIVE, REGION
from tests.support.lint_cases import named, written
from tests.tiers import in_turn, seeds

DIFFERENT = lint_cases.DIFFERENT + lint_cases.CALLS
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


@pytest.mark.parametrize("case", **named(lint_cases.NOT_COMPILED))
def test_what_does_not_compile_is_said_with_its_line_and_what_to_write(tmp_path, case):
    line = written(tmp_path, case)

    with pytest.raises(CompilationError) as refused:
        compile_alone(tmp_path)

    where = f"{tmp_path / COLLECTIVE}:{line}: region {REGION}"
    assert str(refused.value) == f"{where} cannot be compiled: {case.said}"


@pytest.mark.parametrize("case", in_turn(lint_cases.ALIKE), ids=attrgetter("name"))
def test_what_is_not_warned_of_is_alike(tmp_path, case):
    written(tmp_path, case)

    assert not _is_different(tmp_path)


def test_sums_of_floats_differ_from_python_3_12_on(tmp_path):
    written(tmp_path, lint_cases.SUMS)

    assert _is_different(tmp_path) == (sys.version_info >= (3, 12))
