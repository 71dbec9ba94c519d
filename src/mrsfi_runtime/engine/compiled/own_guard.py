"""Holds compiled effects of a team's own to what their fault types name."""

from typing import Any

from numba import types
from numba.extending import intrinsic

from mrsfi_runtime.engine.compiled.inlining import jitable
from mrsfi_runtime.engine.compiled.layout import N_ALLOWED
from mrsfi_runtime.engine.recording import record_type
from mrsfi_runtime.kernel.injections import OwnFault

_FAULT: Any = record_type(OwnFault)
_N_CONSTANT, _FIRST_ALLOWED = _FAULT.fields["memory"][1] // 8, _FAULT.itemsize // 8
_ODD = -7046029254386353131


def _word(_context: Any, record: Any, _place: Any) -> Any:
    """Type and write what reads a word of 8 bytes of a record."""

    def written(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        word = context.get_value_type(signature.return_type)
        words = builder.bitcast(arguments[0], word.as_pointer())
        return builder.load(builder.gep(words, [arguments[1]]))

    return types.int64(record, types.int64), written


_word_of: Any = intrinsic(_word)


def guarded(apply: Any, n_recorded: int, spans: tuple[tuple[int, int], ...]) -> Any:
    """Return an effect that fails compiled if it changes what its fault does not allow.

    ``spans`` are the words of a state that it must leave alone, ``n_recorded`` how many lead a
    state, of which a fault names those that it may change. A sum is taken of the words before and
    after: that no single change escapes follows from the factor, which is odd.
    """

    @jitable
    def add(total: Any, record: Any, first: Any, last: Any) -> Any:
        for place in range(first, last):
            total = (total + _word_of(record, place)) * _ODD
        return total

    @jitable
    def fixed(ci: Any, inbox: Any, fault: Any) -> Any:
        total = add(add(0, inbox, 0, n_recorded), fault, 0, _N_CONSTANT)
        for first, last in spans:
            total = add(add(total, ci, first, last), inbox, first, last)
        first = 0
        for k in range(N_ALLOWED):
            last = _word_of(fault, _FIRST_ALLOWED + k)
            total = add(total, ci, first, last)
            first = last + 1
        return total

    @jitable
    def apply_guarded(ci: Any, inbox: Any, fault: Any) -> None:
        before = fixed(ci, inbox, fault)
        apply(ci, inbox, fault)
        if fixed(ci, inbox, fault) != before:
            raise ValueError

    return apply_guarded
