"""Names that compiled regions had better not use: why, and what to write instead.

Everything here was measured, CPython 3.11 against numba 0.68 on x86-64: see
``tests/conformance/test_region_lint.py``. What is not listed was found the same, such as
``//``, ``%``, ``round(x)``, ``math.sqrt`` and, on this processor family, ``math.sin``.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple


class Remark(NamedTuple):
    """Why a name is remarked upon, as a sentence ends; whether it compiles, to something else."""

    does_compile: bool
    why: str


_LAST_BIT = "may differ in the last bit when compiled"
_NOT_COMPILED = "cannot be compiled"

_DRAWS = Remark(
    True,
    "draws other numbers when compiled, if it compiles at all; write randomness.uniform or "
    "randomness.choice, which draw the same everywhere",
)
_HYPOT = Remark(True, f"{_LAST_BIT}; write math.sqrt(x * x + y * y)")
_GAMMA = Remark(True, f"{_LAST_BIT}; read the values from a table in the team's own constants")
_MATH = Remark(True, f"{_LAST_BIT}; write the function of math, or read a table")
_SUM = Remark(True, "adds in another order when compiled; add in a loop")
_ARGSORT = Remark(True, "may order equals otherwise when compiled; sort tuples of value and index")
_FORMULA = Remark(False, f"{_NOT_COMPILED}; write the formula with + - * / // % and math.sqrt")
_LOOP = Remark(False, f"{_NOT_COMPILED}; write a loop")
_EFFECT = Remark(False, f"{_NOT_COMPILED}; leave it out: a region reads and commands `ci` alone")

_UNCOMPILED_MATH = (
    "cbrt", "comb", "dist", "factorial", "fmod", "fsum", "isclose", "isqrt", "lcm", "modf",
    "perm", "prod", "remainder", "ulp",
)  # fmt: skip
_ROUNDED_NUMPY = (
    "arccos", "arcsin", "arcsinh", "arctan", "arctan2", "arctanh", "cbrt", "cosh", "exp", "exp2",
    "expm1", "log10", "log1p", "power", "sinh", "tan", "tanh",
)  # fmt: skip
_SUMS_OF_NUMPY = ("average", "linalg.norm", "mean", "nanmean", "nansum", "std", "sum", "var")

NAMES: Mapping[str, Remark] = MappingProxyType(
    {
        "math.hypot": _HYPOT,
        "math.gamma": _GAMMA,
        "math.lgamma": _GAMMA,
        **{f"math.{name}": _FORMULA for name in _UNCOMPILED_MATH},
        **{f"numpy.{name}": _MATH for name in _ROUNDED_NUMPY},
        **{f"numpy.{name}": _SUM for name in _SUMS_OF_NUMPY},
        "numpy.argsort": _ARGSORT,
        **dict.fromkeys(("all", "any", "reversed"), _LOOP),
        **dict.fromkeys(("format", "id", "input", "open", "setattr"), _EFFECT),
    }
)
"""Remarks by dotted name, as it is after imports."""

PACKAGES: Mapping[str, Remark] = MappingProxyType(
    {
        "random": _DRAWS,
        "numpy.random": _DRAWS,
        **dict.fromkeys(("datetime", "logging", "os", "sys", "time"), _EFFECT),
    }
)
"""Remarks on everything in a module."""


def remark_on(name: str) -> Remark | None:
    """Return what is remarked upon a dotted name, if anything."""
    parts = name.split(".")
    parents = [".".join(parts[:n]) for n in range(1, len(parts))]
    remarks = (NAMES.get(name), *map(PACKAGES.get, parents))
    return next((remark for remark in remarks if remark), None)
