"""Compiles the kernel's flight, and regions of a team, to object files; this alone takes numba."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

from numba import types
from numba.core import compiler
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target

from mrsfi_runtime.engine.compiled import views
from mrsfi_runtime.engine.compiled.batch_flight import BY_TASK, Flights, fly_many
from mrsfi_runtime.engine.compiled.compilation_errors import explain
from mrsfi_runtime.engine.compiled.layout import CALLS
from mrsfi_runtime.engine.compiled.machine_code import MachineCode, lend_runtime
from mrsfi_runtime.engine.compiled.pipeline import Inlined, jitable
from mrsfi_runtime.engine.compiled.reach import Reached, names_of
from mrsfi_runtime.engine.compiled.regions import EFFECT, ROLES, CompilationError, Region
from mrsfi_runtime.kernel.goal_tasks.table import FUNCTIONS
from mrsfi_runtime.kernel.state import is_kernel

_FLIGHT = (views.View(Flights), types.int64, types.int64)
_TYPING, _TARGET = cpu_target.typing_context, cpu_target.target_context
lend_runtime()
_REGISTERED: dict[FunctionType, str] = {}


def compiled_kernel(machine: Any = None) -> MachineCode:
    """Compile the kernel's flight, for this machine or another."""
    functions = (fly_many, *BY_TASK)
    register(each for one in functions for each in _reached_by(one)[1:])
    arguments = (_FLIGHT, *(views.BY_TASK for _ in BY_TASK))
    found: MachineCode = _compiled(zip(functions, arguments, strict=True), machine)
    return found


def compiled_region(directory: Path, region: Region, reached: Reached) -> MachineCode:
    """Compile a region of a mission, or raise which line of it does not compile."""
    register(reached.functions)
    try:
        with _by_address():
            found: MachineCode = _compiled([(_called(region), views.arguments_of(region.role))])
    except OSError:
        raise
    except Exception as error:
        raise explain(directory, region, reached.functions, error) from error
    return found


def register(functions: Iterable[FunctionType]) -> None:
    """Let compiled code call functions, unless they read other values than when first compiled."""
    for function in functions:
        is_ours = function.__module__.startswith("mrsfi_runtime.")
        text = "" if is_ours else Reached([function], is_deep=False).text
        if function not in _REGISTERED:
            _REGISTERED[function] = text
            jitable(function)
        if _REGISTERED[function] != text:
            code = function.__code__
            raise CompilationError(
                f"{code.co_filename}:{code.co_firstlineno}: what '{function.__name__}' reads has "
                "changed since this process compiled it; begin another process"
            )


def _called(region: Region) -> Callable[..., Any]:
    """Return what the kernel calls: every region returns an integer."""
    function = region.function

    def apply(ci: Any, inbox: Any, fault: Any) -> int:
        function(ci, inbox, fault)
        return 0

    def check(view: Any) -> int:
        return 1 if function(view) else 0

    def act(view: Any) -> int:
        function(view)
        return 0

    known: dict[str, Callable[..., Any]] = {EFFECT: apply, "check": check}
    return known.get(region.role, act)


@contextmanager
def _by_address() -> Iterator[None]:
    """Have regions call what a task says where the kernel has it: much of it compiles long."""
    register(_STAND_INS)
    register(_STAND_INS.values())
    _TYPING.refresh()
    typed = _TYPING._lookup_global  # noqa: SLF001 - numba has no other name for it
    known = {each: typed(each) for each in _STAND_INS}
    try:
        for function, stand_in in _STAND_INS.items():
            _know(function, typed(stand_in))
        yield
    finally:
        for function, kind in known.items():
            _know(function, kind)


def _know(function: FunctionType, kind: Any) -> None:
    _TYPING._remove_global(function)  # noqa: SLF001 - likewise
    _TYPING.insert_global(function, kind)


def _stand_in(role: str, task: int) -> Any:
    """Return what calls by address what a task says."""
    place = 1 + ROLES.index(role)

    def check(view: Any, g: int) -> bool:
        address = getattr(view, CALLS)[3 * len(view.goals) + place]
        return bool(views.call_by_task(address, view, g, task))

    def act(view: Any, g: int) -> None:
        views.call_by_task(getattr(view, CALLS)[3 * len(view.goals) + place], view, g, task)

    return check if role == "check" else act


_STAND_INS: dict[Any, Any] = {
    function: _stand_in(role, task)
    for role, functions in FUNCTIONS.items()
    for task, function in enumerate(functions)
    if function is not None
}
"""Of what generated regions call, in regions of a team."""


def _reached_by(first: Any) -> list[FunctionType]:
    found: list[FunctionType] = [first]
    for function in found:
        names = set(names_of(function.__code__))
        read = [function.__globals__[name] for name in names & function.__globals__.keys()]
        for module in [each for each in read if isinstance(each, ModuleType)]:
            read += [vars(module)[name] for name in names & vars(module).keys()]
        found += [each for each in dict.fromkeys(filter(is_kernel, read)) if each not in found]
    return found


@global_compiler_lock  # type: ignore[untyped-decorator]
def _compiled(
    functions: Iterable[tuple[Callable[..., Any], tuple[Any, ...]]], machine: Any = None
) -> MachineCode:
    """Return the machine code of functions, by their arguments; each returns an integer."""
    flags: Any = compiler.Flags()
    flags.nrt = flags.boundscheck = flags.no_compile = True
    flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
    _TYPING.refresh()
    _TARGET.refresh()
    names = []
    module: Any = None
    for function, arguments in functions:
        result = compiler.compile_extra(
            _TYPING, _TARGET, function, arguments, types.int64, flags, {}, pipeline_class=Inlined
        )
        names.append(result.fndesc.llvm_func_name)
        found = _optimised(_TARGET.codegen(), result.library.whole(), names[-1])
        if module is None:
            module = found
        else:
            module.link_in(found)
    machine = machine or _TARGET.codegen()._tm  # noqa: SLF001 - numba's own
    binary = machine.emit_object(module)
    known = (*module.functions, *module.global_variables)
    taken = [each.name for each in known if each.is_declaration]
    return MachineCode(tuple(names), binary, tuple(n for n in taken if not n.startswith("llvm.")))


def _optimised(codegen: Any, module: Any, name: str) -> Any:
    """Return a module of which one function is called from elsewhere, optimised.

    Loops are short as a rule: more optimisation takes longer, and makes flights slower. So does a
    second function in the same module, because what both call is not inlined.
    """
    for each in (*module.functions, *module.global_variables):
        if not each.is_declaration:
            each.linkage = "external" if each.name == name else "internal"
    passes, builder = codegen._module_pass_manager(  # noqa: SLF001
        opt=2, loop_vectorize=False, slp_vectorize=False
    )
    passes.add_global_dead_code_eliminate_pass()
    passes.run(module, builder)
    module.verify()
    return module
