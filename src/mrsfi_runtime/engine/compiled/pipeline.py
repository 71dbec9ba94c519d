"""Numba's pipeline: for regions it refuses what Python does, and what others call it inlines.

To numba alone a list of the state is an array, with more attributes and operators, and a record of
an array of the team's is like one of the state.

Numba optimises every function with all that it calls, and writes machine code for it. Here they
are kept as they were lowered, and optimised once, where they end up. That takes some two fifths of
compilation away.
"""

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any, get_args, get_type_hints

from numba import types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, DefaultPassBuilder
from numba.core.compiler_machinery import AnalysisPass, register_pass
from numba.core.errors import TypingError
from numba.core.runtime.nrt import rtsys
from numba.core.typed_passes import NopythonTypeInference
from numba.extending import register_jitable

from mrsfi_runtime.engine.compiled.layout import ALLOWED
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


class Inlined(Checked):
    """Numba's pipeline, for ``pipeline_class`` of functions that others call."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)  # type: ignore[no-untyped-call]
        codegen = self.state.targetctx.codegen()
        self.state.library = _Library(codegen, "inlined")  # type: ignore[no-untyped-call]


class _Library(JITCodeLibrary):
    """A function's code, to be linked into what calls it."""

    def finalize(self) -> None:
        self._final_module.verify()
        self._finalized = True

    def get_pointer_to_function(self, _: str) -> int:
        """Return the address of nothing."""
        self.linked()
        return 0

    @property
    def codegen(self) -> SimpleNamespace:
        """What sets environments: there is no machine code yet that could have one."""
        return SimpleNamespace(set_env=lambda *_: None)

    def linked(self) -> Any:
        """Return the code without that of what it calls."""
        self._ensure_finalized()  # type: ignore[no-untyped-call]
        return self._final_module

    def reached(self) -> Iterator[Any]:
        return iter(self._linking_libraries)

    def whole(self) -> Any:
        """Return the code with that of all functions that it calls, however deep."""
        if self._shared_module is None:
            module = self.linked().clone()
            for library in sorted(_closure(self)[1:], key=_rank):
                module.link_in(_code(library), preserve=True)
            for function in module.functions:
                if not function.is_declaration and function.linkage.name == "external":
                    function.linkage = "linkonce_odr"
            self._shared_module = module
        return self._shared_module

    _get_module_for_linking = whole


def _closure(first: _Library) -> list[Any]:
    found: list[Any] = [first]
    for library in found:
        for each in library.reached() if isinstance(library, _Library) else ():
            if each not in found:
                found.append(each)
    return found


def _rank(library: Any) -> int:
    """Return when to link: of numba's own code only what is called by then is taken."""
    return 2 if library is rtsys.library else not isinstance(library, _Library)


def _code(library: Any) -> Any:
    if isinstance(library, _Library):
        return library.linked()
    return library._get_module_for_linking()  # noqa: SLF001 - numba's own libraries ask each other


jitable = register_jitable(boundscheck=True, no_cfunc_wrapper=True, pipeline_class=Inlined)
"""Lets compiled code call a function, which stays as it is."""
