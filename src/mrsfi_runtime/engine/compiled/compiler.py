"""Compiles the kernel's flight and a team's regions to object files; only this module needs numba.

Numba's pipeline has two changes here. ``Checked`` refuses operations that Python refuses: to numba,
a list of the state is an array, with more attributes and operators, and a record of a team's array
is like one of the state. ``Inlined`` leaves functions unoptimised until they are inlined in their
callers; numba would optimise and write each separately. That saves two fifths of the time.

Begin with ``compiled_kernel`` and ``compiled_region``. ``explain`` names the line and region that
cannot be compiled, and the reason in plain words.
"""

import ast
import importlib
import inspect
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from textwrap import dedent
from types import FunctionType, ModuleType, SimpleNamespace
from typing import Any, get_args, get_type_hints

import numba
from llvmlite.binding import parse_assembly, set_option
from numba import types
from numba.core import compiler
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, DefaultPassBuilder
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import AnalysisPass, register_pass
from numba.core.errors import TypingError
from numba.core.registry import cpu_target
from numba.core.runtime.nrt import rtsys
from numba.core.typed_passes import NopythonTypeInference
from numba.extending import register_jitable

from mrsfi_runtime.engine.compiled import views
from mrsfi_runtime.engine.compiled.layout import ALLOWED, CALLS
from mrsfi_runtime.engine.compiled.machine_code import MachineCode, lend_runtime, this_machine
from mrsfi_runtime.engine.compiled.regions import (
    EFFECT,
    ROLES,
    CompilationError,
    Reached,
    Region,
    names_of,
)
from mrsfi_runtime.engine.compiled.views import (
    GUARDED,
    TASK_FUNCTIONS,
    Flights,
    arguments_of,
    fly_many,
)
from mrsfi_runtime.files import lines_in_regions
from mrsfi_runtime.kernel.effects import believe, note
from mrsfi_runtime.kernel.geometry import in_area
from mrsfi_runtime.kernel.goal_tasks import avoid_collision
from mrsfi_runtime.kernel.goal_tasks.table import FUNCTIONS
from mrsfi_runtime.kernel.guidance import roam_in
from mrsfi_runtime.kernel.injections import OwnFault
from mrsfi_runtime.kernel.neighbours import gather
from mrsfi_runtime.kernel.state import State, is_kernel

_BLAS = "scipy.linalg.cython_blas"
if _BLAS not in sys.modules:  # numba imports it, slowly, to see whether it is there
    sys.modules[_BLAS] = ModuleType(_BLAS)
    importlib.import_module("numba.np.arraymath")
    del sys.modules[_BLAS]

_KNOWN = tuple(
    get_type_hints(record).keys()
    for kind in (State, OwnFault, *get_type_hints(State).values())
    for record in (*get_args(kind), kind)
    if hasattr(record, "__dataclass_fields__")
)
"""Names of the fields of all records that a region is given."""


@register_pass(mutates_CFG=False, analysis_only=True)
class _LikePython(AnalysisPass):
    """Refuses attributes and operators that objects of the reference engine do not have."""

    _name = "like_python"

    def __init__(self) -> None:
        """Hold nothing."""

    def run_pass(self, state: Any) -> bool:
        is_ours = state.func_id.func.__module__.startswith("mrsfi_runtime.")
        for block in () if is_ours else state.func_ir.blocks.values():
            for found in block.find_exprs():
                named = {"getattr": "attr", "static_getitem": "index"}.get(found.op)
                name = getattr(found, named) if named else ""
                is_operator = found.op in ("binop", "inplace_binop", "unary")
                if isinstance(name, str) and (named or is_operator):
                    kinds = [state.typemap[each.name] for each in found.list_vars()]
                    if any(_refused(kind, found.op, name) for kind in kinds):
                        what = f"'{name or found.fn.__name__}'"
                        raise TypingError(f"{what} has another meaning in Python", loc=found.loc)
        return False


def _refused(kind: Any, op: str, name: str) -> bool:
    """Return whether Python refuses an operator, an attribute or an entry by name of an operand."""
    if isinstance(kind, types.Record):
        return (kind.fields.keys() - {ALLOWED} in _KNOWN) != (op == "getattr")
    is_of_records = isinstance(kind, types.Array) and isinstance(kind.dtype, types.Record)
    is_list = is_of_records or isinstance(kind, types.NestedArray)
    return is_list or (isinstance(kind, types.Number) and name == "item")


class Checked(Compiler):
    """Numba's pipeline, which refuses operations that Python refuses."""

    def define_pipelines(self) -> list[Any]:
        """Return the pipeline."""
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
        """Return no address: there is no machine code yet."""
        self.linked()
        return 0

    @property
    def codegen(self) -> SimpleNamespace:
        """The setter of environments, without effect: there is no machine code yet."""
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
    """Return when to link: numba's own code last, because only functions in use are taken."""
    return 2 if library is rtsys.library else not isinstance(library, _Library)


def _code(library: Any) -> Any:
    if isinstance(library, _Library):
        return library.linked()
    return library._get_module_for_linking()  # noqa: SLF001 - numba's own libraries ask each other


INLINED = frozenset(
    {
        avoid_collision.gap_along,
        avoid_collision.gap_between,
        avoid_collision.gap_to,
        avoid_collision.gap_to_obstacles_along,
        believe,
        gather,
        in_area,
        note,
        roam_in,
    }
)
"""Functions that most ticks call, which LLVM by itself would not inline in their callers."""


def jitable(function: Callable[..., Any]) -> None:
    """Let compiled code call a function, and leave the function unchanged."""
    register_jitable(
        boundscheck=True,
        no_cfunc_wrapper=True,
        forceinline=function in INLINED,
        pipeline_class=Inlined,
    )(function)


_REASONS = (
    (r"Untyped global name '(\w+)'.*<class 'function'>", "'{0}' is not marked @kernel; mark it"),
    (
        r"Untyped global name '(\w+)'.*<class 'builtin_",
        "the compiler does not support Python's '{0}'; write a loop, or leave it out",
    ),
    (
        r"Untyped global name '(\w+)'.*<class '(\w+)'>",
        "'{0}' is a global {1}; write a number, or a tuple of numbers",
    ),
    (
        r"a reflected (\w+).*? variable '(\w+)' in globals",
        "'{1}' is a global {0}; write a tuple of numbers",
    ),
    (r"NameError: name '(\w+)'", "'{0}' is not defined"),
    (r"Cannot unify (.+?) and (.+?) for '(\w+)", "'{2}' holds values of two types"),
    (r"^'(\w+)'$", "records have no '{0}'"),
    (r"\(UNPACK_EX\)", "it unpacks with a star; unpack by index"),
    (
        r"exception_match|Exception object",
        "it distinguishes exceptions; write `except Exception:`, or test beforehand",
    ),
    (
        r"Unknown attribute '(\w+)' of type Module\(<module '(\w+)'",
        "the compiler does not support '{1}.{0}'; write the formula, or leave it out",
    ),
    (r"Unknown attribute '(\w+)' of type array", "a list has no '{0}' when compiled; write a loop"),
    (
        r"f-strings|'format' of type Literal|in function mod>[\s\S]*Literal\[str\]",
        "it builds a text; leave texts to the analysis",
    ),
    (r"<built-in function (min|max)>", "'{0}' takes only numbers; write a loop"),
    (r"load_from_data_pointer", "it makes a list of records; make one of their indices"),
    (
        r"Cannot type empty list",
        "the type of an empty list is unknown; keep lasting values in `ci`",
    ),
    (
        r"of function Function\(<function (\w+) ",
        "'{0}' does not compile for these arguments; a function cannot call itself",
    ),
)
"""Patterns of numba's messages, and what they mean in plain words."""

_UNKNOWN: Mapping[type[ast.AST], str] = {
    ast.GeneratorExp: "a generator expression; write a loop",
    ast.SetComp: "a set comprehension; write a loop",
    ast.NamedExpr: "`:=`; assign on a line of its own",
    ast.With: "a `with`; leave it out: a region only reads and commands `ci`",
    ast.Import: "an import; import in the region 'imports'",
    ast.ImportFrom: "an import; import in the region 'imports'",
    ast.Global: "a `global`; keep lasting values in the fields of `ci`",
    ast.ClassDef: "a class; write functions, or constants in the region 'helpers'",
    ast.Delete: "a `del`; leave the name alone",
}
"""Syntax that numba never supports, for which its messages are vague and may name another line."""


def explain(
    directory: Path, region: Region, functions: Sequence[FunctionType], error: Exception
) -> CompilationError:
    """Return which line of a region, or of the functions it reaches, does not compile, and why."""
    for function in functions:
        for line, why in _unknown(function):
            return _error(directory, function, line, why)
    place = re.compile(r'File "([^"]+)", line (\d+)|Raised from (\S+) \((\d+)\)')
    called: list[Any] = [region.function]
    if region.role == EFFECT:
        names = region.function.__code__.co_names
        called[:0] = [region.function.__globals__.get(name) for name in names]
    for function in filter(is_kernel, called):
        try:
            numba.njit(pipeline_class=Checked)(function).compile(arguments_of(region.role))
        except Exception as found:  # noqa: BLE001 - numba raises errors of any kind
            named = [
                int(line or other_line)
                for file, line, other, other_line in place.findall(str(found))
                if Path(file or other).name == Path(inspect.getfile(function)).name
            ]
            return _error(directory, function, named[-1] if named else None, _why(found))
    return _error(directory, region.function, None, _why(error))


def _unknown(function: FunctionType) -> Iterator[tuple[int, str]]:
    """Yield the lines of a team's function that have unsupported syntax, and the reason."""
    if not function.__module__.startswith("mrsfi_runtime."):
        with suppress(OSError, SyntaxError):  # no file, or a function within a line
            lines, first = inspect.getsourcelines(function)
            for node in ast.walk(ast.parse(dedent("".join(lines)))):
                if type(node) in _UNKNOWN:
                    line = first - 1 + getattr(node, "lineno", 1)
                    yield line, f"it has {_UNKNOWN[type(node)]}"


def _error(
    directory: Path, function: Callable[..., Any], line: int | None, why: str
) -> CompilationError:
    """Return an error with file, line and region; by default the first line of the region."""
    path = Path(inspect.getfile(function))
    lines, first = inspect.getsourcelines(function)
    regions = lines_in_regions(path.read_text(encoding="utf-8"))
    if line is None:
        line = next(filter(regions.get, range(first, first + len(lines))), first + 1)
    place = f"region {regions[line]}" if line in regions else f"function {function.__name__}"
    path = directory / path.name if path.parent == directory.absolute() else path
    return CompilationError(f"{path}:{line}: {place} cannot be compiled: {why}")


def _why(error: Exception) -> str:
    text = str(error) or type(error).__name__
    for pattern, words in _REASONS:
        match = re.search(pattern, text)
        if match:
            return words.format(*match.groups())
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[1 if len(lines) > 1 and "pipeline" in lines[0] else 0].partition(" Raised from")[0]


set_option("", "-disable-loop-idiom-all")  # code for ``NEAR`` cannot call memset
set_option("", "-min-jump-table-entries=100")  # jumps by task or property are rarely foreseen
_TYPING, _TARGET = cpu_target.typing_context, cpu_target.target_context
lend_runtime()
_REGISTERED: dict[FunctionType, str] = {}


def compiled_kernel(machine: Any = None) -> MachineCode:
    """Compile the kernel's flight, for this machine or another.

    Last among the functions is the flight of missions in which no code of a team runs.
    """
    functions = (fly_many, *TASK_FUNCTIONS)
    register(each for one in functions for each in _reached_by(one)[1:])
    flight = (views.View(Flights), types.int64, types.int64)
    arguments = (flight, *(views.TASK_SIGNATURE for _ in TASK_FUNCTIONS))
    machine = machine or this_machine(is_near=True)
    found: MachineCode = _compiled(zip(functions, arguments, strict=True), machine, "fly_unguarded")
    return replace(found, is_near=True)


def compiled_region(directory: Path, region: Region, reached: Reached) -> MachineCode:
    """Compile a region of a mission, or raise which line of it does not compile."""
    register(reached.functions)
    try:
        with _by_address():
            called = [(_called(region), views.arguments_of(region.role))]
            found: MachineCode = _compiled(called, _TARGET.codegen()._tm)  # noqa: SLF001 - numba's
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
                f"{code.co_filename}:{code.co_firstlineno}: '{function.__name__}' reads a value "
                "that has changed since this process compiled it; start another process"
            )


def _called(region: Region) -> Callable[..., Any]:
    """Return a region as the kernel calls it: it returns an integer."""
    function = region.function

    def apply(ci: Any, inbox: Any, fault: Any) -> int:
        function(ci, inbox, fault)
        return 0

    def check(view: Any) -> int:
        return 1 if function(view) else 0

    def act(view: Any) -> int:
        function(view)
        return 0

    if region.role == EFFECT:
        return apply
    return check if region.role == "check" else act


@contextmanager
def _by_address() -> Iterator[None]:
    """Have regions call functions of tasks in the kernel, because they take long to compile."""
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
    """Return a function that calls the function of a task by address."""
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
"""Replacements, in a team's regions, of the functions that generated regions call."""


def _reached_by(first: Any) -> list[FunctionType]:
    found: list[FunctionType] = [first]
    for function in found:
        names = set(names_of(function.__code__))
        read = [function.__globals__[name] for name in names & function.__globals__.keys()]
        read += [cell.cell_contents for cell in function.__closure__ or ()]
        for module in [each for each in read if isinstance(each, ModuleType)]:
            read += [vars(module)[name] for name in names & vars(module).keys()]
        found += [each for each in dict.fromkeys(filter(is_kernel, read)) if each not in found]
    return found


@global_compiler_lock  # type: ignore[untyped-decorator]
def _compiled(
    functions: Iterable[tuple[Callable[..., Any], tuple[Any, ...]]],
    machine: Any,
    unguarded: str = "",
) -> MachineCode:
    """Return the code of functions for a machine, by their arguments; each returns an integer.

    If ``unguarded`` is a name, the first function is repeated last, without ``GUARDED``.
    """
    flags: Any = compiler.Flags()
    flags.nrt = flags.boundscheck = flags.no_compile = True
    flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
    _TYPING.refresh()
    _TARGET.refresh()
    names, modules = list[str](), list[Any]()
    for function, arguments in functions:
        result = compiler.compile_extra(
            _TYPING, _TARGET, function, arguments, types.int64, flags, {}, pipeline_class=Inlined
        )
        names.append(result.fndesc.llvm_func_name)
        modules.append(result.library.whole())
    if unguarded:
        modules[0].get_function(names[0]).linkage = "external"  # else it would not be linked
        modules.append(parse_assembly(f"@{GUARDED} = constant i8 0"))
        modules[-1].link_in(modules[0], preserve=True)
        modules[-1].get_function(names[0]).name = unguarded
        names.append(unguarded)
    for module, name in zip(modules, names, strict=True):
        _optimise(module, name)
    module, *others = modules
    for other in others:
        module.link_in(other)
    binary = machine.emit_object(module)
    known = (*module.functions, *module.global_variables)
    taken = [each.name for each in known if each.is_declaration]
    return MachineCode(tuple(names), binary, tuple(n for n in taken if not n.startswith("llvm.")))


def _optimise(module: Any, name: str) -> None:
    """Optimise a module, of which other modules call one function.

    Loops are mostly short: vectors take longer, and make flights slower. So does a second function
    in the same module, because functions that both call are not inlined.
    """
    for each in (*module.functions, *module.global_variables):
        if not each.is_declaration:
            each.linkage = "external" if each.name == name else "internal"
    passes, builder = _TARGET.codegen()._module_pass_manager(  # noqa: SLF001
        opt=3, loop_vectorize=False, slp_vectorize=False
    )
    passes.add_global_dead_code_eliminate_pass()
    passes.run(module, builder)
    module.verify()
