import pytest

from mrsfi_runtime.causes.chain import HEADING, Change, First, changed
from mrsfi_runtime.model.fault_types import Units


@pytest.mark.parametrize(
    ("quantity", "found", "otherwise", "said"),
    [
        (
            "position",
            (3.0, 4.0, 0.0),
            (3.0, 5.0, 0.0),
            "(3.00, 4.00, 0.00), not (3.00, 5.00, 0.00)",
        ),
        ("position", (3.0, 4.0, 0.0), (3.0, 4.001, 0.0), "(3.00, 4.00, 0.00), 1e-03 off"),
        (HEADING, (40.0,), (20.0,), "40.0 degrees, not 20.0 degrees"),
        (HEADING, (0.01,), (360.0,), "0.0 degrees, not 360.0 degrees"),
        (HEADING, (20.0,), (20.000004,), "20.0 degrees, 4e-06 off"),
        ("energy", (7.0,), (8.5,), "7, not 8.50"),
    ],
)
def test_a_change_is_told_so_that_it_can_be_seen(quantity, found, otherwise, said):
    first = First(3, (Change("r1", quantity, found, otherwise),))

    assert changed(first, Units()) == f"r1 {quantity} {said}"
