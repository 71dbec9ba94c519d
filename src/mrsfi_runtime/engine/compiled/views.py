"""Numba's view of records of lists: the address of a directory, whose fields read as in Python.

What a directory says never changes while compiled code runs, which LLVM is told.
"""

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import from_dtype, types
from numba.core import cgutils
from numba.core.datamodel import models
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    infer_getattr,
    intrinsic,
    lower_getattr_generic,
    lower_setattr_generic,
    register_model,
)
from numba.np.arrayobj import make_array, populate_array

from mrsfi_runtime.engine.compiled.layout import OWN, Entry, entries
from mrsfi_runtime.engine.compiled.regions import EFFECT
from mrsfi_runtime.kernel.state import State

_intrinsic: Callable[[Callable[..., Any]], Callable[..., Any]] = intrinsic  # typed as it is called
_WORD = ir.IntType(64)
_LENGTHS = [ir.Constant(_WORD, 0), ir.Constant(_WORD, 2**40)]


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
            return entry, types.Array(element, 1, "C")
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
    """Return an entry's word, which is always the same."""
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
        length = _word(builder, directory, 2 * entry.place + 1)
        length.set_metadata("range", builder.module.add_metadata(_LENGTHS))
        populate_array(array, data, [length], [size], size, meminfo=None)
        return array._getvalue()  # noqa: SLF001 - as numba's own code does
    if entry.kind == "record":
        return builder.inttoptr(address, context.get_value_type(kind))
    return builder.load(_number(builder, address, entry, name, context.get_value_type(kind)))


@lower_setattr_generic(View)  # type: ignore[untyped-decorator]
def _set(context: Any, builder: Any, signature: Any, arguments: Any, name: str) -> None:
    view, kind = signature.args
    entry, _ = view.entry(name)
    address = _word(builder, arguments[0], 2 * entry.place)
    builder.store(
        arguments[1], _number(builder, address, entry, name, context.get_value_type(kind))
    )


def _number(builder: Any, address: Any, entry: Entry, name: str, kind: Any) -> Any:
    offset = entry.layout.fields[name][1]  # type: ignore[index]
    return builder.inttoptr(builder.add(address, ir.Constant(_WORD, offset)), kind.as_pointer())


def seen_as(kind: type) -> Any:
    """Return what makes a view of a directory's address in compiled code."""

    def view_of(_context: Any, address: Any) -> Any:
        def written(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            return builder.inttoptr(arguments[0], _WORD.as_pointer())

        return View(kind)(address), written

    return _intrinsic(view_of)


_STATE = View(State)
BY_TASK = (_STATE, types.int64, types.int64)


def arguments_of(role: str) -> tuple[Any, ...]:
    """Return the types of what a region is called with; effects of a team's own take more."""
    return (_STATE, _STATE, from_dtype(OWN)) if role == EFFECT else (_STATE,)


def _called(address: Any, *arguments: Any) -> Any:
    """Type and write a call of a compiled region, whose error is one of the caller."""
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
    """Call what a task says by its address, with a state, a goal and the task."""
    return _called(address, view, g, task)


@_intrinsic
def call_effect(_context: Any, address: Any, ci: Any, inbox: Any, fault: Any) -> Any:
    """Call the effects of a team's own by their address."""
    return _called(address, ci, inbox, fault)


@_intrinsic
def word_of(_context: Any, record: Any, place: Any) -> Any:
    """Read a word of 8 bytes of a record."""

    def written(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        words = builder.bitcast(arguments[0], _WORD.as_pointer())
        return builder.load(builder.gep(words, [arguments[1]]))

    return types.int64(record, place), written
