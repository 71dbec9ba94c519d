"""Which timed faults are admitted, whoever made them."""

from dataclasses import replace
from fractions import Fraction
from math import inf, nan

import numpy as np
import pytest

from mrsfi_runtime.errors import SpecificationError
from mrsfi_runtime.model.faults import LAST, MOST, FaultPool, Gate, TimedFault, at_work
from mrsfi_runtime.record import database
from tests.support.world import paper_code

CODE = paper_code()
GATE = Gate(CODE.mission, CODE.pool)
PLACE = (1.0, 2.0, 3.0)


def f8(delay):
    return [TimedFault("f8", 0, 9, (delay,))]


@pytest.mark.parametrize(
    "specification",
    [
        [TimedFault("f9", 100.5, 400, PLACE)],
        [TimedFault("f9", 100.0, 400, PLACE)],
        [TimedFault("f9", True, 400, PLACE)],
        [TimedFault("f9", np.True_, 400, PLACE)],
        [TimedFault("f9", "3", 400, PLACE)],
        [TimedFault("f9", None, 400, PLACE)],
        [TimedFault("f9", 100, inf, PLACE)],
        [TimedFault("f9", nan, 100, PLACE)],
        [TimedFault("f1", 9, 8)],
        [TimedFault("f1", -1, 8)],
        [TimedFault("f1", 0, LAST + 1)],
        f8(2.7),
        f8(-3),
        f8(float(LAST + 1)),
        f8("3"),
        f8(True),
        f8(None),
        f8(nan),
        f8(inf),
        f8(10**400),
        [TimedFault("f10", 0, 9, (1.001 * MOST,))],
        [TimedFault("f14", 0, 9, (-1e10,))],
        [TimedFault("f14", 0, 9, (-LAST - 2.0,))],
        [TimedFault("f24", 0, 9, (5.0, 4.0))],
        [TimedFault("f4", 0, 9)],
        [TimedFault("f1", 0, 9, (1.0,))],
        [TimedFault("f9", 0, 9, 1.0)],
        [("f1", 0, 9, (), "t", 1)],
        [TimedFault("f1", 0, 9, (), 7)],
        [TimedFault("f1", 0, 9, (), "low")],
        [("f9", 1)],
        [TimedFault(3, 0, 9)],
        [TimedFault(["f1"], 0, 9)],
        7,
        TimedFault("f1", 0, 9),
        [TimedFault("f33", 0, 9)],
        [TimedFault("f4", 0, 9, (1.0,)), TimedFault("f27", 9, 12)],
        [TimedFault("f1", 0, 9), TimedFault("f1", 5, 12)],
    ],
)
def test_what_makes_no_sense_is_refused(specification, refused):
    with refused(SpecificationError):
        GATE.admitted(specification)


def copies(*names: str) -> FaultPool:
    """Return a written specification of copies of f7, of a message that carries no speed."""
    fault = replace(CODE.pool["f7"], target="m1", start=0, finish=9)
    return FaultPool("written", tuple(replace(fault, id=name) for name in names))


@pytest.mark.parametrize("names", [("f7.1", "f7.2"), ("f7", "f7.1"), ("gone.1", "gone.2")])
def test_written_copies_of_one_fault_never_overlap_even_if_they_touch_nothing(names, refused):
    written = copies(*names)
    gate = Gate(CODE.mission, written, CODE.pool.by_id)

    with refused(SpecificationError):
        gate.admitted(written.written_specification())


@pytest.mark.parametrize("names", [("f7", "f6"), ("f7.1", "f6.1"), ("f7.a", "f7.b"), (".1", ".2")])
def test_written_faults_that_are_no_copies_of_one_may_overlap_where_they_touch_nothing(names):
    written = copies(*names)

    admitted = Gate(CODE.mission, written, CODE.pool.by_id).admitted(
        written.written_specification()
    )

    assert [timed.fault for timed in admitted] == [*names]


def test_faults_of_the_pool_are_no_copies_whatever_they_are_called():
    written = copies("pump.1", "pump.2")

    gate = Gate(CODE.mission, written, {"pump.1", "pump.2"})

    assert len(gate.admitted(written.written_specification())) == 2


def test_what_comes_out_is_of_pythons_own_kinds():
    asked = [
        TimedFault(np.str_("f8"), np.int64(10), np.int32(20), [np.int8(4)]),
        ("f10", 0, LAST, (Fraction(1, 2),)),
        TimedFault("f14", 0, 9, (3,)),
        TimedFault("f14", 10, 19, (-LAST - 1,)),
    ]

    admitted = GATE.admitted(asked)

    assert admitted == (
        TimedFault("f8", 10, 20, (4.0,)),
        TimedFault("f10", 0, LAST, (0.5,)),
        TimedFault("f14", 0, 9, (3.0,)),
        TimedFault("f14", 10, 19, (-(2.0**31),)),
    )
    kinds = {type(part) for timed in admitted for part in (*timed[:3], *timed.values)}
    assert kinds == {str, int, float}


def test_what_is_plain_already_stays_the_same_object():
    asked = (TimedFault("f4", 0, 8, (1.0,)), TimedFault("f27", 9, 12))

    assert [*map(id, GATE.admitted(asked))] == [*map(id, asked)]


def test_values_are_given_by_the_names_of_their_parameters(refused):
    fault = CODE.pool["f9"]

    timed = at_work("f9", fault.kind, 1, 2, {"NEW_Z": 3, "NEW_X": 1, "NEW_Y": 2})

    assert timed == TimedFault("f9", 1, 2, PLACE)
    with refused(SpecificationError):
        at_work("f9", fault.kind, 1, 2, {"NEW_W": 3})


@pytest.mark.parametrize("row", [["f9", 15.08, 20, []], ["f9", 1, 2, ["3"]], ["f9", 1, 2, [2e12]]])
def test_a_record_takes_and_gives_no_other_fault_than_it_was_given(row, refused):
    with refused(ValueError):
        database.specification([row])
    with refused(SpecificationError):
        database.specification_text([TimedFault(*row)])
