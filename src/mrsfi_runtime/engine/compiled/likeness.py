"""Keeps compiled regions from what plain Python refuses, where numba alone would not.

To it a list of the state is an array, with more attributes and operators, and a record of an array
of the team's is like one of the state.
"""

from typing import Any, get_args, get_type_hints

from numba import types
from numba.core.compiler import Compiler, DefaultPassBuilder
from numba.core.compiler_machinery import AnalysisPass, register_pass
from numba.core.errors import TypingError
from numba.core.typed_passes import NopythonTypeInference

from mrsfi_runtime.engine.compiled.directories import ALLOWED
from mrsfi_runtime.kernel.injections import OwnFault
from mrsfi_runtime.kernel.state import State

_KNOWN = tuple(
    get_type_hints(record).keys()
    for kind in (State, OwnFault, *get_type_hints(State).values())
    for record in (*get_args(kind), kind)
    if hasattr(record, "__dataclass_fields__")
)
"""Names of the fields of all records that a region is given."""

_OPERATORS = ("binop", "inplace_binop", "unary")


@register_pass(mutates_CFG=False, analysis_only=True)
class _LikePython(AnalysisPass):
    """Refuses what objects of the reference engine do not have."""

    _name = "like_python"

    def __init__(self) -> None:
        """Hold nothing."""

    def run_pass(self, state: Any) -> bool:
        """Look at every expression of a function that is not ours."""
        is_ours = state.func_id.func.__module__.startswith("mrsfi_runtime.")
        for block in () if is_ours else state.func_ir.blocks.values():
            for found in block.find_exprs():
                named = {"getattr": "attr", "static_getitem": "index"}.get(found.op)
                name = getattr(found, named) if named else ""
                if isinstance(name, str) and (named or found.op in _OPERATORS):
                    kinds = [state.typemap[each.name] for each in found.list_vars()]
                    if any(_refused(kind, found.op, name) for kind in kinds):
                        what = f"'{name or found.fn.__name__}'"
                        raise TypingError(f"{what} is not in Python what it is here", loc=found.loc)
        return False


def _refused(kind: Any, op: str, name: str) -> bool:
    """Return whether Python refuses an operator, an attribute or an entry by name of an operand."""
    if isinstance(kind, types.Record):
        return (kind.fields.keys() - {ALLOWED} in _KNOWN) != (op == "getattr")
    is_of_records = isinstance(kind, types.Array) and isinstance(kind.dtype, types.Record)
    is_list = is_of_records or isinstance(kind, types.NestedArray)
    return is_list or (isinstance(kind, types.Number) and name == "item")


class Checked(Compiler):
    """Numba's pipeline, and what Python refuses refused."""

    def define_pipelines(self) -> list[Any]:
        """Return it."""
        passes: Any = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.add_pass_after(_LikePython, NopythonTypeInference)
        passes.finalize()
        return [passes]
