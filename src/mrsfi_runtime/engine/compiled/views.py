"""The state in compiled code, and the function that flies a batch.

To numba a record of lists is a ``View``: the address of a directory, whose fields read as in
Python. A directory never changes while compiled code runs, which the loads declare to LLVM
(``invariant.load``). The first half types views, their attributes, and calls by address.

The second half runs only compiled, and takes views. ``fly_many`` flies the specifications of a
batch one after the other. For each goal it calls the function of the goal's task or, by its
address, the region that a team wrote.
"""

import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from llvmlite import ir
from numba import from_dtype, types
from numba.core import cgutils
from numba.core.datamodel import models
from numba.core.typing.templates import AttributeTemplate
from numba.cpython import slicing
from numba.extending import (
    infer_getattr,
    intrinsic,
    lower_builtin,
    lower_getattr_generic,
    lower_setattr_generic,
    register_model,
)
from numba.np.arrayobj import load_item, make_array, populate_array, store_item

from mrsfi_runtime.engine.compiled.layout import (
    ALLOWED,
    CALLS,
    N_ALLOWED,
    OWN,
    RECORDED,
    Entry,
    entries,
)
from mrsfi_runtime.engine.compiled.regions import EFFECT
from mrsfi_runtime.engine.recording import VERDICTS, record_type
from mrsfi_runtime.kernel.commands import move
from mrsfi_runtime.kernel.effects import issue, send
from mrsfi_runtime.kernel.flight import MissionFunctions, Verdicts, answer
from mrsfi_runtime.kernel.goal_tasks import table
from mrsfi_runtime.kernel.injections import Plan
from mrsfi_runtime.kernel.state import MapState, MissionState, State, kernel

_intrinsic: Callable[[Callable[..., Any]], Callable[..., Any]] = intrinsic  # typed as it is called
_WORD = ir.IntType(64)
_OURS = "_ZN13mrsfi_runtime"  # how numba names functions of mrsfi


class Rows(types.Array):
    """A list of a state: an array, whose bounds are checked in one comparison."""


register_model(Rows)(models.ArrayModel)


class View(types.Type):
    """A record of lists, by its directory."""

    def __init__(self, kind: type) -> None:
        self.kind = kind
        super().__init__(f"view of {kind.__name__}")

    def entry(self, name: str) -> tuple[Entry, Any] | None:
        """Return a field and its type; ``None`` if there is none of the name."""
        entry = entries(self.kind).get(name)
        if entry is None:
            return None
        if entry.inner:
            return entry, View(entry.inner)
        element = from_dtype(entry.layout)
        if entry.kind == "list":
            return entry, Rows(element, 1, "C")
        return entry, element.typeof(name) if entry.kind == "number" else element


@register_model(View)
class _Model(models.PrimitiveModel):
    def __init__(self, manager: Any, view: Any) -> None:
        super().__init__(manager, view, _WORD.as_pointer())  # type: ignore[no-untyped-call]


@infer_getattr
class _Attributes(AttributeTemplate):
    key = View

    def generic_resolve(self, view: View, name: str) -> Any:  # type: ignore[override]
        found = view.entry(name)
        return found and found[1]


def _word(builder: Any, directory: Any, place: int) -> Any:
    """Return an entry's word, which never changes."""
    word = builder.load(builder.gep(directory, [ir.Constant(_WORD, place)]))
    word.set_metadata("invariant.load", builder.module.add_metadata([]))
    return word


@lower_getattr_generic(View)  # type: ignore[untyped-decorator]
def _get(context: Any, builder: Any, view: View, directory: Any, name: str) -> Any:
    entry, kind = view.entry(name)  # type: ignore[misc]
    if entry.inner:
        return builder.gep(directory, [ir.Constant(_WORD, 2 * entry.place)])
    address = _word(builder, directory, 2 * entry.place)
    if entry.kind == "list":
        array = make_array(kind)(context, builder)
        size = context.get_constant(types.intp, entry.layout.itemsize)
        data = builder.inttoptr(address, context.get_data_type(kind.dtype).as_pointer())
        length = _word(builder, directory, 2 * entry.sized + 1)
        least_and_most = [ir.Constant(_WORD, 0), ir.Constant(_WORD, 2**40)]
        length.set_metadata("range", builder.module.add_metadata(least_and_most))
        populate_array(array, data, [length], [size], size, meminfo=None)
        return array._getvalue()  # noqa: SLF001 - as numba's own code does
    if entry.kind == "record":
        return builder.inttoptr(address, context.get_value_type(kind))
    return builder.load(_number(builder, address, entry, name, context.get_value_type(kind)))


@lower_builtin(operator.getitem, Rows, types.Integer)  # type: ignore[untyped-decorator]
def _row(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    rows, index = signature.args
    place = _place(context, builder, rows, index, arguments)
    return load_item(context, builder, rows, place)


@lower_builtin(operator.setitem, Rows, types.Integer, types.Any)  # type: ignore[untyped-decorator]
def _set_row(context: Any, builder: Any, signature: Any, arguments: Any) -> None:
    rows, index, kind = signature.args
    place = _place(context, builder, rows, index, arguments)
    value = context.cast(builder, arguments[2], kind, rows.dtype)
    store_item(context, builder, rows, value, place)


GUARDED = "mrsfi_guarded"
"""Name of a constant, 1 unless code is compiled for missions without regions that a team wrote."""


def _guarded(builder: Any) -> Any:
    """Return whether a team's code can run, which may write any index into a state."""
    module, byte = builder.module, ir.IntType(8)
    flag = module.globals.get(GUARDED)
    if flag is None:
        flag = ir.GlobalVariable(module, byte, GUARDED)
        flag.linkage, flag.global_constant = "weak", True  # else it would be folded too early
        flag.initializer = ir.Constant(byte, 1)
    return builder.icmp_unsigned("!=", builder.load(flag), ir.Constant(byte, 0))


@_intrinsic
def is_guarded(_context: Any) -> Any:
    """Return whether regions that a team wrote can be called."""
    return types.boolean(), lambda _context, builder, _signature, _arguments: _guarded(builder)


def _place(context: Any, builder: Any, rows: Any, kind: Any, arguments: Any) -> Any:
    """Return the address of a row; the function that is compiled returns an error if there is none.

    A negative index counts from the end only in a team's functions: the kernel has none. Indices
    of the kernel itself are right, so they are checked only if a team's code can change them.
    """
    array = make_array(rows)(context, builder, arguments[0])
    index = context.cast(builder, arguments[1], kind, types.intp)
    (length,) = cgutils.unpack_tuple(builder, array.shape, 1)
    if not builder.function.name.startswith(_OURS):
        index = slicing.fix_index(builder, index, length)
    is_wrong = builder.and_(_guarded(builder), builder.icmp_unsigned(">=", index, length))
    with cgutils.if_unlikely(builder, is_wrong):
        context.call_conv.return_user_exc(builder, IndexError, ("index is out of bounds",))
    return builder.gep(array.data, [index])


@lower_setattr_generic(View)  # type: ignore[untyped-decorator]
def _set(context: Any, builder: Any, signature: Any, arguments: Any, name: str) -> None:
    view, kind = signature.args
    entry, _ = view.entry(name)
    address = _word(builder, arguments[0], 2 * entry.place)
    place = _number(builder, address, entry, name, context.get_value_type(kind))
    builder.store(arguments[1], place)


def _number(builder: Any, address: Any, entry: Entry, name: str, kind: Any) -> Any:
    offset = entry.layout.fields[name][1]  # type: ignore[index]
    return builder.inttoptr(builder.add(address, ir.Constant(_WORD, offset)), kind.as_pointer())


def view_at(kind: type) -> Any:
    """Return what makes a view of a directory's address in compiled code."""

    def view_of(_context: Any, address: Any) -> Any:
        def written(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            return builder.inttoptr(arguments[0], _WORD.as_pointer())

        return View(kind)(address), written

    return _intrinsic(view_of)


_STATE = View(State)
TASK_SIGNATURE = (_STATE, types.int64, types.int64)


def arguments_of(role: str) -> tuple[Any, ...]:
    """Return the types of a region's arguments; effects of user-defined fault types have more."""
    return (_STATE, _STATE, from_dtype(OWN)) if role == EFFECT else (_STATE,)


def _called(address: Any, *arguments: Any) -> Any:
    """Type and write a call of a compiled region; its error becomes one of the caller."""
    result = types.int64

    def written(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        kinds = signature.args[1:]
        convention = context.call_conv
        function = convention.get_function_type(result, kinds)
        pointer = builder.inttoptr(values[0], function.as_pointer())
        status, returned = convention.call_function(builder, pointer, result, kinds, values[1:])
        with cgutils.if_unlikely(builder, status.is_error):
            convention.return_status_propagate(builder, status)
        return returned

    return result(address, *arguments), written


@_intrinsic
def call(_context: Any, address: Any, view: Any) -> Any:
    """Call a region of a goal by its address, with a state."""
    return _called(address, view)


@_intrinsic
def call_by_task(_context: Any, address: Any, view: Any, g: Any, task: Any) -> Any:
    """Call the function of a task by its address, with a state, a goal and the task."""
    return _called(address, view, g, task)


@_intrinsic
def call_effect(_context: Any, address: Any, ci: Any, inbox: Any, fault: Any) -> Any:
    """Call the effects of user-defined fault types by their address."""
    return _called(address, ci, inbox, fault)


@_intrinsic
def word_of(_context: Any, record: Any, place: Any) -> Any:
    """Read a word of 8 bytes of a record."""

    def written(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        words = builder.bitcast(arguments[0], _WORD.as_pointer())
        return builder.load(builder.gep(words, [arguments[1]]))

    return types.int64(record, place), written


_N_CONSTANT = OWN.fields["memory"][1] // 8  # type: ignore[index]
_N_MISSION, _N_MAP = (record_type(kind).itemsize // 8 for kind in (MissionState, MapState))
_N_VERDICTS = len(VERDICTS)
_ODD = -7046029254386353131  # no single change of a word escapes a sum that is multiplied by it


@kernel
def region(view: Any, place: int) -> int:
    """Return the address of a region that a team wrote; 0 for a default one."""
    return getattr(view, CALLS)[place] if is_guarded() else 0


@kernel
def progress(view: Any) -> None:
    """Bring the progress of every goal up to the tick of a state."""
    for g in range(len(view.goals)):
        address = region(view, 3 * g)
        if address:
            call(address, view)
        else:
            table.progress(view, g, view.goals[g].task)


@kernel
def check(view: Any, violated: Any) -> None:
    """Write 1 for every goal that is violated in a state, else 0."""
    for g in range(len(view.goals)):
        address = region(view, 3 * g + 1)
        if address:
            violated[g] = call(address, view)
        else:
            violated[g] = table.violated(view, g, view.goals[g].task)


@kernel
def react(ci: Any) -> None:
    """Let every goal command its members."""
    for g in range(len(ci.goals)):
        address = region(ci, 3 * g + 2)
        if address:
            call(address, ci)
        else:
            table.react(ci, g, ci.goals[g].task)


@kernel
def progress_by_task(view: Any, g: int, task: int) -> int:
    """Update the memory of a goal, as a task defines it; regions call this by address."""
    table.progress(view, g, task)
    return 0


@kernel
def check_by_task(view: Any, g: int, task: int) -> int:
    """Return whether a goal is violated, as a task defines it; called by address, too."""
    return 1 if table.violated(view, g, task) else 0


@kernel
def react_by_task(ci: Any, g: int, task: int) -> int:
    """Command the members of a goal, as a task defines it; called by address, too."""
    table.react(ci, g, task)
    return 0


TASK_FUNCTIONS = (progress_by_task, check_by_task, react_by_task)
"""Their addresses follow those of all goals and of user-defined effects."""


@kernel
def apply(ci: Any, inbox: Any, fault: Any) -> None:
    """Let a user-defined fault act; raise an error if it changes more than its type allows."""
    address = region(ci, 3 * len(ci.goals))
    if address == 0:
        return
    before = fixed(ci, inbox, fault)
    call_effect(address, ci, inbox, fault)
    if fixed(ci, inbox, fault) != before:
        raise ValueError


@kernel
def fixed(ci: Any, inbox: Any, fault: Any) -> Any:
    """Return a sum of all words that a fault must not change."""
    believed = getattr(ci, RECORDED)
    total = add(0, getattr(inbox, RECORDED), 0, len(believed))
    total = add_record(total, fault, _N_CONSTANT)
    for view in (ci, inbox):
        total = add_record(add_record(total, view.mission, _N_MISSION), view.map, _N_MAP)
    first = 0
    allowed = getattr(fault, ALLOWED)
    for k in range(N_ALLOWED):
        total = add(total, believed, first, allowed[k])
        first = allowed[k] + 1
    return total


@kernel
def add(total: int, words: Sequence[int], first: int, last: int) -> int:
    """Add some words to a sum."""
    for place in range(first, last):
        total = (total + words[place]) * _ODD
    return total


@kernel
def add_record(total: int, record: Any, n_words: int) -> int:
    """Add the first words of a record to a sum."""
    for place in range(n_words):
        total = (total + word_of(record, place)) * _ODD
    return total


@dataclass(slots=True)
class Flights:
    """The data that flights read and write.

    ``states`` are the directories of truth, belief and inbox; ``plans`` and ``verdicts`` have one a
    specification. ``fresh`` is the changing part of a state before the first tick; ``world, belief,
    inbox`` are that part of the states; ``samples`` has the valid samples of each sensor, tick
    after tick. ``results`` has a row a specification: words of last truth and belief, and verdicts;
    ``moments`` one for each of ``n_moments`` ticks. ``at`` receives the number of the specification
    that flies, and holds its first tick and the one after its last.
    """

    n_moments: int
    at: list[int]
    states: list[int]
    fresh: list[int]
    world: list[int]
    belief: list[int]
    inbox: list[int]
    samples: bytes
    plans: list[int]
    verdicts: list[int]
    results: list[int]
    moments: list[int]


_state, _plan, _verdicts = view_at(State), view_at(Plan), view_at(Verdicts)


@kernel
def fly_many(flights: Flights, first: int, last: int) -> int:
    """Fly the specifications ``first … last - 1`` of a batch, each from the first tick or on."""
    functions = MissionFunctions(progress, check, react, apply)
    world = _state(flights.states[0])
    belief = _state(flights.states[1])
    inbox = _state(flights.states[2])
    n_sensors = len(world.sensors)
    n_recorded = len(getattr(world, RECORDED))
    n_words = 2 * n_recorded + _N_VERDICTS * len(world.goals)
    begin, end = flights.at[1], flights.at[2]
    for k in range(first, last):
        flights.at[0] = k
        plan = _plan(flights.plans[k])
        verdicts = _verdicts(flights.verdicts[k])
        row = k * n_words
        if begin == 0:
            n_fresh = len(flights.fresh)
            copy(flights.fresh, 0, flights.world, 0, n_fresh)
            copy(flights.fresh, 0, flights.belief, 0, n_fresh)
            copy(flights.fresh, 0, flights.inbox, 0, n_fresh)
            issue(belief, world, plan, 0)
        for tick in range(begin, end):
            valid = flights.samples[tick * n_sensors : (tick + 1) * n_sensors]
            move(world, valid, tick)
            send(world, inbox)
            answer(functions, world, belief, inbox, world, plan, verdicts, tick)
            moment = tick - begin
            if moment < flights.n_moments or tick + 1 == end:
                copy(flights.world, 0, flights.results, row, n_recorded)
                copy(flights.belief, 0, flights.results, row + n_recorded, n_recorded)
            if moment < flights.n_moments:
                copy(flights.results, row, flights.moments, moment * n_words, n_words)
    return 0


@kernel
def copy(words: list[int], first: int, target: list[int], place: int, n: int) -> None:
    """Copy words to a place."""
    for k in range(n):
        target[place + k] = words[first + k]
